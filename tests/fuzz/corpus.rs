//! Small valid files of every format, most of them written by ourselves.

use balayage::document::Document;
use balayage_render::groom::{Groom, PaintedValues, hair_bytes, tfx_bytes, usda_bytes};
use balayage_render::image::Picture;
use balayage_render::param::{LobeRatios, PigmentSet, PointValues};
use balayage_tests::{repository, wild_groom};

fn repository_file(path: &str) -> Vec<u8> {
    std::fs::read(repository(path)).unwrap()
}

/// The groom that projects are painted on.
pub fn groom() -> Groom {
    wild_groom(41, 8, false)
}

pub fn hair() -> Vec<Vec<u8>> {
    [false, true]
        .map(|equal| hair_bytes(&wild_groom(42, 6, equal)).unwrap())
        .into()
}

pub fn tfx() -> Vec<Vec<u8>> {
    let groom = wild_groom(43, 5, true);
    let mut version_3 = 3.0_f32.to_le_bytes().to_vec();
    version_3.extend(5_u32.to_le_bytes());
    version_3.extend(9_u32.to_le_bytes());
    version_3.resize(296, 0);
    version_3[144] = 40;
    version_3[145] = 1;
    let floats = groom.positions().iter().flat_map(glam::Vec3::to_array);
    version_3.extend(floats.flat_map(f32::to_le_bytes));
    vec![tfx_bytes(&groom).unwrap(), version_3]
}

pub fn usda() -> Vec<Vec<u8>> {
    let groom = wild_groom(44, 3, false);
    let painted = PaintedValues {
        values: vec![PointValues::default(); groom.point_count()],
        ratios: vec![LobeRatios::default(); groom.point_count()],
        pigments: PigmentSet::Deon2011,
    };
    vec![
        usda_bytes(&groom, Some(&painted)).unwrap(),
        repository_file("tests/fuzz/corpus/scene.usda"),
    ]
}

pub fn usdc() -> Vec<Vec<u8>> {
    vec![
        super::usdc::valid(),
        repository_file("tests/fuzz/corpus/scene.usdc"),
    ]
}

pub fn abc() -> Vec<Vec<u8>> {
    vec![repository_file("tests/fuzz/corpus/curves.abc")]
}

pub fn obj() -> Vec<Vec<u8>> {
    let tetrahedron = "# a tetrahedron and a square\no head\nv 0 0 0\nv 1 0 0 1\nv 0 1 0\nv 0 0 1e-1\nvn 0 0 1\ns off\nf 1/1/1 3//1 2\nf -4 -3 -1\nf 1 2 3 4\n";
    vec![tetrahedron.into()]
}

pub fn hdr() -> Vec<Vec<u8>> {
    // Rows packed the new way, the old way, and not at all.
    let head = |size: &str| {
        format!("#?RADIANCE\n# by hand\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2.0\n\n{size}\n").into_bytes()
    };
    let mut packed = head("-Y 4 +X 8");
    for row in 0..4_u8 {
        packed.extend([2, 2, 0, 8]);
        for channel in 0..4_u8 {
            packed.extend([132, 100 + channel, 4, 1, 2, 3, row]);
        }
    }
    let mut old = head("-Y 2 +X 8");
    for _ in 0..2 {
        old.extend([90, 80, 70, 129, 1, 1, 1, 6, 10, 20, 30, 128]);
    }
    let mut flat = head("-Y 2 +X 4");
    flat.extend((0..32).map(|i| 100 + i));
    vec![packed, old, flat]
}

pub fn exr() -> Vec<Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.exr");
    let pixels = (0..128).map(|i| [i as f32, 0.5, 0.25, 1.0]);
    let picture = Picture {
        width: 16,
        height: 8,
        pixels: pixels.collect(),
    };
    picture.write_exr(&path).unwrap();
    let ours = std::fs::read(&path).unwrap();
    let uncompressed = {
        use exr::prelude::*;
        let image = Image::from_encoded_channels(
            (16, 8),
            Encoding::UNCOMPRESSED,
            SpecificChannels::rgb(|at: Vec2<usize>| {
                (
                    f16::from_f32(at.x() as f32),
                    f16::from_f32(1.0),
                    f16::from_f32(0.1),
                )
            }),
        );
        image.write().to_file(&path).unwrap();
        std::fs::read(&path).unwrap()
    };
    let tiled = {
        use exr::prelude::*;
        let encoding = Encoding {
            compression: Compression::PIZ,
            blocks: Blocks::Tiles(Vec2(8, 8)),
            line_order: LineOrder::Increasing,
        };
        let image = Image::from_encoded_channels(
            (16, 8),
            encoding,
            SpecificChannels::rgb(|at: Vec2<usize>| (at.y() as f32, 1.0_f32, 2.0_f32)),
        );
        image.write().to_file(&path).unwrap();
        std::fs::read(&path).unwrap()
    };
    vec![ours, uncompressed, tiled]
}

pub fn project() -> Vec<Vec<u8>> {
    // Projects of the repository with a few strokes each, and one with everything that a project can hold.
    let few = |path: &str| {
        let mut project: serde_json::Value = serde_json::from_slice(&repository_file(path)).unwrap();
        if let Some(operations) = project["operations"].as_array_mut() {
            operations.truncate(3);
            for operation in operations {
                if let Some(dabs) = operation["dabs"].as_array_mut() {
                    dabs.truncate(2);
                }
            }
        }
        project.to_string().into_bytes()
    };
    let sample = Document::sample().unwrap().document;
    let mut plain = balayage::document::Project::new(sample.project().groom.clone());
    plain.light = sample.project().light.clone();
    vec![
        few("projects/curly.json"),
        few("projects/older/version-1.json"),
        serde_json::to_vec(&plain).unwrap(),
        repository_file("tests/fuzz/corpus/project.json"),
    ]
}

pub fn strokes() -> Vec<Vec<u8>> {
    let mut few: serde_json::Value =
        serde_json::from_slice(&repository_file("projects/strokes/demo.json")).unwrap();
    few["operations"].as_array_mut().unwrap().truncate(3);
    vec![
        repository_file("projects/strokes/salon.json"),
        few.to_string().into_bytes(),
    ]
}

pub fn lights() -> Vec<Vec<u8>> {
    let lights = r#"{"lights": [{"direction": [0, 1, 0], "bandwidth": 0.5, "radiance": [3, 3, 3]}, {"direction": [0.6, 0, 0.8], "bandwidth": 2, "radiance": [0, 1e3, 0.5]}], "constant": [0.5, 0.5, 0.5]}"#;
    let camera = r#"{"world_from_camera": [[1,0,0,10],[0,1,0,6],[0,0,1,60],[0,0,0,1]], "fov_y_deg": 30}"#;
    vec![lights.into(), camera.into()]
}
