//! Every reader with its files, its mutations and what it may return.

use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

use balayage::document::{CameraPose, Document, Project, check_camera, json};
use balayage::paint::StrokeFile;
use balayage_render::groom::{
    Groom, LoadedGroom, Mesh, ReadOptions, parse_abc, parse_hair, parse_tfx, parse_usd,
};
use balayage_render::light::{EnvironmentMap, LightSet};
use balayage_tests::assert_sound;
use rand_pcg::Pcg64Mcg;

use super::{corpus, mutate, usdc};

/// A reader under fuzzing.
pub struct Target {
    /// What it is called on the command line.
    pub name: &'static str,
    /// Valid files.
    pub corpus: fn() -> Vec<Vec<u8>>,
    /// A new input from that one of the pool.
    pub mutate: fn(&mut Pcg64Mcg, &[Vec<u8>], usize) -> Vec<u8>,
    /// Reads an input: the words of the refusal, or a sound result. Panics where the result is not sound.
    pub read: fn(&[u8]) -> Result<(), String>,
}

/// All readers.
pub const TARGETS: [Target; 11] = [
    Target {
        name: "hair",
        corpus: corpus::hair,
        mutate: mutate::bytes,
        read: |bytes| groom(parse_hair(bytes, "f", None)),
    },
    Target {
        name: "tfx",
        corpus: corpus::tfx,
        mutate: mutate::bytes,
        read: |bytes| groom(parse_tfx(bytes, "f", None)),
    },
    Target {
        name: "usda",
        corpus: corpus::usda,
        mutate: mutate::text,
        read: usd,
    },
    Target {
        name: "usdc",
        corpus: corpus::usdc,
        mutate: usdc::damaged,
        read: usd,
    },
    Target {
        name: "abc",
        corpus: corpus::abc,
        mutate: mutate::bytes,
        read: |bytes| groom(parse_abc(bytes, "f", None).map(|abc| abc.loaded)),
    },
    Target {
        name: "obj",
        corpus: corpus::obj,
        mutate: mutate::text,
        read: mesh,
    },
    Target {
        name: "hdr",
        corpus: corpus::hdr,
        mutate: mutate::bytes,
        read: map,
    },
    Target {
        name: "exr",
        corpus: corpus::exr,
        mutate: mutate::bytes,
        read: map,
    },
    Target {
        name: "project",
        corpus: corpus::project,
        mutate: mutate::json,
        read: project,
    },
    Target {
        name: "strokes",
        corpus: corpus::strokes,
        mutate: mutate::json,
        read: strokes,
    },
    Target {
        name: "lights",
        corpus: corpus::lights,
        mutate: mutate::json,
        read: lights,
    },
];

/// Readers that do what none may.
pub const BROKEN: [Target; 2] = [
    Target {
        name: "panics",
        corpus: corpus::hair,
        mutate: mutate::bytes,
        read: |bytes| {
            assert!(bytes.len() < 100 || bytes[60] == b'B', "byte 60");
            Ok(())
        },
    },
    Target {
        name: "allocates",
        corpus: corpus::hair,
        mutate: mutate::bytes,
        read: |bytes| {
            let count = bytes.get(10).map_or(0, |byte| usize::from(*byte) << 22);
            std::hint::black_box(Vec::<u8>::with_capacity(count));
            Ok(())
        },
    },
];

fn groom<E: std::fmt::Display>(read: Result<LoadedGroom, E>) -> Result<(), String> {
    let loaded = read.map_err(|e| e.to_string())?;
    assert_sound(&loaded.groom);
    Ok(())
}

fn usd(bytes: &[u8]) -> Result<(), String> {
    let options = ReadOptions {
        time: bytes.len().is_multiple_of(2).then_some(1.5),
        ..ReadOptions::default()
    };
    let usd = parse_usd(bytes, "f", options).map_err(|e| e.to_string())?;
    assert_sound(&usd.loaded.groom);
    if let Some(painted) = usd.painted {
        assert_eq!(painted.values.len(), usd.loaded.groom.point_count());
        assert_eq!(painted.ratios.len(), usd.loaded.groom.point_count());
        assert!(painted.values.iter().all(|value| value.out_of_range().is_none()));
        let ratios = painted.ratios.iter();
        assert!(
            ratios
                .flat_map(|r| [r.alpha_tt, r.alpha_trt, r.beta_tt, r.beta_trt])
                .all(f32::is_finite)
        );
    }
    Ok(())
}

fn mesh(bytes: &[u8]) -> Result<(), String> {
    let mesh = Mesh::parse_obj(bytes, "f").map_err(|e| e.to_string())?;
    let points = mesh.positions().iter().chain(mesh.normals());
    assert!(points.into_iter().all(|p| p.is_finite()));
    let corners = mesh.triangles().iter().flatten();
    assert!(
        corners
            .into_iter()
            .all(|&v| (v as usize) < mesh.positions().len())
    );
    Ok(())
}

fn map(bytes: &[u8]) -> Result<(), String> {
    let (map, _) = EnvironmentMap::from_bytes(bytes, Path::new("f")).map_err(|e| e.to_string())?;
    assert_eq!(map.pixels.len(), map.width * map.height);
    assert!(map.pixels.iter().all(|p| p.is_finite() && p.min_element() >= 0.0));
    Ok(())
}

fn text(bytes: &[u8]) -> Result<&str, String> {
    std::str::from_utf8(bytes).map_err(|_| "not UTF-8".to_owned())
}

/// The groom that projects are painted on.
static GROOM: LazyLock<Arc<Groom>> = LazyLock::new(|| Arc::new(corpus::groom()));

fn project(bytes: &[u8]) -> Result<(), String> {
    let project = Project::parse(text(bytes)?).map_err(|e| e.to_string())?;
    // What is written is read as the same project.
    let written = json::to_text(&project).map_err(|e| e.to_string())?;
    let again = Project::parse(&written).unwrap_or_else(|e| panic!("what was written is refused: {e}"));
    assert_eq!(project, again);
    let document = Document::new(GROOM.clone(), project, PathBuf::new()).map_err(|e| e.to_string())?;
    assert!(
        document
            .values()
            .iter()
            .all(|value| value.out_of_range().is_none())
    );
    Ok(())
}

fn strokes(bytes: &[u8]) -> Result<(), String> {
    let strokes = StrokeFile::parse(text(bytes)?).map_err(|e| e.to_string())?;
    let written = serde_json::to_string(&strokes).map_err(|e| e.to_string())?;
    let again = StrokeFile::parse(&written).unwrap_or_else(|e| panic!("what was written is refused: {e}"));
    assert_eq!(strokes.operations, again.operations);
    Ok(())
}

/// Lists of lights, and cameras, which are as small.
fn lights(bytes: &[u8]) -> Result<(), String> {
    let text = text(bytes)?;
    if text.contains("world_from") {
        let camera: CameraPose = serde_json::from_str(text).map_err(|e| e.to_string())?;
        return check_camera(&camera).map_err(|e| e.to_string());
    }
    let lights = LightSet::from_json(text, Path::new("f")).map_err(|e| e.to_string())?;
    for light in &lights.lights {
        assert!((light.direction.length() - 1.0).abs() < 1e-4 && light.bandwidth > 0.0);
        assert!(light.radiance.is_finite() && light.radiance.min_element() >= 0.0);
    }
    Ok(())
}
