//! Light in the editor: turned, edited by hand, played; kept over undo, refits, saving and the command line.

use std::{
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use balayage::{
    document::{Environment, HandLight, LightSettings},
    ui::{Command, Editor},
};
use balayage_render::light::{LightSet, SrbfLight};
use egui::{Key, Modifiers, PointerButton, Pos2, Vec2, accesskit::Role};
use egui_kittest::{
    Harness,
    kittest::{NodeT, Queryable},
};
use glam::Vec3;

use crate::{LIGHT, document, project, settle};

/// A Radiance map of 32 x 16 pixels: grey, with a bright patch in column `sun`.
fn write_map(path: &Path, sun: usize) {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16 +X 32\n".to_vec();
    for row in 0..16 {
        for column in 0..32 {
            let is_sun = (4..6).contains(&row) && (sun..sun + 2).contains(&column);
            bytes.extend(if is_sun {
                [200, 160, 120, 134]
            } else {
                [100, 110, 120, 128]
            });
        }
    }
    fs::write(path, bytes).unwrap();
}

/// The project of [`project`] under three maps that follow each other, fitted by four lights.
fn sequence(folder: &Path) -> PathBuf {
    for (i, sun) in [6, 7, 6].into_iter().enumerate() {
        write_map(&folder.join(format!("sky-{i}.hdr")), sun);
    }
    let maps = r#"{"maps": ["sky-0.hdr", "sky-1.hdr", "sky-2.hdr"], "fps": 60}"#;
    lit(
        folder,
        &format!(r#"{{"environment": {{"sequence": {maps}}}, "light_count": 4}}"#),
    )
}

/// Light from everywhere.
pub(super) const EVEN: &str = r#"{"environment": {"constant": [1, 1, 1]}}"#;

/// The project of [`project`] under other light.
pub(super) fn lit(folder: &Path, light: &str) -> PathBuf {
    let path = project(folder);
    let text = fs::read_to_string(&path).unwrap();
    let (head, tail) = text.split_once(LIGHT).unwrap();
    fs::write(&path, format!("{head}{light}{tail}")).unwrap();
    path
}

/// The editor with the light tab open.
fn editor(path: &Path) -> Harness<'static, Editor> {
    let mut harness = crate::editor(path);
    harness.get_all_by_label("Light").last().unwrap().click();
    harness.step();
    harness.step();
    harness
}

fn settings(harness: &Harness<'_, Editor>) -> LightSettings {
    document(harness).project().light.clone()
}

fn lights(harness: &Harness<'_, Editor>) -> LightSet {
    harness.state().lights().unwrap()
}

fn click(harness: &mut Harness<'_, Editor>, label: &str) {
    harness.get_by_label(label).click();
    harness.step();
    harness.step();
}

/// Presses at `from` with `button`, moves by `by` in four steps, releases.
fn drag(
    harness: &mut Harness<'_, Editor>,
    from: Pos2,
    by: Vec2,
    button: PointerButton,
    modifiers: Modifiers,
) {
    let press = |pos, pressed| egui::Event::PointerButton {
        pos,
        button,
        pressed,
        modifiers,
    };
    harness.hover_at(from);
    harness.step();
    harness.event_modifiers(press(from, true), modifiers);
    harness.step();
    for i in 1..=4 {
        harness.event_modifiers(egui::Event::PointerMoved(from + by * (i as f32 / 4.0)), modifiers);
        harness.step();
    }
    harness.event_modifiers(press(from + by, false), modifiers);
    harness.step();
    harness.step();
}

fn drag_light(harness: &mut Harness<'_, Editor>, label: &str, by: Vec2) {
    let from = harness.get_by_label(label).rect().center();
    drag(harness, from, by, PointerButton::Primary, Modifiers::NONE);
}

fn undo(harness: &mut Harness<'_, Editor>) {
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.step();
    harness.step();
}

#[test]
fn a_cancelled_fit_keeps_the_lights_until_the_next_change() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = editor(&sequence(folder.path()));
    let before = lights(&harness);
    let count = |harness: &Harness<'_, Editor>, count: f64| {
        let slider = harness.get_all_by_label("Lights").next().unwrap();
        slider.set_value_accesskit(count);
    };
    count(&harness, 256.0);
    harness.step();
    harness.step();
    click(&mut harness, "Cancel");
    assert!(!harness.state().is_busy(), "nothing is left to wait for");
    assert!(harness.query_by_label("Cancel").is_none());
    let said = harness.state().last_message().unwrap();
    assert!(said.starts_with("Fit cancelled"), "{said}");
    assert_eq!(lights(&harness), before);
    count(&harness, 5.0);
    harness.step();
    let frames = harness.state().frames_shown();
    settle(&mut harness, frames);
    assert_eq!(lights(&harness).lights.len(), 5);
}

