//! A path tracer of hair: the picture that the renderer approximates, by brute force on the CPU.
//!
//! Rays meet the exact fibres of a [`SegmentGrid`] and scatter as [`crate::optics`] says (of a circular fibre R, TT and TRT, or d'Eon's orders);
//! nothing is shared with the shaders. At every fibre met, directions are drawn from the fibre; one of them, drawn in proportion to the light it
//! brings (resampled importance sampling, Talbot 2005), casts the shadow ray, another one goes on. No head, no occluder.

use std::ops::ControlFlow;

use glam::Vec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use crate::gpu::Camera;
use crate::groom::{Groom, RefinedGroom};
use crate::image::Picture;
use crate::light::EnvironmentMap;
use crate::optics::Fibre;
use crate::optics::sample::{sample_deon, sample_marschner};
use crate::param::VertexParams;
use crate::volume::{Hit, SegmentGrid, Strands};

/// Fibres on a path after which it is ended by chance.
const SURE_ORDERS: u32 = 4;

/// Turn of the tangent between two points of the curve that is traced.
const MAX_TURN_RAD: f32 = 0.02;

/// What is traced.
pub struct Scene<'a> {
    groom: &'a Groom,
    params: &'a [VertexParams],
    environment: &'a EnvironmentMap,
    refined: RefinedGroom,
    grid: SegmentGrid,
}

/// How long.
#[derive(Clone, Copy, Debug)]
pub struct TraceSettings {
    /// Paths a pixel.
    pub samples: u32,
    /// Most fibres on a path.
    pub orders: u32,
    /// Directions that the shadow ray is chosen from.
    pub candidates: u32,
    /// Seed: the same one gives the same picture.
    pub seed: u64,
    /// d'Eon 2011 instead of Marschner 2003.
    pub is_deon: bool,
}

impl Default for TraceSettings {
    fn default() -> Self {
        Self {
            samples: 16,
            orders: 100,
            candidates: 32,
            seed: 0,
            is_deon: false,
        }
    }
}

/// The pictures of one run, noise included.
pub struct Traced {
    /// Light - hair - camera only.
    pub single: Picture,
    /// All orders.
    pub all: Picture,
}

/// A fibre where a ray met it.
struct Place {
    hit: Hit,
    /// Columns u (tangent), v, w; v points to the viewer as far as it can.
    frame: [Vec3; 3],
    theta_o: f64,
    fibre: Fibre,
}

impl<'a> Scene<'a> {
    /// Sorts the fibres, the smooth cubics through the groom's points, into a grid. `params` has one entry per groom point; the environment's pixels are
    /// what shines, each of one radiance.
    pub fn new(groom: &'a Groom, params: &'a [VertexParams], environment: &'a EnvironmentMap) -> Self {
        let refined = RefinedGroom::new(groom, MAX_TURN_RAD);
        let grid = SegmentGrid::new(&Strands::from(&refined));
        Self {
            groom,
            params,
            environment,
            refined,
            grid,
        }
    }

    /// Traces the picture that `camera` sees; `on_row` is told of finished rows and may stop, which gives None.
    pub fn trace(
        &self,
        camera: &Camera,
        [width, height]: [u32; 2],
        settings: &TraceSettings,
        on_row: &(dyn Fn() -> ControlFlow<()> + Sync),
    ) -> Option<Traced> {
        let (width, height) = (width as usize, height as usize);
        let rows: Option<Vec<Vec<[[f32; 4]; 2]>>> = (0..height)
            .into_par_iter()
            .map(|y| {
                let mut random = Pcg64Mcg::seed_from_u64(settings.seed.wrapping_mul(1 << 20) + y as u64);
                let row = (0..width)
                    .map(|x| self.pixel(camera, [x, y], [width, height], settings, &mut random))
                    .collect();
                on_row().is_continue().then_some(row)
            })
            .collect();
        let rows = rows?;
        let picture = |which: usize| Picture {
            width,
            height,
            pixels: rows.iter().flatten().map(|pixel| pixel[which]).collect(),
        };
        Some(Traced {
            single: picture(0),
            all: picture(1),
        })
    }

    /// Mean over the pixel's paths, premultiplied by coverage.
    fn pixel(
        &self,
        camera: &Camera,
        [x, y]: [usize; 2],
        [width, height]: [usize; 2],
        settings: &TraceSettings,
        random: &mut impl Rng,
    ) -> [[f32; 4]; 2] {
        let (mut single, mut all, mut covered) = (Vec3::ZERO, Vec3::ZERO, 0);
        let slope = (0.5 * camera.fov_y_rad).tan() * 2.0 / height as f32;
        for _ in 0..settings.samples {
            let across = (x as f32 + random.random::<f32>() - 0.5 * width as f32) * slope;
            let down = (y as f32 + random.random::<f32>() - 0.5 * height as f32) * slope;
            let direction = camera
                .world_from_camera
                .transform_vector3(Vec3::new(across, -down, -1.0));
            if let Some([once, often]) = self.path(camera.position(), direction.normalize(), settings, random)
            {
                covered += 1;
                single += once;
                all += often;
            }
        }
        let scale = 1.0 / settings.samples.max(1) as f32;
        [single, all].map(|sum| (sum * scale).extend(covered as f32 * scale).to_array())
    }

