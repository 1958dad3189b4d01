//! Grooms: cleaning, arc length, hash, files in and out, real files.

use balayage_render::groom::{
    Groom, GroomBuilder, GroomError, LoadedGroom, RefinedGroom, UnitSource, hair_bytes, parse_hair,
    parse_tfx, read_groom, tfx_bytes, write_groom,
};
use balayage_tests::{POISON, repository, test_data};
pub use balayage_tests::{assert_sound, wild_groom};
use glam::Vec3;

#[test]
fn cleaning_repairs_and_counts_each_fault_once() {
    let x = |x: f32| Vec3::new(x, 0.0, 0.0);
    let mut builder = GroomBuilder::new();
    builder.push_strand([
        (x(0.0), Some(0.1)),
        (x(f32::NAN), Some(0.1)),
        (x(0.1), Some(-1.0)),
        (x(0.1), Some(0.1)),
        (x(2.0e7), Some(0.1)),
        (x(0.2), Some(f32::INFINITY)),
        (x(0.3), None),
    ]);
    builder.push_strand([(x(0.5), Some(0.1)), (x(f32::INFINITY), None)]);
    builder.push_strand([]);
    let (groom, report) = builder.finish("test", Some((0.01, UnitSource::Given))).unwrap();
    assert_sound(&groom);
    assert_eq!(groom.positions(), [x(0.0), x(0.1), x(0.2), x(0.3)]);
    // The default diameter is 0.08 mm, here in centimetres; a diameter that is absent was not repaired.
    for (&got, wanted) in groom.diameters().iter().zip([0.1, 0.008, 0.008, 0.008]) {
        assert!((got - wanted).abs() < 1.0e-7);
    }
    assert_eq!((report.strands, report.points, report.dropped_strands), (1, 4, 2));
    assert_eq!(
        (
            report.non_finite_points,
            report.absurd_points,
            report.duplicate_points
        ),
        (2, 1, 1)
    );
    assert_eq!((report.repaired_diameters, report.repairs()), (2, 8));
    let text = report.to_string();
    assert!(
        text.contains("2 NaN or infinite points dropped") && text.contains("0.01 m per unit"),
        "{text}"
    );
}

#[test]
fn builder_takes_every_poison_value() {
    for a in POISON {
        for b in POISON {
            for diameter in POISON {
                let strand = [Vec3::new(a, b, 0.0), Vec3::new(b, a, 1.0), Vec3::new(a, a, b)];
                match Groom::from_strands([strand], diameter, 1.0) {
                    Ok((groom, _)) => assert_sound(&groom),
                    Err(error) => assert!(matches!(error, GroomError::Refused { .. }), "{error}"),
                }
            }
        }
        let unit = Groom::from_strands([[Vec3::ZERO, Vec3::ONE]], 0.1, a);
        assert_eq!(unit.is_ok(), a.is_normal() && a > 0.0, "metres per unit {a}");
    }
}

#[test]
fn arc_runs_from_zero_to_one_in_proportion_to_length() {
    let groom = wild_groom(3, 50, false);
    let (arc, lengths) = (groom.arc(), groom.lengths());
    assert_eq!(lengths.len(), groom.strand_count());
    for (strand, length) in lengths.iter().enumerate() {
        let range = groom.strand(strand);
        assert_eq!((arc[range.start], arc[range.end - 1]), (0.0, 1.0));
        for point in range.start..range.end - 1 {
            let step = groom.positions()[point].distance(groom.positions()[point + 1]);
            let wanted = step / length;
            assert!((arc[point + 1] - arc[point] - wanted).abs() < 1.0e-6);
            assert!(arc[point + 1] > arc[point]);
        }
    }
}

#[test]
fn hash_tells_grooms_apart_and_ignores_the_unit() {
    let strands = [[Vec3::ZERO, Vec3::X, Vec3::Y], [Vec3::Z, Vec3::ONE, Vec3::X]];
    let hash = |strands: &[[Vec3; 3]], diameter, unit| {
        Groom::from_strands(strands, diameter, unit)
            .unwrap()
            .0
            .content_hash()
    };
    let first = hash(&strands, 0.1, 1.0);
    assert_eq!(first.len(), 64);
    assert_eq!(first, hash(&strands, 0.1, 0.01));
    assert_ne!(first, hash(&strands, 0.2, 1.0));
    assert_ne!(first, hash(&strands[..1], 0.1, 1.0));

    // An independent statement of what is hashed.
    let (groom, _) = Groom::from_strands(strands, 0.1, 1.0).unwrap();
    let mut bytes: Vec<u8> = Vec::new();
    for p in groom.positions() {
        for c in [p.x, p.y, p.z] {
            bytes.extend(c.to_le_bytes());
        }
    }
    bytes.extend([0.1_f32; 6].iter().flat_map(|d| d.to_le_bytes()));
    bytes.extend([0_u32, 3, 6].iter().flat_map(|i| i.to_le_bytes()));
    assert_eq!(first, blake3::hash(&bytes).to_hex().as_str());
}

