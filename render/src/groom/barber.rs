//! Growth and styling of single strands: combed by gravity from a parting, then gathered to locks, curled and roughened.

use glam::{Vec2, Vec3};
use rand::Rng;
use rand_pcg::Pcg64Mcg;

use super::generate::{GROWTH, GeneratorSettings, HairStyle, STYLING, stream};
use super::scalp::{Envelope, HeadMeasure};

/// 0 below `from`, 1 above `to`, smooth between.
pub(super) fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Where a strand starts.
pub(super) struct Root {
    pub position: Vec3,
    /// Unit normal of the skin.
    pub normal: Vec3,
    /// Which side of the parting (positive towards +x) and how strongly, -1 to 1; 0 at the back of the head.
    pub side: f32,
}

/// Grows and styles strands on one head.
pub(super) struct Barber<'a> {
    pub settings: &'a GeneratorSettings,
    pub measure: HeadMeasure,
    pub envelope: Envelope,
}

impl Barber<'_> {
    /// The way a comb pulls at a point of the head: down, away from the parting on top, back and not into the face in front.
    ///
    /// `wander` is the strand's own deviation to either side.
    fn comb(&self, p: Vec3, side: f32, wander: f32) -> Vec3 {
        let Vec2 { x: height, y: depth } = self.measure.height_depth(p);
        let front = smoothstep(0.42, 0.76, depth);
        let top = smoothstep(-0.45, -0.15, height);
        let across = side * (1.2 * top + 0.9 * front) + wander;
        let down = 1.15 - front;
        let back = 0.35 * top + 1.1 * front;
        Vec3::new(across, -down, -back)
    }

    /// The middle line of a strand: out of the skin, laid over by comb and gravity, outside of the head.
    pub fn grow(&self, root: &Root, strand: usize) -> Vec<Vec3> {
        let settings = self.settings;
        let mut random = stream(settings.seed, GROWTH, strand);
        let height = self.measure.height_depth(root.position).x;
        let low = 1.0 - smoothstep(-1.0, -0.1, height);
        let length = settings.length_m
            * (1.0 - 0.6 * settings.graduation * low)
            * (0.85 + 0.15 * random.random::<f32>());
        let step = length / (settings.points_per_strand - 1) as f32;
        let wander = (0.15 + settings.frizz) * (2.0 * random.random::<f32>() - 1.0);

        // Hair from further up lies on top of hair from further down.
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
                let comb = self.comb(p, root.side, wander);
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
    pub fn style(&self, roots: &[Root], grown: &[Vec<Vec3>], strand: usize, leader: usize) -> Vec<Vec3> {
        let settings = self.settings;
        let line = &grown[strand];
        let lead = &grown[leader];
        let step = line[0].distance(line[1]);
        let mut random = stream(settings.seed, STYLING, strand);
        let below_top = -self.measure.depth * self.measure.height_depth(line[0]).x;
        let shape = Curl::new(settings, leader, below_top, &mut random);
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
    ///
    /// `below_top` is how far the root lies below the top of the head in metres: hair that hangs waves in step at equal heights.
    fn new(settings: &GeneratorSettings, leader: usize, below_top: f32, random: &mut Pcg64Mcg) -> Self {
        let mut lock = stream(settings.seed, STYLING ^ 8, leader);
        let tau = std::f32::consts::TAU;
        let vary = |random: &mut Pcg64Mcg, amount: f32| 1.0 + amount * (2.0 * random.random::<f32>() - 1.0);
        // Waves of neighbouring locks go together, curls do not.
        let (radius, roundness, opening, disorder) = match settings.style {
            HairStyle::Straight => (0.0, 0.0, 0.06, 0.0),
            HairStyle::Wavy => (settings.curl_radius_m, 0.35, 0.08, 0.25),
            HairStyle::Curly => (settings.curl_radius_m, 1.0, 0.03, 1.0),
        };
        let rate = tau / settings.curl_pitch_m * vary(&mut lock, 0.12 * disorder) * vary(random, 0.03);
        Self {
            radius: radius * vary(&mut lock, 0.3) * vary(random, 0.15),
            roundness,
            rate,
            phase: rate * below_top
                + disorder * tau * lock.random::<f32>()
                + 0.7 * (random.random::<f32>() - 0.5),
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
