//! Files dropped on the window: grooms and projects are opened, maps light what is open.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};

use balayage::{
    document::Environment,
    ui::{Command, Editor},
};
use egui_kittest::{Harness, kittest::Queryable};

use super::{document, editor, opening, project};

/// A file as the window's system hands it over.
#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        fs::read(&self.0).map_err(|error| error.to_string())
    }
}

/// Drops files and waits until nothing is under way.
fn drop_files(harness: &mut Harness<'_, Editor>, files: &[&Path]) {
    for file in files {
        let dropped = Arc::new(Dropped((*file).to_owned()));
        harness.input_mut().dropped_files.push(dropped);
    }
    let start = Instant::now();
    harness.step();
    harness.step();
    while harness.state().is_busy() {
        harness.step();
        assert!(start.elapsed() < Duration::from_secs(60));
    }
    harness.step();
}

fn environment(harness: &Harness<'_, Editor>) -> Environment {
    document(harness).project().light.environment.clone()
}

/// A Radiance map of 4 x 2 grey pixels.
fn write_map(path: &Path) {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec();
    bytes.extend([100, 110, 120, 128].repeat(8));
    fs::write(path, bytes).unwrap();
}

/// One map becomes the environment, several and a folder a sequence, each one undo entry; what is no map leaves the light alone.
#[test]
fn dropped_maps_light_the_hair() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = editor(&project(folder.path()));
    let before = environment(&harness);
    let maps = folder.path().join("maps");
    fs::create_dir(&maps).unwrap();
    let [a, b] = ["a.hdr", "b.HDR"].map(|name| maps.join(name));
    write_map(&a);
    write_map(&b);

    drop_files(&mut harness, &[&a]);
    assert_eq!(environment(&harness), Environment::Map("maps/a.hdr".to_owned()));
    for files in [vec![a.as_path(), b.as_path()], vec![maps.as_path()]] {
        drop_files(&mut harness, &files);
        let Environment::Sequence(sequence) = environment(&harness) else {
            panic!(
                "{:?}: {:?}",
                environment(&harness),
                harness.state().last_message()
            );
        };
        assert_eq!(sequence.maps, ["maps/a.hdr", "maps/b.HDR"]);
        let context = harness.ctx.clone();
        harness.state_mut().run(&context, Command::Undo);
        assert_eq!(environment(&harness), Environment::Map("maps/a.hdr".to_owned()));
    }
    let context = harness.ctx.clone();
    harness.state_mut().run(&context, Command::Undo);
    assert_eq!(environment(&harness), before);

    let notes = folder.path().join("notes.txt");
    fs::write(&notes, "no hair").unwrap();
    drop_files(&mut harness, &[&notes]);
    assert!(harness.state().last_message().unwrap().contains("notes.txt"));
    assert_eq!(environment(&harness), before);
}

/// A groom and a project are opened; changes that are not saved are asked about first.
#[test]
fn dropped_grooms_and_projects_are_opened() {
    let folder = tempfile::tempdir().unwrap();
    let path = project(folder.path());
    let mut harness = opening(None, folder.path());
    drop_files(&mut harness, &[]);
    let sample = document(&harness).groom().strand_count();
    drop_files(&mut harness, &[&folder.path().join("curtain.hair")]);
    assert_eq!(document(&harness).groom().strand_count(), 300);
    assert!(sample != 300 && document(&harness).path().is_none());

    // A map changes the document: now a project has to wait for an answer.
    let map = folder.path().join("sky.hdr");
    write_map(&map);
    drop_files(&mut harness, &[&map]);
    assert!(document(&harness).is_modified());
    drop_files(&mut harness, &[&path]);
    assert!(document(&harness).path().is_none());
    harness.get_by_label("Discard").click();
    drop_files(&mut harness, &[]);
    assert_eq!(document(&harness).path(), Some(path.as_path()));
}
