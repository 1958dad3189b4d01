//! The journal: what was committed is found again whatever happens to the process, the disk or the file.

use std::{
    fs::{self, File, OpenOptions},
    io,
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
};

use balayage::{
    Problem,
    document::{
        Document, Edit, Environment, HeadReference, Layer, Project, SaveOptions, backup_path,
        files::SaveStep,
        journal::{self, Contents, Found, Journal, Record, Storage},
        recover::{self, Recovered},
    },
    paint::{Dab, Operation, OperationId, Shape, StrokeFile},
};
use balayage_tests::random;
use rand::Rng;

use crate::{cli::balayage, project::sample};

/// A stroke of one dab somewhere on the tuft.
pub fn stroke(number: u64, layer: &str) -> Operation {
    let text = format!(
        r#"{{"version": 2, "operations": [{{"id": {number}, "layer": "{layer}", "channel": "bleach", "mode": "add", "value": 0.01,
            "radius_m": 0.02, "dabs": [{{"root": [{x}, 0, 5], "arc": 0.5, "position": [{x}, 6, 5]}}]}}]}}"#,
        x = number % 20
    );
    StrokeFile::parse(&text).unwrap().operations.remove(0)
}

/// A document with a journal, and the folder of journals that cannot lie beside a project.
fn document(folder: &Path) -> (Document, PathBuf) {
    let state = folder.join("state");
    let mut document = Document::open(&sample(folder), None).unwrap().document;
    document.keep_journal(&state);
    (document, state)
}

/// What a journal holds at this moment; its writer is this process, so that a copy is read.
fn contents(journal: &Path) -> Contents {
    let copy = journal.with_extension("copy");
    fs::copy(journal, &copy).unwrap();
    match journal::read(&copy).unwrap() {
        Found::Journal(contents) => *contents,
        Found::InUse | Found::Empty => panic!("no journal"),
    }
}

/// The project that a crash at this moment would leave.
fn recovered(document: &Document) -> Result<Recovered, Problem> {
    let contents = contents(document.journal_path().unwrap());
    recover::recover(&contents, document.path(), false)
}

/// What an edit can change of a project.
fn edited(project: &Project) -> Project {
    let mut project = project.clone();
    project.camera = None;
    project.groom.hash = None;
    project.groom.metres_per_unit = None;
    project.files.clear();
    project
}

fn any_edit(document: &Document, random: &mut impl Rng, number: u64) -> Edit {
    let project = document.project();
    let layer = project.layers[random.random_range(0..project.layers.len())].clone();
    let index = random.random_range(0..project.operations.len().max(1));
    match random.random_range(0..13) {
        0 => Edit::AddLayer(Layer::new(format!("l{number}"), "New"), random.random_range(0..4)),
        1 if project.layers.len() > 1 => Edit::RemoveLayer(layer.id),
        2 => Edit::MoveLayer(layer.id, random.random_range(0..4)),
        3 => Edit::SetLayer(Layer {
            opacity: random.random(),
            ..layer
        }),
        4 => Edit::DuplicateLayer(layer.id, format!("d{number}")),
        5 => Edit::MergeDown(layer.id),
        6 => {
            let mut hair = project.hair.clone();
            hair.base.known.bleach = random.random();
            Edit::SetHair(hair)
        }
        7 => {
            let environment = Environment::Constant([random.random(); 3]);
            Edit::SetLight(project.light.with_environment(environment))
        }
        8 => Edit::SetHead(random.random::<bool>().then(|| HeadReference {
            path: format!("{number}.obj"),
            extra: serde_json::Map::default(),
        })),
        9 if project.dyes.len() > 2 => Edit::SetDyes(project.dyes[random.random_range(0..2)..].to_vec()),
        10 => Edit::RemoveOperation(index),
        11 if !project.operations.is_empty() => {
            let mut operation = project.operations[index].clone();
            operation.strength = random.random();
            Edit::SetOperation(index, operation)
        }
        _ => {
            let shape = Shape::all().into_iter().next().unwrap();
            Edit::Stroke(Operation::shaped(
                OperationId::Number(number),
                layer.id,
                shape,
                number,
            ))
        }
    }
}

