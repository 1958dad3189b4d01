//! The project file: what is written comes back, nothing is lost, bad files are refused with their place.

use std::{fs, io, path::Path};

use balayage::{
    document::{
        Document, Edit, PROJECT_VERSION, Project,
        files::{SaveStep, write_atomic, write_atomic_with},
        json,
    },
    paint::StrokeFile,
};
use balayage_render::{
    gpu::{Model, Scheme},
    groom::write_groom,
    param::VertexParams,
};

use crate::painting::tuft;

const STROKES: &str = r#"{"version": 1, "operations": [{"id": 7, "layer": "ends", "channel": "dye", "mode": "add", "value": 0.1,
    "radius_m": 0.05, "dabs": [{"root": [5, 0, 5], "arc": 0.9, "position": [5.1, 10.3, 5.2]}]}]}"#;

/// A folder with a groom in a subfolder and a project that names it.
pub fn sample(folder: &Path) -> std::path::PathBuf {
    fs::create_dir(folder.join("grooms")).unwrap();
    write_groom(folder.join("grooms/tuft.hair"), &tuft()).unwrap();
    let path = folder.join("project.json");
    fs::write(
        &path,
        r#"{"version": 1, "groom": {"path": "grooms/tuft.hair", "metres_per_unit": 0.01}}"#,
    )
    .unwrap();
    path
}

fn bits(params: &[VertexParams]) -> Vec<u32> {
    bytemuck::cast_slice(params).to_vec()
}

#[test]
fn a_saved_project_opens_as_the_same_document() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = Document::open(&sample(folder.path()), None).unwrap().document;
    let mut operations = StrokeFile::parse(STROKES).unwrap().operations;
    // Numbers without a short decimal form survive the text, too.
    operations[0].radius_m = 0.1_f32.sqrt() * 0.1;
    operations[0].dabs[0].position[1] += 1.0 / 3.0;
    document
        .apply(Edit::AddLayer(balayage::document::Layer::new("ends", "Ends"), 9))
        .unwrap();
    document.apply(Edit::Stroke(operations.remove(0))).unwrap();
    assert!(document.is_modified());

    // Saving elsewhere moves the reference along.
    fs::create_dir(folder.path().join("other")).unwrap();
    let path = folder.path().join("other/saved.json");
    document.save_as(&path).unwrap();
    assert!(!document.is_modified());
    assert_eq!(document.project().groom.path, "../grooms/tuft.hair");
    let opened = Document::open(&path, None).unwrap();
    assert_eq!(opened.document.project(), document.project());
    assert!(bits(opened.document.params()) == bits(document.params()));
    assert!(opened.warnings.is_empty());
    assert_eq!(
        document.project().groom.hash.as_deref(),
        Some(tuft().content_hash().as_str())
    );

    // A second save of what was opened is the same text.
    let text = fs::read_to_string(&path).unwrap();
    let mut again = opened.document;
    again.save_as(&path).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), text);
}