#[test]
fn hair_round_trip_is_bit_equal() {
    for (seed, equal) in [(1, false), (2, true)] {
        let groom = wild_groom(seed, 40, equal);
        let back = parse_hair(&hair_bytes(&groom).unwrap(), "memory", None).unwrap();
        assert_eq!(back.groom, groom);
        assert_eq!(
            (back.report.repairs(), back.report.unit_source),
            (0, UnitSource::File)
        );
        // A given unit wins over the one in the file.
        let other = parse_hair(&hair_bytes(&groom).unwrap(), "memory", Some(2.0)).unwrap();
        assert_eq!(other.groom.metres_per_unit(), 2.0);
    }

    // Equal counts and diameters are held by the header alone.
    let (even, _) = Groom::from_strands([[Vec3::ZERO, Vec3::X]; 7], 0.3, 1.0).unwrap();
    let bytes = hair_bytes(&even).unwrap();
    assert_eq!(bytes.len(), 128 + 7 * 2 * 12);
    assert_eq!(parse_hair(&bytes, "memory", None).unwrap().groom, even);
}

#[test]
fn tfx_round_trip_keeps_positions() {
    let groom = wild_groom(4, 30, true);
    let back = parse_tfx(&tfx_bytes(&groom).unwrap(), "memory", Some(0.1)).unwrap();
    assert_eq!(back.groom.positions(), groom.positions());
    assert_eq!(back.groom.first_point(), groom.first_point());
    assert!(
        back.groom
            .diameters()
            .iter()
            .all(|&d| (d - 0.8e-3).abs() < 1.0e-9)
    );

    let uneven = tfx_bytes(&wild_groom(5, 30, false)).unwrap_err().to_string();
    assert!(
        uneven.contains(".tfx wants the same number") && uneven.contains("write .hair"),
        "{uneven}"
    );
}

#[test]
fn resampling_gives_equal_counts_on_the_same_curve() {
    let groom = wild_groom(8, 20, false);
    let (even, report) = groom.resampled(33).unwrap();
    assert_eq!(
        (even.strand_count(), even.point_count(), report.repairs()),
        (20, 20 * 33, 0)
    );
    assert!(tfx_bytes(&even).is_ok());
    for strand in 0..20 {
        let (a, b) = (groom.strand(strand), even.strand(strand));
        assert_eq!(groom.positions()[a.start], even.positions()[b.start]);
        assert_eq!(groom.positions()[a.end - 1], even.positions()[b.end - 1]);
        assert_eq!(groom.diameters()[a.end - 1], even.diameters()[b.end - 1]);
    }
    assert_eq!(even.resampled(33).unwrap().0, even);

    // Every point lies on the refined curve, closer than a chord of it can miss.
    let curve = RefinedGroom::new(&groom, 0.02);
    for strand in 0..20 {
        for &p in &even.positions()[even.strand(strand)] {
            let nearest = curve.positions()[curve.strand(strand)]
                .windows(2)
                .map(|c| {
                    let chord = c[1] - c[0];
                    p.distance(
                        c[0] + chord * ((p - c[0]).dot(chord) / chord.length_squared()).clamp(0.0, 1.0),
                    )
                })
                .fold(f32::MAX, f32::min);
            assert!(nearest < 2.0e-3, "{nearest} from the curve");
        }
    }
    assert!(groom.resampled(1).unwrap_err().to_string().contains("at least 2"));
}

#[test]
fn files_are_chosen_by_extension_and_errors_name_them() {
    let folder = tempfile::tempdir().unwrap();
    let groom = wild_groom(6, 10, true);
    for name in ["a.hair", "b.TFX"] {
        let path = folder.path().join(name);
        write_groom(&path, &groom).unwrap();
        assert_eq!(
            read_groom(&path, Some(0.1)).unwrap().groom.positions(),
            groom.positions()
        );
    }
    let message = |name: &str| {
        read_groom(folder.path().join(name), None)
            .unwrap_err()
            .to_string()
    };
    assert!(message("none.hair").contains("none.hair: cannot read"));
    assert!(message("strands.obj").contains("use .hair, .tfx, .usda, .usdc or .abc"));

    // A file in the clothes of another is refused at its first byte.
    std::fs::copy(folder.path().join("b.TFX"), folder.path().join("c.hair")).unwrap();
    std::fs::copy(folder.path().join("a.hair"), folder.path().join("d.tfx")).unwrap();
    assert!(message("c.hair").contains("c.hair: byte 0: it does not start with \"HAIR\""));
    assert!(message("d.tfx").contains("d.tfx: byte 0: the version is"));
}

