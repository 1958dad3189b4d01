//! The command line, in process: exit codes, messages, and that painting by command equals painting by hand.

use std::{fs, path::Path};

use balayage::{
    document::{Document, Edit, Layer},
    paint::StrokeFile,
};
use balayage_render::{
    groom::{read_groom, write_groom},
    image::Picture,
};
use serde_json::Value;

use crate::painting::tuft;

const STROKES: &str = r#"{"version": 1, "groom": null, "operations": [
    {"id": 1, "layer": "ends", "channel": "dye", "mode": "replace", "value": [0.1, 0.9, 2.5], "radius_m": 0.06, "strength": 0.9,
     "hardness": 0.2, "falloff": "smooth", "reach": "surface", "seed": 0,
     "dabs": [{"root": [5, 0, 5], "arc": 0.9, "position": [5.1, 10.3, 5.2], "pressure": 1},
              {"root": [9, 0, 5], "arc": 0.8, "position": [9.1, 9.3, 5.2], "pressure": 0.5}]},
    {"id": 2, "layer": "roots", "channel": "bleach", "mode": "add", "value": 0.6, "radius_m": 0.03, "strength": 1,
     "hardness": 0.5, "falloff": "linear", "reach": "strand", "seed": 0,
     "dabs": [{"root": [12, 0, 12], "arc": 0.1, "position": [12, 1, 12], "pressure": 1}]}]}"#;

/// Exit code, standard output and standard error of a command.
pub fn balayage(args: &[&str]) -> (u8, String, String) {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let args = std::iter::once("balayage").chain(args.iter().copied());
    let code = balayage::cli::run(args, &mut out, &mut err);
    (
        code,
        String::from_utf8(out).unwrap(),
        String::from_utf8(err).unwrap(),
    )
}

fn json(args: &[&str]) -> Value {
    let (code, out, err) = balayage(&[args, &["--json"]].concat());
    assert_eq!(code, 0, "{err}");
    serde_json::from_str(&out).unwrap()
}

/// The error of a command that refuses its input.
fn refused(args: &[&str]) -> String {
    let (code, out, err) = balayage(args);
    assert_eq!(code, 1, "{args:?}: {err}");
    assert!(
        out.is_empty() && err.lines().last().unwrap().starts_with("error: "),
        "{out}{err}"
    );
    err
}

/// A folder with `tuft.hair`, `strokes.json`, `lights.json` and `camera.json`.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_groom(folder.path().join("tuft.hair"), &tuft()).unwrap();
    fs::write(folder.path().join("strokes.json"), STROKES).unwrap();
    let lights = r#"{"lights": [{"direction": [0, 1, 0], "bandwidth": 0.5, "radiance": [3, 3, 3]}], "constant": [0.5, 0.5, 0.5]}"#;
    fs::write(folder.path().join("lights.json"), lights).unwrap();
    let camera = r#"{"world_from_camera": [[1,0,0,10],[0,1,0,6],[0,0,1,60],[0,0,0,1]], "fov_y_deg": 30}"#;
    fs::write(folder.path().join("camera.json"), camera).unwrap();
    folder
}

fn name(folder: &Path, file: &str) -> String {
    folder.join(file).to_str().unwrap().to_owned()
}

/// Painting through the command gives the document that the editor's edits give, bit for bit, also after reopening.
#[test]
fn paint_equals_painting_by_edits() {
    let folder = folder();
    let at = |file: &str| name(folder.path(), file);
    let report = json(&[
        "paint",
        &at("tuft.hair"),
        "--strokes",
        &at("strokes.json"),
        "-o",
        &at("out.json"),
        "--metres-per-unit",
        "0.01",
    ]);
    assert_eq!(report["operations"], 2);

    let mut document = Document::open(folder.path().join("tuft.hair").as_path(), Some(0.01))
        .unwrap()
        .document;
    for operation in StrokeFile::parse(STROKES).unwrap().operations {
        document
            .apply(Edit::AddLayer(
                Layer::new(&operation.layer, &operation.layer),
                usize::MAX,
            ))
            .unwrap();
        document.begin_stroke(operation.clone()).unwrap();
        for dab in operation.dabs {
            document.extend_stroke(vec![dab]).unwrap();
        }
        document.commit_stroke();
    }
    let opened = Document::open(&folder.path().join("out.json"), None)
        .unwrap()
        .document;
    let bits = |document: &Document| bytemuck::cast_slice::<_, u32>(document.params()).to_vec();
    assert!(bits(&opened) == bits(&document));
    assert_eq!(opened.project().operations, document.project().operations);
    let unpainted = document.params()[0];
    let painted = document.params().iter().filter(|p| **p != unpainted).count();
    assert_eq!(report["points_changed"], painted);
    assert!(painted > 100);

    // A second time the operations are there already, which is told.
    let (code, _, err) = balayage(&[
        "paint",
        &at("out.json"),
        "--strokes",
        &at("strokes.json"),
        "-o",
        &at("twice.json"),
    ]);
    assert!(
        code == 0 && err.contains("operation 1 is in the project already"),
        "{err}"
    );
    let other = STROKES.replace("null", "\"abc\"");
    fs::write(folder.path().join("other.json"), other).unwrap();
    let (code, _, err) = balayage(&[
        "paint",
        &at("tuft.hair"),
        "--strokes",
        &at("other.json"),
        "-o",
        &at("o.json"),
    ]);
    assert!(code == 0 && err.contains("another groom"), "{err}");
}

