//! What a scene does not need is not computed: counted after every kind of edit, and the picture hardly tells.

mod bounds;
mod counters;
mod interrupt;

use balayage_render::gpu::{
    Camera, FrameReport, Gpu, Multiple, PHOTON_RAYS, Quality, RenderSettings, Renderer, Saving, Savings,
    Terms,
};
use balayage_render::groom::Groom;
use balayage_render::image::Picture;
use balayage_render::light::{FitSettings, LightSet, PRESETS, Preset, SrbfLight, fit_lights};
use balayage_render::param::{LobeRatios, PigmentSet, PointValues, VertexParams};
use glam::{Quat, Vec3};
use std::ops::ControlFlow;

const SIZE: [u32; 2] = [96, 96];
const STRANDS: usize = 108;

/// Wavy strands in a block, `turns` waves along each.
fn wavy(turns: f32) -> Groom {
    wavy_and_thick(turns, 0.05)
}

/// The same with fibres of a diameter; a pixel of the usual picture is about 0.03.
fn wavy_and_thick(turns: f32, diameter: f32) -> Groom {
    let strands = (0..STRANDS).map(|i| {
        let root = Vec3::new(0.2 * (i % 12) as f32, 0.0, -0.15 * (i / 12) as f32);
        (0..12)
            .map(|k| {
                let s = k as f32 / 11.0;
                let phase = turns * std::f32::consts::TAU * s + 0.7 * i as f32;
                root + Vec3::new(0.1 * phase.sin(), -2.0 * s, 0.1 * phase.cos())
            })
            .collect::<Vec<_>>()
    });
    Groom::from_strands(strands.collect::<Vec<_>>(), diameter, 1.0)
        .unwrap()
        .0
}

/// The same strands, the first `by` moved to the end.
fn reordered(groom: &Groom, by: usize) -> Groom {
    let mut strands: Vec<_> = (0..groom.strand_count())
        .map(|i| groom.positions()[groom.strand(i)].to_vec())
        .collect();
    strands.rotate_left(by);
    Groom::from_strands(strands, 0.05, 1.0).unwrap().0
}

/// Multiple scattering from the sums along the ways from the lights, not from photons.
fn summed() -> RenderSettings {
    let mut settings = RenderSettings::default();
    settings.shade.multiple = Multiple::M3;
    settings
}

fn lights(count: usize) -> LightSet {
    let lights = (0..count).map(|k| {
        let turn = 2.4 * k as f32;
        SrbfLight {
            direction: Vec3::new(turn.cos(), 0.3 + 0.1 * (k % 5) as f32, turn.sin()).normalize(),
            bandwidth: 0.15 + 0.05 * (k % 8) as f32,
            radiance: Vec3::new(1.0, 0.9, 0.8) * (1.0 + (k % 3) as f32),
        }
    });
    LightSet {
        lights: lights.collect(),
        ..Default::default()
    }
}

/// A few lights of a sky or studio.
fn environment(name: &str) -> LightSet {
    match Preset::named(name).unwrap() {
        Preset::Lights(lights) => lights,
        Preset::Sky(sky) => {
            let settings = FitSettings {
                count: 8,
                ..Default::default()
            };
            fit_lights(&sky.map(32).0, &settings, &|_| ControlFlow::Continue(())).unwrap()
        }
    }
}

fn hair(groom: &Groom) -> Vec<VertexParams> {
    vec![
        PointValues::default().vertex_params(PigmentSet::default(), &LobeRatios::default());
        groom.point_count()
    ]
}

struct Scene {
    groom: Groom,
    params: Vec<VertexParams>,
    camera: Camera,
    renderer: Renderer,
}

impl Scene {
    fn new(gpu: &Gpu, groom: Groom, lights: &LightSet) -> Self {
        let mut scene = Self {
            params: Vec::new(),
            camera: Camera::framing(groom.bounds(), 1.0),
            groom: groom.clone(),
            renderer: Renderer::new(gpu).unwrap(),
        };
        scene.wear(groom);
        scene.renderer.set_lights(lights);
        scene
    }

    fn wear(&mut self, groom: Groom) {
        self.params = hair(&groom);
        self.renderer.set_groom(&groom, None).unwrap();
        self.renderer.set_params(&self.params, &[]).unwrap();
        self.groom = groom;
    }

    fn frame(&mut self, settings: &RenderSettings) -> FrameReport {
        self.renderer.render(&self.camera, SIZE, settings).unwrap()
    }

    fn picture(&mut self, settings: &RenderSettings) -> Picture {
        self.frame(settings);
        self.renderer.picture().unwrap()
    }
}

fn rmse(a: &Picture, b: &Picture) -> f64 {
    a.difference(b, 1).tile_rmse
}
