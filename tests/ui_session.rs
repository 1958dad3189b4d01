//! A whole session in the editor: three brushes, ombre, grey, mask, opacity, undo and redo, eyedropper, save, reopen.

use std::{
    path::PathBuf,
    thread::sleep,
    time::{Duration, Instant},
};

use balayage::{document::Document, ui::Editor};
use egui::{Key, Modifiers, Vec2, accesskit::Role};
use egui_kittest::{Harness, kittest::Queryable};

use super::{bits, document, drag, editor, picture, project};

/// What holds after every edit: the buffers are those of a replay, every value is in range.
fn check_invariants(harness: &Harness<'_, Editor>, after: &str) {
    let open = document(harness);
    let again = Document::new(open.groom().clone(), open.project().clone(), PathBuf::new()).unwrap();
    let replayed: &[u32] = bytemuck::cast_slice(again.params());
    assert!(replayed == bits(harness), "{after}: not what a replay gives");
    assert!(
        open.values().iter().all(|v| v.out_of_range().is_none()),
        "{after}"
    );
    let params: &[f32] = bytemuck::cast_slice(open.params());
    assert!(params.iter().all(|x| x.is_finite()), "{after}: not finite");
}

/// Clicks the last control of that name, wherever it is scrolled to.
fn click(harness: &mut Harness<'_, Editor>, label: &str) {
    let found = harness.get_all_by_label(label).last();
    found.unwrap_or_else(|| panic!("no {label}")).click_accesskit();
    harness.step();
    harness.step();
}

/// Chooses an entry of a combo box.
fn choose(harness: &mut Harness<'_, Editor>, list: &str, entry: &str) {
    let found = harness.get_by_role_and_label(Role::ComboBox, list);
    found.click_accesskit();
    harness.step();
    harness.step();
    click(harness, entry);
    // The accessibility tree's click leaves the list open.
    press(harness, Modifiers::NONE, Key::Escape);
    harness.step();
}

/// Drags the slider of that name to `share` of its rail.
fn slide(harness: &mut Harness<'_, Editor>, label: &str, share: f32) {
    let rail = harness.get_by_role_and_label(Role::Slider, label).rect();
    let at = |share: f32| rail.left_center() + Vec2::new(share * rail.width(), 0.0);
    harness.hover_at(at(0.5));
    harness.step();
    harness.drag_at(at(0.5));
    harness.step();
    harness.hover_at(at(0.5 + 0.5 * (share - 0.5)));
    harness.step();
    harness.hover_at(at(share));
    harness.step();
    harness.drop_at(at(share));
    harness.step();
}

/// Steps until the picture is sharp and no other one has come for a while.
fn rest(harness: &mut Harness<'_, Editor>) {
    const QUIET: Duration = Duration::from_millis(1500);
    let start = Instant::now();
    let (mut frames, mut since) = (0, start);
    while since.elapsed() < QUIET || harness.state().is_busy() || harness.state().is_draft() != Some(false) {
        harness.step();
        let shown = harness.state().frames_shown();
        if shown != frames {
            (frames, since) = (shown, Instant::now());
        }
        assert!(start.elapsed() < Duration::from_secs(240), "no rest");
        sleep(Duration::from_millis(20));
    }
}

fn press(harness: &mut Harness<'_, Editor>, modifiers: Modifiers, key: Key) {
    harness.key_press_modifiers(modifiers, key);
    harness.step();
}

