//! What surrounds the brush: palette and keys, comparison, turntable, settings, layers that are dragged, files that are dropped.

use balayage::ui::{Command, Editor, keymap, settings::Settings};
use egui::{Key, Modifiers, Vec2};
use egui_kittest::{Harness, kittest::Queryable};

use super::{bits, document, drag, editor, picture, project, settle};

fn press(harness: &mut Harness<'_, Editor>, modifiers: Modifiers, key: Key) {
    harness.key_press_modifiers(modifiers, key);
    harness.step();
    harness.step();
}

fn click(harness: &mut Harness<'_, Editor>, label: &str) {
    let found = harness.get_all_by_label(label).last();
    found.unwrap_or_else(|| panic!("no {label}")).click_accesskit();
    harness.step();
    harness.step();
}

fn type_text(harness: &mut Harness<'_, Editor>, text: &str) {
    harness.event(egui::Event::Text(text.to_owned()));
    harness.step();
    harness.step();
}

fn shows(harness: &Harness<'_, Editor>, label: &str) -> bool {
    harness.query_all_by_label(label).next().is_some()
}

/// Commands are found and run by typing; keys are changed, taken from others only where the person says so, and kept.
#[test]
fn the_palette_finds_commands_and_changes_keys() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("state/settings.json");
    let mut harness = editor(&project(folder.path()));
    harness.state_mut().use_settings_of_user();
    harness.step();
    harness.step();
    harness.step();
    assert!(shows(&harness, "First steps"), "a first start has hints");
    click(&mut harness, "Got it");
    assert!(!shows(&harness, "First steps"));

    press(&mut harness, Modifiers::NONE, Key::F3);
    for command in [Command::Save, Command::Turntable, Command::Palette] {
        assert!(
            shows(&harness, &format!("Keys of {}", command.label())),
            "{command:?}"
        );
    }
    type_text(&mut harness, "layer add");
    assert!(!shows(&harness, "Keys of Save"));
    press(&mut harness, Modifiers::NONE, Key::Enter);
    assert_eq!(document(&harness).project().layers.len(), 2);
    assert!(
        !shows(&harness, "Search commands"),
        "running a command closes the list"
    );

    // Ctrl+S belongs to Save: that is said, and only a second word takes it.
    press(&mut harness, Modifiers::COMMAND | Modifiers::SHIFT, Key::P);
    click(&mut harness, "Keys of Add layer");
    press(&mut harness, Modifiers::COMMAND, Key::S);
    assert!(shows(&harness, "Ctrl+S are the keys of Save."));
    assert!(
        document(&harness).is_modified(),
        "keys that are asked for do nothing else"
    );
    let before = harness.state().settings_values().keys.clone();
    assert!(before.is_empty());
    click(&mut harness, "Give them to Add layer");
    assert_eq!(harness.state().last_message(), Some("Save has no keys now"));
    press(&mut harness, Modifiers::NONE, Key::Escape);
    assert!(!shows(&harness, "Search commands"));
    press(&mut harness, Modifiers::COMMAND, Key::S);
    assert_eq!(document(&harness).project().layers.len(), 3);

    // The next start knows it; one click puts the preset back.
    let kept = Settings::read(&file).unwrap();
    assert_eq!(kept.values().keys["add_layer"], ["Ctrl+S"]);
    assert!(kept.values().keys["save"].is_empty() && kept.values().hints_read);
    press(&mut harness, Modifiers::NONE, Key::F3);
    click(&mut harness, "Blender");
    click(&mut harness, "Reset keys");
    press(&mut harness, Modifiers::NONE, Key::Escape);
    assert!(Settings::read(&file).unwrap().values().keys.is_empty());
    press(&mut harness, Modifiers::NONE, Key::S);
    press(&mut harness, Modifiers::COMMAND, Key::S);
    assert!(!document(&harness).is_modified());
    assert!(keymap::parse("Ctrl+S").is_some());
}

/// A snapshot stands left of a line that is dragged and moved by keys; the right side is the present.
#[test]
fn looks_are_compared_side_by_side() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = editor(&project(folder.path()));
    press(&mut harness, Modifiers::COMMAND | Modifiers::SHIFT, Key::B);
    assert_eq!(harness.state().last_message(), Some("Took snapshot 1"));
    let before = picture(&mut harness);
    let frames = harness.state().frames_shown();
    drag(&mut harness, Vec2::new(-120.0, 0.0), Vec2::new(120.0, 0.0), 8);
    settle(&mut harness, frames);
    let painted = bits(&harness);
    let after = picture(&mut harness);
    assert!(after != before);

    press(&mut harness, Modifiers::COMMAND, Key::B);
    assert!(shows(&harness, "Before and after"));
    let start = std::time::Instant::now();
    let width = harness.get_by_label("Viewport").rect().width() as usize;
    let different = |a: &[u8], b: &[u8], columns: std::ops::Range<usize>| {
        let pixels = a.chunks(4).zip(b.chunks(4)).enumerate();
        pixels
            .filter(|(i, (a, b))| columns.contains(&(i % width)) && a != b)
            .count()
    };
    // The left side comes from a thread of its own.
    let compared = loop {
        let compared = picture(&mut harness);
        let rest = 40 * width;
        if different(&compared[4 * rest..], &before[4 * rest..], 0..width / 2 - 10) == 0 {
            break compared;
        }
        assert!(
            start.elapsed().as_secs() < 120,
            "the left side never was the snapshot"
        );
        std::thread::sleep(std::time::Duration::from_millis(100));
    };
    let below_names = 4 * 40 * width;
    let (compared, after, before) = (
        &compared[below_names..],
        &after[below_names..],
        &before[below_names..],
    );
    assert_eq!(different(compared, after, width / 2 + 10..width), 0);
    assert!(different(compared, before, width / 2 + 10..width) > 0);
    assert!(different(compared, after, 0..width / 2 - 10) > 0);

    // The line is dragged, not the brush; arrow keys move it as well.
    let place = |harness: &Harness<'_, Editor>| harness.get_by_label("Before and after").rect().center().x;
    let was = place(&harness);
    drag(&mut harness, Vec2::ZERO, Vec2::new(-90.0, 0.0), 4);
    harness.step();
    assert!(
        (place(&harness) - was + 90.0).abs() < 8.0,
        "{} from {was}",
        place(&harness)
    );
    let was = place(&harness);
    harness.get_by_label("Before and after").focus();
    harness.step();
    press(&mut harness, Modifiers::NONE, Key::ArrowRight);
    assert!(place(&harness) > was);
    assert!(bits(&harness) == painted, "comparing changes nothing");
    press(&mut harness, Modifiers::COMMAND, Key::B);
    assert!(!shows(&harness, "Before and after"));
}

