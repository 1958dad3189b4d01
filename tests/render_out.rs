//! Sequences of pictures: names, metadata, what is kept when a render goes on, Ctrl-C, wedges, the farm's template.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use balayage_render::groom::write_groom;
use balayage_render::image::{Picture, png_bytes, read_metadata};
use balayage_tests::{python_with, repository};
use serde_json::Value;

use crate::painting::tuft;

/// Runs a command; its exit code and its answer.
fn balayage(args: &[&str]) -> (u8, Value, String) {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let args = ["balayage"].iter().chain(args).chain(&["--json"]).copied();
    let code = balayage::cli::run(args, &mut out, &mut err);
    let answer = serde_json::from_slice(&out).unwrap_or_default();
    (code, answer, String::from_utf8(err).unwrap())
}

/// A folder with a groom, lights and a camera, and the arguments that render them small.
struct Scene {
    folder: tempfile::TempDir,
    common: Vec<String>,
}

impl Scene {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let common = common(folder.path());
        Self { folder, common }
    }

    fn at(&self, file: &str) -> PathBuf {
        self.folder.path().join(file)
    }

    fn render(&self, output: &str, more: &[&str]) -> (u8, Value, String) {
        let output = self.at(output);
        let mut args: Vec<&str> = self.common.iter().map(String::as_str).collect();
        args.extend(["-o", output.to_str().unwrap()]);
        args.extend(more);
        balayage(&args)
    }
}

fn common(folder: &Path) -> Vec<String> {
    write_groom(folder.join("tuft.hair"), &tuft()).unwrap();
    let lights = r#"{"lights": [{"direction": [0, 1, 0], "bandwidth": 0.5, "radiance": [3, 3, 3]}], "constant": [0.5, 0.5, 0.5]}"#;
    fs::write(folder.join("lights.json"), lights).unwrap();
    let at = |file: &str| folder.join(file).to_str().unwrap().to_owned();
    let args = [
        "render",
        &at("tuft.hair"),
        "--lights",
        &at("lights.json"),
        "--size",
        "48x32",
        "--samples",
        "1",
        "--metres-per-unit",
        "0.01",
        "--set",
        "diameter=0.3",
    ];
    args.map(str::to_owned).into()
}

/// Names of the pictures that were kept.
fn kept(answer: &Value) -> Vec<String> {
    let frames = answer["frames"].as_array().unwrap().iter();
    let kept = frames.filter(|frame| frame["kept"] == true);
    let name = |frame: &Value| {
        let path = PathBuf::from(frame["picture"].as_str().unwrap());
        path.file_name().unwrap().to_str().unwrap().to_owned()
    };
    kept.map(name).collect()
}

