//! The lights of a frame: what the user has, and what stands for a uniform environment where visibility is needed.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

use crate::light::{LightSet, SrbfLight};

/// Lights that a uniform environment is split into.
const CONSTANT_LIGHTS: usize = 32;

/// Their bandwidth: wide enough to overlap, no wider than visibility can follow.
const CONSTANT_BANDWIDTH: f32 = 0.45;

/// Layout of `Light` in `shaders/lib/light.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LightUniform {
    /// Unit vector towards the light.
    pub direction: [f32; 3],
    /// Bandwidth lambda.
    pub bandwidth: f32,
    /// Radiance at the centre, linear Rec.709.
    pub radiance: [f32; 3],
    /// Greatest share, of the three channels, of all lights' power.
    pub share: f32,
}

/// The lights as shaders read them.
pub fn light_uniforms(lights: &[SrbfLight]) -> Vec<LightUniform> {
    let power = |light: &SrbfLight| light.energy();
    let whole = lights
        .iter()
        .map(power)
        .sum::<DVec3>()
        .max(DVec3::splat(f64::MIN_POSITIVE));
    let uniform = |light: &SrbfLight| LightUniform {
        direction: light.direction.to_array(),
        bandwidth: light.bandwidth,
        radiance: light.radiance.to_array(),
        share: (power(light) / whole).max_element() as f32,
    };
    lights.iter().map(uniform).collect()
}

/// The lights of `set`, and after them lights of the same total power as its uniform environment, evenly spread.
pub fn frame_lights(set: &LightSet) -> Vec<SrbfLight> {
    let mut lights = set.lights.clone();
    if set.constant != Vec3::ZERO {
        let omega = crate::volume::lobe::solid_angle(CONSTANT_BANDWIDTH) as f32;
        let radiance = set.constant * (4.0 * std::f32::consts::PI / (CONSTANT_LIGHTS as f32 * omega));
        lights.extend((0..CONSTANT_LIGHTS).map(|k| SrbfLight {
            direction: fibonacci_direction(k, CONSTANT_LIGHTS),
            bandwidth: CONSTANT_BANDWIDTH,
            radiance,
        }));
    }
    lights
}

/// Point `k` of `count` of the spherical Fibonacci lattice.
pub(super) fn fibonacci_direction(k: usize, count: usize) -> Vec3 {
    let golden = 0.5 * (5f32.sqrt() - 1.0);
    let y = 1.0 - (2.0 * k as f32 + 1.0) / count as f32;
    let (sin, cos) = (std::f32::consts::TAU * golden * k as f32).sin_cos();
    let r = (1.0 - y * y).sqrt();
    Vec3::new(r * sin, y, r * cos)
}
