//! What one SRBF and a set of them are worth: integral, value in a direction, rotation, exposure.

use std::f64::consts::PI;

use glam::{DVec3, Quat, Vec3};

use super::{LightSet, SrbfLight};

/// The widest bandwidth that a light may have, radians-like; beyond it a light is uniform to 1 % and `constant` should be used.
pub const MAX_BANDWIDTH: f32 = 10.0;

/// Luminance of a linear Rec.709 colour.
pub fn luminance(rgb: Vec3) -> f32 {
    rgb.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Integral over the sphere of an SRBF of peak 1: Omega = pi lambda^2 (1 - exp(-4 / lambda^2)), steradians.
pub(super) fn solid_angle(bandwidth: f64) -> f64 {
    let lambda_2 = bandwidth * bandwidth;
    -PI * lambda_2 * (-4.0 / lambda_2).exp_m1()
}

impl SrbfLight {
    /// Integral of the SRBF of peak 1 over the sphere, steradians: pi lambda^2 (1 - exp(-4 / lambda^2)).
    pub fn solid_angle(&self) -> f64 {
        solid_angle(f64::from(self.bandwidth))
    }

    /// Irradiance-like energy of the light: radiance times solid angle, linear Rec.709.
    pub fn energy(&self) -> DVec3 {
        self.radiance.as_dvec3() * self.solid_angle()
    }

    /// Radiance in the unit direction `w`.
    pub fn radiance_towards(&self, w: Vec3) -> Vec3 {
        // 1 - w . d as half the squared distance keeps its digits for narrow lights.
        let lambda_2 = self.bandwidth * self.bandwidth;
        self.radiance * (-(w - self.direction).length_squared() / lambda_2).exp()
    }
}

impl LightSet {
    /// A uniform environment of the given radiance and nothing else.
    pub fn uniform(radiance: Vec3) -> Self {
        Self {
            lights: Vec::new(),
            constant: radiance,
        }
    }

    /// Radiance of all lights together in the unit direction `w`, linear Rec.709.
    pub fn radiance(&self, w: Vec3) -> Vec3 {
        self.lights
            .iter()
            .map(|light| light.radiance_towards(w))
            .sum::<Vec3>()
            + self.constant
    }

    /// Energy of all lights together: the integral of [`LightSet::radiance`] over the sphere.
    pub fn energy(&self) -> DVec3 {
        self.lights.iter().map(SrbfLight::energy).sum::<DVec3>() + self.constant.as_dvec3() * (4.0 * PI)
    }

    /// The same lights turned by `angle_rad` about the y axis, counter-clockwise seen from above; a map under
    /// these lights is the old one shifted by -angle / 2 pi of its width.
    #[must_use]
    pub fn rotated(&self, angle_rad: f32) -> Self {
        let turn = Quat::from_rotation_y(angle_rad);
        let lights = self
            .lights
            .iter()
            .map(|light| SrbfLight {
                direction: (turn * light.direction).normalize(),
                ..*light
            })
            .collect();
        Self {
            lights,
            constant: self.constant,
        }
    }

    /// The same lights with every radiance multiplied by `factor` (per channel; finite and not negative).
    #[must_use]
    pub fn scaled(&self, factor: Vec3) -> Self {
        let lights = self
            .lights
            .iter()
            .map(|light| SrbfLight {
                radiance: light.radiance * factor,
                ..*light
            })
            .collect();
        Self {
            lights,
            constant: self.constant * factor,
        }
    }

    /// The same lights, brighter by `ev` photographic stops.
    #[must_use]
    pub fn exposed(&self, ev: f32) -> Self {
        self.scaled(Vec3::splat(ev.exp2()))
    }
}
