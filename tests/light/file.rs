//! Light lists: written, read back, refused with a place and a reason.

use std::path::Path;

use balayage_render::light::LightSet;
use balayage_tests::{POISON, damage};
use glam::Vec3;

use super::three_lights;

#[test]
fn light_files_come_back_exactly() {
    let mut lights = three_lights();
    lights.constant = Vec3::new(0.1, 1e-20, 3.0e30);
    let file = tempfile::NamedTempFile::new().unwrap();
    lights.write(file.path()).unwrap();
    let back = LightSet::read(file.path()).unwrap();
    for (a, b) in lights.lights.iter().zip(&back.lights) {
        assert!(a.direction.abs_diff_eq(b.direction, 1e-6));
        assert_eq!((a.bandwidth, a.radiance), (b.bandwidth, b.radiance));
    }
    assert_eq!((lights.constant, 3), (back.constant, back.lights.len()));
}

#[test]
fn light_files_are_refused_with_light_and_field() {
    let read = |text: &str| LightSet::from_json(text, Path::new("l.json"));
    let light = |direction: &str, bandwidth: &str, radiance: &str| {
        let good = r#"{"direction": [0, 1, 0], "bandwidth": 1, "radiance": [1, 1, 1]}"#;
        let light =
            format!(r#"{{"direction": {direction}, "bandwidth": {bandwidth}, "radiance": {radiance}}}"#);
        read(&format!(r#"{{"lights": [{good}, {light}]}}"#))
    };
    let up = "[0, 1, 0]";
    assert!(light("[0, 1.005, 0]", "10", up).is_ok_and(|set| set.lights[1].direction == Vec3::Y));
    let cases = [
        (light("[0, 2, 0]", "1", up), "light 1, direction", "length 2"),
        (light("[0, 0, 0]", "1", up), "light 1, direction", "length 0"),
        (light(up, "0", up), "light 1, bandwidth", "0 is not in"),
        (light(up, "-1", up), "light 1, bandwidth", "-1 is not in"),
        (light(up, "11", up), "light 1, bandwidth", "11 is not in"),
        (light(up, "1e39", up), "light 1", "inf"),
        (
            light(up, "1", "[1, -1, 0]"),
            "light 1, radiance",
            "not finite and at least 0",
        ),
        (
            light(up, "1", "[1, 1e39, 0]"),
            "light 1, radiance",
            "not finite and at least 0",
        ),
        (light(up, "1", "[1, 1]"), "light 1", "invalid length"),
        (light(up, "\"wide\"", up), "light 1", "invalid type"),
        (
            read(r#"{"lights": [], "constant": [0, -1, 0]}"#),
            "constant",
            "not finite",
        ),
        (read(r#"{"lights": [], "extra": 1}"#), "line 1", "unknown field"),
        (
            read(r#"{"lights": [{"bandwidth": 1}]}"#),
            "light 0",
            "missing field",
        ),
        (read("{"), "line 1", "EOF"),
        (read("[]"), "line 1", ""),
    ];
    for (number, (result, place, reason)) in cases.into_iter().enumerate() {
        let error = result.expect_err("a bad file was read");
        let text = error.to_string();
        assert!(
            text.starts_with("l.json: ") && text.contains(place) && text.contains(reason),
            "{number}: {text}"
        );
    }

    // What would not be read back is not written.
    for poison in POISON {
        let mut lights = three_lights();
        lights.lights[2].bandwidth = poison;
        let file = tempfile::NamedTempFile::new().unwrap();
        let is_good = poison > 0.0 && poison <= 10.0;
        assert_eq!(lights.write(file.path()).is_ok(), is_good, "{poison}");
        assert_eq!(LightSet::read(file.path()).is_ok(), is_good, "{poison}");
    }
}

#[test]
fn damaged_light_lists_are_refused_or_sound() {
    let text = three_lights().to_json();
    let mut refused = 0;
    damage(text.as_bytes(), 64, 5, |bytes| {
        match LightSet::from_json(&String::from_utf8_lossy(bytes), Path::new("lights.json")) {
            Ok(read) => assert!(
                read.constant.is_finite()
                    && read.lights.iter().all(|l| {
                        l.direction.is_normalized()
                            && l.bandwidth > 0.0
                            && l.radiance.is_finite()
                            && l.radiance.min_element() >= 0.0
                    })
            ),
            Err(error) => {
                assert!(error.to_string().starts_with("lights.json: "));
                refused += 1;
            }
        }
    });
    assert!(refused > 100, "{refused} refused");
}
