//! Keys and mouse as Blender has them, quick hands, and hands that do not wait for the picture.

use balayage::ui::{Editor, settings::Navigation, settings::Settings};
use egui::{Event, Key, Modifiers, PointerButton, Vec2, accesskit::Role};
use egui_kittest::{
    Harness,
    kittest::{NodeT, Queryable},
};

use super::{bits, document, drag, editor, opening, project};

fn press(harness: &mut Harness<'_, Editor>, modifiers: Modifiers, key: Key) {
    harness.key_press_modifiers(modifiers, key);
    harness.step();
    harness.step();
}

/// A button goes down or up.
fn button(pos: egui::Pos2, button: PointerButton, pressed: bool) -> Event {
    Event::PointerButton {
        pos,
        button,
        pressed,
        modifiers: Modifiers::NONE,
    }
}

/// Moves the pointer there, in a frame of its own.
fn hover(harness: &mut Harness<'_, Editor>, at: egui::Pos2) {
    harness.hover_at(at);
    harness.step();
}

/// A slider's value.
fn number(harness: &Harness<'_, Editor>, slider: &str) -> f64 {
    let found = harness.get_by_role_and_label(Role::Slider, slider);
    found.accesskit_node().numeric_value().unwrap()
}

/// The editor under Blender's preset.
fn blender(folder: &std::path::Path) -> Harness<'static, Editor> {
    let mut harness = editor(&project(folder));
    let mut settings = Settings::of_session();
    settings
        .change(|values| values.navigation = Navigation::Blender)
        .unwrap();
    harness.state_mut().use_settings(settings);
    harness.step();
    harness
}

#[test]
fn blenders_mouse_and_number_keys_look_around() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = blender(folder.path());
    let clean = bits(&harness);
    let middle = harness.get_by_label("Viewport").rect().center();
    // Position of the eye and direction to it.
    let pose = |harness: &Harness<'_, Editor>| {
        let rows = harness.state().camera_pose().unwrap().world_from_camera;
        [3, 2].map(|column| glam::Vec3::from_array([0, 1, 2].map(|row| rows[row][column])))
    };
    let mut dragged = |modifiers: Modifiers| {
        let before = pose(&harness);
        hover(&mut harness, middle);
        harness.event_modifiers(button(middle, PointerButton::Middle, true), modifiers);
        harness.step();
        hover(&mut harness, middle + Vec2::new(0.0, -60.0));
        harness.event(button(
            middle + Vec2::new(0.0, -60.0),
            PointerButton::Middle,
            false,
        ));
        harness.step();
        (before, pose(&harness))
    };
    let ([_, before], [_, after]) = dragged(Modifiers::NONE);
    assert!(before.distance(after) > 0.1, "the middle button orbits");
    let ([eye, before], [moved, after]) = dragged(Modifiers::SHIFT);
    assert!(before.distance(after) < 1e-5 && (moved - eye).dot(before).abs() < 1e-4);
    assert!(moved.distance(eye) > 0.01, "with Shift it pans");
    let ([eye, before], [moved, after]) = dragged(Modifiers::COMMAND);
    assert!(before.distance(after) < 1e-5 && (moved - eye).normalize().dot(before) < -0.999);

    for (modifiers, key, side) in [
        (Modifiers::NONE, Key::Num1, glam::Vec3::Z),
        (Modifiers::COMMAND, Key::Num1, glam::Vec3::NEG_Z),
        (Modifiers::NONE, Key::Num3, glam::Vec3::X),
        (Modifiers::COMMAND, Key::Num3, glam::Vec3::NEG_X),
        (Modifiers::NONE, Key::Num7, glam::Vec3::Y),
        (Modifiers::COMMAND, Key::Num7, glam::Vec3::NEG_Y),
    ] {
        press(&mut harness, modifiers, key);
        assert!(pose(&harness)[1].dot(side) > 0.999, "{key:?}");
    }
    let far = pose(&harness);
    press(&mut harness, Modifiers::NONE, Key::Home);
    assert!(pose(&harness) != far);
    assert!(bits(&harness) == clean && document(&harness).undo_label().is_none());
}

