//! Procedural hair: roots on the scalp, growth combed by gravity from a parting, then clumps, curls and frizz.

use glam::{Vec2, Vec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::scalp::{Envelope, HeadMeasure};
use super::{Groom, GroomError, Mesh};

/// Overall shape of generated hair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HairStyle {
    /// Long and smooth.
    Straight,
    /// A bob with soft waves.
    Wavy,
    /// Short helices.
    Curly,
}

/// What the generator makes. Lengths in metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GeneratorSettings {
    /// Overall shape.
    pub style: HairStyle,
    /// Number of strands, 1 to 1,000,000.
    pub strand_count: u32,
    /// Points per strand, 4 to 1,024; at least eight per turn of a curl or wave.
    pub points_per_strand: u32,
    /// Length of the middle line of the longest strands, 0.005 to 2 m.
    pub length_m: f32,
    /// Fibre diameter, 1e-5 to 1e-3 m; above real hair (0.08 mm) a few strands cover a head.
    pub diameter_m: f32,
    /// Irregularity of the single strand, 0 to 1.
    pub frizz: f32,
    /// How much strands gather to locks towards their tips, 0 to 1.
    pub clumping: f32,
    /// Radius of curls or amplitude of waves, 0 to 0.05 m; not used by straight hair.
    pub curl_radius_m: f32,
    /// Way along the middle line per turn, 0.005 to 0.5 m.
    pub curl_pitch_m: f32,
    /// Thickness of the coat of hair on the head, 0 to 0.05 m.
    pub volume_m: f32,
    /// Place of the parting: -1 right ear, 0 middle, 1 left ear of the head.
    pub parting: f32,
    /// Equal seeds give equal hair.
    pub seed: u64,
}

impl GeneratorSettings {
    /// Settings of a good-looking example of a style.
    pub fn new(style: HairStyle) -> Self {
        let straight = Self {
            style,
            strand_count: 3_000,
            points_per_strand: 28,
            length_m: 0.40,
            diameter_m: 0.25e-3,
            frizz: 0.12,
            clumping: 0.35,
            curl_radius_m: 0.0,
            curl_pitch_m: 0.1,
            volume_m: 0.012,
            parting: 0.25,
            seed: 1,
        };
        match style {
            HairStyle::Straight => straight,
            HairStyle::Wavy => Self {
                strand_count: 2_800,
                points_per_strand: 40,
                length_m: 0.24,
                frizz: 0.25,
                clumping: 0.6,
                curl_radius_m: 0.006,
                curl_pitch_m: 0.065,
                volume_m: 0.016,
                parting: -0.2,
                ..straight
            },
            HairStyle::Curly => Self {
                strand_count: 1_500,
                points_per_strand: 80,
                length_m: 0.20,
                diameter_m: 0.3e-3,
                frizz: 0.35,
                clumping: 0.55,
                curl_radius_m: 0.008,
                curl_pitch_m: 0.026,
                volume_m: 0.028,
                parting: 0.0,
                ..straight
            },
        }
    }

    /// Refuses what is out of range, naming the setting.
    fn check(&self) -> Result<(), GroomError> {
        let turns = if self.style == HairStyle::Straight {
            0.0
        } else {
            self.length_m / self.curl_pitch_m
        };
        let least_points = (8.0 * turns).max(4.0);
        let ranges = [
            ("strand_count", self.strand_count as f32, 1.0, 1.0e6),
            ("length_m", self.length_m, 0.005, 2.0),
            ("curl_pitch_m", self.curl_pitch_m, 0.005, 0.5),
            (
                "points_per_strand",
                self.points_per_strand as f32,
                least_points,
                1024.0,
            ),
            ("diameter_m", self.diameter_m, 1.0e-5, 1.0e-3),
            ("frizz", self.frizz, 0.0, 1.0),
            ("clumping", self.clumping, 0.0, 1.0),
            ("curl_radius_m", self.curl_radius_m, 0.0, 0.05),
            ("volume_m", self.volume_m, 0.0, 0.05),
            ("parting", self.parting, -1.0, 1.0),
        ];
        for (name, value, least, most) in ranges {
            if !(least..=most).contains(&value) {
                return Err(GroomError::refused(
                    "generator",
                    format!("{name} = {value} is not in {least} to {most}"),
                    "choose a value in the range",
                ));
            }
        }
        Ok(())
    }
}