/// After every edit, undo, redo and save, at random, a crash would leave exactly the document.
#[test]
fn every_kind_of_change_is_recovered() {
    let folder = tempfile::tempdir().unwrap();
    let (mut document, _) = document(folder.path());
    let path = document.path().unwrap().to_owned();
    let mut random = random(7);
    let (mut compared, mut done) = (0, 0);
    for number in 1..400 {
        let before = edited(document.project());
        match random.random_range(0..20) {
            0 => {
                let options = SaveOptions {
                    backups: 2,
                    ..SaveOptions::default()
                };
                document.save_with(&path, options, |_| Ok(())).unwrap();
                assert!(document.journal_path().is_none() && !document.is_modified());
                continue;
            }
            1..=4 => done += usize::from(document.undo().is_some()),
            5..=6 => done += usize::from(document.redo().is_some()),
            7..=12 => {
                let layer = document.project().layers[0].id.clone();
                let mut operation = stroke(number, &layer);
                operation.dabs.extend(stroke(number + 3, &layer).dabs);
                document.apply(Edit::Stroke(operation)).unwrap();
            }
            // Some of them are refused, which leaves no trace.
            13 => {
                let edit = any_edit(&document, &mut random, number);
                done += usize::from(document.apply_continuing(edit).is_ok());
            }
            _ => {
                let edit = any_edit(&document, &mut random, number);
                done += usize::from(document.apply(edit).is_ok());
            }
        }
        if document.journal_path().is_none() {
            assert!(before == edited(document.project()));
            continue;
        }
        let recovered = recovered(&document).unwrap();
        assert!(
            edited(&recovered.project) == edited(document.project()),
            "change {number}: another project"
        );
        compared += 1;
    }
    assert!(compared > 250 && done > 100, "{compared} {done}");
    assert!(document.take_journal_problem().is_none());
}

/// A drag counts as one edit however many moments of it were written, also across a save; another drag is another edit.
#[test]
fn a_drag_is_one_edit() {
    let folder = tempfile::tempdir().unwrap();
    let (mut document, _) = document(folder.path());
    let path = document.path().unwrap().to_owned();
    let turn = |document: &mut Document, degrees: f32, continues: bool| {
        let mut light = document.project().light.clone();
        light.rotation_deg = degrees;
        let edit = Edit::SetLight(light);
        let done = if continues {
            document.apply_continuing(edit)
        } else {
            document.apply(edit)
        };
        done.unwrap();
    };
    for step in 0..10 {
        turn(&mut document, 1.0 + step as f32, step > 0);
    }
    let found = recovered(&document).unwrap();
    assert_eq!((found.edits, found.project.light.rotation_deg), (1, 10.0));
    turn(&mut document, 20.0, false);
    assert_eq!(recovered(&document).unwrap().edits, 2);
    assert_eq!(document.history_labels().1, 2);

    document
        .save_with(&path, SaveOptions::default(), |_| Ok(()))
        .unwrap();
    turn(&mut document, 21.0, true);
    turn(&mut document, 22.0, true);
    let found = recovered(&document).unwrap();
    assert_eq!((found.edits, found.project.light.rotation_deg), (1, 22.0));
    assert_eq!(document.history_labels().1, 2, "a save does not part a drag");
}

/// A stroke whose strength is dragged is written without its dabs.
#[test]
fn dabs_are_not_repeated() {
    let folder = tempfile::tempdir().unwrap();
    let (mut document, _) = document(folder.path());
    let mut operation = stroke(1, "paint");
    operation.dabs = vec![operation.dabs[0].clone(); 2000];
    document.apply(Edit::Stroke(operation)).unwrap();
    let length = |document: &Document| fs::metadata(document.journal_path().unwrap()).unwrap().len();
    let before = length(&document);
    let mut changed = document.project().operations[0].clone();
    changed.strength = 0.25;
    document.apply(Edit::SetOperation(0, changed)).unwrap();
    assert!(length(&document) - before < 1000 && before > 50_000);
    assert!(recovered(&document).unwrap().project.operations == document.project().operations);
}

