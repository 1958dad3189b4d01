//! Saving: backups, files that others have changed, failing disks, projects that are open twice.

use std::{fs, io, path::Path};

use balayage::document::{
    Answers, Document, Edit, JournalAnswer, LockAnswer, LockError, OpenStep, ProjectLock, Question,
    SaveOptions, Source, UserState, backup_path, files::SaveStep, open_step,
};

use crate::{journal::stroke, project::sample};

const BACKED_UP: SaveOptions = SaveOptions {
    backups: 3,
    overwrites_changes: false,
};

fn exposure(path: &Path) -> f32 {
    let text = fs::read_to_string(path).unwrap();
    balayage::document::Project::parse(&text)
        .unwrap()
        .light
        .exposure_ev
}

fn set_exposure(document: &mut Document, exposure_ev: f32) {
    let mut light = document.project().light.clone();
    light.exposure_ev = exposure_ev;
    document.apply(Edit::SetLight(light)).unwrap();
}

#[test]
fn backups_are_the_versions_before() {
    let folder = tempfile::tempdir().unwrap();
    let path = sample(folder.path());
    let mut document = Document::open(&path, None).unwrap().document;
    for version in 1..=5 {
        set_exposure(&mut document, version as f32);
        let saved = document.save_with(&path, BACKED_UP, |_| Ok(())).unwrap();
        assert!(saved.warnings.is_empty(), "{saved:?}");
    }
    assert_eq!(exposure(&path), 5.0);
    for age in 1..=3 {
        assert_eq!(exposure(&backup_path(&path, age)), 5.0 - age as f32);
    }
    assert!(!backup_path(&path, 4).exists() && !backup_path(&path, 0).exists());

    // Saves that fail at the rename leave one backup of the version that stays, however often they are tried.
    set_exposure(&mut document, 6.0);
    for _ in 0..4 {
        let refuse = |step| match step {
            SaveStep::Rename => Err(io::Error::from(io::ErrorKind::PermissionDenied)),
            _ => Ok(()),
        };
        let problem = document.save_with(&path, BACKED_UP, refuse).unwrap_err();
        assert!(problem.remedy.contains("permissions"), "{problem}");
    }
    assert_eq!((exposure(&path), exposure(&backup_path(&path, 3))), (5.0, 3.0));
}

#[test]
fn a_failed_save_keeps_file_document_and_journal() {
    let folder = tempfile::tempdir().unwrap();
    let path = sample(folder.path());
    let mut document = Document::open(&path, None).unwrap().document;
    document.keep_journal(&folder.path().join("state"));
    document.apply(Edit::Stroke(stroke(1, "paint"))).unwrap();
    let old = fs::read(&path).unwrap();
    let causes = [
        (io::ErrorKind::StorageFull, "space"),
        (io::ErrorKind::ReadOnlyFilesystem, "can be written"),
        (io::ErrorKind::PermissionDenied, "permissions"),
        (io::ErrorKind::StaleNetworkFileHandle, "reconnect"),
    ];
    for (cause, remedy) in causes {
        for failing in [
            SaveStep::Create,
            SaveStep::Write,
            SaveStep::Sync,
            SaveStep::Rename,
        ] {
            let refuse = |step| {
                if step == failing {
                    Err(cause.into())
                } else {
                    Ok(())
                }
            };
            let problem = document.save_with(&path, BACKED_UP, refuse).unwrap_err();
            assert!(problem.remedy.contains(remedy), "{problem}");
            assert!(fs::read(&path).unwrap() == old, "{failing:?}");
            assert!(document.is_modified() && document.journal_path().unwrap().exists());
        }
    }

    // When only the last sync fails the new file is in place, the person is told, and saving again is no conflict.
    let refuse = |step| match step {
        SaveStep::SyncFolder => Err(io::Error::other("no")),
        _ => Ok(()),
    };
    assert!(document.save_with(&path, BACKED_UP, refuse).is_err());
    assert!(document.is_modified() && document.journal_path().is_some());
    document.save_with(&path, BACKED_UP, |_| Ok(())).unwrap();
    assert!(!document.is_modified() && document.journal_path().is_none());
}

#[test]
fn a_file_that_another_program_changed_is_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let path = sample(folder.path());
    let mut document = Document::open(&path, None).unwrap().document;
    set_exposure(&mut document, 1.0);
    let text = fs::read_to_string(&path).unwrap();
    let theirs = text.replace(
        "\"version\": 1",
        "\"version\": 1, \"light\": {\"exposure_ev\": 9}",
    );
    fs::write(&path, &theirs).unwrap();
    assert!(document.is_changed_on_disk(&path));
    let problem = document.save_with(&path, BACKED_UP, |_| Ok(())).unwrap_err();
    assert!(problem.reason.contains("another program"), "{problem}");
    assert!(fs::read_to_string(&path).unwrap() == theirs && document.is_modified());

    // Under another name there is no conflict; neither is there with the file's own content or without the file.
    let other = folder.path().join("other.json");
    assert!(!document.is_changed_on_disk(&other));
    fs::write(&path, &text).unwrap();
    assert!(!document.is_changed_on_disk(&path));
    fs::remove_file(&path).unwrap();
    assert!(!document.is_changed_on_disk(&path));

    fs::write(&path, &theirs).unwrap();
    let options = SaveOptions {
        overwrites_changes: true,
        ..BACKED_UP
    };
    document.save_with(&path, options, |_| Ok(())).unwrap();
    assert_eq!((exposure(&path), exposure(&backup_path(&path, 1))), (1.0, 9.0));
}