#[test]
fn counts_that_lie_are_named_with_their_place() {
    let groom = wild_groom(7, 10, false);
    let mut bytes = hair_bytes(&groom).unwrap();
    bytes[4..8].copy_from_slice(&u32::MAX.to_le_bytes());
    let error = parse_hair(&bytes, "lie.hair", None).unwrap_err().to_string();
    assert!(
        error.contains("lie.hair: byte") && error.contains("segment counts needs 8589934590 bytes"),
        "{error}"
    );

    let mut bytes = tfx_bytes(&wild_groom(7, 10, true)).unwrap();
    bytes[4..12].fill(0xff);
    let error = parse_tfx(&bytes, "lie.tfx", None).unwrap_err().to_string();
    assert!(
        error.contains("lie.tfx: byte 160") && error.contains("positions needs"),
        "{error}"
    );

    // Four billion strands of no points need no bytes and must need no memory either.
    bytes[8..12].fill(0);
    assert!(
        parse_tfx(&bytes, "none.tfx", None)
            .unwrap_err()
            .to_string()
            .contains("no usable strand")
    );
}

#[test]
fn unit_is_guessed_from_the_size_of_the_hair() {
    for (extent, unit, source) in [
        (0.3, 1.0, UnitSource::Guessed),
        (3.0, 0.1, UnitSource::Guessed),
        (30.0, 0.01, UnitSource::Guessed),
        (300.0, 0.001, UnitSource::Guessed),
        (0.01, 1.0, UnitSource::Assumed),
        (30_000.0, 1.0, UnitSource::Assumed),
    ] {
        let (groom, _) = Groom::from_strands([[Vec3::ZERO, Vec3::X * extent]], 0.1, 1.0).unwrap();
        let loaded = parse_tfx(&tfx_bytes(&groom).unwrap(), "memory", None).unwrap();
        assert_eq!(
            (loaded.groom.metres_per_unit(), loaded.report.unit_source),
            (unit, source)
        );
    }
}

#[test]
fn sintel_is_the_same_from_tfx_and_from_hair() {
    let (Some(tfx), Some(hair)) = (
        test_data("fetched/hair/sintel_hair_16points_k4.tfx"),
        test_data("fetched/hair/sintel_hair_k4.hair"),
    ) else {
        return;
    };
    let (tfx, hair) = (read_groom(tfx, None).unwrap(), read_groom(hair, None).unwrap());
    assert_eq!(tfx.groom.positions(), hair.groom.positions());
    assert_eq!(tfx.groom.first_point(), hair.groom.first_point());
    assert_eq!(
        (tfx.groom.strand_count(), tfx.groom.point_count()),
        (2_850, 45_600)
    );
    assert_eq!((hair.groom.metres_per_unit(), hair.report.repairs()), (1.0, 0));
    assert_sound(&tfx.groom);
}

#[test]
fn real_grooms_read_with_the_counts_they_have() {
    let read = |name: &str| -> Option<LoadedGroom> {
        let loaded = read_groom(test_data(&format!("fetched/hair/{name}"))?, None).unwrap();
        assert_sound(&loaded.groom);
        println!("{name}: {}", loaded.report);
        Some(loaded)
    };
    for (name, strands) in [
        ("tressfx3_ponytail_back.tfx", 517),
        ("tressfx3_ponytail_all.hair", 4_933),
        ("tressfx3_bear_k8.tfx", 6_015),
        ("tressfx_ratboy_mohawk.tfx", 2_228),
    ] {
        let Some(loaded) = read(name) else { return };
        assert_eq!(
            loaded.report.strands + loaded.report.dropped_strands,
            strands,
            "{name}"
        );
        assert!(loaded.report.dropped_strands <= 9, "{name}");
        assert!(
            loaded.report.non_finite_points + loaded.report.absurd_points == 0,
            "{name}"
        );
    }
}

#[test]
fn bundled_grooms_are_sound_and_small() {
    for name in ["long-straight", "wavy-bob", "curly"] {
        let path = repository(&format!("projects/grooms/{name}.hair"));
        assert!(std::fs::metadata(&path).unwrap().len() <= 1_500_000, "{name}");
        let loaded = read_groom(&path, None).unwrap();
        assert_sound(&loaded.groom);
        assert_eq!(
            (loaded.report.repairs(), loaded.groom.metres_per_unit()),
            (0, 1.0),
            "{name}"
        );
    }
}
