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
        let (map, _) = EnvironmentMap::from_fn(2 * height, height, |w| {
            let rise = w.y.max(0.0).sqrt();
            if w.y < 0.0 {
                self.ground
            } else {
                self.horizon.lerp(self.zenith, rise)
            }
        });

        // The disc covers whole pixels; their radiance follows from the solid angle they really have.
        let radius = self.sun_radius_rad.max(std::f32::consts::PI / height as f32);
        let in_sun = |map: &EnvironmentMap, index: usize| {
            let w = map.direction(index % map.width, index / map.width).as_vec3();
            w.angle_between(self.sun_direction) <= radius
        };
        let covered: Vec<usize> = (0..map.pixels.len())
            .filter(|index| in_sun(&map, *index))
            .collect();
        let solid_angle: f64 = covered
            .iter()
            .map(|index| map.pixel_solid_angle(index / map.width))
            .sum();
        let sun = self.sun_irradiance / solid_angle as f32;
        let mut pixels = map.pixels;
        for index in covered {
            pixels[index] += sun;
        }
        EnvironmentMap::cleaned(RawMap {
            width: 2 * height,
            height,
            pixels,
            warnings: Vec::new(),
        })
    }
}
