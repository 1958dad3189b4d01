//! The editor, driven through its accessibility tree.

#![allow(clippy::unwrap_used, reason = "a helper that fails fails its test")]

mod ui_drop;
mod ui_keys;
mod ui_light;
mod ui_safety;
mod ui_session;
mod ui_tools;

use std::{
    fs,
    path::{Path, PathBuf},
    thread::sleep,
    time::{Duration, Instant},
};

use balayage::{
    document::{Document, UserState},
    ui::Editor,
};
use balayage_render::groom::{Groom, ReadOptions, write_groom};
use egui::{Key, Modifiers, Vec2};
use egui_kittest::{Harness, kittest::Queryable};
use glam::Vec3;

/// The light of [`project`]: one wide light, which is a thirtieth of the work of an even world.
const LIGHT: &str = r#"{"environment": {"lights": "lamp.json"}}"#;

/// A project with a small curtain of hair.
fn project(folder: &Path) -> PathBuf {
    let strands = (0..300).map(|s| {
        let root = Vec3::new(0.01 * (s % 60) as f32, 0.3, 0.01 * (s / 60) as f32);
        (0..10)
            .map(|i| root - Vec3::Y * 0.03 * i as f32)
            .collect::<Vec<_>>()
    });
    let (groom, _) = Groom::from_strands(strands, 0.004, 1.0).unwrap();
    write_groom(folder.join("curtain.hair"), &groom).unwrap();
    let path = folder.join("project.json");
    let lamp = r#"{"lights": [{"direction": [0, 0.6, 0.8], "bandwidth": 1, "radiance": [2, 2, 2]}], "constant": [0, 0, 0]}"#;
    fs::write(folder.join("lamp.json"), lamp).unwrap();
    let text = format!(
        r#"{{"version": 1, "groom": {{"path": "curtain.hair", "metres_per_unit": 1}}, "light": {LIGHT},
        "camera": {{"world_from_camera": [[1,0,0,0.3],[0,1,0,0.15],[0,0,1,1],[0,0,0,1]], "fov_y_deg": 35}}}}"#
    );
    fs::write(&path, text).unwrap();
    path
}

/// The editor with `path` open and its first sharp picture shown.
fn editor(path: &Path) -> Harness<'static, Editor> {
    let mut harness = opening(Some(path), path.parent().unwrap());
    settle(&mut harness, 0);
    harness
}

/// The editor on its way to `path`, with a memory of its own in `folder`.
fn opening(path: Option<&Path>, folder: &Path) -> Harness<'static, Editor> {
    let path = path.map(Path::to_owned);
    let state = UserState::in_folder(folder.join("state"));
    Harness::builder()
        .with_size(Vec2::new(1100.0, 800.0))
        .with_step_dt(1.0 / 60.0)
        .build_eframe(|creation| Editor::with_state(&creation.egui_ctx, path, ReadOptions::default(), state))
}

/// Steps until a sharp picture newer than number `frames` is shown and nothing is under way.
fn settle(harness: &mut Harness<'_, Editor>, frames: u64) {
    let start = Instant::now();
    loop {
        harness.step();
        let editor = harness.state();
        if !editor.is_busy() && editor.frames_shown() > frames && editor.is_draft() == Some(false) {
            return;
        }
        assert!(
            start.elapsed() < Duration::from_secs(240),
            "no picture: {:?}",
            editor.last_message()
        );
        sleep(Duration::from_millis(20));
    }
}

/// Drags over the middle of the viewport in `steps` moves.
fn drag(harness: &mut Harness<'_, Editor>, from: Vec2, to: Vec2, steps: usize) {
    let middle = harness.get_by_label("Viewport").rect().center();
    harness.hover_at(middle + from);
    harness.step();
    harness.drag_at(middle + from);
    harness.step();
    for i in 1..=steps {
        harness.hover_at(middle + from + (to - from) * (i as f32 / steps as f32));
        harness.step();
    }
    harness.drop_at(middle + to);
    harness.step();
}

fn document<'a>(harness: &'a Harness<'_, Editor>) -> &'a Document {
    harness.state().document().unwrap()
}

fn bits(harness: &Harness<'_, Editor>) -> Vec<u32> {
    bytemuck::cast_slice(document(harness).params()).to_vec()
}

/// What the viewport shows, the pointer elsewhere.
fn picture(harness: &mut Harness<'_, Editor>) -> Vec<u8> {
    harness.hover_at(egui::pos2(2.0, 2.0));
    harness.step();
    harness.step();
    let viewport = harness.get_by_label("Viewport").rect();
    let window = harness.render().unwrap();
    let [x, y, width, height] = [
        viewport.left(),
        viewport.top(),
        viewport.width(),
        viewport.height(),
    ];
    image::imageops::crop_imm(&window, x as u32, y as u32, width as u32, height as u32)
        .to_image()
        .into_raw()
}

