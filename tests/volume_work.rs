//! The density volume's work and its other ways to visibility: what is built, painted, traced and given up, by its own counters.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use balayage_render::gpu::{
    Gpu, GpuError, MeanFibre, RenderSettings, Renderer, Terms, Transmittance, VisibilitySource, VolumeReport,
};
use balayage_render::groom::{Groom, ball};
use balayage_render::light::{LightSet, SrbfLight};
use balayage_render::optics::{Fibre, scattering_averages};
use balayage_render::param::{LobeRatios, PigmentSet, PointValues, VertexParams};
use balayage_render::volume::{DensityVolume, SegmentGrid, Strands, VolumeSettings, lobe};
use balayage_tests::random;
use glam::Vec3;
use rand::Rng;

/// Voxels of one size, so that grooms differ in their strands alone.
const VOXELS: VolumeSettings = VolumeSettings {
    voxel_spacings: 1.0,
    voxel_size: Some(0.06),
    max_stored_voxels: 4 << 20,
    max_shares: 12 << 20,
};

fn plain(count: usize) -> Vec<VertexParams> {
    vec![PointValues::default().vertex_params(PigmentSet::default(), &LobeRatios::default()); count]
}

fn light(direction: Vec3, bandwidth: f32) -> SrbfLight {
    SrbfLight {
        direction,
        bandwidth,
        radiance: Vec3::ONE,
    }
}

/// A transmittance that holds the groom in voxels of one size.
fn of_groom(gpu: &Gpu, groom: &Groom) -> (Transmittance, VolumeReport) {
    let mut transmittance = Transmittance::new(gpu).unwrap();
    let report = transmittance
        .set_strands(gpu, &Strands::from(groom), None, &VOXELS)
        .unwrap();
    (transmittance, report)
}

#[test]
fn building_is_linear_in_strands() {
    let gpu = Gpu::headless().unwrap();
    let built = [500, 1000, 4000].map(|strands| of_groom(&gpu, &ball(strands, 0.01, 1).unwrap()).1);
    for (strands, report) in [500, 1000, 4000].into_iter().zip(&built) {
        assert_eq!(report.segments, strands * 11);
        // A segment is cut into as many parts, whatever lies around it.
        let per_segment = report.shares as f64 / report.segments as f64;
        let expected = built[2].shares as f64 / built[2].segments as f64;
        assert!(
            (per_segment / expected - 1.0).abs() < 0.02 && per_segment > 1.2,
            "{strands} strands: {per_segment} parts a segment instead of {expected}"
        );
        assert!(report.filled_voxels <= report.shares && report.filled_voxels > 0);
    }
    // Where parts are bounded voxels grow until they fit.
    let bounded = VolumeSettings {
        max_shares: 8000,
        ..VOXELS
    };
    let few = DensityVolume::build(&Strands::from(&ball(500, 0.01, 1).unwrap()), None, &bounded);
    assert!(
        few.shares.len() <= 8000,
        "5500 segments are cut into {} parts",
        few.shares.len()
    );
    // Finer voxels cut more: the counter does not stand still.
    let fine = VolumeSettings {
        voxel_size: Some(0.03),
        ..VOXELS
    };
    let groom = ball(500, 0.01, 1).unwrap();
    let finer = Transmittance::new(&gpu)
        .unwrap()
        .set_strands(&gpu, &Strands::from(&groom), None, &fine)
        .unwrap();
    assert!(finer.shares as f64 > 1.3 * built[0].shares as f64);
}