#[test]
fn check_tells_what_a_file_is() {
    let folder = folder();
    let at = |file: &str| name(folder.path(), file);
    balayage(&[
        "paint",
        &at("tuft.hair"),
        "--strokes",
        &at("strokes.json"),
        "-o",
        &at("project.json"),
    ]);
    fs::write(
        folder.path().join("head.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    )
    .unwrap();
    for (file, kind) in [
        ("tuft.hair", "groom"),
        ("strokes.json", "strokes"),
        ("lights.json", "lights"),
        ("camera.json", "camera"),
        ("project.json", "project"),
        ("head.obj", "head"),
    ] {
        assert_eq!(json(&["check", &at(file)])["kind"], kind, "{file}");
        let (code, out, _) = balayage(&["check", &at(file)]);
        assert!(code == 0 && out.contains(file), "{out}");
    }

    // What the light of a project holds, and which of its files are missing.
    let project = r#"{"version": 1, "groom": {"path": "tuft.hair"}, "light": {"environment": {"sequence": {"maps": ["a.hdr", "b.hdr"]}},
        "hand": [{"name": "key", "light": {"direction": [0,1,0], "bandwidth": 0.3, "radiance": [1,1,1]}}]}}"#;
    fs::write(folder.path().join("lit.json"), project).unwrap();
    let light = &json(&["check", &at("lit.json")])["light"];
    assert_eq!(
        *light,
        serde_json::json!({"environment": "sequence", "files": 2, "hand_lights": 1})
    );
    let (_, _, err) = balayage(&["check", &at("lit.json")]);
    assert!(err.contains("a.hdr") && err.contains("b.hdr"), "{err}");
}

#[test]
fn bad_files_exit_with_1_and_name_file_place_and_remedy() {
    let folder = folder();
    let at = |file: &str| name(folder.path(), file);
    for (file, text, expected) in [
        ("a.json", "{\"version\": 1,\n \"operations\": 3}", "line 2"),
        ("b.json", "{}", "top level"),
        (
            "c.json",
            "{\"lights\": [{\"direction\": [0,0,0], \"bandwidth\": 1, \"radiance\": [1,1,1]}]}",
            "light 0",
        ),
        (
            "d.json",
            "{\"world_from_camera\": [[0,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]], \"fov_y_deg\": 30}",
            "world_from_camera",
        ),
        (
            "e.json",
            "{\"version\": 1, \"groom\": {\"path\": \"gone.hair\"}}",
            "gone.hair",
        ),
        ("f.hair", "HAIR", "f.hair"),
        ("g.tfx", "", "g.tfx"),
        ("h.hdr", "#?RADIANCE\n", "h.hdr"),
        ("i.txt", "x", "extension"),
    ] {
        fs::write(folder.path().join(file), text).unwrap();
        let err = refused(&["check", &at(file)]);
        assert!(err.contains(expected), "{err}");
        assert!(err.contains(file) || expected == "gone.hair", "{err}");
    }
    let (code, out, _) = balayage(&["check", &at("missing.hair"), "--json"]);
    assert_eq!(code, 1);
    assert!(
        serde_json::from_str::<Value>(&out).unwrap()["error"]
            .as_str()
            .unwrap()
            .contains("missing.hair")
    );
    refused(&[
        "paint",
        &at("tuft.hair"),
        "--strokes",
        &at("a.json"),
        "-o",
        &at("o.json"),
    ]);
    refused(&[
        "paint",
        &at("tuft.hair"),
        "--strokes",
        &at("strokes.json"),
        "-o",
        &at("no/folder/o.json"),
    ]);
    refused(&["convert", &at("tuft.hair"), &at("tuft.abc")]);
    refused(&["fit", &at("tuft.hair"), "-o", &at("l.json")]);
    assert!(!folder.path().join("o.json").exists());
}

