//! USD: what usd-core finds, round trips to the bit, bases and transforms, damaged files.
//!
//! `BALAYAGE_USD_PYTHON` names a Python that has `usd-core` (pip install usd-core); without it the comparison skips.

use std::path::PathBuf;
use std::process::Command;

use balayage_render::groom::{
    Groom, LoadedUsd, PaintedValues, UsdOptions, hair_bytes, parse_hair, parse_tfx, parse_usd, tfx_bytes,
    usda_bytes,
};
use balayage_render::param::{Channel, LobeRatios, PigmentSet, PointValues};
use balayage_tests::{damage, test_data};
use glam::Vec3;
use rand::Rng;

use crate::groom::{assert_sound, wild_groom};

/// Every fetched USD file with the curves and control points that usd-core 26.11 reports (`tests/usd/counts.py`).
const FETCHED: [(&str, usize, usize); 14] = [
    ("arnoldusd_0171_catmull_widths.usda", 12, 84),
    ("arnoldusd_0179_hair_test.usda", 285, 3135),
    ("arnoldusd_0184_groom_sphere.usda", 118, 1534),
    ("arnoldusd_0189_grid_fur.usda", 2484, 22356),
    ("arnoldusd_0239_pinned.usda", 1987, 19870),
    ("arnoldusd_1334_catmull.usda", 3, 89),
    ("openusd_BasisCurves3.usda", 4051, 28357),
    ("openusd_basicCurves.usda", 7, 30),
    ("openusd_moreCurves.usda", 19, 97),
    ("openusd_pinnedCurves.usda", 4, 11),
    ("tinyusdz_curves.usda", 72, 648),
    ("tinyusdz_hair.usda", 10, 90),
    ("tinyusdz_hair.usdc", 10, 90),
    ("tinyusdz_hair_blender.usda", 1000, 9000),
];

fn read(bytes: &[u8]) -> LoadedUsd {
    parse_usd(bytes, "test.usda", UsdOptions::default()).unwrap()
}

/// A layer with one prim of curves.
fn layer(body: &str) -> String {
    format!(
        "#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\ndef BasisCurves \"c\"\n{{\n{body}\n}}\n"
    )
}

fn painted(groom: &Groom, seed: u64) -> PaintedValues {
    let mut random = balayage_tests::random(seed);
    let values = (0..groom.point_count()).map(|_| {
        let mut value = PointValues::default();
        for channel in Channel::ALL {
            let range = channel.range();
            value.set(
                channel,
                std::array::from_fn(|_| random.random_range(range.clone())),
            );
        }
        value
    });
    PaintedValues {
        values: values.collect(),
        pigments: PigmentSet::Cycles,
    }
}