/// Grows hair on a head: a mesh of head and neck in metres, y up, facing +z, middle at x = 0. The groom is in metres.
///
/// # Errors
/// [`GroomError::Refused`] when a setting is out of range or the mesh has no scalp.
pub fn generate(settings: &GeneratorSettings, head: &Mesh) -> Result<Groom, GroomError> {
    settings.check()?;
    let measure = HeadMeasure::new(head);
    let envelope = Envelope::new(head);
    let roots = place_roots(settings, head, &measure)?;
    let barber = Barber {
        settings,
        measure,
        envelope,
    };

    // Every strand has its own random stream, so that the order of work does not matter.
    let grown: Vec<Vec<Vec3>> = roots
        .par_iter()
        .enumerate()
        .map(|(strand, root)| barber.grow(root, strand))
        .collect();
    let leaders = leaders(settings, &roots);
    let strands: Vec<Vec<Vec3>> = (0..roots.len())
        .into_par_iter()
        .map(|strand| barber.style(&roots, &grown, strand, leaders[strand]))
        .collect();
    Groom::from_strands(strands, settings.diameter_m, 1.0).map(|(groom, _)| groom)
}

/// Where a strand starts.
struct Root {
    position: Vec3,
    normal: Vec3,
    /// +1 left of the parting (towards +x), -1 right of it.
    side: f32,
}

/// Random numbers of one strand and one purpose.
fn stream(seed: u64, purpose: u64, strand: usize) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(
        seed ^ purpose.wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ (strand as u64).wrapping_mul(0xd1b5_4a32_d192_ed03),
    )
}

const GROWTH: u64 = 1;
const ROOTS: u64 = 2;
const STYLING: u64 = 3;

/// Stratified samples of the scalp: equal shares of its area, one root at a random place in each.
fn place_roots(
    settings: &GeneratorSettings,
    head: &Mesh,
    measure: &HeadMeasure,
) -> Result<Vec<Root>, GroomError> {
    // The running area of the triangles that bear hair.
    let mut area = 0.0_f64;
    let mut scalp: Vec<(f64, usize)> = Vec::new();
    for triangle in 0..head.triangles().len() {
        let [a, b, c] = head.corners(triangle);
        let (centre, normal) = ((a + b + c) / 3.0, (b - a).cross(c - a));
        let bears = [a, b, c].iter().any(|&p| measure.above_hairline(p) > 0.0);
        if bears && measure.faces_out(centre, normal) {
            area += f64::from(normal.length()) / 2.0;
            scalp.push((area, triangle));
        }
    }
    if scalp.is_empty() || area <= 0.0 {
        return Err(GroomError::refused(
            "head",
            "no triangle lies above the hairline",
            "give a head with y up, facing +z",
        ));
    }

    // A root below the hairline is tried again anywhere; a blurred hairline looks natural.
    let parting = settings.parting * 0.4 * measure.depth;
    let count = settings.strand_count as usize;
    let roots = (0..count).map(|strand| {
        let mut random = stream(settings.seed, ROOTS, strand);
        let mut share = (strand as f64 + random.random::<f64>()) / count as f64;
        let mut best = (f32::NEG_INFINITY, Vec3::ZERO, Vec3::Y);
        for _ in 0..64 {
            let i = scalp
                .partition_point(|&(running, _)| running < share * area)
                .min(scalp.len() - 1);
            let triangle = scalp[i].1;
            let (r, t) = (random.random::<f32>().sqrt(), random.random::<f32>());
            let weights = [1.0 - r, r * (1.0 - t), r * t];
            let blend = |values: [Vec3; 3]| -> Vec3 {
                values
                    .iter()
                    .zip(weights)
                    .map(|(&value, weight)| value * weight)
                    .sum()
            };
            let position = blend(head.corners(triangle));
            let normal = blend(head.triangles()[triangle].map(|v| head.normals()[v as usize]));
            let inside = measure.above_hairline(position) - 0.03 * random.random::<f32>().powi(2);
            if inside > best.0 {
                best = (inside, position, normal.normalize_or(Vec3::Y));
            }
            if inside > 0.0 {
                break;
            }
            share = random.random();
        }
        let (_, position, normal) = best;
        let blur = 0.004 * measure.depth * (random.random::<f32>() - 0.5);
        let side = if position.x + blur > parting { 1.0 } else { -1.0 };
        Root {
            position,
            normal,
            side,
        }
    });
    Ok(roots.collect())
}