#[test]
fn painting_touches_the_voxels_of_painted_strands_and_ends_as_if_all_were_painted() {
    let gpu = Gpu::headless().unwrap();
    let groom = ball(3000, 0.01, 1).unwrap();
    let volume = DensityVolume::build(&Strands::from(&groom), None, &VOXELS);
    let (mut transmittance, report) = of_groom(&gpu, &groom);
    transmittance.set_lights(&gpu, &[light(Vec3::Y, 0.3)]).unwrap();
    let mut params = plain(groom.point_count());
    let mean = MeanFibre::of(&params);
    let buffer = gpu.storage_of("parameters", &params).unwrap();
    transmittance.set_params(&buffer, mean, &[]);
    let first = transmittance.update(&gpu, None, false, 0).unwrap();
    assert_eq!(first.painted_voxels, u64::from(report.stored_voxels));

    let mut painted = Vec::new();
    for strands in [10, 100] {
        let dirty = 0..groom.first_point()[strands];
        for point in &mut params[..dirty.end as usize] {
            point.sigma_a = [0.1, 2.0, 3.0];
        }
        gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&params));
        transmittance.set_params(&buffer, mean, std::slice::from_ref(&dirty));
        let done = transmittance.update(&gpu, None, false, 0).unwrap();
        let touched: BTreeSet<usize> = volume
            .first_share
            .windows(2)
            .enumerate()
            .filter(|(_, ends)| {
                let shares = &volume.shares[ends[0] as usize..ends[1] as usize];
                shares.iter().any(|share| share.point < dirty.end)
            })
            .map(|(voxel, _)| voxel)
            .collect();
        assert_eq!(done.painted_voxels, touched.len() as u64, "{strands} strands");
        assert_eq!(done.visibility_rays, 0);
        painted.push(done.painted_voxels as f64);
    }
    let ratio = painted[1] / painted[0];
    assert!(
        (8.0..10.5).contains(&ratio),
        "ten times the strands: {ratio} times the voxels"
    );

    let records = transmittance.path_records(&gpu, groom.point_count()).unwrap();
    let (mut fresh, _) = of_groom(&gpu, &groom);
    fresh.set_lights(&gpu, &[light(Vec3::Y, 0.3)]).unwrap();
    fresh.set_params(&buffer, mean, &[]);
    fresh.update(&gpu, None, false, 0).unwrap();
    assert!(records == fresh.path_records(&gpu, groom.point_count()).unwrap());

    // A change that nobody is told of stays unseen: the comparison can fail.
    params.iter_mut().for_each(|p| p.sigma_a = [3.0; 3]);
    gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&params));
    transmittance.set_params(&buffer, mean, std::slice::from_ref(&(0..1)));
    transmittance.update(&gpu, None, false, 0).unwrap();
    fresh.set_params(&buffer, mean, &[]);
    fresh.update(&gpu, None, false, 0).unwrap();
    let kept = transmittance.path_records(&gpu, groom.point_count()).unwrap();
    assert!(kept != fresh.path_records(&gpu, groom.point_count()).unwrap());
}

/// Root mean square error and bias of the records' means against exact rays at every `step`-th point.
fn error(records: &[[f32; 4]], groom: &Groom, lights: &[SrbfLight], step: usize) -> (f64, f64) {
    let grid = SegmentGrid::new(&Strands::from(groom));
    let mut random = random(3);
    let mut errors = Vec::new();
    for point in (0..groom.point_count()).step_by(step) {
        for (j, light) in lights.iter().enumerate() {
            let at = groom.positions()[point];
            let free = grid.free_share(at, (point / 12) as u32, light, 128, &mut random);
            let seen = records[j * groom.point_count() + point][0];
            assert!((0.0..=1.0).contains(&seen) || records.len() > 1 && seen.is_finite());
            errors.push(f64::from(seen - free));
        }
    }
    let mean = |f: fn(f64) -> f64| errors.iter().map(|&e| f(e)).sum::<f64>() / errors.len() as f64;
    (mean(|e| e * e).sqrt(), mean(|e| e))
}

#[test]
fn harmonics_see_what_marches_see() {
    let gpu = Gpu::headless().unwrap();
    let groom = ball(1500, 0.02, 1).unwrap();
    let lights = [
        light(Vec3::Y, 0.3),
        light(Vec3::X, 0.6),
        light(Vec3::new(-0.6, 0.0, -0.8), 0.9),
    ];
    let (mut transmittance, _) = of_groom(&gpu, &groom);
    transmittance.set_lights(&gpu, &lights).unwrap();
    transmittance.update(&gpu, None, false, 0).unwrap();
    let marched = transmittance
        .visibility_records(&gpu, groom.point_count())
        .unwrap();
    transmittance
        .set_visibility_source(&gpu, VisibilitySource::Sh9)
        .unwrap();
    let done = transmittance.update(&gpu, None, false, 64).unwrap();
    assert_eq!(done.exact_rays, 0, "exact rays do not refine harmonics");
    let mut found = transmittance
        .visibility_records(&gpu, groom.point_count())
        .unwrap();

    let [of_marches, of_harmonics] = [&marched, &found].map(|records| error(records, &groom, &lights, 149));
    eprintln!("RMSE, bias: marches {of_marches:.4?}, harmonics {of_harmonics:.4?}");
    assert!(
        of_harmonics.0 < 0.16 && of_harmonics.1.abs() < 0.06,
        "{of_harmonics:?}"
    );
    // b points where more is seen, as that of the marches does.
    let agree = marched
        .iter()
        .zip(&found)
        .filter(|(a, b)| a[1] * b[1] + a[2] * b[2] + a[3] * b[3] > 0.0)
        .count();
    assert!(
        agree as f64 > 0.75 * found.len() as f64,
        "{agree} of {}",
        found.len()
    );
    // Lights exchanged are noticed.
    found.rotate_left(groom.point_count());
    assert!(error(&found, &groom, &lights, 149).0 > 0.2);
    // Back to marches, as if nothing had been.
    transmittance
        .set_visibility_source(&gpu, VisibilitySource::Voxel)
        .unwrap();
    transmittance.update(&gpu, None, false, 0).unwrap();
    assert!(
        transmittance
            .visibility_records(&gpu, groom.point_count())
            .unwrap()
            == marched
    );
}