/// Turning, dragging, muting, deleting: each one undo entry, none a new fit; saved, reopened and rendered the same.
#[test]
fn lights_are_edited_by_hand_undone_saved_and_reopened() {
    let folder = tempfile::tempdir().unwrap();
    let path = sequence(folder.path());
    let mut harness = editor(&path);
    let (clean, fitted) = (settings(&harness), lights(&harness));
    assert_eq!(fitted.lights.len(), 4);

    // Shift and the right button turn the environment; the lights turn with it and are not fitted anew.
    let middle = harness.get_by_label("Viewport").rect().center();
    let right = PointerButton::Secondary;
    drag(
        &mut harness,
        middle,
        Vec2::new(80.0, 0.0),
        right,
        Modifiers::SHIFT,
    );
    assert!(!harness.state().is_busy());
    let turned = settings(&harness);
    assert!(turned.rotation_deg > 30.0 && turned.hand.is_empty());
    let turn_rad = turned.rotation_deg.to_radians();
    for (light, expected) in lights(&harness)
        .lights
        .iter()
        .zip(&fitted.rotated(turn_rad).lights)
    {
        assert!(
            light.direction.abs_diff_eq(expected.direction, 1e-6),
            "{light:?} {expected:?}"
        );
        assert_eq!(
            (light.bandwidth, light.radiance),
            (expected.bandwidth, expected.radiance)
        );
    }

    // A drag in the panel moves one light to the right and a little down, and leaves the others.
    let before = lights(&harness);
    let panel = harness.get_by_label("Light map").rect();
    drag_light(
        &mut harness,
        "Light 1 on the map",
        Vec2::new(0.1 * panel.width(), 8.0),
    );
    assert!(!harness.state().is_busy());
    let moved = lights(&harness);
    let azimuth = |light: &SrbfLight| light.direction.x.atan2(-light.direction.z);
    let by_deg = (azimuth(&moved.lights[0]) - azimuth(&before.lights[0]))
        .to_degrees()
        .rem_euclid(360.0);
    assert!((by_deg - 36.0).abs() < 3.0, "{by_deg}");
    assert_eq!(moved.lights[0].radiance, before.lights[0].radiance);
    assert_eq!(moved.lights[1..], before.lights[1..]);
    undo(&mut harness);
    assert_eq!(harness.state().last_message(), Some("Undone: Move light"));
    assert_eq!(settings(&harness), turned, "one drag is one entry");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Y);
    harness.step();
    harness.step();
    assert_eq!(lights(&harness), moved);

    // Mute takes one light out, Delete another.
    click(&mut harness, "Mute Light 2");
    assert_eq!(lights(&harness).lights.len(), 3);
    click(&mut harness, "Light 3");
    harness.key_press(Key::Delete);
    harness.step();
    harness.step();
    assert_eq!(lights(&harness).lights.len(), 2);
    let edited = settings(&harness);
    assert_eq!(edited.hand.len(), 3);

    // What is saved opens as the same lights, and the command line renders them: the picture under the written list is equal.
    let shown = lights(&harness);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    harness.step();
    let list = folder.path().join("lights.json");
    harness.state_mut().save_lights(&list);
    drop(harness);
    let mut harness = editor(&path);
    assert_eq!(settings(&harness), edited);
    assert_eq!(lights(&harness), shown);
    let of_project = render(&path, &[]);
    let of_list = [
        "--lights",
        list.to_str().unwrap(),
        "--rotate",
        "0",
        "--exposure",
        "0",
    ];
    assert!(
        of_project == render(&path, &of_list),
        "the command line shows other lights"
    );
    assert!(of_project != render(&path, &["--rotate", "0"]));

    // Another count is another fit: what was edited stays, and what it replaced does not come back.
    let energy = shown.energy();
    for name in ["Edited 1", "Edited 2"] {
        assert!(harness.query_by_label(name).is_some(), "{name}");
    }
    let slider = harness.get_all_by_label("Lights").next().unwrap();
    slider.set_value_accesskit(7.0);
    harness.step();
    let frames = harness.state().frames_shown();
    settle(&mut harness, frames);
    assert_eq!(settings(&harness).light_count, 7);
    assert_eq!(settings(&harness).hand, edited.hand);
    let refitted = lights(&harness).energy();
    assert!(
        refitted.abs_diff_eq(energy, 0.05 * energy.max_element()),
        "{refitted} {energy}"
    );
    undo(&mut harness);
    let frames = harness.state().frames_shown();
    settle(&mut harness, frames);
    assert_eq!(lights(&harness), shown);
    assert_eq!(clean.hand, Vec::<HandLight>::new());
}

