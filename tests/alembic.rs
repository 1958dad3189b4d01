//! Alembic curves: what Blender and Maya write is read with its transforms and widths; what is not read is said.

use balayage_render::groom::{parse_abc, read_groom, write_groom};
use balayage_tests::{assert_sound, damage, repository, test_data};
use glam::Vec3;

fn corpus() -> Vec<u8> {
    std::fs::read(repository("tests/fuzz/corpus/curves.abc")).unwrap()
}

/// `tests/fuzz/corpus/abc.py` made the file in Blender: a Bezier and a poly curve under a transform.
#[test]
fn what_blender_writes_is_read() {
    let abc = parse_abc(&corpus(), "curves.abc", Some(1.0)).unwrap();
    assert_sound(&abc.loaded.groom);
    assert_eq!((abc.curves, abc.control_points), (3, 12));
    let groom = abc.loaded.groom;
    // Blender's z is up, Alembic's y: (x, y, z) becomes (x, z, -y).
    for (strand, first, last) in [
        (0, Vec3::new(1.0, 3.0, -2.0), Vec3::new(1.0, 5.0, -3.0)),
        (1, Vec3::new(0.0, 3.0, -2.0), Vec3::new(0.0, 6.0, -2.0)),
        (2, Vec3::new(5.0, 0.0, 0.0), Vec3::new(5.0, 2.0, 0.0)),
    ] {
        let range = groom.strand(strand);
        let (a, b) = (groom.positions()[range.start], groom.positions()[range.end - 1]);
        assert!(
            a.distance(first) < 1e-5 && b.distance(last) < 1e-5,
            "{strand}: {a} {b}"
        );
    }
}

#[test]
fn the_fetched_file_has_its_curves() {
    let Some(path) = test_data("fetched/hair/alembic_curves1.abc") else {
        return;
    };
    let bytes = std::fs::read(&path).unwrap();
    let abc = parse_abc(&bytes, "curves1.abc", None).unwrap();
    assert_eq!((abc.curves, abc.control_points), (2, 12));
    assert_sound(&abc.loaded.groom);
    let loaded = read_groom(&path, None).unwrap();
    assert_eq!(loaded.groom, abc.loaded.groom);
    let folder = tempfile::tempdir().unwrap();
    let error = write_groom(folder.path().join("out.abc"), &loaded.groom).unwrap_err();
    assert!(error.to_string().contains("read, not written"), "{error}");
}

#[test]
fn refusals_name_place_and_reason() {
    let valid = corpus();
    let open = [&valid[..5], &[0], &valid[6..]].concat();
    let mut circle = valid.clone();
    let root: [u8; 8] = valid[8..16].try_into().unwrap();
    let at = u64::from_le_bytes(root) as usize;
    // The root object becomes the archive itself.
    circle[at + 24..at + 32].copy_from_slice(&root);
    for (bytes, reason) in [
        (b"\x89HDF\r\n\x1a\n and more".to_vec(), "HDF5"),
        (b"Ogawa".to_vec(), "the header needs 16 bytes"),
        (b"something else that is long".to_vec(), "does not start with"),
        (open, "did not finish"),
        (circle, ""),
    ] {
        let error = parse_abc(&bytes, "bad.abc", None).unwrap_err().to_string();
        assert!(error.starts_with("bad.abc") && error.contains(reason), "{error}");
    }
}

#[test]
fn damaged_alembic() {
    let valid = corpus();
    let mut read = 0;
    damage(&valid, 200, 51, |bytes| {
        match parse_abc(bytes, "damaged.abc", None) {
            Ok(abc) => {
                read += 1;
                assert_sound(&abc.loaded.groom);
            }
            Err(error) => assert!(error.to_string().starts_with("damaged.abc"), "{error}"),
        }
    });
    assert!(read > 0);
}
