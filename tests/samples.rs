//! The sample projects and their strokes: what is bundled is what is made here from the sample grooms.
//!
//! `BALAYAGE_WRITE_SAMPLES=1 cargo test --workspace --test suite sample_projects` writes them anew.

use std::{fs, path::Path};

use balayage::{
    document::{CameraPose, Document, Environment, GroomReference, HeadReference, Layer, Project, json},
    paint::{
        Dab, Extra, Falloff, Mode, Nearest, Operation, OperationId, Reach, STROKE_VERSION, StrokeFile,
        StrokeValue,
    },
};
use balayage_render::{
    gpu::{Camera, CameraFile},
    groom::{Groom, read_groom},
    param::{Channel, PointValues},
};
use balayage_tests::repository;
use glam::Vec3;

/// The tips of locks, `spacing` metres apart.
fn locks(groom: &Groom, spacing: f32) -> Vec<Dab> {
    let mut tips: Vec<Vec3> = Vec::new();
    let mut dabs = Vec::new();
    for strand in 0..groom.strand_count() {
        let points = &groom.positions()[groom.strand(strand)];
        let (root, tip) = (points[0], points[points.len() - 1]);
        if tips.iter().all(|other| other.distance(tip) > spacing) {
            tips.push(tip);
            dabs.push(Dab {
                root: root.into(),
                arc: 1.0,
                position: tip.into(),
                pressure: 1.0,
                extra: Extra::new(),
            });
        }
    }
    dabs
}

/// The stroke painted along whole locks: from their tips up over `arc_reach` of their length, fading towards the roots.
fn along_locks(stroke: Operation, arc_reach: f32) -> Operation {
    Operation {
        reach: Reach::Strand,
        arc_reach: Some(arc_reach),
        hardness: 0.4,
        ..stroke
    }
}

/// A stroke of replaced values, soft at its rim.
fn stroke(
    id: u64,
    layer: &str,
    channel: Channel,
    value: StrokeValue,
    strength: f32,
    radius_m: f32,
    dabs: Vec<Dab>,
) -> Operation {
    Operation {
        id: OperationId::Number(id),
        layer: layer.into(),
        channel,
        mode: Mode::Replace,
        value,
        radius_m,
        strength,
        hardness: 0.2,
        falloff: Falloff::Smooth,
        reach: Reach::Surface,
        nearest: Nearest::Point,
        arc_reach: None,
        arc_range: None,
        shape: None,
        hidden: false,
        flow: 1.0,
        across: 0.0,
        seed: 0,
        dabs,
        extra: Extra::new(),
    }
}

/// The camera at `distance` metres that sees the hair from the side that `towards_eye` points to, rounded so that every platform
/// writes the same text.
fn pose(groom: &Groom, towards_eye: Vec3, distance: f32) -> CameraPose {
    let (low, high) = groom.bounds();
    let target = 0.5 * (low + high);
    let eye = target + distance * towards_eye.normalize();
    let file = CameraFile::from(Camera::look_at(eye, target, 25.0_f32.to_radians()));
    let rounded = |x: f32| (x * 1e4).round() / 1e4;
    CameraPose {
        world_from_camera: file.world_from_camera.map(|row| row.map(rounded)),
        fov_y_deg: rounded(file.fov_y_deg),
        extra: Extra::new(),
    }
}

/// A project on a sample groom with natural hair of the given melanins, under an environment with its exposure and rotation.
fn natural(
    groom: &str,
    environment: (&str, f32, f32),
    melanin: [f32; 2],
    (towards_eye, distance): (Vec3, f32),
) -> (Project, Groom) {
    let path = format!("grooms/{groom}.hair");
    let loaded = read_groom(repository(&format!("projects/{path}")), None)
        .unwrap()
        .groom;
    let mut project = Project::new(GroomReference {
        path,
        hash: Some(loaded.content_hash()),
        metres_per_unit: Some(loaded.metres_per_unit()),
        extra: Extra::new(),
        usd_time: None,
    });
    project.head = Some(HeadReference {
        path: "head.obj".into(),
        extra: Extra::new(),
    });
    let (map, exposure_ev, rotation_deg) = environment;
    project.light.environment = Environment::Map(format!("environments/{map}.hdr"));
    project.light.exposure_ev = exposure_ev;
    project.light.rotation_deg = rotation_deg;
    project.camera = Some(pose(&loaded, towards_eye, distance));
    project.hair.base = PointValues {
        eumelanin: melanin[0],
        pheomelanin: melanin[1],
        ..PointValues::default()
    }
    .into();
    (project, loaded)
}