#[test]
fn unknown_fields_are_kept_everywhere() {
    let folder = tempfile::tempdir().unwrap();
    let path = sample(folder.path());
    let text = r#"{"version": 1, "new": {"a": [1, {"b": null}]},
        "groom": {"path": "grooms/tuft.hair", "new": 1}, "head": null,
        "light": {"environment": {"constant": [1, 2, 3]}, "new": 2},
        "camera": {"world_from_camera": [[1,0,0,0],[0,1,0,0],[0,0,1,50],[0,0,0,1]], "fov_y_deg": 30, "new": 3},
        "hair": {"base": {"eta": 1.6, "new": 4}, "ratios": {"beta_tt": 0.4, "new": 5}, "new": 6},
        "layers": [{"id": "x", "name": "X", "new": 7}],
        "operations": [{"id": 1, "layer": "x", "channel": "dye", "mode": "smooth", "radius_m": 1, "new": 8,
            "dabs": [{"root": [0,0,0], "arc": 0, "position": [0,0,0], "new": 9}]}]}"#;
    fs::write(&path, text).unwrap();
    let mut document = Document::open(&path, None).unwrap().document;
    document.save_as(&path).unwrap();
    let saved: serde_json::Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    assert_eq!(saved["new"]["a"][1]["b"], serde_json::Value::Null);
    let found = [
        &saved["groom"],
        &saved["light"],
        &saved["camera"],
        &saved["hair"]["base"],
        &saved["hair"]["ratios"],
        &saved["hair"],
        &saved["layers"][0],
        &saved["operations"][0],
        &saved["operations"][0]["dabs"][0],
    ]
    .map(|object| object["new"].as_u64().unwrap_or(0));
    assert_eq!(found, [1, 2, 3, 4, 5, 6, 7, 8, 9]);
    assert_eq!(document.values()[0].eta, 1.6);

    // Every default is written out.
    for (place, field) in [
        ("light", "light_count"),
        ("hair", "pigments"),
        ("hair", "diameter"),
        ("light", "exposure_ev"),
    ] {
        assert!(saved[place].get(field).is_some(), "{place}.{field}");
    }
    for field in ["strength", "hardness", "falloff", "reach", "seed"] {
        assert!(saved["operations"][0].get(field).is_some(), "{field}");
    }
}

#[test]
fn a_failed_save_leaves_the_old_file_and_no_litter() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.json");
    write_atomic(&path, b"old").unwrap();
    for failing in [
        SaveStep::Create,
        SaveStep::Write,
        SaveStep::Sync,
        SaveStep::Rename,
    ] {
        let problem = write_atomic_with(&path, b"new", |step| {
            if step == failing {
                Err(io::Error::from(io::ErrorKind::StorageFull))
            } else {
                Ok(())
            }
        })
        .unwrap_err();
        assert!(
            problem.file.ends_with("p.json") && problem.remedy.contains("space"),
            "{problem}"
        );
        assert_eq!(fs::read(&path).unwrap(), b"old", "{failing:?}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "{failing:?}");
    }

    // After the rename the new content is there, and the failure is still told.
    let late = |step| {
        if step == SaveStep::SyncFolder {
            Err(io::Error::other("no"))
        } else {
            Ok(())
        }
    };
    assert!(write_atomic_with(&path, b"new", late).is_err());
    assert_eq!(fs::read(&path).unwrap(), b"new");
    let mut steps = Vec::new();
    write_atomic_with(&path, b"newer", |step| {
        steps.push(step);
        Ok(())
    })
    .unwrap();
    assert_eq!(
        steps,
        [
            SaveStep::Create,
            SaveStep::Write,
            SaveStep::Sync,
            SaveStep::Rename,
            SaveStep::SyncFolder
        ]
    );
    assert!(write_atomic(&folder.path().join("missing/p.json"), b"x").is_err());
}

#[test]
fn a_failed_save_leaves_the_document_modified() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = Document::open(&sample(folder.path()), None).unwrap().document;
    document
        .apply(Edit::AddLayer(balayage::document::Layer::new("a", "A"), 0))
        .unwrap();
    assert!(document.save_as(&folder.path().join("missing/p.json")).is_err());
    assert!(document.is_modified());
    assert_eq!(document.project().groom.path, "grooms/tuft.hair");
}

#[test]
fn a_changed_groom_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = sample(folder.path());
    let mut document = Document::open(&path, None).unwrap().document;
    document.save_as(&path).unwrap();
    assert!(Document::open(&path, None).unwrap().warnings.is_empty());
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replace(&tuft().content_hash(), "0123456789abcdef")).unwrap();
    let warnings = Document::open(&path, None).unwrap().warnings;
    assert!(
        warnings.len() == 1 && warnings[0].contains("tuft.hair") && warnings[0].contains("0123456789ab"),
        "{warnings:?}"
    );
}