/// The pixels that the command line renders of a project.
fn render(project: &Path, options: &[&str]) -> Vec<u8> {
    let output = project.with_file_name("out.png");
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let (input, picture) = (project.to_str().unwrap(), output.to_str().unwrap());
    let args = ["balayage", "render", input, "-o", picture, "--size", "64x64"];
    let code = balayage::cli::run(args.iter().chain(options), &mut out, &mut err);
    assert_eq!(code, 0, "{}", String::from_utf8_lossy(&err));
    image::open(output).unwrap().into_rgba8().into_raw()
}

/// A double click adds a light where nothing is, the wheel and the ring's handle widen it, its handle in the viewport moves it.
#[test]
fn a_light_is_added_widened_and_moved_by_its_handle() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = editor(&lit(folder.path(), EVEN));
    assert!(lights(&harness).lights.is_empty());
    let at = harness.get_by_label("Light map").rect().center() + Vec2::new(0.0, -20.0);
    harness.hover_at(at);
    // The click on the tab is long ago: a third click is no double click.
    harness.run_steps(60);
    for pressed in [true, false, true, false] {
        harness.event(egui::Event::PointerButton {
            pos: at,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        });
    }
    harness.run_steps(12);
    let added = lights(&harness).lights;
    assert_eq!(added.len(), 1, "{:?}", harness.state().last_message());
    assert!(
        added[0].direction.z > 0.8 && added[0].direction.y > 0.1,
        "{added:?}"
    );

    // The wheel turns several times: one undo entry. The energy stays.
    for _ in 0..3 {
        harness.event(egui::Event::MouseWheel {
            unit: egui::MouseWheelUnit::Point,
            delta: Vec2::new(0.0, 30.0),
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Wheel,
            modifiers: Modifiers::NONE,
        });
        harness.step();
    }
    harness.run_steps(30);
    let wide = lights(&harness).lights;
    assert!(wide[0].bandwidth > 1.2 * added[0].bandwidth, "{wide:?}");
    assert!(wide[0].energy().abs_diff_eq(added[0].energy(), 1e-4));
    undo(&mut harness);
    assert_eq!(harness.state().last_message(), Some("Undone: Widen light"));
    assert_eq!(lights(&harness).lights, added);
    drag_light(&mut harness, "Width handle", Vec2::new(20.0, 0.0));
    assert!(lights(&harness).lights[0].bandwidth > 1.2 * added[0].bandwidth);
    undo(&mut harness);

    // Handles in the viewport, on the ball round the hair: a drag to the left moves the light towards -x.
    click(&mut harness, "Light handles");
    drag_light(&mut harness, "Added 1 handle", Vec2::new(-150.0, 0.0));
    let moved = lights(&harness).lights;
    assert!(moved[0].direction.x < added[0].direction.x - 0.1, "{moved:?}");
    assert!((moved[0].direction.length() - 1.0).abs() < 1e-5);
    undo(&mut harness);
    assert_eq!(lights(&harness).lights, added, "one drag is one entry");

    // The constant light goes out while one light is solo.
    assert!(lights(&harness).constant != Vec3::ZERO);
    click(&mut harness, "Solo Added 1");
    assert_eq!(lights(&harness).constant, Vec3::ZERO);
    click(&mut harness, "Solo Added 1");
    assert!(lights(&harness).constant != Vec3::ZERO);
}

