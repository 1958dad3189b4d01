//! Directions spread over an SRBF light, and how transmittance along them becomes a linear function of direction.
//!
//! G(w; w_j, lambda) = exp(2 (w . w_j - 1) / lambda^2) is, up to its integral, a von Mises-Fisher density of concentration
//! kappa = 2 / lambda^2. Its mean direction is A w_j with A = coth kappa - 1 / kappa.

use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DVec3, Vec3};

use crate::light::SrbfLight;

/// How many observations of "no slope" the linear fit starts from.
const PSEUDO_OBSERVATIONS: f64 = 3.0;

/// Directions above which the fit needs no such observations.
const ENOUGH_DIRECTIONS: usize = 8;

/// Widest light, in bandwidth, that one direction stands for.
pub const ONE_DIRECTION_BANDWIDTH: f32 = 0.12;

/// A light's frame and its two sets of directions, same layout as `LobeLight` in `shaders/lib/volume.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LobeLight {
    /// Unit vector towards the light.
    pub axis: Vec3,
    /// First of the directions that visibility is fitted to.
    pub first_visibility: u32,
    /// Unit vector normal to `axis`.
    pub tangent: Vec3,
    /// Number of those.
    pub visibility_count: u32,
    /// `axis` x `tangent`.
    pub bitangent: Vec3,
    /// First of the directions along which multiple scattering is summed and shaded.
    pub first_path: u32,
    /// Number of those.
    pub path_count: u32,
    /// Length A of the lobe's mean direction.
    pub mean_cosine: f32,
    /// Bandwidth lambda.
    pub bandwidth: f32,
    /// Integral of G over the sphere.
    pub solid_angle: f32,
}

impl LobeLight {
    /// Whether rays towards this light are those towards `other`: the directions of both may stand in different places of their tables.
    pub fn is_marched_as(&self, other: &Self) -> bool {
        let placed = Self {
            first_visibility: other.first_visibility,
            first_path: other.first_path,
            ..*self
        };
        placed == *other
    }
}

/// One direction of a light, same layout as `LobeDirection` in `shaders/lib/volume.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LobeDirection {
    /// Unit vector in the light's frame (tangent, bitangent, axis).
    pub local: Vec3,
    /// Weight of this direction's transmittance in a of T(w) = a + b . (w - A w_j).
    pub weight_a: f32,
    /// Weight of this direction's transmittance in b, light's frame.
    pub weight_b: Vec3,
    /// Solid angle that the direction stands for: all of a set sum to [`solid_angle`].
    pub solid_angle: f32,
}

/// Integral of G over the sphere: pi lambda^2 (1 - exp(-4 / lambda^2)).
pub fn solid_angle(bandwidth: f32) -> f64 {
    let lambda2 = f64::from(bandwidth).powi(2);
    -std::f64::consts::PI * lambda2 * (-4.0 / lambda2).exp_m1()
}

/// Length A of the lobe's mean direction, coth kappa - 1 / kappa with kappa = 2 / lambda^2.
pub fn mean_cosine(bandwidth: f32) -> f64 {
    let kappa = 2.0 / f64::from(bandwidth).powi(2);
    // Below 0.01 the two terms cancel; the series' next term is 2 kappa^5 / 945.
    if kappa < 1e-2 {
        kappa / 3.0 - kappa.powi(3) / 45.0
    } else {
        kappa.tanh().recip() - kappa.recip()
    }
}

/// Lights with less than this share of the whole power get one direction, however wide: what is seen of such a light is then some 20 % off
/// at a point, the whole by less than 0.2 % for each of them (all together measured: tile means of a picture differ by 0.4 to 0.8 % RMS).
pub const ONE_DIRECTION_SHARE: f64 = 0.01;

/// Radiance (mean of the channels) times solid angle.
fn power(light: &SrbfLight) -> f64 {
    f64::from(light.radiance.element_sum() / 3.0) * solid_angle(light.bandwidth)
}

/// Number of directions that visibility is fitted to: one up to a bandwidth of 0.12, eight from 0.45 on.
pub fn visibility_count(bandwidth: f32) -> usize {
    match bandwidth {
        ..=ONE_DIRECTION_BANDWIDTH => 1,
        ..=0.3 => 4,
        ..=0.45 => 6,
        _ => 8,
    }
}

/// Number of directions for multiple scattering, which is smoother: one up to a bandwidth of 0.35, six above 0.7.
pub fn path_count(bandwidth: f32) -> usize {
    match bandwidth {
        ..=0.35 => 1,
        ..=0.7 => 3,
        _ => 6,
    }
}