/// For every strand the nearest strand of the same side that leads a lock; there are about 25 strands to a lock.
fn leaders(settings: &GeneratorSettings, roots: &[Root]) -> Vec<usize> {
    let step = 25.min(roots.len());
    let leads: Vec<usize> = (0..roots.len())
        .step_by(step)
        .map(|first| {
            let last = (first + step).min(roots.len());
            stream(settings.seed, ROOTS, roots.len() + first).random_range(first..last)
        })
        .collect();
    roots
        .par_iter()
        .enumerate()
        .map(|(strand, root)| {
            let distance = |&lead: &usize| root.position.distance_squared(roots[lead].position);
            leads
                .iter()
                .copied()
                .filter(|&lead| roots[lead].side == root.side)
                .min_by(|a, b| distance(a).total_cmp(&distance(b)))
                .unwrap_or(strand)
        })
        .collect()
}

fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Grows and styles strands on one head.
struct Barber<'a> {
    settings: &'a GeneratorSettings,
    measure: HeadMeasure,
    envelope: Envelope,
}

impl Barber<'_> {
    /// The way a comb pulls at a point of the head: down, away from the parting on top, back and not into the face in front.
    fn comb(&self, p: Vec3, side: f32) -> Vec3 {
        let Vec2 { x: height, y: depth } = self.measure.height_depth(p);
        let front = smoothstep(0.50, 0.78, depth);
        let top = smoothstep(-0.45, -0.15, height);
        let across = side * (0.15 + 1.1 * smoothstep(0.15, 0.45, depth) * top + 0.8 * front);
        let back = 0.35 * top + 1.1 * front;
        Vec3::new(across, front - 1.0 - 0.15, -back)
    }

    /// The middle line of a strand: out of the skin, laid over by comb and gravity, outside of the head.
    fn grow(&self, root: &Root, strand: usize) -> Vec<Vec3> {
        let settings = self.settings;
        let mut random = stream(settings.seed, GROWTH, strand);
        let length = settings.length_m * (0.82 + 0.18 * random.random::<f32>());
        let step = length / (settings.points_per_strand - 1) as f32;

        // Hair from further up lies on top of hair from further down.
        let height = self.measure.height_depth(root.position).x;
        let layer =
            settings.volume_m * (0.15 + 0.55 * smoothstep(-0.9, 0.0, height) + 0.3 * random.random::<f32>());

        // Small steps follow the head closely; every few of them give a point.
        let small_steps = (step / 0.002).ceil().max(1.0);
        let h = step / small_steps;
        let (mut p, mut direction, mut travelled) = (root.position, root.normal, 0.0);
        let mut points = vec![p];
        while points.len() < settings.points_per_strand as usize {
            for _ in 0..small_steps as usize {
                let normal = self.envelope.normal(p);
                let distance = self.envelope.distance(p);
                let lift = layer * smoothstep(0.0, 0.035, travelled);

                // Near the head hair follows the comb along the surface, further away it falls.
                let comb = self.comb(p, root.side);
                let along = (comb - normal * normal.dot(comb)).normalize_or_zero();
                let homing = ((lift - distance) / 0.012).clamp(-0.7, 0.7);
                let away = smoothstep(layer + 0.008, layer + 0.04, distance);
                let wanted = (along + normal * homing)
                    .lerp(Vec3::NEG_Y, away)
                    .normalize_or(Vec3::NEG_Y);
                let obedience = 1.0 - (-h / 0.009).exp();
                direction = direction.lerp(wanted, obedience).normalize_or(Vec3::NEG_Y);

                travelled += h;
                p = self
                    .envelope
                    .pushed_out(p + direction * h, self.clearance(travelled));
            }
            points.push(p);
        }
        points
    }

    /// Least distance from the hull at `travelled` metres from the root.
    fn clearance(&self, travelled: f32) -> f32 {
        0.2 * self.settings.volume_m * smoothstep(0.0, 0.03, travelled)
    }

    /// The finished strand: gathered to its lock, curled, roughened, and outside of the head again.
    fn style(&self, roots: &[Root], grown: &[Vec<Vec3>], strand: usize, leader: usize) -> Vec<Vec3> {
        let settings = self.settings;
        let line = &grown[strand];
        let lead = &grown[leader];
        let step = line[0].distance(line[1]);
        let mut random = stream(settings.seed, STYLING, strand);
        let shape = Curl::new(settings, leader, &mut random);
        let frizz = Frizz::new(settings, &mut random);

        // Strands of a lock keep a share of the distance that their roots have, in a random direction.
        let spread = roots[strand].position.distance(roots[leader].position);
        let apart = 0.5 * spread * random_direction(&mut random);
        let last = (line.len() - 1) as f32;
        let mut normal = roots[strand].normal;
        (0..line.len())
            .map(|i| {
                let travelled = i as f32 * step;
                let gather = settings.clumping * smoothstep(0.1, 0.9, i as f32 / last);
                let middle = line[i].lerp(lead[i] + apart, gather);
                if i == 0 {
                    return line[0];
                }
                // The frame of the curl follows the line.
                let tangent = (line[i] - line[i - 1]).normalize_or(Vec3::NEG_Y);
                normal =
                    (normal - tangent * tangent.dot(normal)).normalize_or(tangent.any_orthonormal_vector());
                let offset = shape.offset(tangent, normal, travelled) + frizz.offset(travelled);
                self.envelope
                    .pushed_out(middle + offset, self.clearance(travelled))
            })
            .collect()
    }
}