/// A sequence plays: every map in turn, fitted in the background while the window goes on; pause, step, edits stay.
#[test]
fn a_sequence_plays_pauses_and_steps() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = editor(&sequence(folder.path()));
    let frame = |harness: &Harness<'_, Editor>| document(harness).project().frame;
    let first = lights(&harness);
    click(&mut harness, "Mute Light 1");
    click(&mut harness, "Play");
    assert!(harness.state().is_playing());
    let start = Instant::now();
    let (mut seen, mut slowest) = (vec![frame(&harness)], Duration::ZERO);
    while seen.len() < 5 {
        let step = Instant::now();
        harness.step();
        slowest = slowest.max(step.elapsed());
        assert!(harness.state().lights().is_some(), "the last good lights stay");
        if frame(&harness) != seen[seen.len() - 1] {
            seen.push(frame(&harness));
        }
        let waited = start.elapsed() < Duration::from_secs(120);
        assert!(waited, "{seen:?}: {:?}", harness.state().last_message());
        std::thread::sleep(Duration::from_millis(2));
    }
    let in_turn = |pair: &[u32]| pair[1] == (pair[0] + 1) % 3;
    assert!(seen.windows(2).all(in_turn), "{seen:?}");
    assert!(
        slowest < Duration::from_secs(2),
        "the window stood still for {slowest:?}"
    );

    click(&mut harness, "Pause");
    let frames = harness.state().frames_shown();
    settle(&mut harness, frames.saturating_sub(1));
    let paused = lights(&harness);
    let (dark, bright) = (paused.energy().x, first.energy().x);
    assert!(
        dark < 0.5 * bright,
        "the muted light does not stay muted: {dark} of {bright}"
    );
    let at = frame(&harness);
    click(&mut harness, "Step");
    assert_eq!(frame(&harness), (at + 1) % 3);
    let context = harness.ctx.clone();
    harness.state_mut().run(&context, Command::PreviousMap);
    assert_eq!(frame(&harness), at);
    assert!(!document(&harness).project().light.hand.is_empty());

    // A map that cannot be read stops the sequence with a reason; the lights stay.
    let frames = harness.state().frames_shown();
    settle(&mut harness, frames.saturating_sub(1));
    let next = format!("sky-{}.hdr", (at + 1) % 3);
    fs::remove_file(folder.path().join(&next)).unwrap();
    let before = lights(&harness);
    click(&mut harness, "Step");
    while harness.state().is_busy() {
        harness.step();
    }
    assert!(harness.state().last_message().unwrap().contains(&next));
    assert_eq!(lights(&harness), before);
    assert!(matches!(settings(&harness).environment, Environment::Sequence(_)));
}

/// Sets the slider that is called `label`.
fn set(harness: &mut Harness<'_, Editor>, label: &str, value: f64) {
    let slider = harness.get_all_by_label(label).next();
    slider
        .unwrap_or_else(|| panic!("no {label}"))
        .set_value_accesskit(value);
    harness.step();
    harness.step();
}

