//! Environments without a file.

use glam::Vec3;

use super::map::RawMap;
use super::{EnvironmentMap, MapReport};

/// A sky that grades from horizon to zenith, a ground below, and a sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GradientSky {
    /// Radiance straight up, linear Rec.709.
    pub zenith: Vec3,
    /// Radiance at the horizon, linear Rec.709.
    pub horizon: Vec3,
    /// Radiance below the horizon, linear Rec.709.
    pub ground: Vec3,
    /// Unit vector towards the sun.
    pub sun_direction: Vec3,
    /// Irradiance of the sun on a surface that faces it (radiance times solid angle), linear Rec.709; zero for none.
    pub sun_irradiance: Vec3,
    /// Angular radius of the sun's disc, radians; not below one pixel of the map.
    pub sun_radius_rad: f32,
}

impl Default for GradientSky {
    /// A clear afternoon.
    fn default() -> Self {
        Self {
            zenith: Vec3::new(0.18, 0.36, 0.80),
            horizon: Vec3::new(0.80, 0.90, 1.00),
            ground: Vec3::new(0.22, 0.20, 0.17),
            sun_direction: Vec3::new(-0.5, 0.6, 0.62).normalize(),
            sun_irradiance: Vec3::new(4.2, 3.8, 3.1),
            sun_radius_rad: 0.03,
        }
    }
}

impl GradientSky {
    /// The sky as a map of `2 * height` by `height` pixels, and what had to be repaired; the sun keeps its irradiance exactly.
    pub fn map(&self, height: usize) -> (EnvironmentMap, MapReport) {
        let (width, grid) = (
            2 * height,
            EnvironmentMap {
                width: 2 * height,
                height,
                pixels: Vec::new(),
            },
        );
        let direction = |index: usize| grid.direction(index % width, index / width).as_vec3();
        let sky = |w: Vec3| {
            if w.y < 0.0 {
                self.ground
            } else {
                self.horizon.lerp(self.zenith, w.y.sqrt())
            }
        };
        let mut pixels: Vec<Vec3> = (0..width * height).map(|index| sky(direction(index))).collect();

        // The disc covers whole pixels; their radiance follows from the solid angle they really have.
        let radius = self.sun_radius_rad.max(std::f32::consts::PI / height as f32);
        let is_sun = |index: &usize| direction(*index).angle_between(self.sun_direction) <= radius;
        let covered: Vec<usize> = (0..pixels.len()).filter(is_sun).collect();
        let solid_angle: f64 = covered
            .iter()
            .map(|index| grid.pixel_solid_angle(index / width))
            .sum();
        let sun = self.sun_irradiance / solid_angle as f32;
        for index in covered {
            pixels[index] += sun;
        }
        EnvironmentMap::cleaned(RawMap {
            width,
            height,
            pixels,
            warnings: Vec::new(),
        })
    }
}
