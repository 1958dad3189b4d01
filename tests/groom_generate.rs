//! Generated hair, and the bundled samples that it made.

use balayage_render::groom::{
    DEFAULT_MAX_TURN_RAD, GeneratorSettings, Groom, HairStyle, Mesh, RefinedGroom, generate, read_groom,
    undergrowth, write_groom,
};
use balayage_tests::{POISON, repository};
use glam::Vec3;
use rayon::prelude::*;

use crate::groom::assert_sound;

fn head() -> Mesh {
    Mesh::read_obj(repository("projects/head.obj")).unwrap()
}

const SAMPLES: [(&str, HairStyle); 3] = [
    ("long-straight", HairStyle::Straight),
    ("wavy-bob", HairStyle::Wavy),
    ("curly", HairStyle::Curly),
];

/// The samples of `projects/grooms` are what the generator makes of its own settings.
/// `BALAYAGE_WRITE_SAMPLES=1 cargo test --workspace --test suite bundled_samples` writes them anew.
#[test]
fn bundled_samples_are_what_the_generator_makes() {
    let head = head();
    for (name, style) in SAMPLES {
        let groom = generate(&GeneratorSettings::new(style), &head).unwrap();
        let path = repository(&format!("projects/grooms/{name}.hair"));
        if std::env::var_os("BALAYAGE_WRITE_SAMPLES").is_some() {
            write_groom(&path, &groom).unwrap();
        }
        // Sines differ between platforms in their last bits; growth may not amplify them to a tenth of a millimetre.
        let bundled = read_groom(&path, None).unwrap().groom;
        assert_eq!(bundled.first_point(), groom.first_point(), "{name}");
        let apart = bundled
            .positions()
            .iter()
            .zip(groom.positions())
            .map(|(a, b)| a.distance(*b))
            .fold(0.0, f32::max);
        assert!(apart < 1.0e-4, "{name}: {apart} m apart");
    }
}

#[test]
fn samples_are_light_enough_for_software_rendering() {
    for (name, _) in SAMPLES {
        let groom = read_groom(repository(&format!("projects/grooms/{name}.hair")), None)
            .unwrap()
            .groom;
        let vertices = RefinedGroom::new(&groom, DEFAULT_MAX_TURN_RAD).point_count();
        assert!(
            groom.point_count() <= 60_000 && vertices <= 270_000,
            "{name}: {} points, {vertices} vertices",
            groom.point_count()
        );
    }
}

#[test]
fn short_hair_grows_over_the_scalp_and_not_over_the_face() {
    let head = head();
    let (low, high) = head.bounds();
    for (name, _) in SAMPLES {
        let groom = read_groom(repository(&format!("projects/grooms/{name}.hair")), None)
            .unwrap()
            .groom;
        let shares = undergrowth(&head, &groom);
        assert_eq!(shares.len(), head.positions().len());
        for (p, share) in head.positions().iter().zip(shares) {
            assert!((0.0..=1.0).contains(&share), "{name} at {p}: {share}");
            let face = p.y < 0.75 && p.z > low.z + 0.8 * (high.z - low.z);
            let top = p.y > high.y - 0.02;
            assert!(!face || share == 0.0, "{name}: {share} of the face at {p}");
            assert!(!top || share > 0.7, "{name}: {share} of the scalp at {p}");
        }
    }
}

#[test]
fn equal_seeds_give_equal_hair() {
    let head = head();
    let mut settings = GeneratorSettings {
        strand_count: 60,
        ..GeneratorSettings::new(HairStyle::Wavy)
    };
    let first = generate(&settings, &head).unwrap();
    assert_eq!(first, generate(&settings, &head).unwrap());
    settings.seed = 2;
    assert_ne!(first.positions(), generate(&settings, &head).unwrap().positions());
}

/// Share of points that lie inside the head, by counting the crossings of a ray towards +y against every triangle.
fn share_inside(head: &Mesh, groom: &Groom, step: usize) -> f64 {
    let inside = |p: Vec3| {
        let crossings = (0..head.triangles().len())
            .filter(|&t| {
                // A ray in +y crosses where the triangle's shadow on y = 0 holds the point and the plane is above it.
                let [a, b, c] = head.corners(t).map(|q| q - p);
                let edge = |a: Vec3, b: Vec3| a.x * b.z - a.z * b.x;
                let (wa, wb, wc) = (edge(b, c), edge(c, a), edge(a, b));
                let sum = wa + wb + wc;
                let covers = (wa > 0.0) == (wb > 0.0) && (wb > 0.0) == (wc > 0.0) && sum != 0.0;
                covers && (wa * a.y + wb * b.y + wc * c.y) / sum > 0.0
            })
            .count();
        crossings % 2 == 1
    };
    // The root lies on the skin; it may be on either side of it by rounding.
    let points: Vec<Vec3> = (0..groom.strand_count())
        .step_by(step)
        .flat_map(|s| groom.positions()[groom.strand(s)][1..].to_vec())
        .collect();
    points.par_iter().filter(|&&p| inside(p)).count() as f64 / points.len() as f64
}

