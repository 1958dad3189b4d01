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

/// Length of a step of growth.
const STEP_M: f32 = 0.002;

/// Depth from the back of the head, in head depths, in front of which hair is combed out of the face.
const FACE_EDGE: f32 = 0.71;

/// Height of the cut below the top of the head for hair of unit length: the rest goes into the way over the head's curve.
const CUT_BELOW_TOP: f32 = 0.85;

/// Grows and styles strands on one head.
pub(super) struct Barber<'a> {
    pub settings: &'a GeneratorSettings,
    pub measure: HeadMeasure,
    pub envelope: Envelope,
}

impl Barber<'_> {
    /// The way a comb pulls at a point of the head: away from the parting on top, back behind the hairline, out of the face.
    ///
    /// `wander` is the strand's own deviation to either side. Gravity comes on top.
    fn comb(&self, p: Vec3, side: f32, wander: f32) -> Vec3 {
        let Vec2 { x: height, y: depth } = self.measure.height_depth(p);
        let top = smoothstep(-0.45, -0.15, height);
        let front = smoothstep(0.25, 0.55, depth);
        let face = smoothstep(FACE_EDGE - 0.07, FACE_EDGE + 0.10, depth) * (1.0 - 0.4 * top);
        let across = side * (1.1 * top + 1.1 * face) + wander;
        let back = 0.35 * top * front + 1.3 * face;
        Vec3::new(across, 0.0, -back)
    }

    /// The direction of hair that lies on the head: combed along its surface, pulled down but not into it.
    fn along(normal: Vec3, comb: Vec3) -> Vec3 {
        let slide = Vec3::NEG_Y + normal * normal.y.max(0.0);
        (comb - normal * normal.dot(comb) + slide).normalize_or_zero()
    }

    /// The middle line of a strand: out of the skin, laid over by comb and gravity, outside of the head, cut.
    pub fn grow(&self, root: &Root, strand: usize) -> Vec<Vec3> {
        let settings = self.settings;
        let mut random = stream(settings.seed, GROWTH, strand);
        let height = self.measure.height_depth(root.position).x;
        let wander = (0.10 + 0.5 * settings.frizz) * (2.0 * random.random::<f32>() - 1.0);

        // Hair from further up lies on top of hair from further down; at the hairline the coat begins thin.
        let inner = 0.3 + 0.7 * smoothstep(0.0, 0.2, self.measure.above_hairline(root.position));
        let upper = 0.15 + 0.55 * smoothstep(-0.9, 0.0, height) + 0.3 * random.random::<f32>();
        let layer = settings.volume_m * upper * inner;

        // Small steps follow the head closely; a root already leans the way its hair is combed.
        let lean = Self::along(root.normal, self.comb(root.position, root.side, wander));
        let mut direction = (root.normal + 0.8 * lean).normalize_or(root.normal);
        let (mut p, mut travelled) = (root.position, 0.0);
        let mut path = vec![p];
        while travelled < settings.length_m {
            let normal = self.envelope.normal(p);
            let distance = self.envelope.distance(p);
            let comb = self.comb(p, root.side, wander);
            let lift = layer * smoothstep(0.0, 0.035, travelled);

            // The top of the head holds its coat; lower down, and far from the head, hair falls free.
            let hold = 0.2 + 0.5 * smoothstep(-0.6, -0.3, self.measure.height_depth(p).x);
            let homing = ((lift - distance) / 0.012).clamp(-hold, 0.7);
            let away = smoothstep(layer + 0.008, layer + 0.04, distance);
            let wanted = (Self::along(normal, comb) + normal * homing)
                .lerp((Vec3::NEG_Y + comb).normalize_or(Vec3::NEG_Y), away)
                .normalize_or(Vec3::NEG_Y);
            let obedience = 1.0 - (-STEP_M / 0.009).exp();
            direction = direction.lerp(wanted, obedience).normalize_or(Vec3::NEG_Y);

            travelled += STEP_M;
            p = self
                .envelope
                .pushed_out(p + direction * STEP_M, self.clearance(travelled));
            path.push(p);
        }
        let length = self.cut(&path) * (0.93 + 0.07 * random.random::<f32>());
        (0..settings.points_per_strand)
            .map(|i| along_path(&path, length * i as f32 / (settings.points_per_strand - 1) as f32))
            .collect()
    }

    /// How much of a grown path the scissors leave, metres: between its whole length and what hangs above the line of the cut.
    fn cut(&self, path: &[Vec3]) -> f32 {
        let settings = self.settings;
        let line = -CUT_BELOW_TOP * settings.length_m / self.measure.depth;
        let above = path
            .iter()
            .position(|&p| self.measure.height_depth(p).x < line)
            .unwrap_or(path.len() - 1);
        let whole = settings.length_m;
        let trimmed = (STEP_M * above as f32).clamp(0.15 * whole, whole);
        whole + settings.graduation * (trimmed - whole)
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

/// The place `travelled` metres along a path of points [`STEP_M`] apart; its end beyond.
fn along_path(path: &[Vec3], travelled: f32) -> Vec3 {
    let steps = travelled / STEP_M;
    let first = (steps as usize).min(path.len() - 2);
    path[first].lerp(path[first + 1], (steps - first as f32).min(1.0))
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
            HairStyle::Wavy => (settings.curl_radius_m, 0.6, 0.10, 0.25),
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
