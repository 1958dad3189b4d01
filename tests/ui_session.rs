//! A whole session in the editor: three brushes, ombre, grey, mask, opacity, undo and redo, eyedropper, save, reopen.

use std::{
    path::{Path, PathBuf},
    thread::sleep,
    time::{Duration, Instant},
};

use balayage::{
    document::{Document, Project},
    paint::Shape,
    ui::Editor,
};
use egui::{Key, Modifiers, Vec2, accesskit::Role};
use egui_kittest::{Harness, kittest::Queryable};

use super::{bits, document, drag, editor, picture, project, settle};

/// How many steps the history should have: done ones, and all of them.
#[derive(Default)]
struct Expected {
    done: usize,
    all: usize,
}

impl Expected {
    /// After `steps` new edits.
    fn edited(&mut self, harness: &Harness<'_, Editor>, steps: usize, what: &str) {
        self.done += steps;
        self.all = self.done;
        self.check(harness, what);
    }

    /// After one undo.
    fn undone(&mut self, harness: &Harness<'_, Editor>) {
        self.done -= 1;
        self.check(harness, "undo");
    }

    /// After one redo.
    fn redone(&mut self, harness: &Harness<'_, Editor>) {
        self.done += 1;
        self.check(harness, "redo");
    }

    fn check(&self, harness: &Harness<'_, Editor>, after: &str) {
        let (labels, done) = document(harness).history_labels();
        assert_eq!(
            (done, labels.len()),
            (self.done, self.all),
            "{after}: {labels:?}, {:?}",
            harness.state().last_message()
        );
        check_invariants(harness, after);
    }
}

/// What holds after every edit: the project is sound and says all of itself, the buffers are those of a replay, every value is in range.
fn check_invariants(harness: &Harness<'_, Editor>, after: &str) {
    let open = document(harness);
    let again = Document::new(open.groom().clone(), open.project().clone(), PathBuf::new())
        .unwrap_or_else(|problem| panic!("{after}: {problem}"));
    let replayed: &[u32] = bytemuck::cast_slice(again.params());
    assert!(replayed == bits(harness), "{after}: not what a replay gives");
    let text = balayage::document::json::to_text(open.project()).unwrap();
    let read: Project = serde_json::from_str(&text).unwrap();
    assert!(read == *open.project(), "{after}: its file says something else");
    assert!(
        open.values().iter().all(|v| v.out_of_range().is_none()),
        "{after}"
    );
    let params: &[f32] = bytemuck::cast_slice(open.params());
    assert!(params.iter().all(|x| x.is_finite()), "{after}: not finite");
}