#[test]
fn a_colourists_session() {
    let folder = tempfile::tempdir().unwrap();
    let path = project(folder.path());
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(
        &path,
        text.replace("\"light\": {", "\"light\": {\"light_count\": 4, "),
    )
    .unwrap();
    let mut harness = editor(&path);
    let clean = bits(&harness);
    click(&mut harness, "Light");
    choose(&mut harness, "Environment", "Sky");
    click(&mut harness, "Brush");
    let count = |harness: &Harness<'_, Editor>| document(harness).project().operations.len();

    // Three brushes: replaced dye, added dye along strands, bleach with another radius.
    click(&mut harness, "Dye Ruby");
    drag(&mut harness, Vec2::new(-80.0, -20.0), Vec2::new(80.0, -10.0), 5);
    check_invariants(&harness, "first brush");
    click(&mut harness, "Comb-dye");
    choose(&mut harness, "Mode", "Add");
    slide(&mut harness, "From", 0.6);
    drag(&mut harness, Vec2::new(-60.0, 10.0), Vec2::new(0.0, 20.0), 4);
    check_invariants(&harness, "second brush");
    click(&mut harness, "Paint");
    choose(&mut harness, "Mode", "Replace");
    choose(&mut harness, "Channel", "Bleach");
    press(&mut harness, Modifiers::NONE, Key::OpenBracket);
    drag(&mut harness, Vec2::new(20.0, -40.0), Vec2::new(60.0, 40.0), 4);
    check_invariants(&harness, "third brush");
    assert_eq!(count(&harness), 3, "{:?}", harness.state().last_message());
    let arcs = document(&harness).project().operations[1].arc_range.unwrap();
    assert!(arcs[0] > 0.3 && arcs[1] == 1.0, "{arcs:?}");

    // Salon operations on a layer of their own, adjusted afterwards.
    click(&mut harness, "Add layer");
    click(&mut harness, "Operations");
    click(&mut harness, "Add Ombre");
    check_invariants(&harness, "ombre");
    slide(&mut harness, "Start", 0.05);
    check_invariants(&harness, "ombre adjusted");
    click(&mut harness, "Add Grey");
    check_invariants(&harness, "grey");
    let operations = &document(&harness).project().operations;
    assert_eq!(operations.len(), 5);
    assert_eq!(operations[4].title(), "Grey bleach");
    click(&mut harness, "Show 5. Grey bleach");
    assert!(document(&harness).project().operations[4].hidden);
    check_invariants(&harness, "grey hidden");
    click(&mut harness, "Show 5. Grey bleach");

    // Mask by arc length, opacity.
    let before_mask = bits(&harness);
    click(&mut harness, "Mask");
    click(&mut harness, "Add condition");
    click(&mut harness, "Along the strand");
    check_invariants(&harness, "mask");
    assert!(bits(&harness) != before_mask);
    slide(&mut harness, "Opacity", 0.3);
    check_invariants(&harness, "opacity");
    let opacity = document(&harness).project().layers[1].opacity;
    assert!((0.15..0.45).contains(&opacity), "{opacity}");

    // Undo 5, redo 3: the third from last state.
    let done = bits(&harness);
    for _ in 0..5 {
        press(&mut harness, Modifiers::COMMAND, Key::Z);
        check_invariants(&harness, "undo");
    }
    assert!(bits(&harness) != done && bits(&harness) != clean);
    for _ in 0..3 {
        press(&mut harness, Modifiers::COMMAND, Key::Y);
        check_invariants(&harness, "redo");
    }
    assert!(bits(&harness) == before_mask, "opacity and mask are undone");
    click(&mut harness, "History");
    assert!(harness.query_by_label("1. Change environment").is_some());

    // The eyedropper reads the seen colour.
    click(&mut harness, "Brush");
    press(&mut harness, Modifiers::NONE, Key::C);
    click(&mut harness, "Seen colour");
    drag(&mut harness, Vec2::ZERO, Vec2::ZERO, 1);
    let message = harness.state().last_message().unwrap().to_owned();
    assert!(message.starts_with("Took the seen colour"), "{message}");
    harness.step();
    assert!(bits(&harness) == before_mask, "picking paints nothing");

    // Whatever was painted has been taken by the picture.
    rest(&mut harness);
    assert_eq!(harness.state().points_to_draw(), 0);

    // Save, reopen: the same document, the same picture, and the same without a window.
    press(&mut harness, Modifiers::COMMAND, Key::S);
    assert!(
        !document(&harness).is_modified(),
        "{:?}",
        harness.state().last_message()
    );
    rest(&mut harness);
    let (shown, saved) = (picture(&mut harness), document(&harness).project().clone());
    drop(harness);
    let mut harness = editor(&path);
    rest(&mut harness);
    assert!(*document(&harness).project() == saved && bits(&harness) == before_mask);
    let again = picture(&mut harness);
    let different = again
        .chunks(4)
        .zip(shown.chunks(4))
        .filter(|(a, b)| a != b)
        .count();
    assert!(
        again == shown,
        "another picture after reopening: {different} of {} pixels, {} before",
        again.len() / 4,
        shown.len() / 4
    );
    let replayed = Document::open(&path, None).unwrap().document;
    assert!(bytemuck::cast_slice::<_, u32>(replayed.params()) == before_mask);
    assert_eq!(document(&harness).project().operations.len(), 5);

    // Rendered without a window it has the same view of the same hair, and the paint shows in it.
    let render = |project: &std::path::Path, name: &str| {
        let out = folder.path().join(name);
        let (project, out) = (project.to_str().unwrap(), out.to_str().unwrap());
        let args = [
            "balayage",
            "render",
            project,
            "-o",
            out,
            "--size",
            "128x96",
            "--samples",
            "1",
        ];
        let mut said = Vec::new();
        let code = balayage::cli::run(args, &mut Vec::new(), &mut said);
        assert_eq!(code, 0, "{}", String::from_utf8_lossy(&said));
        image::open(out).unwrap().to_rgba8().into_raw()
    };
    let mut bare = saved;
    bare.operations.clear();
    bare.layers.truncate(1);
    let bare_path = folder.path().join("bare.json");
    std::fs::write(&bare_path, balayage::document::json::to_text(&bare).unwrap()).unwrap();
    let (dyed, plain) = (render(&path, "dyed.png"), render(&bare_path, "plain.png"));
    assert!(dyed == render(&path, "again.png") && dyed != plain);
}