/// A journal that was cut or damaged anywhere yields the edits before the damage, and says that something was dropped.
#[test]
fn torn_and_damaged_journals_keep_what_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let (mut document, _) = document(folder.path());
    let path = document.path().unwrap().to_owned();
    let (mut lengths, mut states) = (Vec::new(), Vec::new());
    for number in 1..=4 {
        document.apply(Edit::Stroke(stroke(number, "paint"))).unwrap();
        lengths.push(fs::metadata(document.journal_path().unwrap()).unwrap().len() as usize);
        states.push(document.project().operations.clone());
    }
    let whole = fs::read(document.journal_path().unwrap()).unwrap();
    let torn = folder.path().join("torn.journal");
    let read = |bytes: &[u8]| -> Option<(Vec<Operation>, u64)> {
        fs::write(&torn, bytes).unwrap();
        match journal::read(&torn).unwrap() {
            Found::Journal(contents) => {
                let recovered = recover::recover(&contents, Some(&path), false).unwrap();
                Some((recovered.project.operations, contents.torn_bytes))
            }
            Found::Empty => None,
            Found::InUse => panic!("nobody writes it"),
        }
    };
    for len in 0..=whole.len() {
        let count = lengths.iter().filter(|whole| **whole <= len).count();
        let Some((operations, torn_bytes)) = read(&whole[..len]) else {
            assert!(len < lengths[0]);
            continue;
        };
        let expected = count.checked_sub(1).map_or(&[][..], |last| &states[last]);
        assert!(operations == expected, "cut at {len}");
        assert!(
            lengths.contains(&len) == (torn_bytes == 0) || count == 0,
            "cut at {len}"
        );
    }

    // One flipped bit anywhere ends the journal before the record that it is in.
    let mut random = random(3);
    for _ in 0..400 {
        let at = random.random_range(0..whole.len());
        let mut damaged = whole.clone();
        damaged[at] ^= 1 << random.random_range(0..8);
        let count = lengths.iter().filter(|whole| **whole <= at).count();
        let operations = read(&damaged).map_or_else(Vec::new, |(operations, _)| operations);
        let expected = count.checked_sub(1).map_or(&[][..], |last| &states[last]);
        assert!(operations == expected, "bit at {at}");
    }
}

/// A disk that fails `failures` times after `good` writes, each time after a part of the line.
struct FailingDisk {
    file: File,
    good: Arc<AtomicUsize>,
    failures: Arc<AtomicUsize>,
}

impl Storage for FailingDisk {
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        if self.good.load(Ordering::Relaxed) > 0 {
            self.good.fetch_sub(1, Ordering::Relaxed);
        } else if self.failures.load(Ordering::Relaxed) > 0 {
            self.failures.fetch_sub(1, Ordering::Relaxed);
            self.file.append(&bytes[..bytes.len() / 2])?;
            return Err(io::ErrorKind::StorageFull.into());
        }
        self.file.append(bytes)
    }

    fn cut(&mut self, len: u64) -> io::Result<()> {
        self.file.cut(len)
    }

    fn syncer(&self) -> io::Result<Box<dyn Fn() -> io::Result<()> + Send>> {
        self.file.syncer()
    }
}

