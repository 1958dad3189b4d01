//! After painting only those path sums are made again whose ways cross new paint, and nothing tells.

use std::ops::Range;

use balayage_render::gpu::{Gpu, MeanFibre, Multiple, Renderer, Transmittance};
use balayage_render::groom::{Groom, ball};
use balayage_render::light::SrbfLight;
use balayage_render::param::VertexParams;
use balayage_render::volume::{Strands, VolumeSettings};
use glam::Vec3;

use crate::frame::{curtain, frame_of, pixels, plain, renderer};

const LIGHTS: [SrbfLight; 2] = [
    SrbfLight {
        direction: Vec3::Y,
        bandwidth: 0.2,
        radiance: Vec3::ONE,
    },
    SrbfLight {
        direction: Vec3::X,
        bandwidth: 0.3,
        radiance: Vec3::ONE,
    },
];

/// A transmittance of the groom under all lights, up to date.
fn up_to_date(gpu: &Gpu, groom: &Groom, params: &wgpu::Buffer, mean: MeanFibre) -> (Transmittance, u64) {
    let mut transmittance = Transmittance::new(gpu).unwrap();
    transmittance
        .set_strands(gpu, &Strands::from(groom), None, &VolumeSettings::default())
        .unwrap();
    transmittance.set_lights(gpu, &LIGHTS).unwrap();
    transmittance.set_params(params, mean, &[]);
    let rays = transmittance.update(gpu, None, false, 0).unwrap().path_rays;
    (transmittance, rays)
}

/// Dyes the points within `radius` of the ball's side that no light comes from, and says which they are.
fn dab(groom: &Groom, params: &mut [VertexParams], centre: Vec3, radius: f32) -> Vec<Range<u32>> {
    let mut dirty = Vec::new();
    for (point, at) in (0..).zip(groom.positions()) {
        if at.distance(centre) < radius {
            params[point as usize].sigma_a = [2.0, 0.1 + 0.05 * radius, 0.05];
            dirty.push(point..point + 1);
        }
    }
    dirty
}

#[test]
fn a_dab_marches_the_ways_that_cross_it_and_ends_as_if_all_were_marched() {
    let gpu = Gpu::headless().unwrap();
    let groom = ball(3000, 0.01, 1).unwrap();
    let mut params = plain(&groom);
    let mean = MeanFibre::of(&params);
    let buffer = gpu.storage_of("parameters", &params).unwrap();
    let (mut transmittance, all_rays) = up_to_date(&gpu, &groom, &buffer, mean);
    let records = |t: &Transmittance| t.path_records(&gpu, groom.point_count()).unwrap();

    let centre = Vec3::new(0.5, 0.3, 0.5);
    let mut shares = Vec::new();
    for radius in [0.05, 0.2] {
        let before = records(&transmittance);
        let dirty = dab(&groom, &mut params, centre, radius);
        assert!(!dirty.is_empty());
        gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&params));
        transmittance.set_params(&buffer, mean, &dirty);
        let done = transmittance.update(&gpu, None, false, 0).unwrap();
        let after = records(&transmittance);
        let changed = before.iter().zip(&after).filter(|(a, b)| a != b).count();
        let per_record = all_rays as f64 / before.len() as f64;
        let marched = done.path_rays as f64 / per_record;
        shares.push(marched / before.len() as f64);
        eprintln!(
            "radius {radius}: {changed} records changed, {marched:.0} of {} marched",
            before.len()
        );
        assert!(changed > 0 && marched >= 0.7 * changed as f64);
        assert!(after == records(&up_to_date(&gpu, &groom, &buffer, mean).0));
    }
    assert!(shares[0] < 0.2 && shares[1] < 0.7, "{shares:?}");
    assert!(shares[1] > 1.5 * shares[0], "a larger dab costs more: {shares:?}");

    // Paint that is told of in the wrong place is not followed: the comparison can fail.
    dab(&groom, &mut params, -centre, 0.2);
    gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&params));
    transmittance.set_params(&buffer, mean, std::slice::from_ref(&(0..1)));
    transmittance.update(&gpu, None, false, 0).unwrap();
    assert!(records(&transmittance) != records(&up_to_date(&gpu, &groom, &buffer, mean).0));
}

#[test]
fn a_picture_after_dabs_is_the_picture_of_hair_loaded_so() {
    let gpu = Gpu::headless().unwrap();
    let groom = curtain();
    let mut params = plain(&groom);
    let loaded = |params: &[VertexParams], x: f32| {
        let mut renderer: Renderer = renderer(&gpu, &groom);
        renderer.set_params(params, &[]).unwrap();
        frame_of(&mut renderer, x, false, Multiple::M3);
        pixels(&renderer)
    };
    let mut painted = renderer(&gpu, &groom);
    painted.set_params(&params, &[]).unwrap();
    let first = frame_of(&mut painted, 0.4, false, Multiple::M3);
    frame_of(&mut painted, 1.2, false, Multiple::M3);

    // The tip of a strand at the edge: light from above and the side reaches few other points through it.
    let dirty = 8..9;
    params[8].sigma_a = [2.0, 0.1, 0.05];
    painted.set_params(&params, std::slice::from_ref(&dirty)).unwrap();
    frame_of(&mut painted, 1.2, true, Multiple::M3);
    let resting = frame_of(&mut painted, 1.2, false, Multiple::M3);
    for counter in ["path rays", "multiple scattering evaluations"] {
        let (again, whole) = (resting.counter(counter), first.counter(counter));
        assert!(again > 0 && again < whole / 4, "{counter}: {again} of {whole}");
    }
    assert_eq!(pixels(&painted), loaded(&params, 1.2));

    // A view whose points were no longer seen while they were painted over.
    let dirty = 9..18;
    params[9..18]
        .iter_mut()
        .for_each(|p| p.sigma_a = [0.1, 2.0, 0.05]);
    painted.set_params(&params, std::slice::from_ref(&dirty)).unwrap();
    let before = pixels(&painted);
    frame_of(&mut painted, 1.2, false, Multiple::M3);
    assert_ne!(pixels(&painted), before, "the comparison can fail");
    frame_of(&mut painted, 0.4, false, Multiple::M3);
    assert_eq!(pixels(&painted), loaded(&params, 0.4));
}
