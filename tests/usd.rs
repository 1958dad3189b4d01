//! USD: what usd-core finds, round trips to the bit, bases and transforms, damaged files.
//!
//! The comparison with usd-core runs where a Python has it (pip install usd-core; `BALAYAGE_PYTHON` may name the Python), else it skips.

use std::path::{Path, PathBuf};

use balayage::document::{Document, Edit};
use balayage_render::groom::{
    Groom, LoadedUsd, PaintedValues, ReadOptions, hair_bytes, parse_hair, parse_tfx, parse_usd, tfx_bytes,
    usda_bytes,
};
use balayage_render::param::{Channel, LobeRatios, PigmentSet, PointValues};
use balayage_tests::{damage, python_with, script, test_data};
use glam::Vec3;
use rand::Rng;
use serde_json::json;

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
    parse_usd(bytes, "test.usda", ReadOptions::default()).unwrap()
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
    let values: Vec<_> = values.collect();
    let ratios = values.iter().map(|value| LobeRatios {
        beta_tt: value.eta,
        ..LobeRatios::default()
    });
    PaintedValues {
        ratios: ratios.collect(),
        values,
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
        let usd = parse_usd(&bytes, name, ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
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
    let Some(python) = python_with("pxr") else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("painted.usda");
    let groom = wild_groom(21, 40, false);
    let painted = painted(&groom, 22);
    std::fs::write(&file, usda_bytes(&groom, Some(&painted)).unwrap()).unwrap();
    // A layer that usdchecker must not like.
    let bad = folder.path().join("bad.usda");
    std::fs::write(&bad, layer("")).unwrap();
    let answer = script(&python, "tests/usd/counts.py", &[&file, &bad]);
    assert_ne!(answer[bad.to_str().unwrap()]["complaints"], json!([]));
    let answer = &answer[file.to_str().unwrap()];
    assert_eq!(answer["complaints"], json!([]));
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
    assert_eq!(answer["sigma_a"], json!(bits));
}

#[test]
fn blender_sees_curves_and_primvars() {
    let Some(python) = python_with("bpy") else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("painted.usda");
    let groom = wild_groom(23, 40, false);
    let painted = painted(&groom, 24);
    std::fs::write(&file, usda_bytes(&groom, Some(&painted)).unwrap()).unwrap();
    let answer = script(&python, "tests/blender_import.py", &[&file]);
    let seen = &answer["objects"]["strands"];
    assert_eq!(seen["curves"], groom.strand_count());
    assert_eq!(seen["points"], groom.point_count());
    let names = Channel::ALL.map(|channel| format!("balayage:{}", channel.name()));
    for name in names
        .iter()
        .map(String::as_str)
        .chain(["balayage:sigma_a", "displayColor"])
    {
        let [domain, _, count] = &seen["attributes"][name].as_array().unwrap()[..] else {
            panic!("{name}: {seen}");
        };
        assert_eq!(
            (domain, count),
            (&json!("POINT"), &json!(groom.point_count())),
            "{name}"
        );
    }
    let first = painted.values[0]
        .vertex_params(painted.pigments, &LobeRatios::default())
        .sigma_a;
    assert_eq!(seen["first_sigma_a"], json!(first.map(f64::from)));
    assert!((seen["first_radius"].as_f64().unwrap() - f64::from(groom.diameters()[0]) / 2.0).abs() < 1e-9);
}

#[test]
fn usd_core_counts_what_the_table_says() {
    let Some(python) = python_with("pxr") else { return };
    let mut files = Vec::new();
    for (name, ..) in FETCHED {
        let Some(path) = test_data(&format!("fetched/hair/{name}")) else {
            return;
        };
        files.push(path);
    }
    let paths: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
    let answer = script(&python, "tests/usd/counts.py", &paths);
    for ((name, curves, points), path) in FETCHED.iter().zip(paths) {
        let counted = &answer[path.to_str().unwrap()];
        assert_eq!(
            (&counted["curves"], &counted["points"]),
            (&json!(curves), &json!(points)),
            "{name}"
        );
    }
}

#[test]
fn a_painted_document_comes_back_through_usd_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = Document::sample().unwrap().document;
    let mut layer = document.project().layers[0].clone();
    layer.ratios = Some(
        LobeRatios {
            alpha_tt: -0.4,
            ..LobeRatios::default()
        }
        .into(),
    );
    layer.opacity = 0.7;
    document.apply(Edit::SetLayer(layer)).unwrap();
    let file = folder.path().join("out.usda");
    let groom = document.groom_as_drawn().unwrap();
    std::fs::write(&file, usda_bytes(&groom, Some(&document.painted())).unwrap()).unwrap();
    let again = Document::open(&file, None).unwrap().document;
    let bits = |document: &Document| -> Vec<u32> { bytemuck::cast_slice(document.params()).to_vec() };
    assert!(bits(&document) == bits(&again), "parameters differ");
    assert!(document.values() == again.values());
    assert_eq!(*groom, **again.groom());
    assert!(
        document.params()[0]
            != PointValues::default().vertex_params(PigmentSet::Deon2011, &LobeRatios::default())
    );
}

