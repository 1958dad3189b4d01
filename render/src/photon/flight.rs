//! Photons on their way from fibre to fibre.

use std::ops::Range;
use std::sync::OnceLock;

use glam::Vec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use super::LightField;
use crate::groom::RefinedGroom;
use crate::light::SrbfLight;
use crate::optics::sample::{Sample, sample_deon, sample_marschner};
use crate::param::VertexParams;
use crate::volume::{Hit, SegmentGrid, SolidVoxels, Strands, lobe};

/// Photons of one task, and tasks between two looks at the interrupt.
const PER_TASK: u64 = 256;
const TASKS: u64 = 32;

/// Fibres that a photon meets at most: in white hair it leaves long before, by as many as the hair is deep.
const MOST_FIBRES: u32 = 2048;

/// Below this share of its first power a photon is ended by chance.
const FAINT: f32 = 1.0 / 3.0;

/// Fibres that scatter light: strands, what they are made of and what stands in the way.
pub struct Hair {
    strands: RefinedGroom,
    /// One entry per groom point.
    params: Vec<VertexParams>,
    solid: Option<SolidVoxels>,
    /// Projected area of the segments before each, and of all at the end; the segments' first points and their strands.
    area_before: Vec<f64>,
    segments: Vec<[u32; 2]>,
    grid: OnceLock<SegmentGrid>,
}

/// What is traced and how far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traced {
    /// Photons sent out.
    pub photons: u64,
    /// Rays: whether the light is seen, and from fibre to fibre.
    pub rays: u64,
}

/// Tracing was given up on request; what is in the field is whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interrupted;

/// A meeting of a photon and a fibre.
struct Meeting {
    position: Vec3,
    towards: Vec3,
    power: Vec3,
}

/// A fibre where light arrives.
struct Place {
    position: Vec3,
    strand: u32,
    point: usize,
    fraction: f32,
    /// Columns u (tangent), v, w; v points to where the light comes from as far as it can.
    frame: [Vec3; 3],
    sin_theta: f32,
}

/// Which photons a field takes and how fibres scatter them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rules {
    /// d'Eon 2011 instead of Marschner 2003.
    pub is_deon: bool,
    /// Photons that every fibre so far has scattered to its far side.
    pub onward: bool,
    /// Photons that a fibre has turned back.
    pub turned: bool,
}

impl Hair {
    /// Fibres of the strands' own diameters; parameters have to follow.
    pub fn new(strands: RefinedGroom, solid: Option<SolidVoxels>) -> Self {
        let mut area_before = vec![0.0];
        let mut segments = Vec::with_capacity(strands.point_count());
        let mut sum = 0.0;
        for (strand, ends) in strands.first_point().windows(2).enumerate() {
            for i in ends[0]..ends[1].saturating_sub(1).max(ends[0]) {
                let (a, b) = (i as usize, i as usize + 1);
                let length = strands.positions()[a].distance(strands.positions()[b]);
                sum += f64::from(0.5 * length * (strands.diameters()[a] + strands.diameters()[b]));
                area_before.push(sum);
                segments.push([i, strand as u32]);
            }
        }
        Self {
            strands,
            params: Vec::new(),
            solid,
            area_before,
            segments,
            grid: OnceLock::new(),
        }
    }

    /// Takes the parameters of the groom's points, those of the points in `dirty` where earlier ones are there.
    pub fn set_params(&mut self, params: &[VertexParams], dirty: &[Range<u32>]) {
        if self.params.len() != params.len() {
            params.clone_into(&mut self.params);
            return;
        }
        for range in dirty.iter().map(|range| range.start as usize..range.end as usize) {
            self.params[range.clone()].copy_from_slice(&params[range]);
        }
    }

    /// A dark field of these strands.
    pub fn field(&self, cell: f32) -> LightField {
        LightField::new(&self.lines(), cell)
    }

