//! Procedural hair: settings, and roots on the scalp; [`super::barber`] grows and styles the strands.

use glam::Vec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::barber::{Barber, Root, smoothstep};
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
    /// How much shorter hair is that grows lower on the head, 0 (all of one length) to 1 (cut to about one height).
    pub graduation: f32,
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
            points_per_strand: 20,
            length_m: 0.44,
            diameter_m: 0.45e-3,
            frizz: 0.08,
            clumping: 0.4,
            curl_radius_m: 0.0,
            curl_pitch_m: 0.1,
            volume_m: 0.014,
            graduation: 0.85,
            parting: 0.1,
            seed: 1,
        };
        match style {
            HairStyle::Straight => straight,
            HairStyle::Wavy => Self {
                strand_count: 2_400,
                points_per_strand: 24,
                length_m: 0.29,
                diameter_m: 0.5e-3,
                frizz: 0.08,
                clumping: 0.6,
                curl_radius_m: 0.010,
                curl_pitch_m: 0.115,
                volume_m: 0.020,
                graduation: 0.95,
                parting: -0.45,
                ..straight
            },
            HairStyle::Curly => Self {
                strand_count: 1_350,
                points_per_strand: 32,
                length_m: 0.195,
                diameter_m: 0.5e-3,
                frizz: 0.12,
                clumping: 0.75,
                curl_radius_m: 0.0075,
                curl_pitch_m: 0.065,
                volume_m: 0.032,
                graduation: 0.85,
                parting: 0.1,
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
            ("graduation", self.graduation, 0.0, 1.0),
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

/// Random numbers of one strand and one purpose.
pub(super) fn stream(seed: u64, purpose: u64, strand: usize) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(
        seed ^ purpose.wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ (strand as u64).wrapping_mul(0xd1b5_4a32_d192_ed03),
    )
}

pub(super) const GROWTH: u64 = 1;
const ROOTS: u64 = 2;
pub(super) const STYLING: u64 = 3;

/// Stratified samples of the scalp: equal shares of its area, one root at a random place in each.
fn place_roots(
    settings: &GeneratorSettings,
    head: &Mesh,
    measure: &HeadMeasure,
) -> Result<Vec<Root>, GroomError> {
    // The running area of the triangles that bear hair, weighted by density.
    let mut area = 0.0_f64;
    let mut scalp: Vec<(f64, usize)> = Vec::new();
    for triangle in 0..head.triangles().len() {
        let [a, b, c] = head.corners(triangle);
        let (centre, normal) = ((a + b + c) / 3.0, (b - a).cross(c - a));
        let bears = [a, b, c].iter().any(|&p| measure.above_hairline(p) > 0.0);
        if bears && measure.faces_out(centre, normal) {
            area += f64::from(normal.length() / 2.0 * density(settings, measure, centre));
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
    let untidiness = match settings.style {
        HairStyle::Curly => 0.4,
        HairStyle::Straight | HairStyle::Wavy => 0.03,
    };
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
        let blur = untidiness * measure.depth * (random.random::<f32>() - 0.5);
        // The parting ends at the crown.
        let reach = smoothstep(0.18, 0.42, measure.height_depth(position).y);
        let side = if position.x + blur > parting {
            reach
        } else {
            -reach
        };
        Root {
            position,
            normal,
            side,
        }
    });
    Ok(roots.collect())
}

/// Density of roots at a point of the scalp: highest where hair is seen to begin and no other hair lies on it, at parting and hairline.
fn density(settings: &GeneratorSettings, measure: &HeadMeasure, p: Vec3) -> f32 {
    let hd = measure.height_depth(p);
    let from_parting = (p.x / measure.depth - 0.4 * settings.parting).abs();
    let parting = (1.0 - smoothstep(0.0, 0.22, from_parting)) * smoothstep(-0.5, -0.2, hd.x);
    let hairline = 1.0 - smoothstep(0.0, 0.15, measure.above_hairline(p));
    let front = smoothstep(0.45, 0.7, hd.y);
    1.0 + 5.0 * parting + 3.5 * front * hairline
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
                .filter(|&lead| (roots[lead].side - root.side).abs() < 1.0)
                .min_by(|a, b| distance(a).total_cmp(&distance(b)))
                .unwrap_or(strand)
        })
        .collect()
}
