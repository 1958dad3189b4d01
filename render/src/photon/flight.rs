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
use crate::optics::sample::{Sample, sample_deon_onward, sample_marschner};
use crate::param::VertexParams;
use crate::volume::{Hit, SegmentGrid, SolidVoxels, Strands, lobe};

/// Photons of one task, and tasks between two looks at the interrupt.
const PER_TASK: u64 = 64;
const TASKS: u64 = 32;

/// Rays a photon that count: in white dense hair one takes hundreds, and few photons would be all there is.
const MOST_RAYS_EACH: u64 = 8;

/// Fibres that a photon meets at most: in white hair it leaves long before, by as many as the hair is deep.
const MOST_FIBRES: u32 = 1 << 14;

/// Least sine of the angle between a line and a fibre that it was chosen by.
const LEAST_ACROSS: f64 = 1e-3;

/// Below this share of its first power a photon is ended by chance.
const FAINT: f32 = 0.5;

/// Above this multiple of its first power a photon is split.
const STRONG: f32 = 2.0;
/// Parts that it is split into at most.
const MOST_PARTS: f32 = 16.0;

/// Fibres that scatter light: strands, what they are made of and what stands in the way.
pub struct Hair {
    strands: RefinedGroom,
    /// One entry per groom point.
    params: Vec<VertexParams>,
    solid: Option<SolidVoxels>,
    /// Corners of the box around the fibres.
    bounds: [Vec3; 2],
    /// First points of the segments, and the projected area (diameter times length) of those before each and of all at the end.
    segments: Vec<u32>,
    area_before: Vec<f64>,
    grid: OnceLock<SegmentGrid>,
}

/// What is traced and how far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traced {
    /// Photons sent out.
    pub photons: u64,
    /// Rays: from the lights into the hair, and from fibre to fibre.
    pub rays: u64,
}

/// Tracing was given up on request; what is in the field is whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interrupted;

/// A meeting of a photon and a fibre.
struct Meeting {
    photon: u64,
    position: Vec3,
    towards: Vec3,
    power: Vec3,
}

/// A fibre where light arrives.
#[derive(Clone, Copy)]
struct Place {
    hit: Hit,
    /// On the fibre's axis.
    position: Vec3,
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
        let (low, high) = Strands::from(&strands).bounds();
        let widest = strands.diameters().iter().copied().fold(0.0, f32::max);
        let segments: Vec<u32> = (0..strands.strand_count())
            .flat_map(|strand| Strands::from(&strands).segments(strand))
            .map(|i| i as u32)
            .collect();
        let mut area_before = vec![0.0];
        let mut sum = 0.0;
        for i in segments.iter().map(|i| *i as usize) {
            let length = strands.positions()[i].distance(strands.positions()[i + 1]);
            sum += f64::from(0.5 * length * (strands.diameters()[i] + strands.diameters()[i + 1]));
            area_before.push(sum);
        }
        Self {
            strands,
            params: Vec::new(),
            solid,
            bounds: [low - widest, high + widest],
            segments,
            area_before,
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
        LightField::new(&Strands::from(&self.strands), cell)
    }