    /// Radiance along one camera ray, of one order and of all; None where it meets no fibre.
    fn path(
        &self,
        origin: Vec3,
        direction: Vec3,
        settings: &TraceSettings,
        random: &mut impl Rng,
    ) -> Option<[Vec3; 2]> {
        let hit = self.grid.first(origin, direction, None)?;
        let mut place = self.place(direction, hit);
        let single = self.direct(&place, settings, random);
        let mut all = single;
        let mut throughput = Vec3::ONE;
        for order in 2..=settings.orders {
            let Some((direction, weight)) = place.draw(settings.is_deon, random) else {
                break;
            };
            throughput *= weight;
            if order > SURE_ORDERS {
                let chance = throughput.max_element().min(1.0);
                if random.random::<f32>() >= chance {
                    break;
                }
                throughput /= chance;
            }
            let origin = self.leave(&place, direction, random);
            let Some(hit) = self.grid.first(origin, direction, Some(place.hit.strand)) else {
                break;
            };
            place = self.place(direction, hit);
            all += throughput * self.direct(&place, settings, random);
        }
        Some([single, all])
    }

    fn place(&self, direction: Vec3, hit: Hit) -> Place {
        let point = hit.point as usize;
        let tangents = self.refined.tangents();
        let u = tangents[point]
            .lerp(tangents[point + 1], hit.fraction)
            .normalize();
        let across = direction - u * direction.dot(u);
        let v = (-across)
            .try_normalize()
            .unwrap_or_else(|| u.any_orthonormal_vector());
        let (source, share) = self.refined.source_between(point, hit.fraction);
        let next = (source + 1).min(self.groom.point_count() - 1);
        Place {
            hit,
            frame: [u, v, u.cross(v)],
            theta_o: f64::from((-direction).dot(u)).clamp(-1.0, 1.0).asin(),
            fibre: self.params[source].fibre_towards(&self.params[next], share),
        }
    }

    /// What the environment sends by this one fibre to the viewer.
    fn direct(&self, place: &Place, settings: &TraceSettings, random: &mut impl Rng) -> Vec3 {
        let (mut total, mut chosen) = (0.0, None);
        for _ in 0..settings.candidates {
            let Some((direction, weight)) = place.draw(settings.is_deon, random) else {
                continue;
            };
            let light = weight * self.radiance(direction);
            let brightness = light.element_sum();
            total += brightness;
            if random.random::<f32>() * total < brightness {
                chosen = Some((direction, light / brightness));
            }
        }
        let Some((direction, colour)) = chosen else {
            return Vec3::ZERO;
        };
        let origin = self.leave(place, direction, random);
        if self.grid.is_free(origin, direction, Some(place.hit.strand)) {
            colour * total / settings.candidates as f32
        } else {
            Vec3::ZERO
        }
    }

    /// A line out of the fibre.
    fn leave(&self, place: &Place, direction: Vec3, random: &mut impl Rng) -> Vec3 {
        Strands::from(&self.refined).line_from(&place.hit, direction, random.random_range(-1.0..1.0))
    }

    /// Radiance of the pixel that `direction` falls into.
    fn radiance(&self, direction: Vec3) -> Vec3 {
        let map = self.environment;
        let turn = direction.x.atan2(-direction.z) / std::f32::consts::TAU;
        let down = direction.y.clamp(-1.0, 1.0).acos() / std::f32::consts::PI;
        let x = (turn.rem_euclid(1.0) * map.width as f32) as usize;
        let y = (down * map.height as f32) as usize;
        map.pixels[y.min(map.height - 1) * map.width + x.min(map.width - 1)]
    }
}

impl Place {
    /// A world direction that light comes from, and its weight.
    fn draw(&self, is_deon: bool, random: &mut impl Rng) -> Option<(Vec3, Vec3)> {
        let drawn = if is_deon {
            sample_deon(&self.fibre, self.theta_o, random)
        } else {
            sample_marschner(&self.fibre, self.theta_o, random)?
        };
        let (sin_theta, cos_theta) = (drawn.theta as f32).sin_cos();
        let (sin_phi, cos_phi) = (drawn.phi as f32).sin_cos();
        let [u, v, w] = self.frame;
        let direction = u * sin_theta + (v * cos_phi + w * sin_phi) * cos_theta;
        Some((
            direction.normalize(),
            Vec3::from_array(drawn.weight.map(|x| x as f32)),
        ))
    }
}