/// A direction, uniform over the sphere.
fn random_direction(random: &mut Pcg64Mcg) -> Vec3 {
    let (z, turn) = (
        2.0 * random.random::<f32>() - 1.0,
        std::f32::consts::TAU * random.random::<f32>(),
    );
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(r * turn.cos(), r * turn.sin(), z)
}

/// Helix (curly) or flat wave (wavy) around the middle line.
struct Curl {
    radius: f32,
    /// Share of the motion away from the head.
    roundness: f32,
    /// Radians per metre.
    rate: f32,
    phase: f32,
    /// Way from the root over which the curl opens, metres.
    opening: f32,
}

impl Curl {
    /// Strands of one lock curl nearly together.
    fn new(settings: &GeneratorSettings, leader: usize, random: &mut Pcg64Mcg) -> Self {
        let mut lock = stream(settings.seed, STYLING ^ 8, leader);
        let tau = std::f32::consts::TAU;
        let vary = |random: &mut Pcg64Mcg, amount: f32| 1.0 + amount * (2.0 * random.random::<f32>() - 1.0);
        let (radius, roundness, opening) = match settings.style {
            HairStyle::Straight => (0.0, 0.0, 0.06),
            HairStyle::Wavy => (settings.curl_radius_m, 0.35, 0.08),
            HairStyle::Curly => (settings.curl_radius_m, 1.0, 0.03),
        };
        let rate = tau / settings.curl_pitch_m * vary(&mut lock, 0.12) * vary(random, 0.03);
        Self {
            radius: radius * vary(&mut lock, 0.3) * vary(random, 0.15),
            roundness,
            rate,
            phase: tau * lock.random::<f32>() + 0.7 * (random.random::<f32>() - 0.5),
            opening,
        }
    }

    fn offset(&self, tangent: Vec3, normal: Vec3, travelled: f32) -> Vec3 {
        let radius = self.radius * smoothstep(0.0, self.opening, travelled);
        let (sin, cos) = (self.rate * travelled + self.phase).sin_cos();
        radius * (cos * tangent.cross(normal) + self.roundness * sin * normal)
    }
}

/// Smooth irregular motion of a single strand: three waves of random direction.
struct Frizz {
    waves: [(Vec3, f32, f32); 3],
}

impl Frizz {
    /// A few strands fly away from the others.
    fn new(settings: &GeneratorSettings, random: &mut Pcg64Mcg) -> Self {
        let flies = random.random::<f32>() < 0.06 * settings.frizz;
        let amplitude = settings.frizz * if flies { 0.012 } else { 0.003 };
        let mut wave = |wavelength: f32| {
            let rate = std::f32::consts::TAU / (wavelength * (0.7 + 0.6 * random.random::<f32>()));
            let phase = std::f32::consts::TAU * random.random::<f32>();
            (
                amplitude * random_direction(random) * (wavelength / 0.15).min(1.0),
                rate,
                phase,
            )
        };
        Self {
            waves: [wave(0.2), wave(0.1), wave(0.05)],
        }
    }

    fn offset(&self, travelled: f32) -> Vec3 {
        let sum: Vec3 = self
            .waves
            .iter()
            .map(|&(way, rate, phase)| way * (rate * travelled + phase).sin())
            .sum();
        sum * smoothstep(0.0, 0.10, travelled)
    }
}