/// What a full disk refused is written once there is space again; until then the person is told once.
#[test]
fn a_full_disk_costs_no_edit_once_there_is_space_again() {
    let folder = tempfile::tempdir().unwrap();
    let (mut document, state) = document(folder.path());
    document.apply(Edit::Stroke(stroke(1, "paint"))).unwrap();
    let path = document.journal_path().unwrap().to_owned();
    let sound_len = fs::metadata(&path).unwrap().len();
    let (good, failures) = (Arc::new(AtomicUsize::new(1)), Arc::new(AtomicUsize::new(3)));
    let disk = FailingDisk {
        file: OpenOptions::new().append(true).open(&path).unwrap(),
        good,
        failures: failures.clone(),
    };
    document.resume_journal(&state, Journal::on(&path, Box::new(disk), sound_len));
    let mut told = Vec::new();
    for number in 2..=6 {
        document.apply(Edit::Stroke(stroke(number, "paint"))).unwrap();
        told.extend(document.take_journal_problem());
        let known = contents(&path).records.len();
        let expected = if failures.load(Ordering::Relaxed) > 0 || number == 5 {
            2
        } else {
            6
        };
        assert_eq!(known, expected, "after stroke {number}");
    }
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(
        told[0].remedy.contains("save the project to another disk"),
        "{}",
        told[0]
    );
    assert!(recovered(&document).unwrap().project.operations == document.project().operations);

    // The real thing, where the system has it: a device that is always full.
    if let Ok(full) = OpenOptions::new().append(true).open("/dev/full") {
        let mut journal = Journal::on(Path::new("/dev/full"), Box::new(full), 0);
        let problem = journal.append(&[Record::Saved("x".into())]).unwrap_err();
        assert!(problem.remedy.contains("free some space"), "{problem}");
    }
}

/// A journal that somebody removes is begun anew, with the whole project.
#[test]
fn a_removed_journal_is_begun_anew() {
    let folder = tempfile::tempdir().unwrap();
    let (mut document, _) = document(folder.path());
    document.apply(Edit::Stroke(stroke(1, "paint"))).unwrap();
    fs::remove_file(document.journal_path().unwrap()).unwrap();
    document.apply(Edit::Stroke(stroke(2, "paint"))).unwrap();
    document.undo().unwrap();
    assert_eq!(
        recovered(&document).unwrap().project.operations,
        document.project().operations
    );
    assert_eq!(document.project().operations.len(), 1);
}

/// A crash at any step of a save leaves all edits, and a crash after its rename leaves nothing to recover.
#[test]
fn a_crash_while_saving_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (mut document, _) = document(folder.path());
    let path = document.path().unwrap().to_owned();
    document.apply(Edit::Stroke(stroke(1, "paint"))).unwrap();
    document.save_as(&path).unwrap();
    document.apply(Edit::Stroke(stroke(2, "paint"))).unwrap();
    let journal = document.journal_path().unwrap().to_owned();
    let expected = document.project().operations.clone();
    let mut needed = Vec::new();
    document
        .save_with(&path, SaveOptions::default(), |step| {
            let recovered = recover::recover(&contents(&journal), Some(&path), false).unwrap();
            assert!(recovered.project.operations == expected, "{step:?}");
            needed.push((step, recovered.is_needed));
            Ok(())
        })
        .unwrap();
    use SaveStep::{Create, Rename, Sync, SyncFolder, Write};
    let all = [
        (Create, true),
        (Write, true),
        (Sync, true),
        (Rename, true),
        (SyncFolder, false),
    ];
    assert_eq!(needed, all);
    assert!(!journal.exists());
}

/// Where the project's file was replaced, its backup is what the journal counts from; without one it is told.
#[test]
fn a_foreign_project_file_is_not_painted_on() {
    let folder = tempfile::tempdir().unwrap();
    let (mut document, _) = document(folder.path());
    let path = document.path().unwrap().to_owned();
    document.apply(Edit::Stroke(stroke(1, "paint"))).unwrap();
    let saved = fs::read(&path).unwrap();
    let text = String::from_utf8(saved.clone()).unwrap();
    let foreign = text.replace(
        "\"version\": 1",
        "\"version\": 1, \"light\": {\"exposure_ev\": 1}",
    );
    assert!(foreign != text);
    fs::write(&path, &foreign).unwrap();
    let problem = recovered(&document).unwrap_err();
    assert!(problem.reason.contains("another program"), "{problem}");
    let contents = contents(document.journal_path().unwrap());
    let anyway = recover::recover(&contents, Some(&path), true).unwrap();
    assert!(anyway.project.light.exposure_ev == 1.0 && anyway.strokes == 1);

    fs::write(backup_path(&path, 2), &saved).unwrap();
    let recovered = recovered(&document).unwrap();
    assert!(recovered.from_backup.is_some() && recovered.project.light.exposure_ev == 0.0);
    assert!(recovered.project.operations == document.project().operations);
}

