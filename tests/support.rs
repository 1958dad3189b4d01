//! What the tests share: data folder, comparators with their negative controls, poison values.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail like tests")]

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

use balayage_render::groom::{Groom, GroomBuilder, MAX_COORDINATE, UnitSource};
use glam::Vec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Numbers that no reader may choke on: zeros, denormals, extremes, and what is no number.
pub const POISON: [f32; 12] = [
    0.0,
    -0.0,
    1.0e-45,
    f32::MIN_POSITIVE,
    f32::EPSILON,
    -1.0,
    1.0e7,
    3.0e38,
    -3.0e38,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

/// Tests that went without their data in this run.
static SKIPPED: AtomicUsize = AtomicUsize::new(0);

/// A file of the folder that `BALAYAGE_TEST_DATA` names, or `None` when the variable is not set: then the test skips, and the running
/// number of skips is printed.
///
/// # Panics
/// When the variable is set but the file is not there: a test that was asked for must not pass by skipping.
pub fn test_data(relative: &str) -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("BALAYAGE_TEST_DATA").filter(|folder| !folder.is_empty()) else {
        let skipped = 1 + SKIPPED.fetch_add(1, Ordering::Relaxed);
        // Written past the test harness, which would keep a passing test's words to itself.
        let line = format!("skipped {skipped}: BALAYAGE_TEST_DATA is not set, {relative} not read\n");
        let _ = std::io::stderr().write_all(line.as_bytes());
        return None;
    };
    let path = PathBuf::from(folder).join(relative);
    assert!(path.exists(), "BALAYAGE_TEST_DATA is set but has no {relative}");
    Some(path)
}

/// A Python that can import `module`: the first such of those that `BALAYAGE_PYTHON` lists (as `PATH` lists folders), else `python3`.
/// None, and a line that says so, where there is none: then the test skips.
pub fn python_with(module: &str) -> Option<PathBuf> {
    let listed = std::env::var_os("BALAYAGE_PYTHON").unwrap_or_default();
    let found = std::env::split_paths(&listed)
        .filter(|path| !path.as_os_str().is_empty())
        .chain([PathBuf::from("python3")])
        .find(|python| {
            Command::new(python)
                .args(["-c", &format!("import {module}")])
                .output()
                .is_ok_and(|output| output.status.success())
        });
    if found.is_none() {
        let skipped = 1 + SKIPPED.fetch_add(1, Ordering::Relaxed);
        let line =
            format!("skipped {skipped}: no Python that imports {module} (BALAYAGE_PYTHON may list some)\n");
        let _ = std::io::stderr().write_all(line.as_bytes());
    }
    found
}

/// What a script of this repository prints as JSON.
///
/// # Panics
/// When it fails: a test that found its Python must not pass by skipping.
pub fn script(python: &Path, script: &str, args: &[&Path]) -> serde_json::Value {
    let output = Command::new(python)
        .arg(repository(script))
        .args(args)
        .output()
        .unwrap_or_else(|e| panic!("{}: {e}", python.display()));
    let text = String::from_utf8_lossy(&output.stdout);
    // Programs with plug-ins talk: the answer is the last line.
    let answer = text
        .lines()
        .last()
        .and_then(|line| serde_json::from_str(line).ok());
    match answer {
        Some(answer) if output.status.success() => answer,
        _ => panic!("{script}: {text}{}", String::from_utf8_lossy(&output.stderr)),
    }
}

/// A folder or file of this repository.
pub fn repository(relative: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("..")
        .join(relative)
}

/// Seeded random numbers, the same on every platform.
pub fn random(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

/// Damaged copies of a valid file, each handed to `read`: every prefix of the first `header` bytes, 200 prefixes of the rest, 200 copies
/// with one to eight flipped bits, and every poison value and the largest count in every word of the header and in 32 words of the rest.
pub fn damage(valid: &[u8], header: usize, seed: u64, mut read: impl FnMut(&[u8])) {
    let mut random = random(seed);
    for len in 0..header.min(valid.len()) {
        read(&valid[..len]);
    }
    for _ in 0..200 {
        read(&valid[..random.random_range(0..valid.len())]);
    }
    let mut copy = valid.to_vec();
    for _ in 0..200 {
        for _ in 0..random.random_range(1..=8) {
            let byte = if random.random() {
                random.random_range(0..valid.len())
            } else {
                random.random_range(0..header.min(valid.len()))
            };
            copy[byte] ^= 1 << random.random_range(0..8);
        }
        read(&copy);
        copy.copy_from_slice(valid);
    }
    let rest: Vec<usize> = (0..32)
        .map(|_| random.random_range(0..valid.len() - 4) / 4 * 4)
        .collect();
    let words = (0..header.min(valid.len() - 4)).step_by(4).chain(rest);
    for at in words {
        let poison = POISON
            .map(f32::to_bits)
            .into_iter()
            .chain([u32::MAX, 1 << 31, u32::from(u16::MAX)]);
        for bits in poison {
            copy[at..at + 4].copy_from_slice(&bits.to_le_bytes());
            read(&copy);
        }
        copy[at..at + 4].copy_from_slice(&valid[at..at + 4]);
    }
}

/// Everything that a groom promises.
pub fn assert_sound(groom: &Groom) {
    assert!(groom.strand_count() > 0);
    assert_eq!(groom.positions().len(), groom.diameters().len());
    assert_eq!(groom.first_point()[0], 0);
    assert_eq!(*groom.first_point().last().unwrap() as usize, groom.point_count());
    assert!(
        groom
            .positions()
            .iter()
            .all(|p| p.abs().max_element() <= MAX_COORDINATE)
    );
    assert!(groom.diameters().iter().all(|&d| d > 0.0 && d.is_finite()));
    assert!(groom.metres_per_unit() > 0.0);
    for strand in 0..groom.strand_count() {
        let points = &groom.positions()[groom.strand(strand)];
        assert!(points.len() >= 2);
        assert!(points.windows(2).all(|p| p[0].distance(p[1]) > 0.0));
    }
}

/// Random walks with differing numbers of points and differing diameters.
pub fn wild_groom(seed: u64, strands: usize, equal_points: bool) -> Groom {
    let mut random = random(seed);
    let mut builder = GroomBuilder::new();
    for _ in 0..strands {
        let mut p = Vec3::from_array(random.random::<[f32; 3]>());
        let points = if equal_points {
            9
        } else {
            random.random_range(2..20)
        };
        builder.push_strand((0..points).map(|_| {
            p += 0.05 * (Vec3::from_array(random.random::<[f32; 3]>()) - 0.3);
            (p, Some(1.0e-4 * (0.5 + random.random::<f32>())))
        }));
    }
    builder.finish("wild", Some((0.1, UnitSource::Given))).unwrap().0
}