    /// Sends photons on from number `done.photons` until there were `rays` rays in all; the same numbers give the same field, whoever
    /// traces and with however many threads. `stop` is asked now and then.
    ///
    /// # Errors
    /// [`Interrupted`].
    pub fn trace(
        &self,
        lights: &[SrbfLight],
        rules: Rules,
        rays: u64,
        done: &mut Traced,
        field: &mut LightField,
        stop: &dyn Fn() -> bool,
    ) -> Result<(), Interrupted> {
        let sources = Sources::new(lights);
        let area = self.area_before.last().copied().unwrap_or(0.0);
        if sources.power_before.last().is_none_or(|power| *power <= 0.0)
            || area <= 0.0
            || self.params.is_empty()
        {
            return Ok(());
        }
        let grid = self.grid.get_or_init(|| SegmentGrid::new(&self.lines()));
        while done.rays < rays {
            if stop() {
                return Err(Interrupted);
            }
            let first = done.photons;
            let tasks: Vec<(Vec<Meeting>, u64)> = (0..TASKS)
                .into_par_iter()
                .map(|task| {
                    let numbers = first + task * PER_TASK..first + (task + 1) * PER_TASK;
                    let mut meetings = Vec::new();
                    let rays = numbers
                        .map(|n| self.fly(n, grid, &sources, rules, &mut meetings))
                        .sum();
                    (meetings, rays)
                })
                .collect();
            for (meetings, rays) in tasks {
                for meeting in meetings {
                    field.meet(meeting.position, meeting.towards, meeting.power);
                }
                done.rays += rays;
            }
            done.photons += TASKS * PER_TASK;
        }
        Ok(())
    }