/// Differing of two pictures of RGBA bytes and one width: root mean square of the differences of 8 x 8 means, relative to the mean.
fn difference(a: &[u8], b: &[u8], width: usize) -> f64 {
    assert_eq!(a.len(), b.len());
    const TILE: usize = 8;
    let rows = a.len() / 4 / width;
    let mean = |picture: &[u8], x: usize, y: usize, c: usize| {
        let pixels = (0..TILE * TILE).map(|k| (y + k / TILE) * width + x + k % TILE);
        pixels.map(|k| f64::from(picture[4 * k + c])).sum::<f64>()
    };
    let (mut error, mut norm) = (0.0, 0.0);
    for y in (0..=rows - TILE).step_by(TILE) {
        for x in (0..=width - TILE).step_by(TILE) {
            for c in 0..3 {
                let (a, b) = (mean(a, x, y, c), mean(b, x, y, c));
                error += (a - b).powi(2);
                norm += b * b;
            }
        }
    }
    (error / norm).sqrt()
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

/// Everything a colourist does, from a bare groom to the picture. Only the name of the file to save has no place in the window: the
/// system's dialog asks for it.
#[test]
fn a_colourists_session() {
    let folder = tempfile::tempdir().unwrap();
    let groom = project(folder.path()).with_file_name("curtain.hair");
    let path = folder.path().join("dyed.json");
    let mut harness = editor(&groom);
    let clean = bits(&harness);
    let mut history = Expected::default();
    history.check(&harness, "opening");
    assert!(document(&harness).project().operations.is_empty() && document(&harness).path().is_none());
    click(&mut harness, "Light");
    choose(&mut harness, "Environment", "Overcast");
    history.edited(&harness, 1, "environment");
    slide(&mut harness, "Lights", 0.2);
    history.edited(&harness, 1, "number of lights");
    click(&mut harness, "Brush");
    let count = |harness: &Harness<'_, Editor>| document(harness).project().operations.len();

    // Three brushes: replaced dye, added dye along strands, bleach with another radius.
    click(&mut harness, "Dye Ruby");
    drag(&mut harness, Vec2::new(-80.0, -20.0), Vec2::new(80.0, -10.0), 5);
    history.edited(&harness, 1, "first brush");
    click(&mut harness, "Comb-dye");
    choose(&mut harness, "Mode", "Add");
    slide(&mut harness, "From", 0.6);
    drag(&mut harness, Vec2::new(-60.0, 10.0), Vec2::new(0.0, 20.0), 4);
    history.edited(&harness, 1, "second brush");
    click(&mut harness, "Paint");
    choose(&mut harness, "Mode", "Replace");
    choose(&mut harness, "Channel", "Bleach");
    press(&mut harness, Modifiers::NONE, Key::OpenBracket);
    drag(&mut harness, Vec2::new(20.0, -40.0), Vec2::new(60.0, 40.0), 4);
    history.edited(&harness, 1, "third brush");
    assert_eq!(count(&harness), 3, "{:?}", harness.state().last_message());
    let operations = &document(&harness).project().operations;
    assert!(operations.iter().all(|operation| operation.dabs.len() > 1));
    let arcs = operations[1].arc_range.unwrap();
    assert!(arcs[0] > 0.3 && arcs[1] == 1.0, "{arcs:?}");

    // Salon operations on a layer of their own, adjusted afterwards.
    click(&mut harness, "Add layer");
    history.edited(&harness, 1, "layer");
    click(&mut harness, "Operations");
    click(&mut harness, "Add Ombre");
    history.edited(&harness, 1, "ombre");
    slide(&mut harness, "Start", 0.05);
    history.edited(&harness, 1, "ombre adjusted");
    click(&mut harness, "Add Grey");
    history.edited(&harness, 1, "grey");
    slide(&mut harness, "Grey strands", 0.2);
    history.edited(&harness, 1, "grey adjusted");
    let operations = &document(&harness).project().operations;
    assert_eq!(operations.len(), 5);
    assert_eq!(operations[4].title(), "Grey bleach");
    let Some(Shape::Grey(grey)) = &operations[4].shape else {
        panic!("{:?}", operations[4].shape);
    };
    assert!((0.1..0.3).contains(&grey.share), "{grey:?}");
    click(&mut harness, "Show 5. Grey bleach");
    assert!(document(&harness).project().operations[4].hidden);
    history.edited(&harness, 1, "grey hidden");
    click(&mut harness, "Show 5. Grey bleach");
    history.edited(&harness, 1, "grey shown");

    // Mask by arc length, opacity.
    let before_mask = bits(&harness);
    click(&mut harness, "Mask");
    click(&mut harness, "Add condition");
    click(&mut harness, "Along the strand");
    history.edited(&harness, 1, "mask");
    let masked = bits(&harness);
    assert!(masked != before_mask);
    slide(&mut harness, "Opacity", 0.3);
    history.edited(&harness, 1, "opacity");
    let opacity = document(&harness).project().layers[1].opacity;
    assert!((0.15..0.45).contains(&opacity), "{opacity}");

    // Undo 5, redo 3: opacity and mask are undone.
    let done = bits(&harness);
    for _ in 0..5 {
        press(&mut harness, Modifiers::COMMAND, Key::Z);
        history.undone(&harness);
    }
    assert!(bits(&harness) != done && bits(&harness) != clean);
    for _ in 0..3 {
        press(&mut harness, Modifiers::COMMAND, Key::Y);
        history.redone(&harness);
    }
    assert!(bits(&harness) == before_mask);
    click(&mut harness, "History");
    assert!(harness.query_by_label("1. Change environment").is_some());

    // The eyedropper reads the seen colour, of a picture that is there.
    settle(&mut harness, 0);
    click(&mut harness, "Brush");
    press(&mut harness, Modifiers::NONE, Key::C);
    click(&mut harness, "Seen colour");
    drag(&mut harness, Vec2::ZERO, Vec2::ZERO, 1);
    let message = harness.state().last_message().unwrap().to_owned();
    assert!(message.starts_with("Took the seen colour"), "{message}");
    harness.step();
    history.check(&harness, "picking paints nothing");

    // The picture comes to rest with everything that was painted, before the environment as `render` shows it.
    click(&mut harness, "View");
    click(&mut harness, "Show environment");
    press(&mut harness, Modifiers::NONE, Key::Escape);
    rest(&mut harness);
    assert_eq!(harness.state().points_to_draw(), 0);

    // Save, reopen: the same document and picture, and the same without a window.
    let context = harness.ctx.clone();
    harness.state_mut().save_to(&context, &path);
    assert!(
        !document(&harness).is_modified(),
        "{:?}",
        harness.state().last_message()
    );
    rest(&mut harness);
    let (shown, saved) = (picture(&mut harness), document(&harness).project().clone());
    let viewport = harness.get_by_label("Viewport").rect();
    let width = viewport.width() as usize;
    drop(harness);
    let mut harness = editor(&path);
    assert!(*document(&harness).project() == saved && bits(&harness) == before_mask);
    click(&mut harness, "View");
    click(&mut harness, "Show environment");
    press(&mut harness, Modifiers::NONE, Key::Escape);
    rest(&mut harness);
    let again = picture(&mut harness);
    assert!(
        again == shown,
        "another picture: {}",
        difference(&again, &shown, width)
    );
    let replayed = Document::open(&path, None).unwrap().document;
    assert!(bytemuck::cast_slice::<_, u32>(replayed.params()) == before_mask);
    assert_eq!(document(&harness).project().operations.len(), 5);

    // Rendered without a window, the same: camera and lights are the project's. The bare hair is not that picture.
    let render = |project: &Path| {
        let out = folder.path().join("out.png");
        let (project, out) = (project.to_str().unwrap(), out.to_str().unwrap());
        let size = format!("{}x{}", viewport.width() as u32, viewport.height() as u32);
        let options = [
            "--samples",
            "1",
            "--visibility-rays",
            "16",
            "--background",
            "env",
            "--size",
        ];
        let args = ["balayage", "render", project, "-o", out];
        let mut said = Vec::new();
        let args = args.into_iter().chain(options).chain([size.as_str()]);
        let code = balayage::cli::run(args, &mut Vec::new(), &mut said);
        assert_eq!(code, 0, "{}", String::from_utf8_lossy(&said));
        image::open(out).unwrap().to_rgba8().into_raw()
    };
    let mut bare = saved;
    bare.operations.clear();
    let bare_path = folder.path().join("bare.json");
    std::fs::write(&bare_path, balayage::document::json::to_text(&bare).unwrap()).unwrap();
    let same = difference(&render(&path), &shown, width);
    let other = difference(&render(&bare_path), &shown, width);
    println!("viewport against render: {same}, against bare hair: {other}");
    assert!(same < 0.01, "the viewport is not what is rendered: {same}");
    assert!(other > 0.05, "{other}");
}

/// An editor at rest asks for no frame and draws none, with the pointer over the hair as well; one that turns does.
#[test]
fn an_editor_at_rest_does_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = editor(&project(folder.path()));
    let over_hair = harness.get_by_label("Viewport").rect().center();
    let wants_frame = |harness: &mut Harness<'_, Editor>| {
        // What a step itself wants shows after it.
        harness.step();
        harness.ctx.has_requested_repaint()
    };
    for pointer in [egui::pos2(2.0, 2.0), over_hair] {
        harness.hover_at(pointer);
        rest(&mut harness);
        let frames = harness.state().frames_shown();
        for _ in 0..20 {
            assert!(!wants_frame(&mut harness), "{:?}", harness.ctx.repaint_causes());
            sleep(Duration::from_millis(10));
        }
        assert_eq!(harness.state().frames_shown(), frames);
    }
    press(&mut harness, Modifiers::NONE, Key::T);
    assert!(wants_frame(&mut harness));
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