    /// Sends photons on from number `done.photons` until there were `rays` rays in all, more where photons take many; the same numbers give the same field, whoever
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
        if sources.power_before.last().is_none_or(|power| *power <= 0.0)
            || self.params.is_empty()
            || self.segments.is_empty()
        {
            return Ok(());
        }
        let grid = self
            .grid
            .get_or_init(|| SegmentGrid::new(&Strands::from(&self.strands)));
        while done.rays < rays || done.photons * MOST_RAYS_EACH < rays {
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
                    field.meet(meeting.photon, meeting.position, meeting.towards, meeting.power);
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
        // Light and line from an even sequence (R3 of Roberts): photons that follow each other share neither. By turns lines are spread evenly
        // over the box and over the fibres: hair that fills its box wants the one, thin hair the other.
        let [among, across, along] = [
            0.819_172_513_396_164_4,
            0.671_043_606_703_789_2,
            0.549_700_477_901_970_3,
        ]
        .map(|step: f64| (0.5 + step * (number / 2) as f64).fract());
        let (light, towards) = sources.draw(among, &mut random);
        let (mut entry, silhouette) = self.enter(across, along as f32, towards);
        if number % 2 == 1 {
            let [low, high] = self.bounds;
            entry = self.on_fibre(across) + towards * low.distance(high);
        }
        let mut rays = 1;
        let hits = grid.hits(entry, -towards, None);
        let mut places: Vec<Place> = hits.into_iter().map(|hit| self.place(towards, hit)).collect();
        // Lines per area, both ways together: every fibre has been chosen by its own area.
        let across_fibres = |place: &Place| {
            f64::from(1.0 - place.sin_theta * place.sin_theta)
                .sqrt()
                .max(LEAST_ACROSS)
        };
        let area = self.area_before.last().copied().unwrap_or(0.0);
        let through_fibres = places.iter().map(|place| 1.0 / across_fibres(place)).sum::<f64>() / area;
        let lines = 0.5 * (1.0 / f64::from(silhouette) + through_fibres);
        let power = light * (1.0 / lines) as f32;

        // Light reaches the fibres in front of those of other strands: no strand shades itself.
        places.sort_by(|a, b| a.hit.distance.total_cmp(&b.hit.distance));
        let first = places.first().map(|place| place.hit.strand);
        for here in places
            .into_iter()
            .take_while(|place| Some(place.hit.strand) == first)
        {
            if !self.is_blocked(here.position, towards, f32::INFINITY) {
                let met = meetings.len();
                rays += self.scatter_on(here, power, grid, rules, &mut random, meetings);
                meetings[met..]
                    .iter_mut()
                    .for_each(|meeting| meeting.photon = number);
            }
        }
        rays
    }

    /// Follows light of `power` that arrives at a fibre from the light.
    fn scatter_on(
        &self,
        here: Place,
        power: Vec3,
        grid: &SegmentGrid,
        rules: Rules,
        random: &mut impl Rng,
        meetings: &mut Vec<Meeting>,
    ) -> u64 {
        let mut rays = 0;
        let first = power.max_element();
        let mut arrived = vec![(here, power, false)];
        for _ in 0..MOST_FIBRES {
            let Some((here, mut power, mut has_turned)) = arrived.pop() else {
                return rays;
            };
            let Some(drawn) = self.scatter(&here, rules, random) else {
                continue;
            };
            power *= Vec3::from_array(drawn.weight.map(|x| x as f32));
            has_turned |= drawn.phi.cos() > 0.0;
            if has_turned && !rules.turned {
                continue;
            }
            let chance = power.max_element() / (FAINT * first);
            if chance < 1.0 {
                if random.random::<f32>() >= chance {
                    continue;
                }
                power /= chance;
            }
            let (sin_theta, cos_theta) = (drawn.theta as f32).sin_cos();
            let (sin_phi, cos_phi) = (drawn.phi as f32).sin_cos();
            let [u, v, w] = here.frame;
            let direction = (u * sin_theta + (v * cos_phi + w * sin_phi) * cos_theta).normalize();
            rays += 1;
            let origin =
                Strands::from(&self.strands).line_from(&here.hit, direction, random.random_range(-1.0..1.0));
            let Some(hit) = grid.first(origin, direction, Some(here.hit.strand)) else {
                continue;
            };
            if self.is_blocked(origin, direction, hit.distance) {
                continue;
            }
            let there = self.place(-direction, hit);
            if has_turned || rules.onward {
                meetings.push(Meeting {
                    photon: 0,
                    position: there.position,
                    towards: -direction,
                    power,
                });
            }
            // A photon that has become strong goes on as several.
            let parts = (power.max_element() / (STRONG * first))
                .ceil()
                .clamp(1.0, MOST_PARTS);
            for _ in 0..parts as u32 {
                arrived.push((there, power / parts, has_turned));
            }
        }
        rays
    }