/// `count` unit vectors in the light's frame, one in the middle of each of `count` parts of equal integral of G, turned by
/// the golden angle from one to the next. One direction alone is the centre.
pub fn directions(bandwidth: f32, count: usize) -> Vec<DVec3> {
    if count == 1 {
        return vec![DVec3::Z];
    }
    let golden_angle = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..count)
        .map(|i| {
            let cos = cosine_quantile(bandwidth, (i as f64 + 0.5) / count as f64);
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            let (sin_phi, cos_phi) = (golden_angle * i as f64).sin_cos();
            DVec3::new(sin * cos_phi, sin * sin_phi, cos)
        })
        .collect()
}

/// The cosine to the axis that a share `u` of the lobe exceeds or equals, u in [0, 1].
pub fn cosine_quantile(bandwidth: f32, u: f64) -> f64 {
    let kappa = 2.0 / f64::from(bandwidth).powi(2);
    // 1 + ln(1 - u (1 - exp(-2 kappa))) / kappa
    (1.0 + (u * (-2.0 * kappa).exp_m1()).ln_1p() / kappa).clamp(-1.0, 1.0)
}

/// Two unit vectors that form a right-handed frame (tangent, bitangent, axis) with the unit vector `axis`.
pub fn frame(axis: Vec3) -> (Vec3, Vec3) {
    axis.any_orthonormal_pair()
}

/// Frames and directions of all lights, for marches through voxels.
pub fn lobe_tables(lights: &[SrbfLight]) -> (Vec<LobeLight>, Vec<LobeDirection>) {
    tables(lights, |light, is_weak| {
        if is_weak {
            (1, 1)
        } else {
            (visibility_count(light.bandwidth), path_count(light.bandwidth))
        }
    })
}

/// Frames and directions of all lights, for `rays` exact rays to a light, a quarter of them to a weak one. Exact rays see a fibre or none, so
/// even the narrowest light wants many. No directions for multiple scattering.
pub fn exact_tables(lights: &[SrbfLight], rays: u32) -> (Vec<LobeLight>, Vec<LobeDirection>) {
    tables(lights, |_, is_weak| {
        let share = if is_weak { 4 } else { 1 };
        ((rays / share).max(1) as usize, 0)
    })
}

/// Frames and directions of all lights; `counts` says how many directions a light, weak or not, gets for visibility and for multiple scattering.
fn tables(
    lights: &[SrbfLight],
    counts: impl Fn(&SrbfLight, bool) -> (usize, usize),
) -> (Vec<LobeLight>, Vec<LobeDirection>) {
    let mut table = Vec::new();
    let least_power = ONE_DIRECTION_SHARE * lights.iter().map(power).sum::<f64>();
    let frames = lights
        .iter()
        .map(|light| {
            let axis = light.direction.normalize();
            let (tangent, bitangent) = frame(axis);
            let (visibility, path) = counts(light, power(light) < least_power);
            let first_visibility = table.len() as u32;
            table.extend(fitted_directions(light.bandwidth, visibility));
            let first_path = table.len() as u32;
            table.extend(fitted_directions(light.bandwidth, path));
            LobeLight {
                axis,
                first_visibility,
                tangent,
                visibility_count: visibility as u32,
                bitangent,
                first_path,
                path_count: path as u32,
                mean_cosine: mean_cosine(light.bandwidth) as f32,
                bandwidth: light.bandwidth,
                solid_angle: solid_angle(light.bandwidth) as f32,
            }
        })
        .collect();
    (frames, table)
}

