//! Damaged groom and mesh files: an error or something sound, never a panic.

use balayage_render::groom::{GroomError, LoadedGroom, Mesh, hair_bytes, parse_hair, parse_tfx, tfx_bytes};
use balayage_tests::{damage, repository, test_data};

use crate::groom::{assert_sound, wild_groom};

/// Feeds damaged copies to a reader; most short ones must be refused, and every refusal must name the file.
fn survive(valid: &[u8], header: usize, seed: u64, parse: impl Fn(&[u8]) -> Result<LoadedGroom, GroomError>) {
    let (mut refused, mut read) = (0, 0);
    assert_sound(&parse(valid).unwrap().groom);
    damage(valid, header, seed, |bytes| match parse(bytes) {
        Ok(loaded) => {
            read += 1;
            assert_sound(&loaded.groom);
        }
        Err(error) => {
            refused += 1;
            assert!(error.to_string().starts_with("damaged"), "{error}");
            // A prefix can not be blamed on anything but a place inside the file.
            if let GroomError::Format { offset, .. } = error {
                assert!(offset <= bytes.len() as u64);
            }
        }
    });
    assert!(refused >= header && read > 50, "{refused} refused, {read} read");
}

#[test]
fn damaged_hair() {
    for (seed, equal) in [(1, false), (2, true)] {
        let valid = hair_bytes(&wild_groom(seed, 60, equal)).unwrap();
        survive(&valid, 128, seed, |bytes| parse_hair(bytes, "damaged.hair", None));
    }
}

#[test]
fn damaged_tfx_version_4() {
    let valid = tfx_bytes(&wild_groom(3, 60, true)).unwrap();
    survive(&valid, 160, 3, |bytes| parse_tfx(bytes, "damaged.tfx", None));
}

#[test]
fn damaged_tfx_version_3() {
    let groom = wild_groom(4, 60, true);
    let mut valid = 3.0_f32.to_le_bytes().to_vec();
    valid.extend(60_u32.to_le_bytes());
    valid.extend(9_u32.to_le_bytes());
    valid.resize(296, 0);
    valid[144..148].copy_from_slice(&296_u32.to_le_bytes());
    valid.extend(
        groom
            .positions()
            .iter()
            .flat_map(glam::Vec3::to_array)
            .flat_map(f32::to_le_bytes),
    );
    assert_eq!(
        parse_tfx(&valid, "v3.tfx", None).unwrap().groom.positions(),
        groom.positions()
    );
    survive(&valid, 296, 4, |bytes| parse_tfx(bytes, "damaged.tfx", None));
}

#[test]
fn damaged_real_files() {
    for (name, header) in [
        ("sintel_hair_k4.hair", 128),
        ("tressfx3_ponytail_back.tfx", 296),
        ("tressfx_ratboy_mohawk_k2.tfx", 160),
    ] {
        let Some(path) = test_data(&format!("fetched/hair/{name}")) else {
            return;
        };
        let valid = std::fs::read(path).unwrap();
        survive(&valid, header, 5, |bytes| {
            if header == 128 {
                parse_hair(bytes, "damaged.hair", None)
            } else {
                parse_tfx(bytes, "damaged.tfx", None)
            }
        });
    }
}

#[test]
fn damaged_mesh() {
    let cube = b"# a tetrahedron and a square\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\nf 1/1/1 3//1 2\nf -4 -3 -1\nf 1 2 3 4\n";
    let mesh = Mesh::parse_obj(cube, "cube.obj").unwrap();
    assert_eq!((mesh.positions().len(), mesh.triangles().len()), (4, 4));
    assert_eq!(mesh.triangles()[1], [0, 1, 3]);

    let mut read = 0;
    damage(cube, cube.len(), 6, |bytes| {
        match Mesh::parse_obj(bytes, "damaged.obj") {
            Ok(mesh) => {
                read += 1;
                assert!(
                    mesh.positions()
                        .iter()
                        .chain(mesh.normals())
                        .all(|p| p.is_finite())
                );
                assert!(
                    mesh.triangles()
                        .iter()
                        .flatten()
                        .all(|&v| (v as usize) < mesh.positions().len())
                );
            }
            Err(error) => assert!(error.to_string().starts_with("damaged.obj: byte"), "{error}"),
        }
    });
    assert!(read > 20);

    for (text, reason) in [
        ("v 0 nan 0\n", "three finite coordinates"),
        ("v 0 0 1e30\n", "three finite coordinates"),
        ("v 0 0 0\nf 1 1 2\n", "names a vertex"),
        ("v 0 0 0\nv 1 0 0\nf 1 2\n", "fewer than three corners"),
        ("v 0 0 0\nf 1 1 1\n", "no triangle"),
        ("v 0 0 0\nf 0 1 1\n", "names a vertex"),
    ] {
        let error = Mesh::parse_obj(text.as_bytes(), "bad.obj")
            .unwrap_err()
            .to_string();
        assert!(error.contains(reason), "{text:?}: {error}");
    }
}

#[test]
fn bundled_head_is_closed_below_and_in_metres() {
    let head = Mesh::read_obj(repository("projects/head.obj")).unwrap();
    let (min, max) = head.bounds();
    assert!((0.2..0.3).contains(&(max.y - min.y)) && (0.15..0.25).contains(&(max.z - min.z)));
    // The divergence theorem: a closed surface that faces out encloses its volume, a few litres here.
    let volume: f32 = (0..head.triangles().len())
        .map(|t| {
            let [a, b, c] = head.corners(t);
            a.dot(b.cross(c)) / 6.0
        })
        .sum();
    assert!((0.003..0.006).contains(&volume), "{volume} cubic metres");
}