#[test]
fn wrong_usage_exits_with_2_and_help_with_0() {
    for args in [
        &["render"][..],
        &["render", "-o", "x.jpg"],
        &["render", "-o", "x.png", "--size", "0x5"],
        &["render", "-o", "x.png", "--size", "100000x5"],
        &["render", "-o", "x.png", "--set", "eta=nan"],
        &["render", "-o", "x.png", "--set", "hue=1"],
        &["render", "-o", "x.png", "--exposure", "inf"],
        &["render", "-o", "x.png", "--light-count", "0"],
        &["render", "-o", "x.png", "--frames", "3-1", "--turntable"],
        &["render", "-o", "x.png", "--env", "a.hdr", "--lights", "b.json"],
        &["fit", "a.hdr", "-n", "0", "-o", "l.json"],
        &["paint", "a.hair", "-o", "b.json"],
        &["wobble"],
    ] {
        let (code, out, err) = balayage(args);
        assert!(
            code == 2 && out.is_empty() && !err.is_empty(),
            "{args:?}: {code} {out}{err}"
        );
    }
    for args in [&["--help"][..], &["--version"], &["render", "--help"]] {
        let (code, out, err) = balayage(args);
        assert!(
            code == 0 && err.is_empty() && out.to_lowercase().contains("balayage"),
            "{args:?}: {code} {out}{err}"
        );
    }
}

#[test]
fn convert_keeps_the_strands() {
    let folder = folder();
    let at = |file: &str| name(folder.path(), file);
    json(&["convert", &at("tuft.hair"), &at("tuft.tfx")]);
    json(&["convert", &at("tuft.tfx"), &at("again.hair")]);
    let positions = |file: &str| {
        read_groom(folder.path().join(file), None)
            .unwrap()
            .groom
            .positions()
            .to_vec()
    };
    assert_eq!(positions("tuft.hair"), positions("tuft.tfx"));
    assert_eq!(positions("tuft.hair"), positions("again.hair"));
}

/// The salon operations of the samples: by command, by edits and after reopening the same bits; `check` counts them.
#[test]
fn a_usd_groom_is_opened_at_the_time_that_is_asked_for() {
    let folder = folder();
    let at = |file: &str| name(folder.path(), file);
    let usda = "#usda 1.0\n(\n metersPerUnit = 0.01\n)\ndef BasisCurves \"c\"\n{\n uniform token type = \"linear\"\n int[] curveVertexCounts = [3]\n \
        point3f[] points.timeSamples = { 1: [(0,0,0), (1,0,0), (2,0,0)], 2: [(0,0,0), (1,5,0), (2,9,0)], }\n}\n";
    fs::write(at("moving.usda"), usda).unwrap();
    let hash = |args: &[&str]| json(&[&["check", &at("moving.usda")], args].concat())["hash"].clone();
    let (first, second) = (hash(&[]), hash(&["--usd-time", "2"]));
    assert_ne!(first, second);
    assert_eq!(first, hash(&["--usd-time", "1"]));

    // A painted project remembers its time, and another one may be asked for.
    let painted = at("painted.json");
    let strokes = at("strokes.json");
    let out = json(&[
        "paint",
        &at("moving.usda"),
        "--usd-time",
        "2",
        "--strokes",
        &strokes,
        "-o",
        &painted,
    ]);
    assert_eq!(out["groom"], second);
    let opened = Document::open(Path::new(&painted), None).unwrap();
    assert_eq!(opened.document.groom().content_hash(), second.as_str().unwrap());
    let (code, _, err) = balayage(&["check", &painted, "--usd-time", "1"]);
    assert!(code == 0 && err.contains("changed since"), "{err}");

    let err = refused(&["check", &at("tuft.hair"), "--usd-time", "1"]);
    assert!(err.contains("only USD files hold samples in time"), "{err}");
    assert_eq!(balayage(&["check", &at("moving.usda"), "--usd-time", "nan"]).0, 2);
}

#[test]
fn salon_operations_by_command_equal_those_by_edits() {
    let folder = folder();
    let at = |file: &str| name(folder.path(), file);
    let strokes = balayage_tests::repository("projects/strokes/salon.json");
    let strokes = strokes.to_str().unwrap();
    assert_eq!(json(&["check", strokes])["operations"], 4);
    let groom = balayage_tests::repository("projects/grooms/wavy-bob.hair");
    json(&[
        "paint",
        groom.to_str().unwrap(),
        "--strokes",
        strokes,
        "-o",
        &at("salon.json"),
    ]);
    let painted = Document::open(Path::new(&at("salon.json")), None)
        .unwrap()
        .document;

    let mut document = Document::open(&groom, None).unwrap().document;
    for layer in ["balayage", "grey"] {
        document
            .apply(Edit::AddLayer(Layer::new(layer, layer), usize::MAX))
            .unwrap();
    }
    for operation in StrokeFile::parse(&fs::read_to_string(strokes).unwrap())
        .unwrap()
        .operations
    {
        document.apply(Edit::Stroke(operation)).unwrap();
    }
    assert!(document.params() == painted.params());
    let unpainted = document.unpainted_params();
    let share = document
        .params()
        .iter()
        .zip(&unpainted)
        .filter(|(a, b)| a != b)
        .count() as f64
        / unpainted.len() as f64;
    assert!((0.2..0.95).contains(&share), "{share}");
}