#[test]
fn bad_projects_are_refused_with_file_and_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = sample(folder.path());
    let with = |field: &str| format!(r#"{{"version": 1, "groom": {{"path": "grooms/tuft.hair"}}, {field}}}"#);
    let cases = [
        (String::new(), "line 1"),
        ("[]".into(), "line 1"),
        ("{\"version\": 1}".into(), "line 1"),
        (with("").replace("version\": 1", "version\": 99"), "line 1"),
        (
            with("\"x\": 1").replace("version\": 1", "version\": 99"),
            "version",
        ),
        (with("\"x\": 1").replace("grooms/tuft.hair", ""), "groom.path"),
        (with(r#""light": {"exposure_ev": 1e9}"#), "light.exposure_ev"),
        (with(r#""light": {"exposure_ev": 1e39}"#), "line 1"),
        (with(r#""light": {"light_count": 0}"#), "light.light_count"),
        (
            with(r#""light": {"environment": {"constant": [1, -1, 1]}}"#),
            "light.environment.constant",
        ),
        (with(r#""light": {"tint": [1, -1, 1]}"#), "light.tint"),
        (
            with(r#""light": {"environment": {"sequence": {"maps": []}}}"#),
            "light.environment.sequence.maps",
        ),
        (
            with(r#""light": {"environment": {"sequence": {"maps": ["a.hdr"], "fps": 0}}}"#),
            "light.environment.sequence.fps",
        ),
        (
            with(r#""light": {"hand": [{"name": "", "light": null}]}"#),
            "light.hand[0].name",
        ),
        (
            with(
                r#""light": {"hand": [{"name": "a", "light": {"direction": [0,2,0], "bandwidth": 1, "radiance": [1,1,1]}}]}"#,
            ),
            "light.hand[0].light.direction",
        ),
        (
            with(
                r#""light": {"hand": [{"name": "a", "light": null, "replaces": {"direction": [0,1,0], "bandwidth": 0, "radiance": [1,1,1]}}]}"#,
            ),
            "light.hand[0].replaces.bandwidth",
        ),
        (with(r#""hair": {"base": {"bleach": 1.5}}"#), "hair.base.bleach"),
        (
            with(r#""hair": {"ratios": {"beta_trt": 0}}"#),
            "hair.ratios.beta_trt",
        ),
        (with(r#""hair": {"diameter": -1}"#), "hair.diameter"),
        (
            with(
                r#""camera": {"world_from_camera": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,1,1]], "fov_y_deg": 30}"#,
            ),
            "camera.world_from_camera",
        ),
        (
            with(
                r#""camera": {"world_from_camera": [[2,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]], "fov_y_deg": 30}"#,
            ),
            "camera.world_from_camera",
        ),
        (
            with(
                r#""camera": {"world_from_camera": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]], "fov_y_deg": 300}"#,
            ),
            "camera.fov_y_deg",
        ),
        (
            with(r#""layers": [{"id": "a", "name": "A"}, {"id": "a", "name": "B"}]"#),
            "layers[1].id",
        ),
        (
            with(r#""layers": [{"id": "a", "name": "A", "opacity": 2}]"#),
            "layers[0].opacity",
        ),
        (
            with(&format!("\"x\": {}{}", "[".repeat(5000), "]".repeat(5000))),
            "line 1",
        ),
    ];
    for (text, place) in cases {
        fs::write(&path, &text).unwrap();
        let problem = Document::open(&path, None).map(drop).unwrap_err();
        assert!(problem.place.starts_with(place), "{text:.80}: {problem}");
        assert!(
            problem.file.ends_with("project.json") && !problem.remedy.is_empty(),
            "{problem}"
        );
    }
    fs::write(&path, b"\xff\xfe{}").unwrap();
    assert!(
        Document::open(&path, None)
            .map(drop)
            .unwrap_err()
            .to_string()
            .contains("UTF-8")
    );
    fs::write(&path, with("\"x\": 1").replace("tuft.hair", "gone.hair")).unwrap();
    assert!(
        Document::open(&path, None)
            .map(drop)
            .unwrap_err()
            .to_string()
            .contains("gone.hair")
    );
    assert!(Document::open(folder.path(), None).is_err());
}

/// Every prefix of a project and 400 damaged ones: an error or a sound document, never a panic.
#[test]
fn damaged_projects_never_panic() {
    use rand::{Rng, SeedableRng};
    let mut project = Project::new(balayage::document::GroomReference {
        path: "a.hair".into(),
        ..Default::default()
    });
    project.operations = StrokeFile::parse(STROKES).unwrap().operations;
    project.add_missing_layers();
    let text = json::to_text(&project).unwrap();
    assert_eq!(Project::parse(&text).unwrap(), project);
    assert_eq!(project.version, PROJECT_VERSION);
    let end = text.trim_end().len();
    assert!((0..end).all(|n| Project::parse(&text[..n]).is_err()));
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(2);
    let mut refused = 0;
    for _ in 0..400 {
        let mut bytes = text.clone().into_bytes();
        let at = rng.random_range(0..bytes.len());
        bytes[at] = rng.random_range(32..127);
        refused += usize::from(Project::parse(std::str::from_utf8(&bytes).unwrap()).is_err());
    }
    assert!(refused > 100, "{refused}");
}

/// A project of version 1 opens as it was painted, and is saved as the present version with the same values.
#[test]
fn version_1_is_read_as_it_was_painted() {
    let old = balayage_tests::repository("projects/older/version-1.json");
    let text = fs::read_to_string(&old).unwrap();
    assert!(text.contains("\"version\": 1"));
    let mut document = Document::open(&old, None).unwrap().document;
    assert_eq!(document.project().version, PROJECT_VERSION);
    let present = Document::open(&balayage_tests::repository("projects/curly.json"), None).unwrap();
    assert!(bits(document.params()) == bits(present.document.params()));
    let mut hasher = blake3::Hasher::new();
    for values in document.values() {
        for channel in balayage_render::param::Channel::ALL {
            hasher.update(bytemuck::bytes_of(&values.get(channel)));
        }
    }
    // What people painted stays what they painted: a change that moves this hash changes their projects.
    let painted = &hasher.finalize().to_hex()[..16];
    assert_eq!(painted, "e81fd4a1f3a60bda");

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("new.json");
    document.save_as(&path).unwrap();
    assert!(fs::read_to_string(&path).unwrap().contains("\"version\": 2"));
    let again = Document::open(&path, None).unwrap().document;
    assert!(bits(again.params()) == bits(document.params()));
    assert_eq!(again.project().operations, document.project().operations);
}

#[test]
fn model_and_scheme_are_kept_in_the_project_and_are_optional() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = Document::open(&sample(folder.path()), None).unwrap().document;
    let usual = document.project().hair.clone();
    assert_eq!(usual.scheme, Scheme::Nodes);
    let mut hair = usual.clone();
    hair.scheme = Scheme::Xu2011 { segments: 6 };
    hair.model = Model::Deon;
    document.apply(Edit::SetHair(hair)).unwrap();
    let path = folder.path().join("saved.json");
    document.save_as(&path).unwrap();
    assert!(
        fs::read_to_string(&path)
            .unwrap()
            .replace(char::is_whitespace, "")
            .contains(r#""scheme":{"xu2011":{"segments":6}}"#)
    );
    let opened = Document::open(&path, None).unwrap().document;
    assert_eq!(opened.project().hair.scheme, Scheme::Xu2011 { segments: 6 });
    assert_eq!(opened.project().hair.model, Model::Deon);

    // The usual scheme leaves no trace in the file; a number out of range is refused with its place.
    document.undo();
    document.save_as(&path).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    assert!(!text.contains("scheme") && !text.contains("model"));
    let bad =
        r#"{"version": 1, "groom": {"path": "a.hair"}, "hair": {"scheme": {"xu2011": {"segments": 99}}}}"#;
    let problem = Project::parse(bad).unwrap_err().to_string();
    assert!(
        problem.contains("hair.scheme") && problem.contains("2 to 16"),
        "{problem}"
    );
}
