//! The sample projects and their strokes: what is bundled is what is made here from the sample grooms.
//!
//! `BALAYAGE_WRITE_SAMPLES=1 cargo test -p balayage-tests --test suite sample_projects` writes them anew.

use std::{fs, path::Path};

use balayage::{
    document::{CameraPose, Document, Environment, GroomReference, HeadReference, Layer, Project, json},
    paint::{
        Dab, Extra, Falloff, Mode, Operation, OperationId, Reach, STROKE_VERSION, StrokeFile, StrokeValue,
    },
};
use balayage_render::{
    gpu::{Camera, CameraFile},
    groom::{Groom, read_groom},
    param::{Channel, PointValues},
};
use balayage_tests::repository;
use glam::Vec3;

/// Where a stroke goes: places on the hair for which `wanted(position, arc)` holds, a radius apart.
fn dabs(groom: &Groom, radius: f32, wanted: impl Fn(Vec3, f32) -> bool) -> Vec<Dab> {
    let arc = groom.arc();
    let mut taken: Vec<Vec3> = Vec::new();
    let mut dabs = Vec::new();
    for strand in 0..groom.strand_count() {
        let points = groom.strand(strand);
        let root = groom.positions()[points.start];
        for p in points {
            let position = groom.positions()[p];
            if wanted(position, arc[p]) && taken.iter().all(|other| other.distance(position) > 0.8 * radius) {
                taken.push(position);
                dabs.push(Dab {
                    root: root.into(),
                    arc: arc[p],
                    position: position.into(),
                    pressure: 1.0,
                    extra: Extra::new(),
                });
            }
        }
    }
    dabs
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
        arc_reach: None,
        seed: 0,
        dabs,
        extra: Extra::new(),
    }
}

/// The camera that sees the hair from the side that `towards_eye` points to, rounded so that every platform writes the same text.
fn pose(groom: &Groom, towards_eye: Vec3) -> CameraPose {
    let file = CameraFile::from(Camera::framing_from(groom.bounds(), 1.0, towards_eye));
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
    towards_eye: Vec3,
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
    });
    project.head = Some(HeadReference {
        path: "head.obj".into(),
        extra: Extra::new(),
    });
    let (map, exposure_ev, rotation_deg) = environment;
    project.light.environment = Environment::Map(format!("environments/{map}.hdr"));
    project.light.exposure_ev = exposure_ev;
    project.light.rotation_deg = rotation_deg;
    project.camera = Some(pose(&loaded, towards_eye));
    project.hair.base = PointValues {
        eumelanin: melanin[0],
        pheomelanin: melanin[1],
        ..PointValues::default()
    }
    .into();
    (project, loaded)
}

/// Ends lightened in two steps, then toned, with brushes of `radius` metres.
fn balayage(project: &mut Project, groom: &Groom, tone: [f32; 3], radius: f32) {
    project.layers = vec![Layer::new("lightener", "Lightener"), Layer::new("toner", "Toner")];
    let tips = |radius: f32, start: f32| dabs(groom, radius, move |_, arc| arc > start);
    let bleach = |share| StrokeValue::Scalar(share);
    let fine = 0.75 * radius;
    project.operations = vec![
        stroke(
            1,
            "lightener",
            Channel::Bleach,
            bleach(0.7),
            0.7,
            radius,
            tips(radius, 0.5),
        ),
        stroke(
            2,
            "lightener",
            Channel::Bleach,
            bleach(0.92),
            0.9,
            fine,
            tips(fine, 0.75),
        ),
        stroke(
            3,
            "toner",
            Channel::Dye,
            StrokeValue::Rgb(tone),
            0.8,
            radius,
            tips(radius, 0.7),
        ),
    ];
}

/// Light and view of the bob, which shows more hair than face.
const BOB_LIGHT: (&str, f32, f32) = ("sunrise", 0.5, 90.0);
const BOB_VIEW: Vec3 = Vec3::new(0.9, 0.15, -0.35);

/// Every bundled JSON with its text.
fn samples() -> Vec<(&'static str, String)> {
    let (mut straight, groom) = natural(
        "long-straight",
        ("city", 1.0, 150.0),
        [1.3, 0.2],
        Vec3::new(0.7, 0.1, -0.7),
    );
    balayage(&mut straight, &groom, [0.03, 0.16, 0.4], 0.04);
    let (mut curly, groom) = natural(
        "curly",
        ("studio", 2.0, 0.0),
        [1.8, 0.3],
        Vec3::new(0.6, 0.15, 0.8),
    );
    balayage(&mut curly, &groom, [0.05, 0.5, 0.12], 0.019);
    let (mut bob, groom) = natural("wavy-bob", BOB_LIGHT, [0.12, 0.05], BOB_VIEW);
    let teal = StrokeValue::Rgb([0.9, 0.08, 0.14]);
    let left = dabs(&groom, 0.03, |position, arc| arc > 0.55 && position.x > 0.0);
    bob.operations = vec![stroke(1, "paint", Channel::Dye, teal, 0.9, 0.03, left)];

    // The demo dyes an untouched bob: copper on one side, violet on the other, roots left out.
    let (demo, _) = natural("wavy-bob", BOB_LIGHT, [0.12, 0.05], BOB_VIEW);
    let side = |sign: f32| {
        dabs(&groom, 0.035, move |position, arc| {
            arc > 0.3 && sign * position.x > 0.01
        })
    };
    let strokes = StrokeFile {
        version: STROKE_VERSION,
        groom: Some(groom.content_hash()),
        operations: vec![
            stroke(
                1,
                "copper",
                Channel::Dye,
                StrokeValue::Rgb([0.06, 0.55, 1.3]),
                0.9,
                0.035,
                side(1.0),
            ),
            stroke(
                2,
                "violet",
                Channel::Dye,
                StrokeValue::Rgb([0.35, 0.95, 0.18]),
                0.9,
                0.035,
                side(-1.0),
            ),
        ],
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