#[test]
fn a_refinement_that_is_given_up_is_made_later() {
    let gpu = Gpu::headless().unwrap();
    let groom = ball(300, 0.02, 1).unwrap();
    let lights = [light(Vec3::Y, 0.3), light(Vec3::X, 0.6)];
    let (mut transmittance, _) = of_groom(&gpu, &groom);
    transmittance.set_lights(&gpu, &lights).unwrap();
    let stop = Arc::new(AtomicBool::new(true));
    transmittance.set_interrupt(Some(stop.clone()));
    let given_up = transmittance.update(&gpu, None, false, 32);
    assert!(matches!(given_up, Err(GpuError::Interrupted)), "{given_up:?}");
    let first = transmittance
        .visibility_records(&gpu, groom.point_count())
        .unwrap();
    let coarse = error(&first, &groom, &lights, 37).0;

    stop.store(false, Ordering::Relaxed);
    let done = transmittance.update(&gpu, None, false, 32).unwrap();
    assert_eq!(done.visibility_rays, 0, "what was marched is kept");
    assert_eq!(done.exact_rays, 2 * 32 * groom.point_count() as u64);
    let refined = transmittance
        .visibility_records(&gpu, groom.point_count())
        .unwrap();
    let fine = error(&refined, &groom, &lights, 37).0;
    assert!(fine < 0.8 * coarse, "RMSE {coarse} before, {fine} after");
    let again = transmittance.update(&gpu, None, false, 32).unwrap();
    assert_eq!(again.exact_rays, 0);
}

/// `count` fibres along x in a slab around `z` of the square of side 4, without order.
fn mat(count: usize, z: f32, thickness: f32, seed: u64) -> Vec<Vec<Vec3>> {
    let mut random = random(seed);
    let mut between = |low: f32, high: f32| random.random_range(low..high);
    (0..count)
        .map(|_| {
            let (y, z, slope) = (
                between(-2.0, 2.0),
                z + thickness * between(-0.5, 0.5),
                between(-0.3, 0.3),
            );
            (0..17)
                .map(|k| -2.0 + 0.25 * k as f32)
                .map(|x| Vec3::new(x, y + slope * x, z))
                .collect()
        })
        .collect()
}