    /// Sends photon `number`, notes what it meets and returns how many rays that took.
    fn fly(
        &self,
        number: u64,
        grid: &SegmentGrid,
        sources: &Sources<'_>,
        rules: Rules,
        meetings: &mut Vec<Meeting>,
    ) -> u64 {
        let mut random = Pcg64Mcg::seed_from_u64(number);
        // Fibre and light from an even sequence (R2 of Roberts): photons that follow each other share neither.
        let [along, among] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3]
            .map(|step: f64| (0.5 + step * number as f64).fract());
        let (light, towards) = sources.draw(among, &mut random);
        let Some(mut here) = self.start(along, towards) else {
            return 0;
        };
        let mut rays = 1;
        let cos_theta = (1.0 - here.sin_theta * here.sin_theta).max(0.0).sqrt();
        if !grid.is_free(here.position, towards, Some(here.strand))
            || self.is_blocked(here.position, towards, f32::INFINITY)
        {
            return rays;
        }
        let area = self.area_before.last().copied().unwrap_or(0.0) as f32;
        let mut power = light * (area * cos_theta);
        let first = power.max_element();
        let mut has_turned = false;
        for _ in 0..MOST_FIBRES {
            let Some(drawn) = self.scatter(&here, rules, &mut random) else {
                return rays;
            };
            power *= Vec3::from_array(drawn.weight.map(|x| x as f32));
            has_turned |= drawn.phi.cos() > 0.0;
            if has_turned && !rules.turned {
                return rays;
            }
            let chance = power.max_element() / (FAINT * first);
            if chance < 1.0 {
                if random.random::<f32>() >= chance {
                    return rays;
                }
                power /= chance;
            }
            let (sin_theta, cos_theta) = (drawn.theta as f32).sin_cos();
            let (sin_phi, cos_phi) = (drawn.phi as f32).sin_cos();
            let [u, v, w] = here.frame;
            let direction = (u * sin_theta + (v * cos_phi + w * sin_phi) * cos_theta).normalize();
            rays += 1;
            let Some(hit) = grid.first(here.position, direction, Some(here.strand)) else {
                return rays;
            };
            if self.is_blocked(here.position, direction, hit.distance) {
                return rays;
            }
            here = self.place(here.position + direction * hit.distance, -direction, hit);
            if has_turned || rules.onward {
                meetings.push(Meeting {
                    position: here.position,
                    towards: -direction,
                    power,
                });
            }
        }
        rays
    }

    /// The fibre at the share `along` of all projected area, where light arrives from `towards`.
    fn start(&self, along: f64, towards: Vec3) -> Option<Place> {
        let area = along * self.area_before.last()?;
        let index = self
            .area_before
            .partition_point(|before| *before <= area)
            .checked_sub(1)?;
        let [point, strand] = *self.segments.get(index)?;
        let (before, after) = (self.area_before[index], self.area_before[index + 1]);
        let fraction = ((area - before) / (after - before)) as f32;
        let i = point as usize;
        let position = self.strands.positions()[i].lerp(self.strands.positions()[i + 1], fraction);
        let hit = Hit {
            distance: 0.0,
            point,
            fraction,
            strand,
        };
        Some(self.place(position, towards, hit))
    }

    fn place(&self, position: Vec3, towards: Vec3, hit: Hit) -> Place {
        let i = hit.point as usize;
        let tangents = self.strands.tangents();
        let u = tangents[i].lerp(tangents[i + 1], hit.fraction).normalize();
        let sin_theta = towards.dot(u).clamp(-1.0, 1.0);
        let v = (towards - u * sin_theta)
            .try_normalize()
            .unwrap_or_else(|| u.any_orthonormal_vector());
        Place {
            position,
            strand: hit.strand,
            point: i,
            fraction: hit.fraction,
            frame: [u, v, u.cross(v)],
            sin_theta,
        }
    }

    fn scatter(&self, here: &Place, rules: Rules, random: &mut impl Rng) -> Option<Sample> {
        let (source, share) = self.strands.source_between(here.point, here.fraction);
        let next = (source + 1).min(self.params.len() - 1);
        let fibre = self.params[source].fibre_towards(&self.params[next], share);
        let theta = f64::from(here.sin_theta).asin();
        if rules.is_deon {
            Some(sample_deon(&fibre, theta, random))
        } else {
            sample_marschner(&fibre, theta, random)
        }
    }

    fn is_blocked(&self, origin: Vec3, direction: Vec3, distance: f32) -> bool {
        self.solid
            .as_ref()
            .is_some_and(|solid| solid.blocks(origin, direction, distance))
    }

    fn lines(&self) -> Strands<'_> {
        Strands {
            positions: self.strands.positions(),
            diameters: self.strands.diameters(),
            first_point: self.strands.first_point(),
        }
    }
}

/// Lights, drawn in proportion to their power.
struct Sources<'a> {
    lights: &'a [SrbfLight],
    /// Power (sum of the channels) of the lights before each, and of all at the end.
    power_before: Vec<f64>,
}

impl<'a> Sources<'a> {
    fn new(lights: &'a [SrbfLight]) -> Self {
        let mut power_before = vec![0.0];
        let mut sum = 0.0;
        for light in lights {
            sum += light.energy().element_sum().max(0.0);
            power_before.push(sum);
        }
        Self { lights, power_before }
    }

    /// A light by `among` in [0, 1): its radiance times solid angle over its chance, and a direction of its lobe.
    fn draw(&self, among: f64, random: &mut impl Rng) -> (Vec3, Vec3) {
        let all = self.power_before[self.lights.len()];
        let index = self.power_before.partition_point(|before| *before <= among * all);
        let light = &self.lights[index.clamp(1, self.lights.len()) - 1];
        let cos = lobe::cosine_quantile(light.bandwidth, random.random::<f64>()) as f32;
        let axis = light.direction.normalize();
        let (tangent, bitangent) = lobe::frame(axis);
        let (sin_phi, cos_phi) = (random.random::<f32>() * std::f32::consts::TAU).sin_cos();
        let across = (tangent * cos_phi + bitangent * sin_phi) * (1.0 - cos * cos).max(0.0).sqrt();
        let energy = light.energy();
        (
            (energy * (all / energy.element_sum())).as_vec3(),
            axis * cos + across,
        )
    }
}