    /// Where a line towards the light enters the fibres' box, all such lines alike, and the area of the box's silhouette: each line crosses one of
    /// the three faces that the light sees.
    fn enter(&self, across: f64, along: f32, towards: Vec3) -> (Vec3, f32) {
        let [low, high] = self.bounds;
        let size = high - low;
        let seen = towards.abs() * Vec3::new(size.y * size.z, size.z * size.x, size.x * size.y);
        let silhouette = seen.element_sum();
        let mut rest = across * f64::from(silhouette);
        let mut axis = 2;
        for face in 0..2 {
            if rest < f64::from(seen[face]) {
                axis = face;
                break;
            }
            rest -= f64::from(seen[face]);
        }
        let across = (rest / f64::from(seen[axis].max(f32::MIN_POSITIVE))).min(1.0) as f32;
        let mut share = Vec3::ZERO;
        share[axis] = if towards[axis] > 0.0 { 1.0 } else { 0.0 };
        share[(axis + 1) % 3] = across;
        share[(axis + 2) % 3] = along;
        (low + size * share, silhouette)
    }

    /// The place on a fibre's axis at the share `along` of the projected area of all fibres.
    fn on_fibre(&self, along: f64) -> Vec3 {
        let area = along * self.area_before.last().copied().unwrap_or(0.0);
        let after = self.area_before.partition_point(|before| *before <= area);
        let index = after.clamp(1, self.segments.len()) - 1;
        let (before, after) = (self.area_before[index], self.area_before[index + 1]);
        let fraction = ((area - before) / (after - before).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0) as f32;
        let i = self.segments[index] as usize;
        self.strands.positions()[i].lerp(self.strands.positions()[i + 1], fraction)
    }

    fn place(&self, towards: Vec3, hit: Hit) -> Place {
        let i = hit.point as usize;
        let tangents = self.strands.tangents();
        let u = tangents[i].lerp(tangents[i + 1], hit.fraction).normalize();
        let sin_theta = towards.dot(u).clamp(-1.0, 1.0);
        let v = (towards - u * sin_theta)
            .try_normalize()
            .unwrap_or_else(|| u.any_orthonormal_vector());
        Place {
            hit,
            position: Strands::from(&self.strands).place(&hit),
            frame: [u, v, u.cross(v)],
            sin_theta,
        }
    }

    fn scatter(&self, here: &Place, rules: Rules, random: &mut impl Rng) -> Option<Sample> {
        let Hit { point, fraction, .. } = here.hit;
        let (source, share) = self.strands.source_between(point as usize, fraction);
        let next = (source + 1).min(self.params.len() - 1);
        let fibre = self.params[source].fibre_towards(&self.params[next], share);
        let theta = f64::from(here.sin_theta).asin();
        if rules.is_deon {
            Some(sample_deon_onward(&fibre, theta, random))
        } else {
            sample_marschner(&fibre, theta, random)
        }
    }

    fn is_blocked(&self, origin: Vec3, direction: Vec3, distance: f32) -> bool {
        self.solid
            .as_ref()
            .is_some_and(|solid| solid.blocks(origin, direction, distance))
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

    /// A direction of the light at `among` in [0, 1): the radiance of all lights there over the direction's density, and the direction.
    fn draw(&self, among: f64, random: &mut impl Rng) -> (Vec3, Vec3) {
        let all = self.power_before[self.lights.len()];
        let index = self.power_before.partition_point(|before| *before <= among * all);
        let light = &self.lights[index.clamp(1, self.lights.len()) - 1];
        let cos = lobe::cosine_quantile(light.bandwidth, random.random::<f64>()) as f32;
        let axis = light.direction.normalize();
        let (tangent, bitangent) = lobe::frame(axis);
        let (sin_phi, cos_phi) = (random.random::<f32>() * std::f32::consts::TAU).sin_cos();
        let across = (tangent * cos_phi + bitangent * sin_phi) * (1.0 - cos * cos).max(0.0).sqrt();
        let towards = axis * cos + across;
        // Whichever light was drawn, all shine from there. Drawn by the sums of their channels, photons are alike in power and have the colour of
        // their direction (the balance heuristic of Veach 1997).
        let radiance: Vec3 = self
            .lights
            .iter()
            .map(|light| light.radiance_towards(towards))
            .sum();
        // In float64: where the dimmest lights underflow no light is left, not 0 times infinity.
        let sum = f64::from(radiance.element_sum().max(f32::MIN_POSITIVE));
        ((radiance.as_dvec3() * (all / sum)).as_vec3(), towards)
    }
}