/// A painted project renders to PNG and EXR; the EXR shows where the dye went, a turntable numbers its frames.
#[test]
fn render_writes_what_was_painted() {
    let folder = folder();
    let at = |file: &str| name(folder.path(), file);
    // One dab that reaches everything.
    let everywhere = STROKES
        .replace("\"radius_m\": 0.06", "\"radius_m\": 9")
        .replace("bleach", "eccentricity");
    fs::write(folder.path().join("everywhere.json"), everywhere).unwrap();
    json(&[
        "paint",
        &at("tuft.hair"),
        "--strokes",
        &at("everywhere.json"),
        "-o",
        &at("dyed.json"),
        "--metres-per-unit",
        "0.01",
    ]);
    let common = [
        "--lights",
        &at("lights.json"),
        "--camera",
        &at("camera.json"),
        "--size",
        "64x48",
        "--samples",
        "1",
    ];
    let render = |input: &str, output: &str, more: &[&str]| {
        json(&[&["render", &at(input), "-o", &at(output)][..], &common, more].concat())
    };
    let blond = [
        "--set",
        "eumelanin=0.1",
        "--set",
        "diameter=0.3",
        "--metres-per-unit",
        "0.01",
    ];
    let report = render("dyed.json", "dyed.exr", &blond);
    assert_eq!(report["lights"], 1);
    assert!(
        report["frames"][0]["passes_ms"]["strand shading"]
            .as_f64()
            .unwrap()
            > 0.0
    );
    render("tuft.hair", "plain.exr", &blond);
    let pixels = |file: &str| Picture::read_exr(&folder.path().join(file)).unwrap();
    let (dyed, plain) = (pixels("dyed.exr"), pixels("plain.exr"));
    assert_eq!((dyed.width, dyed.height), (64, 48));
    assert_eq!(dyed.non_finite() + plain.non_finite(), 0);

    // The dye absorbs blue and moves nothing.
    let blue = |picture: &Picture| picture.pixels.iter().map(|p| f64::from(p[2])).sum::<f64>();
    assert!(
        blue(&dyed) < 0.8 * blue(&plain),
        "{} {}",
        blue(&dyed),
        blue(&plain)
    );
    let coverage = |picture: &Picture| picture.pixels.iter().map(|p| p[3]).collect::<Vec<_>>();
    assert!(coverage(&dyed) == coverage(&plain) && coverage(&plain).iter().any(|a| *a > 0.5));

    let turn = render("dyed.json", "turn.png", &["--frames", "2-3", "--turntable", "4"]);
    assert_eq!(turn["frames"].as_array().unwrap().len(), 2);
    let frames = ["turn-0002.png", "turn-0003.png"].map(|file| fs::read(folder.path().join(file)).unwrap());
    assert!(frames[0] != frames[1] && frames[0].starts_with(b"\x89PNG"));
}

#[test]
fn schemes_and_their_numbers_are_checked() {
    use balayage::cli::method_options::{MethodOptions, SchemeName};
    use balayage_render::gpu::Scheme;

    for bad in [
        ["--segments", "1"],
        ["--segments", "17"],
        ["--directions", "15"],
        ["--directions", "4097"],
        ["--scheme", "other"],
    ] {
        let (code, _, err) = balayage(&["probe", bad[0], bad[1]]);
        assert_eq!(code, 2, "{bad:?}: {err}");
        assert!(err.contains(bad[1]), "{err}");
    }
    // The command line overrides the project, number by number.
    let of_project = Scheme::Xu2011 { segments: 7 };
    let mut options = MethodOptions::default();
    assert_eq!(options.method(of_project).scheme, of_project);
    options.segments = Some(9);
    assert_eq!(options.method(of_project).scheme, Scheme::Xu2011 { segments: 9 });
    options.scheme = Some(SchemeName::Directional);
    options.directions = Some(32);
    assert_eq!(
        options.method(of_project).scheme,
        Scheme::Directional { directions: 32 }
    );
}