/// The turntable turns until a hand comes; one term alone, no panels, and back.
#[test]
fn the_view_turns_by_itself_until_it_is_touched() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = editor(&project(folder.path()));
    press(&mut harness, Modifiers::NONE, Key::T);
    let pose = |harness: &Harness<'_, Editor>| harness.state().camera_pose().unwrap();
    let start = pose(&harness);
    for _ in 0..5 {
        harness.step();
    }
    let turned = pose(&harness);
    assert!(turned != start);
    press(&mut harness, Modifiers::NONE, Key::Escape);
    let stopped = pose(&harness);
    for _ in 0..5 {
        harness.step();
    }
    assert!(pose(&harness) == stopped);
    assert!(bits(&harness).len() > 100 && !document(&harness).is_modified());

    press(&mut harness, Modifiers::NONE, Key::L);
    assert_eq!(harness.state().last_message(), Some("Only R"));
    press(&mut harness, Modifiers::SHIFT, Key::L);
    assert!(shows(&harness, "Layers"));
    press(&mut harness, Modifiers::NONE, Key::H);
    assert!(!shows(&harness, "Layers"));
    press(&mut harness, Modifiers::NONE, Key::H);
    click(&mut harness, "Statistics");
    for name in ["Strands", "Points changed", "Not computed", "Log"] {
        assert!(shows(&harness, name), "{name}");
    }
}

/// Layers change places when one is dragged over another.
#[test]
fn layers_are_ordered_by_drag() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = editor(&project(folder.path()));
    click(&mut harness, "Add layer");
    let order = |harness: &Harness<'_, Editor>| -> Vec<String> {
        let layers = document(harness).project().layers.iter();
        layers.map(|layer| layer.id.clone()).collect()
    };
    let before = order(&harness);
    let row = |harness: &Harness<'_, Editor>, id: &str| {
        let layers = &document(harness).project().layers;
        let name = layers.iter().find(|layer| layer.id == id).unwrap().name.clone();
        let found = harness.get_all_by_label(&name).last();
        found.unwrap().rect().center()
    };
    let (lower, upper) = (row(&harness, &before[0]), row(&harness, &before[1]));
    harness.hover_at(lower);
    harness.step();
    harness.drag_at(lower);
    harness.step();
    harness.hover_at(lower.lerp(upper, 0.5));
    harness.step();
    harness.hover_at(upper);
    harness.step();
    harness.drop_at(upper);
    harness.step();
    harness.step();
    assert_eq!(order(&harness), [before[1].clone(), before[0].clone()]);
    press(&mut harness, Modifiers::COMMAND, Key::Z);
    assert_eq!(order(&harness), before);
}

/// An empty window offers what was opened lately.
#[test]
fn an_empty_window_offers_recent_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = project(folder.path());
    let missing = folder.path().join("missing.json");
    let mut harness = Harness::builder()
        .with_size(Vec2::new(1100.0, 800.0))
        .build_eframe(|creation| Editor::new(&creation.egui_ctx, Some(missing)));
    let mut settings = Settings::of_session();
    settings.remember(&path).unwrap();
    harness.state_mut().use_settings(settings);
    let start = std::time::Instant::now();
    while harness.state().is_busy() {
        harness.step();
        assert!(start.elapsed().as_secs() < 60);
    }
    harness.step();
    assert!(shows(&harness, "Recent"));
    click(&mut harness, "project.json");
    settle(&mut harness, 0);
    assert!(document(&harness).path().is_some());
}

/// How fine the hair volume is changes the picture, not the document, and back again.
#[test]
fn the_hair_volume_is_as_fine_as_the_view_menu_says() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = editor(&project(folder.path()));
    let usual = picture(&mut harness);
    let mut choose = |name: &str| {
        let frames = harness.state().frames_shown();
        for label in ["View", "Hair volume", name] {
            harness.get_by_label(label).click();
            harness.run_steps(3);
        }
        settle(&mut harness, frames);
        picture(&mut harness)
    };
    let coarse = choose("Very coarse");
    assert!(coarse != usual, "voxels three times as large are seen");
    assert!(choose("Usual") == usual);
    assert!(!document(&harness).is_modified());
}