/// The directions of one light with their weights in the linear fit.
///
/// The fit minimises sum (T_i - a - b . d_i)^2 + m b^T C b over a and b, with d_i = w_i - A w_j, C the lobe's covariance and m = 3 pseudo-observations up to eight directions. It is
/// linear in the T_i, so a and b are fixed weights times transmittances.
fn fitted_directions(bandwidth: f32, count: usize) -> Vec<LobeDirection> {
    let locals = directions(bandwidth, count);
    let mean_axis = DVec3::Z * mean_cosine(bandwidth);
    let offsets: Vec<_> = locals.iter().map(|w| *w - mean_axis).collect();
    let centre = offsets.iter().sum::<DVec3>() / count as f64;

    // Covariance of the lobe: A / kappa across the axis, 1 - 2 A / kappa - A^2 along it.
    let kappa = 2.0 / f64::from(bandwidth).powi(2);
    let across = mean_axis.z / kappa;
    let along = (1.0 - 2.0 * across - mean_axis.z.powi(2)).max(1e-3 * across);
    // With enough directions a trace of it keeps the normal matrix regular.
    let observations = if count > ENOUGH_DIRECTIONS {
        1e-2
    } else {
        PSEUDO_OBSERVATIONS
    };
    let prior = DMat3::from_diagonal(DVec3::new(across, across, along)) * observations;
    let normal = offsets.iter().fold(prior, |sum, d| {
        let d = *d - centre;
        sum + DMat3::from_cols(d * d.x, d * d.y, d * d.z)
    });
    // One direction says nothing about slopes; a light so narrow has a singular normal matrix besides.
    let inverse = if count == 1 { DMat3::ZERO } else { normal.inverse() };

    let solid_angle = solid_angle(bandwidth) / count as f64;
    locals
        .iter()
        .zip(&offsets)
        .map(|(local, offset)| {
            let weight_b = inverse * (*offset - centre);
            LobeDirection {
                local: local.as_vec3(),
                weight_a: (1.0 / count as f64 - weight_b.dot(centre)) as f32,
                weight_b: weight_b.as_vec3(),
                solid_angle: solid_angle as f32,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const BANDWIDTHS: [f32; 6] = [0.05, 0.14, 0.4, 1.0, 2.5, 10.0];

    /// Integral over the sphere of G times a function of the cosine, by the midpoint rule in the cosine.
    fn sphere_integral(bandwidth: f32, f: impl Fn(f64) -> f64) -> f64 {
        let (n, lambda2) = (200_000, f64::from(bandwidth).powi(2));
        let lowest = (1.0 - 20.0 * lambda2).max(-1.0);
        let step = (1.0 - lowest) / f64::from(n);
        (0..n)
            .map(|i| {
                let cos = lowest + (f64::from(i) + 0.5) * step;
                2.0 * std::f64::consts::PI * step * (2.0 * (cos - 1.0) / lambda2).exp() * f(cos)
            })
            .sum()
    }

    #[test]
    fn moments_agree_with_quadrature() {
        for bandwidth in BANDWIDTHS {
            let omega = sphere_integral(bandwidth, |_| 1.0);
            assert!(
                (solid_angle(bandwidth) / omega - 1.0).abs() < 1e-6,
                "solid angle at {bandwidth}"
            );
            let mean = sphere_integral(bandwidth, |cos| cos) / omega;
            assert!(
                (mean_cosine(bandwidth) - mean).abs() < 1e-6,
                "mean cosine at {bandwidth}"
            );
        }
    }

    #[test]
    fn quantiles_split_the_lobe_evenly() {
        for bandwidth in BANDWIDTHS {
            let omega = solid_angle(bandwidth);
            for u in [0.1, 0.5, 0.9] {
                let limit = cosine_quantile(bandwidth, u);
                let above = sphere_integral(bandwidth, |cos| f64::from(cos >= limit)) / omega;
                assert!(
                    (above - u).abs() < 1e-3,
                    "share above {limit} at {bandwidth} is {above}, wanted {u}"
                );
            }
        }
    }

    #[test]
    fn weak_lights_get_one_direction() {
        let light = |radiance| SrbfLight {
            direction: Vec3::Y,
            bandwidth: 0.5,
            radiance: Vec3::splat(radiance),
        };
        let (frames, table) = lobe_tables(&[light(1.0), light(0.009), light(0.011)]);
        let counts: Vec<_> = frames
            .iter()
            .map(|f| (f.visibility_count, f.path_count))
            .collect();
        let full = (visibility_count(0.5) as u32, path_count(0.5) as u32);
        assert_eq!(counts, [full, (1, 1), full]);
        assert_eq!(table.len() as u32, 2 * (full.0 + full.1) + 2);
        let (dark, _) = lobe_tables(&[light(0.0)]);
        assert_eq!(
            dark[0].visibility_count, full.0,
            "no light is weak among dark ones"
        );
    }

    #[test]
    fn the_fit_reproduces_a_constant_and_shrinks_a_slope() {
        for bandwidth in BANDWIDTHS {
            let count = visibility_count(bandwidth);
            let table = fitted_directions(bandwidth, count);
            let omega: f64 = table.iter().map(|d| f64::from(d.solid_angle)).sum();
            assert!((omega / solid_angle(bandwidth) - 1.0).abs() < 1e-5);
            let (a, b) = table
                .iter()
                .fold((0.0, Vec3::ZERO), |(a, b), d| (a + d.weight_a, b + d.weight_b));
            assert!(
                (a - 1.0).abs() < 1e-4 && b.length() * bandwidth < 1e-3,
                "constant at {bandwidth}: {a} {b}"
            );
            // T = w . e across the axis has slope 1; the pseudo-observations let through count / (count + 3) of it in the mean.
            let slope: f32 = table
                .iter()
                .map(|d| 0.5 * (d.weight_b.x * d.local.x + d.weight_b.y * d.local.y))
                .sum();
            let expected = if count == 1 {
                0.0
            } else {
                count as f32 / (count as f32 + 3.0)
            };
            assert!(
                (slope - expected).abs() < 0.15,
                "slope at {bandwidth}: {slope}, expected about {expected}"
            );
        }
    }
}