/// Turning, exposing and tinting fit nothing anew, nor do edits by hand, undo and redo; another number of lights does, once.
#[test]
fn rotation_exposure_and_tint_never_fit_anew() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = editor(&sequence(folder.path()));
    let fits = harness.state().fits_started();
    let mut seen = vec![settings(&harness)];
    set(&mut harness, "Rotation", 90.0);
    seen.push(settings(&harness));
    set(&mut harness, "Exposure", 1.5);
    seen.push(settings(&harness));
    let tinted = LightSettings {
        tint: [1.0, 0.5, 0.0],
        ..settings(&harness)
    };
    assert!(tinted.same_fit(&settings(&harness)) && tinted != settings(&harness));
    click(&mut harness, "Mute Light 2");
    seen.push(settings(&harness));
    let differ = |pair: &[LightSettings]| pair[0] != pair[1];
    assert!(seen.windows(2).all(differ), "something changed nothing: {seen:?}");
    for _ in 0..3 {
        undo(&mut harness);
    }
    assert_eq!(settings(&harness), seen[0]);
    assert_eq!(harness.state().fits_started(), fits);

    // The counter counts: another number of lights is a fit, and so is the way back.
    set(&mut harness, "Lights", 6.0);
    assert_eq!(harness.state().fits_started(), fits + 1);
    undo(&mut harness);
    assert_eq!(harness.state().fits_started(), fits + 2);
}

/// A hair error instead of a number of lights: as few as reach it, soon enough to wait for, and one undo away.
#[test]
fn lights_by_error_are_as_few_as_it_takes() {
    let folder = tempfile::tempdir().unwrap();
    write_map(&folder.path().join("sky.hdr"), 9);
    let light = r#"{"environment": {"map": "sky.hdr"}, "light_count": 30}"#;
    let mut harness = editor(&lit(folder.path(), light));
    let many = lights(&harness).lights.len();
    let start = Instant::now();
    click(&mut harness, "Lights by error");
    assert_eq!(settings(&harness).target_error, Some(0.01));
    while harness.state().is_busy() {
        harness.step();
        assert!(start.elapsed() < Duration::from_secs(60));
    }
    let few = lights(&harness).lights.len();
    assert!(few < many && few > 1, "{few} of {many} lights");

    // What is measured of them afterwards keeps the word.
    let measured = |harness: &Harness<'_, Editor>| {
        let report = harness.query_by_label_contains("lights fitted in")?;
        let text = report.accesskit_node().label().or_else(|| report.value())?;
        let percent = text.split_once("hair ")?.1.split_once(" %")?.0.parse::<f64>();
        Some(percent.unwrap())
    };
    let percent = loop {
        harness.step();
        if let Some(percent) = measured(&harness) {
            break percent;
        }
        assert!(start.elapsed() < Duration::from_secs(60), "nothing was measured");
    };
    assert!(percent <= 1.0, "{percent} %");
    undo(&mut harness);
    assert_eq!(
        (settings(&harness).target_error, settings(&harness).light_count),
        (None, 30)
    );
}

/// A rotation that a file gives backwards is shown as what it is, and looking at it changes nothing.
#[test]
fn a_rotation_backwards_is_shown_forwards() {
    let folder = tempfile::tempdir().unwrap();
    let constant = r#"{"environment": {"constant": [1, 1, 1]}, "rotation_deg": -100, "exposure_ev": 9.5}"#;
    let harness = editor(&lit(folder.path(), constant));
    let number = |slider: &str| {
        let found = harness.get_by_role_and_label(Role::Slider, slider);
        found.accesskit_node().numeric_value().unwrap()
    };
    assert_eq!([number("Rotation"), number("Exposure")], [260.0, 9.5]);
    assert_eq!(document(&harness).project().light.rotation_deg, -100.0);
}
