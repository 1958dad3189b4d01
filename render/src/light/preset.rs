//! Environments without a file.

use glam::Vec3;

use super::map::RawMap;
use super::{EnvironmentMap, LightSet, MapReport, SrbfLight};

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

/// An environment that has a name.
#[derive(Clone, Debug, PartialEq)]
pub enum Preset {
    /// A sky, to be fitted as a map.
    Sky(GradientSky),
    /// Lights as they stand.
    Lights(LightSet),
}

/// The names that [`Preset::named`] knows.
pub const PRESETS: [&str; 7] = [
    "afternoon",
    "noon",
    "golden-hour",
    "dusk",
    "overcast",
    "three-point",
    "uniform",
];

impl Preset {
    /// The preset of one of the names in [`PRESETS`].
    pub fn named(name: &str) -> Option<Self> {
        let sky = GradientSky::default();
        Some(match name {
            "afternoon" => Self::Sky(sky),
            "noon" => Self::Sky(GradientSky {
                zenith: Vec3::new(0.14, 0.32, 0.82),
                horizon: Vec3::new(0.70, 0.85, 1.00),
                sun_direction: Vec3::new(-0.15, 0.95, 0.27).normalize(),
                sun_irradiance: Vec3::new(5.2, 5.0, 4.6),
                ..sky
            }),
            "golden-hour" => Self::Sky(GradientSky {
                zenith: Vec3::new(0.16, 0.24, 0.46),
                horizon: Vec3::new(1.00, 0.62, 0.30),
                ground: Vec3::new(0.18, 0.13, 0.09),
                sun_direction: Vec3::new(-0.80, 0.16, -0.58).normalize(),
                sun_irradiance: Vec3::new(4.6, 2.4, 0.8),
                ..sky
            }),
            "dusk" => Self::Sky(GradientSky {
                zenith: Vec3::new(0.05, 0.08, 0.20),
                horizon: Vec3::new(0.42, 0.26, 0.30),
                ground: Vec3::new(0.04, 0.04, 0.05),
                sun_irradiance: Vec3::ZERO,
                ..sky
            }),
            "overcast" => Self::Sky(GradientSky {
                zenith: Vec3::new(1.00, 1.02, 1.06),
                horizon: Vec3::new(0.48, 0.50, 0.53),
                ground: Vec3::new(0.15, 0.14, 0.13),
                sun_irradiance: Vec3::ZERO,
                ..sky
            }),
            "three-point" => Self::Lights(three_point()),
            "uniform" => Self::Lights(LightSet::uniform(Vec3::ONE)),
            _ => return None,
        })
    }
}

/// A studio: warm key from the upper left, wide fill from the right, cool rim from behind, for a camera that looks along -z.
fn three_point() -> LightSet {
    let light = |direction: Vec3, bandwidth, radiance| SrbfLight {
        direction: direction.normalize(),
        bandwidth,
        radiance,
    };
    LightSet {
        lights: vec![
            light(Vec3::new(-0.70, 0.60, 0.75), 0.35, Vec3::new(6.5, 6.0, 5.3)),
            light(Vec3::new(0.85, 0.20, 0.70), 0.60, Vec3::new(0.65, 0.70, 0.80)),
            light(Vec3::new(0.45, 0.65, -0.90), 0.30, Vec3::new(5.2, 5.8, 6.8)),
        ],
        constant: Vec3::splat(0.03),
    }
}
