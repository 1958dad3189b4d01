//! The editor when something goes wrong: the device, the process before, the file under it.

use std::{
    fs,
    path::Path,
    thread::sleep,
    time::{Duration, Instant},
};

use balayage::{
    document::{Document, Edit, Layer},
    ui::Editor,
};
use egui::{Key, Modifiers, Vec2};
use egui_kittest::{Harness, kittest::Queryable};

use super::{bits, document, drag, editor, opening, picture, project, settle};

/// Steps until a control of that name is there.
fn wait_for(harness: &mut Harness<'_, Editor>, label: &str) {
    let start = Instant::now();
    while harness.query_by_label(label).is_none() {
        harness.step();
        assert!(
            start.elapsed() < Duration::from_secs(60),
            "no {label}: {:?}",
            harness.state().last_message()
        );
        sleep(Duration::from_millis(10));
    }
}

fn click(harness: &mut Harness<'_, Editor>, label: &str) {
    harness.get_by_label(label).click();
    harness.step();
    harness.step();
}

/// What a session leaves that dies after adding a layer to `path`.
fn dead_session(path: &Path, state: &Path) {
    let mut document = Document::open(path, None).unwrap().document;
    document.keep_journal(state);
    let id = format!("left-{}", document.project().layers.len());
    document
        .apply(Edit::AddLayer(Layer::new(id, "Left behind"), 9))
        .unwrap();
}

fn layers(harness: &Harness<'_, Editor>) -> usize {
    document(harness).project().layers.len()
}

/// The device goes while a painted picture is shown: document and picture stay, and painting goes on.
#[test]
fn a_lost_device_costs_a_frame() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = editor(&project(folder.path()));
    let frames = harness.state().frames_shown();
    drag(&mut harness, Vec2::new(-80.0, 0.0), Vec2::new(80.0, 10.0), 4);
    settle(&mut harness, frames);
    let (painted, shown) = (bits(&harness), picture(&mut harness));

    let frames = harness.state().frames_shown();
    harness.state_mut().destroy_device();
    settle(&mut harness, frames);
    let message = harness.state().last_message().unwrap();
    assert!(message.contains("the document is safe"), "{message}");
    assert!(bits(&harness) == painted && document(&harness).is_modified());
    assert!(
        picture(&mut harness) == shown,
        "another picture on the new device"
    );

    // Twice, and in the middle of a stroke.
    let frames = harness.state().frames_shown();
    harness.state_mut().destroy_device();
    drag(&mut harness, Vec2::new(-80.0, 40.0), Vec2::new(80.0, 50.0), 4);
    settle(&mut harness, frames);
    assert!(bits(&harness) != painted);
    assert_eq!(document(&harness).project().operations.len(), 2);
    assert!(picture(&mut harness) != shown);
}

#[test]
fn recovery_is_offered_at_the_next_start() {
    let folder = tempfile::tempdir().unwrap();
    let path = project(folder.path());
    let state = folder.path().join("state");
    dead_session(&path, &state);

    // Kept for later, the project opens as it was saved; the question comes again.
    let mut harness = opening(Some(&path), folder.path());
    wait_for(&mut harness, "Work that was not saved");
    click(&mut harness, "Keep for later");
    settle(&mut harness, 0);
    assert_eq!(layers(&harness), 1);
    drop(harness);

    let mut harness = opening(Some(&path), folder.path());
    wait_for(&mut harness, "Recover");
    click(&mut harness, "Recover");
    settle(&mut harness, 0);
    assert!(layers(&harness) == 2 && document(&harness).is_modified());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    harness.step();
    assert!(
        !document(&harness).is_modified(),
        "{:?}",
        harness.state().last_message()
    );
    drop(harness);
    let names: Vec<_> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".journal"))
        .collect();
    assert!(names.is_empty(), "{names:?}");

    // Discarded, it is gone.
    dead_session(&path, &state);
    let mut harness = opening(Some(&path), folder.path());
    wait_for(&mut harness, "Discard");
    click(&mut harness, "Discard");
    settle(&mut harness, 0);
    assert!(layers(&harness) == 2 && !document(&harness).is_modified());
}

#[test]
fn a_file_that_changed_under_the_editor_is_asked_about() {
    let folder = tempfile::tempdir().unwrap();
    let path = project(folder.path());
    let mut harness = editor(&path);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    harness.step();
    let ours = fs::read_to_string(&path).unwrap();
    click(&mut harness, "Add layer");
    let theirs = ours.replace("\"exposure_ev\": 0.0", "\"exposure_ev\": 1.0");
    assert!(theirs != ours);
    fs::write(&path, &theirs).unwrap();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    harness.step();
    wait_for(&mut harness, "The file has changed");
    click(&mut harness, "Cancel");
    assert!(fs::read_to_string(&path).unwrap() == theirs && document(&harness).is_modified());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    harness.step();
    wait_for(&mut harness, "Overwrite");
    click(&mut harness, "Overwrite");
    assert!(
        !document(&harness).is_modified(),
        "{:?}",
        harness.state().last_message()
    );
    let backup = balayage::document::backup_path(&path, 1);
    assert!(fs::read_to_string(backup).unwrap() == theirs);
}

/// A second editor on the project is offered a copy; a project that reads files elsewhere is asked about.
#[test]
fn second_editors_and_foreign_files_are_asked_about() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("inside");
    fs::create_dir(&inside).unwrap();
    let path = project(&inside);
    let mut lock = path.clone().into_os_string();
    lock.push(".lock");
    fs::write(&lock, r#"{"pid": 5, "host": "another", "since": 0}"#).unwrap();
    fs::rename(inside.join("curtain.hair"), folder.path().join("curtain.hair")).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replace("curtain.hair", "../curtain.hair")).unwrap();

    let mut harness = opening(Some(&path), folder.path());
    wait_for(&mut harness, "The project is open elsewhere");
    click(&mut harness, "Open a copy");
    wait_for(&mut harness, "Files outside the project's folder");
    click(&mut harness, "Read them");
    settle(&mut harness, 0);
    assert!(document(&harness).path().is_none());
    drop(harness);

    // The folder is remembered; what is missing is asked for.
    fs::remove_file(&lock).unwrap();
    fs::remove_file(folder.path().join("curtain.hair")).unwrap();
    let mut harness = opening(Some(&path), folder.path());
    wait_for(&mut harness, "Find groom…");
    assert!(harness.query_by_label("Open without").is_none());
}
