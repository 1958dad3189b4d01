//! What the tests share: data folder, comparators with their negative controls, poison values.

use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

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
    let Some(folder) = std::env::var_os("BALAYAGE_TEST_DATA") else {
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