#[test]
fn fetched_usd_files_have_the_counts_of_usd_core() {
    for (name, curves, points) in FETCHED {
        let Some(path) = test_data(&format!("fetched/hair/{name}")) else {
            return;
        };
        let bytes = std::fs::read(path).unwrap();
        let usd = parse_usd(&bytes, name, UsdOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((usd.curves, usd.control_points), (curves, points), "{name}");
        assert_sound(&usd.loaded.groom);
        assert_eq!(
            usd.loaded.groom.strand_count() + usd.loaded.report.dropped_strands,
            curves,
            "{name}"
        );
    }
}

#[test]
fn text_and_binary_of_one_hair_are_equal() {
    let (Some(text), Some(binary)) = (
        test_data("fetched/hair/tinyusdz_hair.usda"),
        test_data("fetched/hair/tinyusdz_hair.usdc"),
    ) else {
        return;
    };
    let (text, binary) = (std::fs::read(text).unwrap(), std::fs::read(binary).unwrap());
    let (text, binary) = (read(&text).loaded.groom, read(&binary).loaded.groom);
    assert_eq!(text.first_point(), binary.first_point());
    for (a, b) in text.positions().iter().zip(binary.positions()) {
        assert!(a.distance(*b) <= 1e-5 * a.length().max(1.0), "{a} {b}");
    }
}

#[test]
fn usda_returns_groom_and_paint_bit_for_bit() {
    for equal in [false, true] {
        let groom = wild_groom(11, 40, equal);
        let painted = painted(&groom, 12);
        let bytes = usda_bytes(&groom, Some(&painted)).unwrap();
        let usd = read(&bytes);
        assert_eq!(usd.loaded.groom, groom);
        assert_eq!(usd.painted.as_ref(), Some(&painted));
        // The comparison can fail: one value one bit off.
        let mut other = painted.clone();
        other.values[3].dye[1] = f32::from_bits(other.values[3].dye[1].to_bits() ^ 1);
        assert_ne!(usd.painted, Some(other));
        assert_eq!(read(&usda_bytes(&groom, None).unwrap()).painted, None);
    }
}

#[test]
fn sintel_is_one_groom_in_three_formats() {
    let Some(path) = test_data("fetched/hair/sintel_hair_16points_k4.tfx") else {
        return;
    };
    let tfx = parse_tfx(&std::fs::read(path).unwrap(), "sintel.tfx", Some(0.1))
        .unwrap()
        .groom;
    let hair = parse_hair(&hair_bytes(&tfx).unwrap(), "sintel.hair", None)
        .unwrap()
        .groom;
    let usda = read(&usda_bytes(&tfx, None).unwrap()).loaded.groom;
    let again = parse_tfx(&tfx_bytes(&usda).unwrap(), "sintel.tfx", Some(0.1))
        .unwrap()
        .groom;
    assert!(tfx == hair && tfx == usda && tfx == again);
}

#[test]
fn usd_core_reads_what_is_written() {
    let Some(python) = std::env::var_os("BALAYAGE_USD_PYTHON").map(PathBuf::from) else {
        eprintln!("skipped: BALAYAGE_USD_PYTHON names no Python with usd-core");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("painted.usda");
    let groom = wild_groom(21, 40, false);
    let painted = painted(&groom, 22);
    std::fs::write(&file, usda_bytes(&groom, Some(&painted)).unwrap()).unwrap();
    let script = balayage_tests::repository("tests/usd/counts.py");
    let output = Command::new(&python).arg(script).arg(&file).output().unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let answer = &answer[file.to_str().unwrap()];
    assert_eq!(answer["curves"], groom.strand_count());
    assert_eq!(answer["points"], groom.point_count());
    let bits: Vec<u32> = painted
        .values
        .iter()
        .flat_map(|value| {
            value
                .vertex_params(painted.pigments, &LobeRatios::default())
                .sigma_a
                .map(f32::to_bits)
        })
        .collect();
    assert_eq!(answer["sigma_a"], serde_json::json!(bits));
}

#[test]
fn bases_pass_where_they_must() {
    // Control points on a line, evenly spaced: every basis stays on it and goes its own way along it.
    let points = "point3f[] points = [(0,0,0), (0,1,0), (0,2,0), (0,3,0)]\nint[] curveVertexCounts = [4]";
    for (basis, wrap, first, last) in [
        ("bspline", "nonperiodic", 1.0, 2.0),
        ("catmullRom", "nonperiodic", 1.0, 2.0),
        ("bspline", "pinned", 0.0, 3.0),
        ("catmullRom", "pinned", 0.0, 3.0),
        ("bezier", "nonperiodic", 0.0, 3.0),
    ] {
        let text = layer(&format!(
            "uniform token type = \"cubic\"\nuniform token basis = \"{basis}\"\nuniform token wrap = \"{wrap}\"\n{points}\n\
             float[] widths = [1, 2, 3, 4] (interpolation = \"vertex\")"
        ));
        let groom = read(text.as_bytes()).loaded.groom;
        let (low, high) = (groom.positions()[0], *groom.positions().last().unwrap());
        assert!((low - Vec3::Y * first).length() < 1e-6, "{basis} {wrap}: {low}");
        assert!((high - Vec3::Y * last).length() < 1e-6, "{basis} {wrap}: {high}");
        // Widths are one more than the height, in every basis.
        for (p, d) in groom.positions().iter().zip(groom.diameters()) {
            assert!((d - 1.0 - p.y).abs() < 1e-5, "{basis} {wrap}");
        }
    }
}

#[test]
fn transforms_axes_times_and_widths() {
    let text = "#usda 1.0\n(\n metersPerUnit = 0.01\n upAxis = \"Z\"\n)\ndef Xform \"a\" (\n kind = \"group\"\n)\n{\n double3 xformOp:translate = (1, 2, 3)\n \
        float3 xformOp:rotateXYZ = (0, 0, 90)\n uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:rotateXYZ\"]\n def BasisCurves \"c\"\n {\n \
        uniform token type = \"linear\"\n int[] curveVertexCounts = [2, 3]\n point3f[] points.timeSamples = { 1: [(0,0,0), (1,0,0), (0,0,0), (0,1,0), (0,2,0)],\n \
        2: [(0,0,0), (5,0,0), (0,0,0), (0,1,0), (0,2,0)], }\n float[] widths = [0.1, 0.2] (\n interpolation = \"uniform\"\n )\n }\n}\n";
    let groom = |time| {
        let options = UsdOptions {
            time,
            metres_per_unit: None,
        };
        parse_usd(text.as_bytes(), "t.usda", options)
            .unwrap()
            .loaded
            .groom
    };
    // (1, 0, 0) turns to (0, 1, 0), moves to (1, 3, 3), and with y up is (1, 3, -3).
    assert!((groom(None).positions()[1] - Vec3::new(1.0, 3.0, -3.0)).length() < 1e-6);
    assert!((groom(Some(2.0)).positions()[1] - Vec3::new(1.0, 3.0, -7.0)).length() < 1e-6);
    let diameters = groom(Some(1.5)).diameters().to_vec();
    assert!(
        diameters
            .iter()
            .zip([0.1, 0.1, 0.2, 0.2, 0.2])
            .all(|(a, b)| (a - b).abs() < 1e-6)
    );
    assert_eq!(groom(None).metres_per_unit(), 0.01);
}

#[test]
fn refusals_name_place_and_reason() {
    for (text, reason) in [
        ("#usda 2.0\n".to_owned(), "byte 0"),
        (
            layer("int[] curveVertexCounts = [5]\npoint3f[] points = [(0,0,0)]"),
            "add up to 5",
        ),
        (layer("int[] curveVertexCounts = [1e]"), "line 8"),
        (layer("uniform token basis = \"hermite\""), "hermite"),
        (layer("point3f[] points = [(0,0"), "value is expected"),
        (layer(&"def \"x\" {".repeat(200)), "nested deeper"),
        (
            layer(&format!("int[] curveVertexCounts = {}", "[".repeat(100_000))),
            "nested deeper",
        ),
        (layer(""), "no usable strand"),
    ] {
        let error = parse_usd(text.as_bytes(), "bad.usda", UsdOptions::default())
            .unwrap_err()
            .to_string();
        assert!(
            error.starts_with("bad.usda") && error.contains(reason),
            "{reason}: {error}"
        );
    }
}

#[test]
fn damaged_usd() {
    let groom = wild_groom(31, 6, false);
    let text = usda_bytes(&groom, Some(&painted(&groom, 32))).unwrap();
    let mut files = vec![text];
    if let Some(path) = test_data("fetched/hair/tinyusdz_hair.usdc") {
        files.push(std::fs::read(path).unwrap());
    }
    for file in files {
        let mut read = 0;
        damage(&file, 400.min(file.len()), 33, |bytes| {
            match parse_usd(bytes, "damaged.usd", UsdOptions::default()) {
                Ok(usd) => {
                    read += 1;
                    assert_sound(&usd.loaded.groom);
                }
                Err(error) => assert!(error.to_string().starts_with("damaged.usd"), "{error}"),
            }
        });
        assert!(read > 0);
    }
}