#[test]
fn hair_does_not_pass_through_the_head() {
    let head = head();
    // The test can tell: the middle of the head is inside, a point above it is not.
    let inner: Vec<Vec3> = (0..5)
        .map(|i| Vec3::new(0.001, 0.76 + 0.002 * i as f32, 0.06))
        .collect();
    let outer: Vec<Vec3> = inner.iter().map(|p| p + Vec3::Y).collect();
    assert_eq!(
        share_inside(&head, &Groom::from_strands([inner], 1.0e-4, 1.0).unwrap().0, 1),
        1.0
    );
    assert_eq!(
        share_inside(&head, &Groom::from_strands([outer], 1.0e-4, 1.0).unwrap().0, 1),
        0.0
    );

    for (name, _) in SAMPLES {
        let groom = read_groom(repository(&format!("projects/grooms/{name}.hair")), None)
            .unwrap()
            .groom;
        let share = share_inside(&head, &groom, 17);
        assert!(share < 0.002, "{name}: {share} of the points are inside the head");
    }
}

#[test]
fn hair_grows_on_the_scalp_and_leaves_the_face_free() {
    for (name, _) in SAMPLES {
        let groom = read_groom(repository(&format!("projects/grooms/{name}.hair")), None)
            .unwrap()
            .groom;
        assert_sound(&groom);
        let mut on_face = 0;
        for strand in 0..groom.strand_count() {
            let points = &groom.positions()[groom.strand(strand)];
            // No root below the nape or on the face.
            assert!(
                points[0].y > 0.65 && !(points[0].z > 0.13 && points[0].y < 0.79),
                "{name}: {}",
                points[0]
            );
            on_face += usize::from(
                points
                    .iter()
                    .any(|p| p.x.abs() < 0.04 && p.z > 0.12 && (0.63..0.76).contains(&p.y)),
            );
        }
        assert!(
            on_face * 50 < groom.strand_count(),
            "{name}: {on_face} strands cross the face"
        );
    }
}

#[test]
fn settings_out_of_range_are_refused_by_name() {
    let head = head();
    let fine = GeneratorSettings {
        strand_count: 3,
        ..GeneratorSettings::new(HairStyle::Curly)
    };
    type Set = fn(&mut GeneratorSettings, f32);
    let fields: [(&str, Set); 8] = [
        ("length_m", |s, x| s.length_m = x),
        ("diameter_m", |s, x| s.diameter_m = x),
        ("frizz", |s, x| s.frizz = x),
        ("clumping", |s, x| s.clumping = x),
        ("curl_radius_m", |s, x| s.curl_radius_m = x),
        ("curl_pitch_m", |s, x| s.curl_pitch_m = x),
        ("volume_m", |s, x| s.volume_m = x),
        ("parting", |s, x| s.parting = x),
    ];
    for (name, set) in fields {
        let mut refused = 0;
        for poison in POISON {
            let mut settings = fine.clone();
            set(&mut settings, poison);
            match generate(&settings, &head) {
                Ok(groom) => assert_sound(&groom),
                Err(error) => {
                    refused += 1;
                    assert!(
                        error.to_string().contains(name) || name == "length_m",
                        "{name} = {poison}: {error}"
                    );
                }
            }
        }
        assert!(refused >= 5, "{name}: only {refused} refused");
    }
    let few = GeneratorSettings {
        points_per_strand: 20,
        ..fine.clone()
    };
    assert!(
        generate(&few, &head)
            .unwrap_err()
            .to_string()
            .contains("points_per_strand = 20")
    );
    let none = GeneratorSettings {
        strand_count: 0,
        ..fine
    };
    assert!(
        generate(&none, &head)
            .unwrap_err()
            .to_string()
            .contains("strand_count")
    );
}

#[test]
fn a_mesh_without_scalp_is_refused() {
    let floor = Mesh::parse_obj(b"v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n", "floor.obj").unwrap();
    let error = generate(&GeneratorSettings::new(HairStyle::Straight), &floor)
        .unwrap_err()
        .to_string();
    assert!(error.contains("no triangle lies above the hairline"), "{error}");
}