#[test]
fn a_red_sheet_tints_the_sheet_behind_as_the_fibres_along_exact_rays_do() {
    let gpu = Gpu::headless().unwrap();
    const BACK: usize = 60;
    let groom = Groom::from_strands(
        [mat(BACK, 0.0, 0.05, 1), mat(400, 0.6, 0.5, 2)].concat(),
        0.02,
        1.0,
    )
    .unwrap()
    .0;
    let lights = [light(Vec3::new(0.1, 0.2, 1.0).normalize(), 0.15)];
    let mut transmittance = Transmittance::new(&gpu).unwrap();
    transmittance
        .set_strands(&gpu, &Strands::from(&groom), None, &VolumeSettings::default())
        .unwrap();
    transmittance.set_lights(&gpu, &lights).unwrap();
    let mut params = plain(groom.point_count());
    params.iter_mut().for_each(|p| p.sigma_a = [0.1; 3]);
    let mean = MeanFibre::of(&params);
    let front = BACK * 17;
    let mut arriving = |params: &[VertexParams]| {
        let buffer = gpu.storage_of("parameters", params).unwrap();
        transmittance.set_params(&buffer, mean, &[]);
        transmittance.update(&gpu, None, false, 0).unwrap();
        transmittance.path_records(&gpu, groom.point_count()).unwrap()
    };
    let plain = arriving(&params);
    params[front..]
        .iter_mut()
        .for_each(|p| p.sigma_a = [0.1, 1.0, 2.5]);
    let red = arriving(&params);

    // Points of the back sheet whose rays stay under the front one, and what their exact rays bring.
    let points: Vec<usize> = (0..front)
        .filter(|&point| groom.positions()[point].truncate().abs().max_element() < 1.2)
        .collect();
    assert!(points.len() > 200);
    let forward: Vec<f64> = [0.1, 1.0, 2.5].map(|sigma_a| a_f(&params[0], sigma_a)).to_vec();
    let grid = SegmentGrid::new(&Strands::from(&groom));
    let mut random = random(9);
    let (mut exact, mut exact_plain) = ([0.0; 3], 0.0);
    let (mut scattered, mut scattered_plain) = ([0.0; 3], 0.0);
    const RAYS: usize = 16;
    for &point in &points {
        for k in 0..RAYS {
            let w = in_lobe(
                &lights[0],
                (k as f64 + random.random::<f64>()) / RAYS as f64,
                random.random(),
            );
            let hits = grid.hits(groom.positions()[point], w, Some((point / 17) as u32));
            let crossed = hits.iter().filter(|hit| hit.point as usize >= front).count();
            let behind = hits.len() - crossed;
            for channel in 0..3 {
                let passed = forward[0].powi(behind as i32) * forward[channel].powi(crossed as i32);
                exact[channel] += passed / (points.len() * RAYS) as f64;
                if !hits.is_empty() {
                    scattered[channel] += passed;
                }
            }
            let passed = forward[0].powi(hits.len() as i32);
            exact_plain += passed / (points.len() * RAYS) as f64;
            if !hits.is_empty() {
                scattered_plain += passed;
            }
        }
    }
    let mean_of = |records: &[[f32; 8]], channel: usize| {
        points
            .iter()
            .map(|&p| f64::from(records[p][channel]))
            .sum::<f64>()
            / points.len() as f64
    };
    let found = [0, 1, 2].map(|channel| mean_of(&red, channel));
    eprintln!(
        "arriving: {found:.4?}, exact {exact:.4?}, before {:.4} exact {exact_plain:.4}",
        mean_of(&plain, 1)
    );
    for channel in 0..3 {
        let error = found[channel] / exact[channel] - 1.0;
        assert!(
            error.abs() < 0.05,
            "channel {channel}: {found:?} instead of {exact:?}"
        );
    }
    assert!((mean_of(&plain, 1) / exact_plain - 1.0).abs() < 0.05);
    // Painted hair is told from unpainted by far more than that.
    assert!(exact[1] < 0.85 * exact_plain && exact[2] < exact[1]);

    // The picture's photons, which bend at every fibre where exact rays go on straight.
    let mut renderer = Renderer::new(&gpu).unwrap();
    renderer.set_groom(&groom, None).unwrap();
    renderer.set_lights(&LightSet {
        lights: lights.to_vec(),
        constant: Vec3::ZERO,
    });
    let mut settings = RenderSettings {
        visibility_rays: 16,
        ..RenderSettings::default()
    };
    settings.shade.terms = Terms::D;
    let points: Vec<u32> = points.iter().map(|point| *point as u32).collect();
    let mut through = |params: &[VertexParams]| -> Vec3 {
        renderer.set_params(params, &[]).unwrap();
        let behind = -100.0 * Vec3::Z;
        let radiance = renderer.radiance_of_points(&points, behind, &settings).unwrap();
        radiance.iter().sum()
    };
    let seen_red = through(&params);
    params.iter_mut().for_each(|p| p.sigma_a = [0.1; 3]);
    let tint = (seen_red / through(&params)).as_dvec3().to_array();
    let exact_tint = scattered.map(|passed| passed / scattered_plain);
    eprintln!("tint of what the front sheet passes on: {tint:.3?}, exact {exact_tint:.3?}");
    for (tint, exact) in tint.into_iter().zip(exact_tint) {
        assert!((tint - exact).abs() < 0.05, "{tint} instead of {exact}");
    }
}

/// a_f of the usual fibre with that absorption, at right angles: the sheets' fibres lie within 25 degrees of them.
fn a_f(params: &VertexParams, sigma_a: f64) -> f64 {
    let [alpha, beta] = [params.alpha_rad, params.beta_rad].map(f64::from);
    let [alpha_ratios, beta_ratios] = [params.alpha_ratios, params.beta_ratios].map(|r| r.map(f64::from));
    let fibre = Fibre {
        eta: params.eta.into(),
        eccentricity: 1.0,
        sigma_a: [sigma_a; 3],
        alpha: [alpha, alpha * alpha_ratios[0], alpha * alpha_ratios[1]],
        beta: [beta, beta * beta_ratios[0], beta * beta_ratios[1]],
        azimuthal_width: params.azimuthal_width.into(),
    };
    let averages = [-0.1, 0.1].map(|theta| scattering_averages(&fibre, theta, 1e-3).unwrap().a_f[0]);
    0.5 * (averages[0] + averages[1])
}

/// A direction of a light's lobe for two numbers of [0, 1).
fn in_lobe(light: &SrbfLight, u: f64, turn: f32) -> Vec3 {
    let cos = lobe::cosine_quantile(light.bandwidth, u) as f32;
    let (tangent, bitangent) = lobe::frame(light.direction);
    let (sin_phi, cos_phi) = (turn * std::f32::consts::TAU).sin_cos();
    light.direction * cos + (tangent * cos_phi + bitangent * sin_phi) * (1.0 - cos * cos).max(0.0).sqrt()
}
