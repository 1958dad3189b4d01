//! What readers allocate: never more than twice the file plus 64 MiB. A binary of its own, because the allocator counts for all threads.

#![allow(clippy::unwrap_used, reason = "a helper that fails fails its test")]

use balayage_render::groom::{GroomError, Mesh, hair_bytes, parse_hair, parse_tfx, read_groom, tfx_bytes};
use balayage_render::image::Picture;
use balayage_render::light::EnvironmentMap;
use balayage_tests::{damage, repository};
use peak_alloc::PeakAlloc;

#[global_allocator]
static COUNTER: PeakAlloc = PeakAlloc;

/// Bytes allocated at the peak of `work`, beyond what was there before.
fn peak_of<T>(work: impl FnOnce() -> T) -> (T, usize) {
    COUNTER.reset_peak_usage();
    let before = COUNTER.current_usage();
    let result = work();
    (result, COUNTER.peak_usage().saturating_sub(before))
}

/// Reads damaged copies, each within its budget.
fn stay_within_budget<T>(valid: &[u8], header: usize, parse: impl Fn(&[u8]) -> Result<T, GroomError>) {
    let mut largest = 0;
    damage(valid, header, 9, |bytes| {
        let (_, peak) = peak_of(|| parse(bytes).is_ok());
        // The slack of 64 MiB would hide a lie on files this small: hold them to the law that scales.
        assert!(
            peak <= 4 * bytes.len() + 65_536,
            "{peak} bytes for a file of {}",
            bytes.len()
        );
        largest = largest.max(peak);
    });
    assert!(largest > 0, "the counter does not count");
}

/// Damaged environment maps: a map unpacks to more than its file, so that the rule with its slack of 64 MiB is what holds.
fn maps_stay_within_the_rule() {
    let (map, _) = EnvironmentMap::from_fn(64, 32, |w| w * 0.5 + 0.5);
    let folder = tempfile::tempdir().unwrap();
    let pixels = map.pixels.iter().map(|p| p.extend(1.0).to_array()).collect();
    let exr = folder.path().join("map.exr");
    Picture {
        width: map.width,
        height: map.height,
        pixels,
    }
    .write_exr(&exr)
    .unwrap();
    let hdr = repository("projects/environments/city.hdr");
    for path in [&exr, &hdr] {
        let valid = std::fs::read(path).unwrap();
        damage(&valid, 320.min(valid.len()), 11, |bytes| {
            let (_, peak) = peak_of(|| EnvironmentMap::from_bytes(bytes, path).is_ok());
            let budget = 2 * bytes.len() + (64 << 20);
            assert!(
                peak <= budget,
                "{}: {peak} bytes for a file of {}",
                path.display(),
                bytes.len()
            );
        });
    }
}

/// One test, so that nothing else allocates beside it.
#[test]
fn readers_allocate_in_proportion_to_the_file() {
    let (_, counted) = peak_of(|| std::hint::black_box(vec![1_u8; 10_000_000]).len());
    assert!(counted >= 10_000_000, "the counter does not count");

    let path = repository("projects/grooms/long-straight.hair");
    let groom = read_groom(&path, None).unwrap().groom;
    let hair = hair_bytes(&groom).unwrap();
    let tfx = tfx_bytes(&groom).unwrap();
    let obj = std::fs::read(repository("projects/head.obj")).unwrap();
    let (_, peak) = peak_of(|| read_groom(&path, None).is_ok());
    assert!(
        peak <= 5 * hair.len() / 2,
        "{peak} bytes for a file of {}",
        hair.len()
    );
    stay_within_budget(&hair, 128, |bytes| parse_hair(bytes, "hair", None));
    stay_within_budget(&tfx, 160, |bytes| parse_tfx(bytes, "tfx", None));
    stay_within_budget(&obj, 64, |bytes| Mesh::parse_obj(bytes, "obj"));

    maps_stay_within_the_rule();

    // A file of counts only: four billion of everything.
    let mut lie = vec![0xff_u8; 4_096];
    lie[..4].copy_from_slice(b"HAIR");
    let (_, peak) = peak_of(|| parse_hair(&lie, "lie", None).is_err());
    assert!(peak < 65_536);
    lie[..4].copy_from_slice(&4.0_f32.to_le_bytes());
    lie[8..12].fill(0);
    let (_, peak) = peak_of(|| parse_tfx(&lie, "lie", None).is_err());
    assert!(peak < 65_536);
}