/// Open, paint by a drag, undo bit for bit, redo, save, reopen: the same document, the same picture.
#[test]
fn a_session_paints_undoes_saves_and_reopens() {
    let folder = tempfile::tempdir().unwrap();
    let path = project(folder.path());
    let mut harness = editor(&path);
    let clean = bits(&harness);
    let clean_picture = picture(&mut harness);
    assert!(harness.query_by_label("Layers").is_some());

    let frames = harness.state().frames_shown();
    drag(&mut harness, Vec2::new(-80.0, 0.0), Vec2::new(80.0, 10.0), 6);
    let painted = bits(&harness);
    assert!(painted != clean, "{:?}", harness.state().last_message());
    assert_eq!(document(&harness).project().operations.len(), 1);
    assert!(document(&harness).project().operations[0].dabs.len() > 3);
    settle(&mut harness, frames);

    // Undo and redo by key; the buffers come back bit for bit.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.step();
    assert!(bits(&harness) == clean);
    assert_eq!(harness.state().last_message(), Some("Undone: Paint dye"));
    let frames = harness.state().frames_shown();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Y);
    harness.step();
    assert!(bits(&harness) == painted);
    settle(&mut harness, frames);
    let painted_picture = picture(&mut harness);
    assert!(painted_picture != clean_picture);

    // Save by key; what is opened again is the same document.
    assert!(document(&harness).is_modified());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    harness.step();
    assert!(
        !document(&harness).is_modified(),
        "{:?}",
        harness.state().last_message()
    );
    let saved = document(&harness).project().clone();
    drop(harness);
    let mut harness = editor(&path);
    assert_eq!(*document(&harness).project(), saved);
    assert!(bits(&harness) == painted);
    assert!(
        picture(&mut harness) == painted_picture,
        "another picture after reopening"
    );

    // Replay without a window gives the same bits.
    let replayed = Document::open(&path, None).unwrap().document;
    assert!(bytemuck::cast_slice::<_, u32>(replayed.params()) == painted);
}

/// Esc drops the stroke under way; leaving with unsaved changes is asked about.
#[test]
fn escape_cancels_and_unsaved_changes_are_guarded() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = editor(&project(folder.path()));
    let clean = bits(&harness);
    let middle = harness.get_by_label("Viewport").rect().center();
    harness.hover_at(middle);
    harness.step();
    harness.drag_at(middle);
    harness.step();
    harness.hover_at(middle + Vec2::new(30.0, 0.0));
    harness.step();
    assert!(bits(&harness) != clean);
    harness.key_press(Key::Escape);
    harness.step();
    assert!(bits(&harness) == clean);
    harness.drop_at(middle);
    harness.step();
    assert!(document(&harness).undo_label().is_none());

    harness.get_by_label("Add layer").click();
    harness.step();
    harness.step();
    assert_eq!(document(&harness).project().layers.len(), 2);
    assert!(document(&harness).is_modified());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Q);
    harness.step();
    harness.step();
    assert!(harness.query_by_label("Unsaved changes").is_some());
    harness.get_by_label("Cancel").click();
    harness.step();
    harness.step();
    assert!(harness.query_by_label("Unsaved changes").is_none());
    assert!(document(&harness).is_modified());
}

/// Every control of the docks has a name in the accessibility tree.
#[test]
fn controls_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = editor(&ui_light::lit(folder.path(), ui_light::EVEN));
    for name in [
        "Viewport",
        "Paint",
        "Erase",
        "Smooth",
        "Eyedropper",
        "Undo",
        "Redo",
        "Channel",
        "Mode",
        "Dye colour",
        "Radius",
        "Strength",
        "Hardness",
        "Falloff",
        "Depth",
        "Terms",
    ] {
        assert!(harness.query_all_by_label(name).next().is_some(), "{name}");
    }
    // The first one is the menu.
    harness.get_all_by_label("Hair").last().unwrap().click();
    harness.step();
    harness.step();
    for name in [
        "Roughness",
        "Tilt",
        "Index",
        "Eccentricity",
        "Diameter",
        "Pigments",
    ] {
        assert!(harness.query_all_by_label(name).next().is_some(), "{name}");
    }
    harness.get_all_by_label("Light").last().unwrap().click();
    harness.step();
    harness.step();
    for name in [
        "Environment",
        "Radiance",
        "Rotation",
        "Exposure",
        "Tint",
        "Lights",
        "Light handles",
        "Light map",
        "Add light",
        "Delete light",
        "Reset light",
    ] {
        assert!(harness.query_all_by_label(name).next().is_some(), "{name}");
    }
}