/// Every control of the painter has a name in the accessibility tree, and does what it says.
#[test]
fn controls_of_the_painter_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = editor(&project(folder.path()));
    let named = |harness: &Harness<'_, Editor>, names: &[&str]| {
        for name in names {
            let found = harness.query_all_by_label(name).next().is_some();
            assert!(found, "{name}");
        }
    };
    named(
        &harness,
        &[
            "Comb-dye",
            "Mask",
            "Lasso",
            "Duplicate layer",
            "Merge down",
            "Layer name",
            "Opacity",
            "Blend",
            "On bleached hair",
            "Dye strength",
            "Dye Copper",
            "Dye name",
            "Save dye",
            "Mirror",
        ],
    );
    click(&mut harness, "Hair");
    named(&harness, &["Melanin", "Redness", "Lobes"]);
    assert!(
        !document(&harness).is_modified(),
        "looking at a panel changes nothing"
    );
    click(&mut harness, "Operations");
    for shape in balayage::paint::Shape::all() {
        named(&harness, &[&format!("Add {}", shape.name())]);
    }
    click(&mut harness, "Add Ombre");
    named(
        &harness,
        &[
            "Start",
            "Transition",
            "Variation",
            "Curve",
            "Soft",
            "Amount",
            "Draw again",
            "Delete 1. Ombre dye",
        ],
    );
    click(&mut harness, "Delete 1. Ombre dye");
    assert!(document(&harness).project().operations.is_empty());
    click(&mut harness, "Add Balayage");
    click(&mut harness, "Tone it");
    let operations = &document(&harness).project().operations;
    assert_eq!(
        (operations.len(), operations[1].title().as_str()),
        (2, "Balayage dye")
    );
    assert!(operations[0].shape == operations[1].shape && operations[0].seed == operations[1].seed);
    check_invariants(&harness, "toned");
    click(&mut harness, "History");
    harness.step();
    named(&harness, &["1. Ombre dye", "2. Remove ombre dye", "Memory"]);
    click(&mut harness, "1. Ombre dye");
    assert_eq!(document(&harness).project().operations.len(), 1);
}