fn files(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// What is in a picture; attributes of an EXR have no order.
fn pixels(path: &Path) -> Vec<u32> {
    if path.extension().is_some_and(|e| e == "exr") {
        let picture = Picture::read_exr(path).unwrap();
        return picture.pixels.iter().flatten().map(|x| x.to_bits()).collect();
    }
    let picture = image::open(path).unwrap().into_rgba8();
    picture.pixels().map(|p| u32::from_le_bytes(p.0)).collect()
}

#[test]
fn a_turntable_goes_on_where_it_stopped() {
    let scene = Scene::new();
    for extension in ["exr", "png"] {
        let name = |frame: u32| format!("frame.{frame:04}.{extension}");
        let output = format!("{extension}/frame.####.{extension}");
        let go = |more: &[&str]| {
            scene.render(
                &output,
                &[&["--frames", "1-3", "--turntable", "4"], more].concat(),
            )
        };
        let (code, answer, err) = go(&[]);
        assert_eq!(code, 0, "{err}");
        assert!(kept(&answer).is_empty());
        let folder = scene.at(extension);
        assert_eq!(files(&folder), [name(1), name(2), name(3)]);
        let first = fs::read(folder.join(name(1))).unwrap();

        // One is cut off, one is gone, one is of another kind: only what is whole and the same stays.
        let second = fs::read(folder.join(name(2))).unwrap();
        let seen = pixels(&folder.join(name(2)));
        fs::write(folder.join(name(2)), &second[..second.len() - 40]).unwrap();
        fs::remove_file(folder.join(name(3))).unwrap();
        let (code, answer, err) = go(&["--resume"]);
        assert_eq!(code, 0, "{err}");
        assert_eq!(kept(&answer), [name(1)]);
        assert!(answer["frames"][1]["passes_ms"].is_object());
        assert!(fs::read(folder.join(name(1))).unwrap() == first);
        assert!(pixels(&folder.join(name(2))) == seen);

        // All there: nothing is rendered, and no adapter is asked for.
        let (_, answer, _) = go(&["--resume"]);
        assert_eq!(kept(&answer).len(), 3);
        assert!(answer["adapter"].is_null());
        let metadata = read_metadata(&folder.join(name(2))).unwrap();
        let field = |name: &str| {
            metadata
                .iter()
                .find(|(key, _)| key == name)
                .map(|(_, text)| text.as_str())
        };
        assert_eq!(field("balayage:frame"), Some("2"));
        assert_eq!(field("balayage:project").unwrap().len(), 64);
        let settings: Value = serde_json::from_str(field("balayage:settings").unwrap()).unwrap();
        assert_eq!(settings["size"], serde_json::json!([48, 32]));
    }
    // Another setting, other lights in a file of the same name: nothing stays.
    let one = |more: &[&str]| {
        let range = ["--frames", "1", "--turntable", "4", "--resume"];
        let (_, answer, _) = scene.render("exr/frame.####.exr", &[&range, more].concat());
        kept(&answer).len()
    };
    assert_eq!(
        (one(&[]), one(&["--exposure", "1"]), one(&["--exposure", "1"])),
        (1, 0, 1)
    );
    assert_eq!(one(&[]), 0);
    let lights = fs::read_to_string(scene.at("lights.json")).unwrap();
    fs::write(scene.at("lights.json"), format!("{lights} ")).unwrap();
    assert_eq!(one(&[]), 0);

    // Frames differ, and a fifth of four is the first.
    let pixels = |file: &str| Picture::read_exr(&scene.at(file)).unwrap();
    assert_ne!(pixels("exr/frame.0001.exr"), pixels("exr/frame.0002.exr"));
    scene.render("exr/turn.#.exr", &["--frames", "5", "--turntable", "4"]);
    let (a, b) = (pixels("exr/frame.0001.exr"), pixels("exr/turn.5.exr"));
    let difference = a
        .pixels
        .iter()
        .flatten()
        .zip(b.pixels.iter().flatten())
        .map(|(a, b)| (a - b).abs());
    assert!(difference.fold(0.0, f32::max) < 0.05);
}

#[test]
fn wedges_render_once_for_every_file() {
    let scene = Scene::new();
    let write = |name: &str, text: &str| {
        fs::write(scene.at(name), text).unwrap();
        scene.at(name).to_str().unwrap().to_owned()
    };
    let dark = write("dark.json", r#"{"hair": {"base": {"eumelanin": 4}}}"#);
    let blond = write("blond.json", r#"{"hair": {"base": {"eumelanin": 0.1}}}"#);
    let rose = write(
        "rose.json",
        r#"{"version": 2, "groom": null, "operations": [{"id": 1, "layer": "x", "channel": "dye", "mode": "replace", "value": [0, 2, 2], "shape": {"fill": {}}}]}"#,
    );
    let plain = write("plain.json", "{}");
    let (code, answer, err) = scene.render(
        "look_{dye}.exr",
        &[
            "--wedge",
            &format!("base={dark},{blond}"),
            "--wedge",
            &format!("dye={plain},{rose}"),
        ],
    );
    assert_eq!(code, 0, "{err}");
    assert_eq!(answer["frames"].as_array().unwrap().len(), 4);
    let mean = |file: &str| -> [f64; 3] {
        let picture = Picture::read_exr(&scene.at(file)).unwrap();
        std::array::from_fn(|c| picture.pixels.iter().map(|p| f64::from(p[c])).sum())
    };
    let (dark, blond) = (mean("look_plain-dark.exr"), mean("look_plain-blond.exr"));
    assert!(blond[1] > 1.5 * dark[1], "{blond:?} {dark:?}");
    let rose = mean("look_rose-blond.exr");
    assert!(
        rose[1] < 0.7 * blond[1] && rose[0] > 0.9 * blond[0],
        "{rose:?} {blond:?}"
    );

    for (text, said) in [
        ("[1]", "no object"),
        (r#"{"hair": {"base": {"eta": 0}}}"#, "bad.json: hair.base.eta"),
    ] {
        let bad = write("bad.json", text);
        let (code, _, err) = scene.render("x.exr", &["--wedge", &format!("a={bad}")]);
        assert!(code == 1 && err.contains(said), "{err}");
    }
    let twice = format!("a={plain},{plain}");
    assert_eq!(scene.render("x.exr", &["--wedge", &twice]).0, 2);
}

#[test]
fn metadata_survives_and_damage_is_seen() {
    let folder = tempfile::tempdir().unwrap();
    let metadata = vec![
        ("a".to_owned(), "plain".to_owned()),
        ("b".to_owned(), "Strähne \u{1f487}".to_owned()),
    ];
    let picture = Picture {
        width: 20,
        height: 20,
        pixels: (0..400).map(|i| [i as f32, 0.5, 0.25, 1.0]).collect(),
    };
    let exr = folder.path().join("a.exr");
    let png = folder.path().join("a.png");
    fs::write(&exr, picture.exr_bytes(&exr, &metadata).unwrap()).unwrap();
    fs::write(&png, png_bytes(&png, [20, 20], &[7; 1600], &metadata).unwrap()).unwrap();
    assert_eq!(Picture::read_exr(&exr).unwrap(), picture);
    for path in [exr, png] {
        let mut found = read_metadata(&path).unwrap();
        found.sort();
        assert_eq!(found[0], metadata[0]);
        assert_eq!(found[1].1, r"Str\u{e4}hne \u{1f487}");
        let bytes = fs::read(&path).unwrap();
        for len in [0, 10, bytes.len() / 2, bytes.len() - 1] {
            fs::write(&path, &bytes[..len]).unwrap();
            assert!(read_metadata(&path).is_err(), "{} cut to {len}", path.display());
        }
    }
}

/// Set by the test below for the process that it interrupts.
const CHILD: &str = "BALAYAGE_TEST_RENDER_IN";

/// Does nothing, except in the process that is interrupted.
#[test]
fn child_that_renders() {
    let Some(folder) = std::env::var_os(CHILD).map(PathBuf::from) else {
        return;
    };
    let mut args = common(&folder);
    let output = folder.join("out/frame.####.exr").to_str().unwrap().to_owned();
    args.extend(["-o".to_owned(), output]);
    args.extend(["--frames", "1-10000", "--turntable"].map(str::to_owned));
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    balayage(&args);
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_no_half_picture() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "render_out::child_that_renders", "--nocapture"])
        .env(CHILD, folder.path())
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let out = folder.path().join("out");
    let start = Instant::now();
    while !out.join("frame.0003.exr").exists() {
        assert!(start.elapsed() < Duration::from_secs(120), "no pictures");
        assert!(child.try_wait().unwrap().is_none(), "the child ended");
        std::thread::sleep(Duration::from_millis(5));
    }
    let pid = child.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-INT", &pid])
            .status()
            .unwrap()
            .success()
    );
    let output = child.wait_with_output().unwrap();
    let err = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{err}");
    assert!(err.contains("pictures were written"), "{err}");
    let names = files(&out);
    assert!((3..10_000).contains(&names.len()));
    for name in names {
        assert!(name.ends_with(".exr"), "{name} was left");
        read_metadata(&out.join(&name)).unwrap();
    }
}

#[test]
fn the_farm_template_is_valid() {
    let Some(python) = python_with("openjd.cli") else {
        return;
    };
    let template = repository("projects/turntable.openjd.yaml");
    let check = |path: &Path| {
        let mut command = Command::new(&python);
        let program = "import sys; from openjd.cli import main; sys.exit(main())";
        command.args(["-c", program, "check"]).arg(path);
        command.output().unwrap()
    };
    let output = check(&template);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stdout)
    );
    // The check can fail.
    let folder = tempfile::tempdir().unwrap();
    let bad = folder.path().join("bad.yaml");
    let text = fs::read_to_string(&template)
        .unwrap()
        .replace("{{Task.Param.Frame}}", "{{Task.Param.Nothing}}");
    fs::write(&bad, text).unwrap();
    assert!(!check(&bad).status.success());
}

#[test]
fn voxels_are_as_fine_as_the_user_wants() {
    let scene = Scene::new();
    let painted = |spacings: &str| {
        let (code, answer, said) = scene.render("v.exr", &["--multiple", "m3", "--voxel-spacings", spacings]);
        assert_eq!(code, 0, "{said}");
        let voxels = answer["frames"][0]["counters"]["voxels painted"].as_u64();
        (voxels.unwrap(), pixels(&scene.at("v.exr")))
    };
    let ((usual, a), (coarse, b)) = (painted("1.25"), painted("5"));
    assert!(usual > 4 * coarse, "{usual} and {coarse} voxels");
    assert!(a != b, "shadows come from them");
    for absurd in ["0", "0.4", "NaN", "1e9", "fine"] {
        let (code, _, said) = scene.render("no.exr", &["--voxel-spacings", absurd]);
        assert_eq!(code, 2);
        assert!(said.contains("from 0.5 (fine) to 16 (coarse)"), "{said}");
    }
    assert!(!scene.at("no.exr").exists());
}