/// A balayage: fine and broad locks lightened towards their tips, then toned.
fn balayage(groom: &Groom, spacing: f32, bleach: f32, tone: [f32; 3]) -> Vec<Operation> {
    let bleach = StrokeValue::Scalar(bleach);
    let everywhere = |spacing: f32| locks(groom, spacing);
    let lighten = |id, strength, spacing: f32, arc_reach| {
        let dabs = everywhere(spacing);
        along_locks(
            stroke(
                id,
                "lightener",
                Channel::Bleach,
                bleach,
                strength,
                0.6 * spacing,
                dabs,
            ),
            arc_reach,
        )
    };
    let tone = stroke(
        3,
        "toner",
        Channel::Dye,
        StrokeValue::Rgb(tone),
        1.0,
        spacing,
        everywhere(spacing),
    );
    vec![
        lighten(1, 0.9, spacing, 0.75),
        lighten(2, 1.0, 0.5 * spacing, 0.5),
        along_locks(tone, 0.6),
    ]
}

/// The layers of a balayage.
fn balayage_layers() -> Vec<Layer> {
    vec![Layer::new("lightener", "Lightener"), Layer::new("toner", "Toner")]
}

/// Light and view of the demo.
const DEMO_LIGHT: (&str, f32, f32) = ("city", 1.3, -100.0);
const DEMO_VIEW: (Vec3, f32) = (Vec3::new(0.75, 0.12, 0.8), 0.78);

/// Every bundled JSON with its text.
fn samples() -> Vec<(&'static str, String)> {
    let (mut straight, groom) = natural(
        "long-straight",
        ("city", 0.9, 150.0),
        [1.6, 0.4],
        (Vec3::new(0.75, 0.1, 0.7), 1.04),
    );
    straight.layers = balayage_layers();
    straight.operations = balayage(&groom, 0.03, 0.93, [0.01, 0.05, 0.13]);

    let (mut curly, groom) = natural(
        "curly",
        ("city", 1.0, -40.0),
        [1.3, 0.5],
        (Vec3::new(0.65, 0.15, 0.7), 0.76),
    );
    curly.layers = balayage_layers();
    curly.operations = balayage(&groom, 0.03, 0.96, [0.04, 0.5, 0.22]);

    // Platinum with rose lengths and violet tips.
    let (mut bob, groom) = natural(
        "wavy-bob",
        ("city", 0.6, -100.0),
        [0.08, 0.04],
        (Vec3::new(0.6, 0.12, 0.8), 0.78),
    );
    let vivid = |id, layer: &str, dye, spacing: f32, arc_reach| {
        let dabs = locks(&groom, spacing);
        let stroke = stroke(id, layer, Channel::Dye, StrokeValue::Rgb(dye), 1.0, spacing, dabs);
        along_locks(stroke, arc_reach)
    };
    bob.layers = vec![Layer::new("rose", "Rose"), Layer::new("violet", "Violet")];
    bob.operations = vec![
        vivid(1, "rose", [0.03, 0.42, 0.2], 0.03, 0.85),
        vivid(2, "violet", [0.22, 0.5, 0.05], 0.025, 0.45),
    ];

    // The demo dyes an untouched brown bob.
    let (demo, _) = natural("wavy-bob", DEMO_LIGHT, [1.7, 0.4], DEMO_VIEW);
    let strokes = StrokeFile {
        version: STROKE_VERSION,
        groom: Some(groom.content_hash()),
        operations: balayage(&groom, 0.03, 0.95, [0.01, 0.05, 0.11]),
        extra: Extra::new(),
    };
    vec![
        ("long-straight.json", json::to_text(&straight).unwrap()),
        ("wavy-bob.json", json::to_text(&bob).unwrap()),
        ("curly.json", json::to_text(&curly).unwrap()),
        ("demo.json", json::to_text(&demo).unwrap()),
        ("strokes/demo.json", json::to_text(&strokes).unwrap()),
    ]
}

#[test]
fn sample_projects_are_what_is_made_from_the_sample_grooms() {
    for (name, text) in samples() {
        let path = repository(&format!("projects/{name}"));
        if std::env::var_os("BALAYAGE_WRITE_SAMPLES").is_some() {
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(&path, &text).unwrap();
        }
        assert!(
            fs::read_to_string(&path).unwrap() == text,
            "{name} is not what is made"
        );
        assert!(text.len() < 300_000, "{name} has {} bytes", text.len());
    }
}

#[test]
fn sample_projects_open_without_a_warning_and_are_dyed() {
    for name in ["long-straight", "wavy-bob", "curly"] {
        let opened = Document::open(&repository(&format!("projects/{name}.json")), None).unwrap();
        assert!(
            opened.warnings.is_empty() && opened.report.repairs() == 0,
            "{name}"
        );
        let base = opened.document.project().hair.base.known;
        let painted = opened
            .document
            .values()
            .iter()
            .filter(|values| **values != base)
            .count();
        let share = painted as f64 / opened.document.values().len() as f64;
        assert!(
            (0.1..0.9).contains(&share),
            "{name}: {share} of the points are painted"
        );
        assert!(opened.document.load_head().unwrap().is_some());
    }
    let sample = Document::sample().unwrap();
    assert!(sample.warnings.is_empty());
    assert!(sample.document.load_head().unwrap().is_some());
    assert!(
        !Path::new(&sample.document.project().groom.path).exists(),
        "the sample needs no file"
    );
}