fn lock_file(path: &Path) -> std::path::PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".lock");
    name.into()
}

#[test]
fn two_cannot_hold_one_project() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.json");
    let lock = ProjectLock::take(&path, false).unwrap();
    for force in [false, true] {
        match ProjectLock::take(&path, force).unwrap_err() {
            LockError::Held { holder, may_be_stale } => {
                assert!(holder.is_this_process() && !may_be_stale);
            }
            other => panic!("{other}"),
        }
    }
    assert!(ProjectLock::holder(&path).is_some());
    drop(lock);
    assert!(!lock_file(&path).exists() && ProjectLock::holder(&path).is_none());

    // A program that died on this computer leaves a file that nobody holds; another computer's may still be held.
    let lock = ProjectLock::take(&path, false).unwrap();
    let text = fs::read_to_string(lock_file(&path)).unwrap();
    drop(lock);
    let dead = text.replace(&format!("\"pid\":{}", std::process::id()), "\"pid\":999999");
    assert!(dead != text);
    fs::write(lock_file(&path), &dead).unwrap();
    assert!(ProjectLock::holder(&path).is_none());
    drop(ProjectLock::take(&path, false).unwrap());
    let elsewhere = r#"{"pid": 5, "host": "another", "since": 0}"#;
    fs::write(lock_file(&path), elsewhere).unwrap();
    match ProjectLock::take(&path, false).unwrap_err() {
        LockError::Held { holder, may_be_stale } => {
            assert!(
                may_be_stale && holder.to_string().contains("process 5 on another"),
                "{holder}"
            );
        }
        other => panic!("{other}"),
    }
    drop(ProjectLock::take(&path, true).unwrap());
    assert!(!lock_file(&path).exists());
    let nowhere = ProjectLock::take(&folder.path().join("gone/p.json"), false);
    assert!(matches!(nowhere, Err(LockError::Impossible(_))));
}

#[test]
fn opening_asks_about_locks_and_journals() {
    let folder = tempfile::tempdir().unwrap();
    let path = sample(folder.path());
    let source = Source::File(path.clone());
    let state = UserState::in_folder(folder.path().join("state"));
    let step = |answers: &Answers| open_step(&source, answers, &state).unwrap();
    let opened = |step: OpenStep| match step {
        OpenStep::Opened(opened) => opened.document,
        OpenStep::Ask(question) => panic!("{question:?}"),
    };

    // Somebody on another computer has it: a copy has no file of its own, taking over has.
    let elsewhere = r#"{"pid": 5, "host": "another", "since": 0}"#;
    fs::write(lock_file(&path), elsewhere).unwrap();
    let asked = step(&Answers::default());
    assert!(matches!(
        asked,
        OpenStep::Ask(Question::Locked {
            may_be_stale: true,
            ..
        })
    ));
    let answer = |lock| Answers {
        lock: Some(lock),
        ..Answers::default()
    };
    let copy = opened(step(&answer(LockAnswer::Copy)));
    assert!(copy.path().is_none() && copy.groom().point_count() == 4800);
    assert_eq!(fs::read_to_string(lock_file(&path)).unwrap(), elsewhere);
    let mut document = opened(step(&answer(LockAnswer::TakeOver)));
    assert!(ProjectLock::holder(&path).unwrap().is_this_process());

    // It is painted and dies: the next one is asked, and may wait.
    document.apply(Edit::Stroke(stroke(1, "paint"))).unwrap();
    let expected = document.project().operations.clone();
    drop(document);
    assert!(!lock_file(&path).exists());
    let OpenStep::Ask(Question::Recover(summary)) = step(&Answers::default()) else {
        panic!("not asked");
    };
    assert_eq!(summary.content, Ok((1, 1)));
    let answer = |journal| Answers {
        journal: Some(journal),
        ..Answers::default()
    };
    let mut later = opened(step(&answer(JournalAnswer::Later)));
    assert!(later.project().operations.is_empty() && !later.is_modified());
    later.apply(Edit::Stroke(stroke(7, "paint"))).unwrap();
    assert_ne!(later.journal_path(), Some(summary.journal.as_path()));
    later.discard_journal().unwrap();
    drop(later);

    // Recovered, it goes on in the same journal until it is saved.
    let mut document = opened(step(&answer(JournalAnswer::Recover(summary.journal.clone()))));
    assert!(document.project().operations == expected && document.is_modified());
    assert_eq!(document.journal_path(), Some(summary.journal.as_path()));
    document.apply(Edit::Stroke(stroke(2, "paint"))).unwrap();
    drop(document);
    let OpenStep::Ask(Question::Recover(summary)) = step(&Answers::default()) else {
        panic!("not asked again");
    };
    assert_eq!(summary.content, Ok((2, 2)));
    let mut document = opened(step(&answer(JournalAnswer::Recover(summary.journal.clone()))));
    document.save_with(&path, BACKED_UP, |_| Ok(())).unwrap();
    assert!(!summary.journal.exists());
    drop(document);
    assert_eq!(opened(step(&Answers::default())).project().operations.len(), 2);
}

