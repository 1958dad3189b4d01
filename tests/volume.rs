//! Density volume and visibility: laws on synthetic hair, and truth by exact rays on real grooms.

use std::path::PathBuf;

use balayage_render::gpu::{Gpu, Transmittance};
use balayage_render::groom::{Groom, read_groom};
use balayage_render::light::SrbfLight;
use balayage_render::volume::{DensityVolume, SegmentGrid, Strands, VolumeSettings, lobe};
use glam::Vec3;
use half::f16;
use rand::{Rng, SeedableRng};
use rayon::prelude::*;

/// Path of a file below $BALAYAGE_TEST_DATA, if that is set.
fn data(name: &str) -> Option<PathBuf> {
    std::env::var_os("BALAYAGE_TEST_DATA").map(|folder| PathBuf::from(folder).join(name))
}

/// Eight lights from all sides, narrow to wide.
fn lights() -> Vec<SrbfLight> {
    [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.1]
        .iter()
        .enumerate()
        .map(|(i, &bandwidth)| {
            let y = 1.0 - (2 * i + 1) as f32 / 8.0;
            let phi = 2.4 * i as f32;
            let r = (1.0 - y * y).sqrt();
            SrbfLight { direction: Vec3::new(r * phi.cos(), y, r * phi.sin()), bandwidth, radiance: Vec3::ONE }
        })
        .collect()
}

/// Visibility records (a, b) of all lights and points, light-major.
fn visibility(gpu: &Gpu, transmittance: &Transmittance, point_count: usize) -> Vec<[f32; 4]> {
    let mut records = Vec::new();
    for batch in transmittance.batches() {
        let halves: Vec<[f16; 4]> = gpu.read(&batch.visibility, batch.lights.len() * point_count).unwrap();
        records.extend(halves.into_iter().map(|r| r.map(f32::from)));
    }
    records
}

/// Share of `rays` directions of the light's lobe that cross no other fibre.
fn free_share(grid: &SegmentGrid, origin: Vec3, strand: u32, light: &SrbfLight, rays: usize, rng: &mut impl Rng) -> f32 {
    let axis = light.direction.normalize();
    let (tangent, bitangent) = lobe::frame(axis);
    let free = (0..rays)
        .filter(|i| {
            let cos = lobe::cosine_quantile(light.bandwidth, (*i as f64 + rng.random::<f64>()) / rays as f64) as f32;
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            let phi = rng.random::<f32>() * std::f32::consts::TAU;
            let w = axis * cos + tangent * (sin * phi.cos()) + bitangent * (sin * phi.sin());
            grid.is_free(origin, w, Some(strand))
        })
        .count();
    free as f32 / rays as f32
}

#[test]
fn measure_show3() {
    let gpu = Gpu::headless().unwrap();
    for name in ["fetched/hair/sintel_hair_16points_k4.tfx", "fetched/hair/tressfx3_ponytail_all.hair", "../reference/pathtraced/groom.hair"] {
        let Some(path) = data(name) else { continue };
        let groom = read_groom(&path, None).unwrap().groom;
        let strands = Strands::from(&groom);
        let t = std::time::Instant::now();
        let exact = SegmentGrid::new(&strands);
        println!("{name}: exact grid {:?}", t.elapsed());
        let mut strand_of = vec![0_u32; groom.point_count()];
        for s in 0..groom.strand_count() {
            strand_of[groom.strand(s)].fill(s as u32);
        }
        let lights = lights();
        let mut rng = rand_pcg::Pcg64::seed_from_u64(5);
        let picks: Vec<usize> = (0..500).map(|_| rng.random_range(0..groom.point_count())).collect();
        let t = std::time::Instant::now();
        let truth: Vec<Vec<f32>> = picks
            .par_iter()
            .map(|&p| {
                let mut rng = rand_pcg::Pcg64::seed_from_u64(p as u64);
                lights.iter().map(|l| free_share(&exact, groom.positions()[p], strand_of[p], l, 256, &mut rng)).collect()
            })
            .collect();
        println!("  truth {:?}", t.elapsed());
        for voxel_spacings in [0.5, 0.7, 1.0, 1.5, 2.0] {
            let mut transmittance = Transmittance::new(&gpu).unwrap();
            let t = std::time::Instant::now();
            let report = transmittance
                .set_strands(&gpu, &strands, None, &VolumeSettings { voxel_spacings, ..Default::default() })
                .unwrap();
            let build = t.elapsed();
            transmittance.set_lights(&gpu, &lights).unwrap();
            let t = std::time::Instant::now();
            let update = transmittance.update(&gpu).unwrap();
            let records = visibility(&gpu, &transmittance, groom.point_count());
            let march = t.elapsed();
            let mut line = String::new();
            let (mut sum, mut sum2, mut all) = (0.0, 0.0, 0);
            for j in 0..lights.len() {
                let (mut s, mut s2) = (0.0, 0.0);
                for (i, &p) in picks.iter().enumerate() {
                    let e = f64::from(records[j * groom.point_count() + p][0].clamp(0.0, 1.0) - truth[i][j]);
                    s += e;
                    s2 += e * e;
                }
                sum += s;
                sum2 += s2;
                all += picks.len();
                line += &format!(" {:.3}/{:+.3}", (s2 / picks.len() as f64).sqrt(), s / picks.len() as f64);
            }
            println!(
                "  {voxel_spacings}: voxel {:.5} grid {:?} stored {} shares {} {} MB; build {build:?}; rays {} in {march:?}; RMSE {:.4} bias {:+.4};{line}",
                report.voxel_size, report.voxels, report.stored_voxels, report.shares, report.bytes >> 20, update.visibility_rays,
                (sum2 / f64::from(all as u32)).sqrt(), sum / f64::from(all as u32)
            );
        }
    }
}