#[test]
fn f_and_shift_f_set_the_brush_until_a_click() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = blender(folder.path());
    let clean = bits(&harness);
    let middle = harness.get_by_label("Viewport").rect().center();
    let (radius, strength) = (number(&harness, "Radius"), number(&harness, "Strength"));
    hover(&mut harness, middle);
    press(&mut harness, Modifiers::NONE, Key::F);
    hover(&mut harness, middle + Vec2::new(40.0, 0.0));
    harness.step();
    let larger = number(&harness, "Radius");
    assert!(larger > 1.2 * radius, "{larger} from {radius}");
    harness.drag_at(middle + Vec2::new(40.0, 0.0));
    harness.step();
    harness.drop_at(middle + Vec2::new(40.0, 0.0));
    harness.step();
    hover(&mut harness, middle);
    assert_eq!(number(&harness, "Radius"), larger, "a click keeps it");
    assert!(bits(&harness) == clean, "and paints nothing");

    press(&mut harness, Modifiers::SHIFT, Key::F);
    hover(&mut harness, middle - Vec2::new(60.0, 0.0));
    harness.step();
    assert!(number(&harness, "Strength") < strength);
    press(&mut harness, Modifiers::NONE, Key::Escape);
    assert_eq!(number(&harness, "Strength"), strength, "Esc puts it back");
    drag(&mut harness, Vec2::new(-40.0, 0.0), Vec2::new(40.0, 0.0), 3);
    assert!(bits(&harness) != clean, "the next drag paints");
}

#[test]
fn the_key_of_the_unpainted_hair_can_be_changed() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = editor(&project(folder.path()));
    drag(&mut harness, Vec2::new(-80.0, 0.0), Vec2::new(80.0, 0.0), 4);
    let mut settings = Settings::of_session();
    settings
        .change(|values| {
            values.keys.insert("before".to_owned(), vec!["U".to_owned()]);
        })
        .unwrap();
    harness.state_mut().use_settings(settings);
    harness.step();
    for (key, shows) in [(Key::B, false), (Key::U, true)] {
        harness.key_down(key);
        harness.step();
        assert_eq!(harness.state().shows_before(), shows, "{key:?}");
        harness.key_up(key);
        harness.step();
        assert!(!harness.state().shows_before());
    }
}

/// Pressed and released between two frames, a click still is one.
#[test]
fn a_click_within_one_frame_counts() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = editor(&project(folder.path()));
    let clean = bits(&harness);
    let middle = harness.get_by_label("Viewport").rect().center();
    hover(&mut harness, middle);
    let events = [true, false].map(|pressed| button(middle, PointerButton::Primary, pressed));
    harness.input_mut().events.extend(events);
    harness.step();
    harness.step();
    assert!(bits(&harness) != clean);
    assert_eq!(document(&harness).history_labels().1, 1);
}

/// Where a slow frame has the whole stroke, it runs where the pointer did.
#[test]
fn a_stroke_within_one_frame_is_that_of_many() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = editor(&project(folder.path()));
    let middle = harness.get_by_label("Viewport").rect().center();
    let way = [(-60.0, 0.0), (0.0, 50.0), (60.0, 0.0)].map(|(x, y)| middle + Vec2::new(x, y));
    hover(&mut harness, way[0]);
    let moves = way.map(Event::PointerMoved);
    let mut events = vec![button(way[0], PointerButton::Primary, true)];
    events.extend(moves);
    events.push(button(way[2], PointerButton::Primary, false));
    harness.input_mut().events.extend(events.clone());
    harness.step();
    hover(&mut harness, way[0]);
    for event in events {
        harness.input_mut().events.push(event);
        harness.step();
    }
    let [swift, slow] = &document(&harness).project().operations[..] else {
        panic!("{:?}", document(&harness).history_labels());
    };
    assert!(swift.dabs.len() > 4 && swift.dabs == slow.dabs);
}

/// A stroke meets the hair before there is a picture of it, here because the sky's lights are still fitted.
#[test]
fn strokes_before_the_first_picture_meet_the_hair() {
    let folder = tempfile::tempdir().unwrap();
    let groom = project(folder.path()).with_file_name("curtain.hair");
    let mut harness = opening(Some(&groom), folder.path());
    let start = std::time::Instant::now();
    while harness.state().document().is_none() {
        harness.step();
        assert!(start.elapsed().as_secs() < 60);
    }
    let clean = bits(&harness);
    drag(&mut harness, Vec2::new(-60.0, 0.0), Vec2::new(60.0, 0.0), 4);
    assert_eq!(harness.state().frames_shown(), 0, "too late to tell");
    assert!(bits(&harness) != clean);
    assert!(document(&harness).project().operations[0].dabs.len() > 3);
}