/// A million painted points, by salon operations and 20,000 dabs: how long saving and loading take and how large the file is.
/// `BALAYAGE_MILLION` names the folder that groom and project are written to; without it nothing is done.
#[test]
fn a_million_painted_points_are_saved_and_loaded() {
    let Some(folder) = std::env::var_os("BALAYAGE_MILLION").map(std::path::PathBuf::from) else {
        return;
    };
    let strands = (0..50_000).map(|s| {
        let root = glam::Vec3::new(0.001 * (s % 250) as f32, 0.0, 0.001 * (s / 250) as f32);
        (0..20)
            .map(|i| root + glam::Vec3::Y * 0.01 * i as f32)
            .collect::<Vec<_>>()
    });
    let (groom, _) = balayage_render::groom::Groom::from_strands(strands, 0.0001, 1.0).unwrap();
    balayage_render::groom::write_groom(folder.join("million.hair"), &groom).unwrap();
    let mut document = Document::open(&folder.join("million.hair"), None)
        .unwrap()
        .document;
    document.keep_journal(&folder.join("state"));
    let before = document.params().to_vec();
    let (mut random, mut slowest) = (balayage_tests::random(1), 0.0_f64);
    for number in 1..=200 {
        let mut operation = stroke(number, "paint");
        operation.radius_m = 0.012;
        let dab = operation.dabs[0].clone();
        operation.dabs = (0..100)
            .map(|_| {
                use rand::Rng;
                let s = random.random_range(0..50_000);
                let root = glam::Vec3::new(0.001 * (s % 250) as f32, 0.0, 0.001 * (s / 250) as f32);
                let arc: f32 = random.random();
                balayage::paint::Dab {
                    root: root.into(),
                    arc,
                    position: (root + glam::Vec3::Y * 0.19 * arc).into(),
                    ..dab.clone()
                }
            })
            .collect();
        document.begin_stroke(operation.clone()).unwrap();
        document.extend_stroke(operation.dabs).unwrap();
        let start = std::time::Instant::now();
        document.commit_stroke();
        slowest = slowest.max(start.elapsed().as_secs_f64());
    }
    let painted = before
        .iter()
        .zip(document.params())
        .filter(|(a, b)| a != b)
        .count();
    let journal = fs::metadata(document.journal_path().unwrap()).unwrap().len();
    let path = folder.join("million.json");
    let start = std::time::Instant::now();
    document.save_with(&path, BACKED_UP, |_| Ok(())).unwrap();
    let saved = start.elapsed().as_secs_f64();
    let start = std::time::Instant::now();
    let opened = Document::open(&path, None).unwrap().document;
    let loaded = start.elapsed().as_secs_f64();
    assert!(opened.params() == document.params());
    println!(
        "{painted} of {} points painted by 200 strokes with 20,000 dabs: saved in {saved:.3} s, loaded in {loaded:.3} s \
         (groom read and strokes replayed), {} bytes; journal {journal} bytes, slowest commit {:.1} ms",
        before.len(),
        fs::metadata(&path).unwrap().len(),
        slowest * 1e3,
    );

    // The worst that a person could store: a dab for each point.
    let mut operation = stroke(1, "paint");
    let dab = operation.dabs[0].clone();
    operation.dabs = groom
        .positions()
        .iter()
        .map(|position| balayage::paint::Dab {
            position: (*position).into(),
            ..dab.clone()
        })
        .collect();
    let path = folder.join("dabs.json");
    let mut project = document.project().clone();
    project.operations = vec![operation];
    let start = std::time::Instant::now();
    let text = balayage::document::json::to_text(&project).unwrap();
    balayage::document::files::write_atomic(&path, text.as_bytes()).unwrap();
    let saved = start.elapsed().as_secs_f64();
    let start = std::time::Instant::now();
    let text = balayage::document::files::read_text(&path, 1 << 30).unwrap();
    let parsed = balayage::document::Project::parse(&text).unwrap();
    let loaded = start.elapsed().as_secs_f64();
    assert!(parsed.operations == project.operations);
    println!(
        "1,000,000 dabs: written in {saved:.3} s, read and checked in {loaded:.3} s, {} bytes",
        text.len()
    );
}
