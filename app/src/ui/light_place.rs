//! Where a light lies on the latitude-longitude panel, how large it is there, which one is under the pointer.

use std::f32::consts::{PI, TAU};

use balayage_render::light::SrbfLight;
use egui::{Color32, Pos2, Rect};
use glam::{Vec2, Vec3};

use crate::document::ListedLight;

/// Bandwidths that the hand can give, radians-like.
pub(super) const BANDWIDTHS: std::ops::RangeInclusive<f32> = 0.02..=2.0;

/// Bandwidth of a light that is added, radians-like: a softbox.
pub(super) const USUAL_BANDWIDTH: f32 = 0.3;

/// Place of a world direction on the panel, in [0, 1]^2: the layout of an environment map.
pub(super) fn place_of(direction: Vec3) -> Vec2 {
    let u = direction.x.atan2(-direction.z) / TAU;
    Vec2::new(u.rem_euclid(1.0), direction.y.clamp(-1.0, 1.0).acos() / PI)
}

/// World direction of a place on the panel.
pub(super) fn direction_at(place: Vec2) -> Vec3 {
    let (sin_phi, cos_phi) = (TAU * place.x).sin_cos();
    let (sin_theta, cos_theta) = (PI * place.y.clamp(0.0, 1.0)).sin_cos();
    Vec3::new(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta)
}

/// A light's colour at full brightness.
pub(super) fn hue(light: &SrbfLight) -> Color32 {
    let [r, g, b] = (light.radiance / light.radiance.max_element().max(f32::MIN_POSITIVE)).to_array();
    egui::Rgba::from_rgb(r, g, b).into()
}

/// Gives a light another bandwidth at the same energy.
pub(super) fn widen(light: &mut SrbfLight, bandwidth: f32) {
    let energy = light.energy();
    light.bandwidth = bandwidth.clamp(*BANDWIDTHS.start(), *BANDWIDTHS.end());
    light.radiance = (energy / light.solid_angle()).as_vec3();
}

/// Point of the panel that stands for a direction.
pub(super) fn on_panel(direction: Vec3, rect: Rect) -> Pos2 {
    let place = place_of(direction);
    rect.min + egui::vec2(place.x * rect.width(), place.y * rect.height())
}

/// Place in [0, 1]^2 of a point of the panel.
pub(super) fn in_panel(at: Pos2, rect: Rect) -> Vec2 {
    let place = (at - rect.min) / rect.size();
    Vec2::new(place.x, place.y)
}

/// Radius of a light's disc, points.
pub(super) fn disc_radius(light: &SrbfLight) -> f32 {
    (3.0 + 8.0 * light.bandwidth).min(12.0)
}

/// The light under the pointer: the chosen one before others, then the nearest.
pub(super) fn nearest(
    at: Pos2,
    lights: &[ListedLight],
    places: &[Pos2],
    selected: Option<usize>,
) -> Option<usize> {
    let reached = |index: &usize| at.distance(places[*index]) <= disc_radius(&lights[*index].light) + 2.0;
    selected.filter(reached).or_else(|| {
        let distance = |index: &usize| at.distance(places[*index]);
        (0..lights.len())
            .filter(reached)
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    })
}

/// Directions at one bandwidth from a light's middle; the first lies to its right.
pub(super) fn ring_of(towards: Vec3, light: &SrbfLight) -> Vec<Vec3> {
    let angle = light.bandwidth.min(0.98 * PI);
    let right = Vec3::Y.cross(towards).try_normalize().unwrap_or(Vec3::X);
    let up = towards.cross(right);
    let at = |k: usize| {
        let (sin, cos) = (TAU * k as f32 / 64.0).sin_cos();
        angle.cos() * towards + angle.sin() * (-cos * right + sin * up)
    };
    (0..=64).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_directions_lead_back() {
        for (u, v) in [(0.1, 0.3), (0.5, 0.5), (0.93, 0.8), (0.25, 0.02)] {
            let direction = direction_at(Vec2::new(u, v));
            assert!(place_of(direction).abs_diff_eq(Vec2::new(u, v), 1e-4));
        }
        // The middle of the panel is +z, its right quarter -x.
        assert!(direction_at(Vec2::new(0.5, 0.5)).abs_diff_eq(Vec3::Z, 1e-6));
        assert!(direction_at(Vec2::new(0.75, 0.5)).abs_diff_eq(-Vec3::X, 1e-6));
    }

    #[test]
    fn widening_keeps_the_energy_and_the_ring_has_the_width() {
        let mut light = SrbfLight {
            direction: Vec3::new(0.6, 0.8, 0.0),
            bandwidth: 0.1,
            radiance: Vec3::new(9.0, 5.0, 1.0),
        };
        let energy = light.energy();
        widen(&mut light, 0.7);
        assert!(light.energy().abs_diff_eq(energy, 1e-6) && light.bandwidth == 0.7);
        let ring = ring_of(light.direction, &light);
        let to_right = place_of(ring[0]).x - place_of(light.direction).x;
        assert!(to_right.rem_euclid(1.0) < 0.5, "{to_right}");
        assert!(
            ring.iter()
                .all(|w| (w.angle_between(light.direction) - 0.7).abs() < 1e-4)
        );
        widen(&mut light, 99.0);
        assert_eq!(light.bandwidth, *BANDWIDTHS.end());
    }
}