/// Projects without a file, or in a folder that is gone, keep their journals in the state folder.
#[test]
fn projects_without_a_folder_keep_journals_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    let path = sample(folder.path());
    let state = folder.path().join("state");
    let mut unsaved = Document::open(&folder.path().join("grooms/tuft.hair"), Some(0.01))
        .unwrap()
        .document;
    unsaved.keep_journal(&state);
    for number in 1..=3 {
        unsaved.apply(Edit::Stroke(stroke(number, "paint"))).unwrap();
    }
    assert!(unsaved.journal_path().unwrap().starts_with(&state));
    assert!(recovered(&unsaved).unwrap().project.operations == unsaved.project().operations);
    assert!(recover::journals_of(None, &state).is_empty(), "its writer lives");
    let expected = unsaved.project().clone();
    drop(unsaved);
    let found = recover::journals_of(None, &state);
    let recovered = recover::recover(&found[0], None, false).unwrap();
    assert!(found.len() == 1 && recovered.project == expected);
    let opened = Document::open_project(recovered.project, &found[0].start.folder).unwrap();
    assert_eq!(opened.document.groom().point_count(), 4800);

    let mut document = Document::open(&path, None).unwrap().document;
    document.keep_journal(&state);
    let moved = folder.path().with_extension("moved");
    fs::create_dir(&moved).unwrap();
    let gone = moved.join("project.json");
    document.save_as(&gone).unwrap();
    fs::remove_dir_all(&moved).unwrap();
    document.apply(Edit::Stroke(stroke(1, "paint"))).unwrap();
    assert!(document.journal_path().unwrap().starts_with(&state));
    assert!(document.take_journal_problem().is_none());
    let problem = document.save_as(&gone).unwrap_err();
    assert!(
        problem.remedy.contains("path") && document.is_modified(),
        "{problem}"
    );
}

/// A stroke under way is not in the journal; once it is committed it is.
#[test]
fn live_strokes_are_written_when_they_are_committed() {
    let folder = tempfile::tempdir().unwrap();
    let (mut document, _) = document(folder.path());
    let operation = stroke(1, "paint");
    let dabs: Vec<Dab> = operation.dabs.clone();
    document.begin_stroke(operation.clone()).unwrap();
    document.extend_stroke(dabs.clone()).unwrap();
    document.cancel_stroke();
    assert!(
        document.journal_path().is_none(),
        "what was cancelled leaves no trace"
    );
    document.begin_stroke(operation).unwrap();
    document.extend_stroke(dabs).unwrap();
    assert!(document.journal_path().is_none());
    document.commit_stroke();
    assert_eq!(recovered(&document).unwrap().strokes, 1);
}