#[test]
fn partial_paint_is_used_and_what_is_missing_said() {
    let body = |paint: &str| {
        layer(&format!(
            "uniform token type = \"linear\"\nint[] curveVertexCounts = [2, 3]\n\
             point3f[] points = [(0,0,0), (0,1,0), (1,0,0), (1,0,0), (1,1,0)]\n{paint}"
        ))
    };
    let text = body(
        "float[] primvars:balayage:eta = [1.4, 1.6] (interpolation = \"uniform\")\n\
         float3[] primvars:balayage:dye = [(1, 2, 3)] (interpolation = \"constant\")\n\
         float[] primvars:balayage:eumelanin = [0, 1, 2, 3, 4] (interpolation = \"vertex\")\n\
         float[] primvars:balayage:beta_deg = [5, 6, 7, 8, 9] (interpolation = \"varying\")\n\
         float[] primvars:balayage:pheomelanin = [0.5, 0.25] (interpolation = \"vertex\")\n\
         int[] primvars:balayage:pheomelanin:indices = [0, 1, 0, 0, 1]\n\
         float[] primvars:balayage:bleach = [0, 0, 1] (interpolation = \"vertex\")\n\
         float[] primvars:balayage:alpha_deg = [99]",
    );
    let usd = read(text.as_bytes());
    let painted = usd.painted.unwrap();
    let column = |of: fn(&PointValues) -> f32| painted.values.iter().map(of).collect::<Vec<_>>();
    // The third curve point repeats the one before it: its values go with it.
    assert_eq!(column(|v| v.eta), [1.4, 1.4, 1.6, 1.6]);
    assert_eq!(column(|v| v.eumelanin), [0.0, 1.0, 2.0, 4.0]);
    assert_eq!(column(|v| v.beta_deg), [5.0, 6.0, 7.0, 9.0]);
    assert_eq!(column(|v| v.pheomelanin), [0.5, 0.25, 0.5, 0.25]);
    assert!(painted.values.iter().all(|v| v.dye == [1.0, 2.0, 3.0]));
    assert_eq!(column(|v| v.bleach), [0.0; 4]);
    assert_eq!(column(|v| v.alpha_deg), [PointValues::default().alpha_deg; 4]);
    let notes = usd.loaded.report.notes.join("\n");
    for said in [
        "/c: primvars:balayage:bleach is not used: 3 numbers of 1 a value fit no interpolation (5 vertex",
        "primvars:balayage:alpha_deg is not used: 99 is outside -30 to 30",
        "primvars:balayage:eccentricity is missing; 1 stands for it",
        "primvars:balayage:alpha_ratios is missing",
    ] {
        assert!(notes.contains(said), "{said}: {notes}");
    }
    assert!(
        !notes.contains("eta is missing") && !notes.contains("dye is"),
        "{notes}"
    );

    // Absorption alone is a dye; an unpainted file says nothing.
    let usd = read(body("float3[] primvars:balayage:sigma_a = [(1, 2, 3)]").as_bytes());
    let value = usd.painted.unwrap().values[3];
    let params = value.vertex_params(PigmentSet::Deon2011, &LobeRatios::default());
    assert_eq!(params.sigma_a, [1.0, 2.0, 3.0]);
    let usd = read(body("").as_bytes());
    assert!(usd.painted.is_none() && usd.loaded.report.notes.is_empty());
}

#[test]
fn paint_on_cubic_curves_follows_them_within_its_range() {
    let text = layer(
        "uniform token type = \"cubic\"\nuniform token basis = \"catmullRom\"\nuniform token wrap = \"pinned\"\n\
         int[] curveVertexCounts = [4]\npoint3f[] points = [(0,0,0), (0,1,0), (0,2,0), (0,3,0)]\n\
         float[] primvars:balayage:eumelanin = [0, 1, 2, 3] (interpolation = \"vertex\")\n\
         float[] primvars:balayage:bleach = [0, 1, 1, 0] (interpolation = \"vertex\")\n\
         float[] primvars:balayage:eta = [1.1, 1.2, 1.3, 1.4] (interpolation = \"varying\")",
    );
    let usd = read(text.as_bytes());
    let values = usd.painted.unwrap().values;
    for (p, value) in usd.loaded.groom.positions().iter().zip(&values) {
        assert!((value.eumelanin - p.y).abs() < 1e-5);
        assert!((value.eta - (1.1 + 0.1 * p.y)).abs() < 1e-5);
        assert!((0.0..=1.0).contains(&value.bleach));
    }
    // A curve between two equal values overshoots them: the range holds.
    assert!(values.iter().filter(|value| value.bleach == 1.0).count() > 2);
}

#[test]
fn pigments_of_two_prims_that_differ_are_said() {
    let prim = |name: &str, pigments: &str| {
        format!(
            "def BasisCurves \"{name}\"\n{{\nuniform token type = \"linear\"\nint[] curveVertexCounts = [2]\n\
             point3f[] points = [(0,0,0), (0,1,0)]\n{pigments}\n}}\n"
        )
    };
    let named = |name: &str, set: &str| {
        let paint = format!(
            "custom uniform token balayage:pigments = \"{set}\"\nfloat[] primvars:balayage:eta = [1.5]"
        );
        prim(name, &paint)
    };
    let text = format!(
        "#usda 1.0\n(\n metersPerUnit = 1\n)\n{}{}{}",
        prim("plain", ""),
        named("a", "cycles"),
        named("b", "deon2011")
    );
    let usd = read(text.as_bytes());
    let painted = usd.painted.unwrap();
    assert_eq!(painted.pigments, PigmentSet::Cycles);
    assert_eq!(painted.values.len(), 6);
    assert_eq!(painted.values[0], PointValues::default());
    let notes = usd.loaded.report.notes.join("\n");
    assert!(notes.contains("deon2011 are taken for cycles"), "{notes}");
    assert!(
        notes.contains("1 prims of curves have no painted primvars"),
        "{notes}"
    );
    assert!(
        notes.contains("/a and 1 other prims: primvars:balayage:dye is missing"),
        "{notes}"
    );
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
        let options = ReadOptions {
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
        let error = parse_usd(text.as_bytes(), "bad.usda", ReadOptions::default())
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
            match parse_usd(bytes, "damaged.usd", ReadOptions::default()) {
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