/// The same on a real file system that is full: `BALAYAGE_SMALL_DISK` names a folder on one of a few hundred kilobytes
/// (`mount -t tmpfs -o size=512k tmpfs FOLDER`).
#[test]
fn a_small_disk_that_fills_up_loses_nothing() {
    let Some(folder) = std::env::var_os("BALAYAGE_SMALL_DISK").map(PathBuf::from) else {
        return;
    };
    let elsewhere = tempfile::tempdir().unwrap();
    let (mut document, _) = document(&folder);
    let path = document.path().unwrap().to_owned();
    document.save_as(&path).unwrap();
    let saved = fs::read(&path).unwrap();
    fs::write(folder.join("ballast"), vec![1; 64 << 10]).unwrap();
    let problem = (1..)
        .find_map(|number| {
            document.apply(Edit::Stroke(stroke(number, "paint"))).unwrap();
            document.take_journal_problem()
        })
        .unwrap();
    println!("{} strokes, then: {problem}", document.project().operations.len());
    assert!(problem.remedy.contains("free some space"), "{problem}");

    // What was written before is whole; the file is as it was; saving there fails with a reason.
    let journal = document.journal_path().unwrap().to_owned();
    let found = |document: &Document| {
        let copy = elsewhere.path().join("copy.journal");
        fs::copy(&journal, &copy).unwrap();
        let Found::Journal(contents) = journal::read(&copy).unwrap() else {
            panic!("no journal");
        };
        let recovered = recover::recover(&contents, document.path(), false).unwrap();
        (recovered.strokes, contents.torn_bytes)
    };
    let painted = document.project().operations.len();
    assert_eq!(found(&document), (painted - 1, 0));
    let problem = document.save_as(&path).unwrap_err();
    println!("saving: {problem}");
    assert!(problem.remedy.contains("free some space") && document.is_modified());
    assert!(fs::read(&path).unwrap() == saved);

    // With space again the next stroke brings those along that waited, and saving works.
    fs::remove_file(folder.join("ballast")).unwrap();
    document.apply(Edit::Stroke(stroke(1_000_000, "paint"))).unwrap();
    assert_eq!(found(&document), (painted + 1, 0));
    let other = elsewhere.path().join("saved.json");
    document.save_as(&other).unwrap();
    assert!(!document.is_modified() && !journal.exists());
    assert_eq!(
        Document::open(&other, None)
            .unwrap()
            .document
            .project()
            .operations
            .len(),
        painted + 1
    );
}

/// The command line tells of a journal, applies it to another file or in place, and discards it.
#[test]
fn commands_check_recover_and_discard() {
    let folder = tempfile::tempdir().unwrap();
    let (mut document, _) = document(folder.path());
    let path = document.path().unwrap().to_owned();
    for number in 1..=3 {
        document.apply(Edit::Stroke(stroke(number, "paint"))).unwrap();
    }
    let (expected, journal) = (
        document.project().operations.clone(),
        document.journal_path().unwrap().to_owned(),
    );
    let project = path.to_str().unwrap();
    let operations = |path: &Path| {
        let opened = Document::open(path, None).unwrap();
        opened.document.project().operations.clone()
    };

    // While its writer lives nobody else takes the journal.
    let (code, _, err) = balayage(&["recover", project]);
    assert!(code == 1 && err.contains("nothing is left to recover"), "{err}");
    drop(document);
    fs::OpenOptions::new()
        .append(true)
        .open(&journal)
        .and_then(|mut file| file.append(b"77 torn"))
        .unwrap();
    let (code, out, err) = balayage(&["check", project, "--json"]);
    let value: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert!(code == 0 && err.contains("3 edits (3 strokes)"), "{err}");
    assert!(value["journals"][0]["strokes"] == 3 && value["journals"][0]["torn_bytes"] == 7);

    let other = folder.path().join("other.json");
    let (code, out, err) = balayage(&["recover", project, "-o", other.to_str().unwrap()]);
    assert!(code == 0 && out.contains("3 edits recovered"), "{out}{err}");
    assert!(operations(&other) == expected && operations(&path).is_empty() && journal.exists());
    let (code, _, err) = balayage(&["recover", project]);
    assert!(
        code == 0 && operations(&path) == expected && !journal.exists(),
        "{err}"
    );
    assert!(backup_path(&path, 1).exists());

    let mut document = Document::open(&path, None).unwrap().document;
    document.keep_journal(folder.path());
    document.undo();
    document.apply(Edit::RemoveOperation(0)).unwrap();
    let journal = document.journal_path().unwrap().to_owned();
    drop(document);
    let (code, out, _) = balayage(&["recover", journal.to_str().unwrap(), "--discard"]);
    assert!(code == 0 && out.contains("discarded") && !journal.exists());
    assert!(operations(&path) == expected);
}
