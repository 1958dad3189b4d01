//! The smooth curve through a groom's points, dense enough for a narrow highlight, with a frame at every point.

use glam::{DQuat, DVec3, Vec3};
use rayon::prelude::*;

use super::Groom;
use super::spline::NaturalSpline;

/// Turn of the tangent between two refined points that a highlight of five degrees bears.
pub const DEFAULT_MAX_TURN_RAD: f32 = 4.0 * std::f32::consts::PI / 180.0;

/// Most refined points per segment of the groom: enough for 256 degrees at the default turn.
const MAX_SUBDIVISION: usize = 64;

/// Most refined points of all strands, so that indices fit into u32.
const MAX_REFINED_POINTS: usize = 1 << 31;

/// Tangents looked at per segment to estimate how far it turns.
const TURN_SAMPLES: usize = 8;

/// Refined points of all strands, strand after strand, root first; every array has one entry per refined point unless it says otherwise.
///
/// The frame (u, v, w) is tangent, normal and their cross product w = u x v; it is rotation-minimizing: it turns with the strand but not
/// around it. Every point of the groom is a refined point too.
#[derive(Clone, Debug, PartialEq)]
pub struct RefinedGroom {
    positions: Vec<Vec3>,
    tangents: Vec<Vec3>,
    normals: Vec<Vec3>,
    diameters: Vec<f32>,
    source_point: Vec<u32>,
    source_fraction: Vec<f32>,
    first_point: Vec<u32>,
    capped_segments: usize,
}

impl RefinedGroom {
    /// Subdivides the natural cubic spline through each strand's points until the tangent turns by at most `max_turn_rad` between two
    /// refined points.
    ///
    /// `max_turn_rad` is kept within [0.1 degrees, pi]; NaN counts as [`DEFAULT_MAX_TURN_RAD`]. A segment is cut into at most 64 pieces;
    /// [`Self::capped_segments`] counts those that would have needed more. Equal input gives equal output, bit for bit.
    pub fn new(groom: &Groom, max_turn_rad: f32) -> Self {
        let _scope = tracing::info_span!("refine strands").entered();
        let max_turn = if max_turn_rad.is_nan() {
            DEFAULT_MAX_TURN_RAD
        } else {
            max_turn_rad
        };
        let max_turn = f64::from(max_turn).clamp(0.1_f64.to_radians(), std::f64::consts::PI);
        let cap = (MAX_REFINED_POINTS / groom.point_count()).clamp(1, MAX_SUBDIVISION);
        let strands: Vec<Strand> = (0..groom.strand_count())
            .into_par_iter()
            .map(|strand| Strand::refine(groom, strand, max_turn, cap))
            .collect();

        // Join the strands in their order.
        let count = strands.iter().map(|s| s.points.len()).sum();
        let mut refined = Self {
            positions: Vec::with_capacity(count),
            tangents: Vec::with_capacity(count),
            normals: Vec::with_capacity(count),
            diameters: Vec::with_capacity(count),
            source_point: Vec::with_capacity(count),
            source_fraction: Vec::with_capacity(count),
            first_point: Vec::with_capacity(strands.len() + 1),
            capped_segments: 0,
        };
        for strand in strands {
            refined.first_point.push(refined.positions.len() as u32);
            refined.capped_segments += strand.capped_segments;
            for point in strand.points {
                refined.positions.push(point.position);
                refined.tangents.push(point.tangent);
                refined.normals.push(point.normal);
                refined.diameters.push(point.diameter);
                refined.source_point.push(point.source_point);
                refined.source_fraction.push(point.source_fraction);
            }
        }
        refined.first_point.push(refined.positions.len() as u32);
        refined
    }

    /// Number of strands, the same as the groom's.
    pub fn strand_count(&self) -> usize {
        self.first_point.len() - 1
    }

    /// Number of refined points of all strands.
    pub fn point_count(&self) -> usize {
        self.positions.len()
    }

    /// Index range of the refined points of strand `strand`, root first.
    pub fn strand(&self, strand: usize) -> std::ops::Range<usize> {
        self.first_point[strand] as usize..self.first_point[strand + 1] as usize
    }

    /// Positions in the groom's unit.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// Unit tangents u, root to tip.
    pub fn tangents(&self) -> &[Vec3] {
        &self.tangents
    }

    /// Unit normals v, orthogonal to the tangents.
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// Fibre diameters in the groom's unit, linear between its points.
    pub fn diameters(&self) -> &[f32] {
        &self.diameters
    }

    /// The groom's point at or before each refined point.
    pub fn source_point(&self) -> &[u32] {
        &self.source_point
    }

    /// How far each refined point lies towards the groom's next point, in [0, 1); 0 at the tip, which has no next point.
    pub fn source_fraction(&self) -> &[f32] {
        &self.source_fraction
    }

    /// The groom's point at or before the place between refined point `i` (`fraction` 0) and the next of its strand (1), and how far that place lies
    /// towards the groom's next point.
    pub fn source_between(&self, i: usize, fraction: f32) -> (usize, f32) {
        let source = self.source_point[i] as usize;
        let ends =
            [i, i + 1].map(|p| (self.source_point[p] as usize - source) as f32 + self.source_fraction[p]);
        (source, ends[0] + (ends[1] - ends[0]) * fraction)
    }

    /// First refined point of every strand, and the count at the end: `strand_count() + 1` entries.
    pub fn first_point(&self) -> &[u32] {
        &self.first_point
    }

    /// Number of segments of the groom that turn too much for the largest subdivision.
    pub fn capped_segments(&self) -> usize {
        self.capped_segments
    }

    /// Values of the groom's points (any channel), carried linearly to the refined points.
    ///
    /// `values` has one entry per point of the groom; `mix(a, b, t)` is the value at fraction t from a to b.
    pub fn interpolate<T: Copy>(&self, values: &[T], mix: impl Fn(T, T, f32) -> T) -> Vec<T> {
        self.source_point
            .iter()
            .zip(&self.source_fraction)
            .map(|(&point, &t)| {
                let value = values[point as usize];
                if t > 0.0 {
                    mix(value, values[point as usize + 1], t)
                } else {
                    value
                }
            })
            .collect()
    }
}

/// One refined point.
struct Point {
    position: Vec3,
    tangent: Vec3,
    normal: Vec3,
    diameter: f32,
    source_point: u32,
    source_fraction: f32,
}

/// The refined points of one strand.
struct Strand {
    points: Vec<Point>,
    capped_segments: usize,
}

impl Strand {
    fn refine(groom: &Groom, strand: usize, max_turn: f64, cap: usize) -> Self {
        let range = groom.strand(strand);
        let source = &groom.positions()[range.clone()];
        let diameters = &groom.diameters()[range.clone()];
        let spline = NaturalSpline::new(source);
        let mut refined = Self {
            points: Vec::with_capacity(2 * source.len()),
            capped_segments: 0,
        };
        let mut frame = Frame::at_root(spline.position(0, 0.0), spline.tangent(0, 0.0));
        let mut push = |segment: usize, t: f64| {
            frame = frame.moved_to(spline.position(segment, t), spline.tangent(segment, t));
            // The tip is fraction 0 of itself, because it has no next point.
            let (point, t) = if t == 1.0 {
                (segment + 1, 0.0)
            } else {
                (segment, t)
            };
            let next = (point + 1).min(source.len() - 1);
            let fraction = t as f32;
            refined.points.push(Point {
                position: frame.position.as_vec3(),
                tangent: frame.tangent.as_vec3(),
                normal: frame.normal.as_vec3(),
                diameter: diameters[point] + fraction * (diameters[next] - diameters[point]),
                source_point: (range.start + point) as u32,
                source_fraction: fraction,
            });
        };

        for segment in 0..spline.segment_count() {
            let (pieces, sufficient) = subdivision(&spline, segment, max_turn, cap);
            refined.capped_segments += usize::from(!sufficient);
            for piece in 0..pieces {
                push(segment, piece as f64 / pieces as f64);
            }
        }
        push(spline.segment_count() - 1, 1.0);
        refined
    }
}

/// How many equal pieces of `segment` keep the turn within `max_turn`, and whether the cap left enough of them.
fn subdivision(spline: &NaturalSpline, segment: usize, max_turn: f64, cap: usize) -> (usize, bool) {
    let turn = |pieces: usize, piece: usize| {
        let at = |i: usize| spline.tangent(segment, i as f64 / pieces as f64);
        at(piece).angle_between(at(piece + 1))
    };
    // The whole turn is a lower bound on the pieces; the curve may turn unevenly, so look and add.
    let whole: f64 = (0..TURN_SAMPLES).map(|i| turn(TURN_SAMPLES, i)).sum();
    let mut pieces = ((whole / max_turn).ceil() as usize).clamp(1, cap);
    loop {
        let sufficient = (0..pieces).all(|piece| turn(pieces, piece) <= max_turn);
        if sufficient || pieces == cap {
            return (pieces, sufficient);
        }
        pieces = (pieces + pieces.div_ceil(4)).min(cap);
    }
}

/// A frame that travels along a strand.
#[derive(Clone, Copy)]
struct Frame {
    position: DVec3,
    tangent: DVec3,
    normal: DVec3,
}

impl Frame {
    /// The frame at the root: the x axis, carried by the shortest rotation that takes +y to the tangent.
    ///
    /// The rule depends on the tangent alone and is continuous but for a strand that starts straight down.
    fn at_root(position: DVec3, tangent: DVec3) -> Self {
        let normal = DQuat::from_rotation_arc(DVec3::Y, tangent) * DVec3::X;
        Self {
            position,
            tangent,
            normal,
        }
        .orthonormal()
    }

    /// The frame at the next point by double reflection (Wang et al. 2008, Computation of Rotation Minimizing Frames, Table I).
    fn moved_to(self, position: DVec3, tangent: DVec3) -> Self {
        // The first mirror lies halfway between the points, the second halfway between the mirrored and the new tangent.
        let reflect = |x: DVec3, mirror: DVec3| {
            let square = mirror.length_squared();
            if square > 0.0 {
                x - mirror * (2.0 * mirror.dot(x) / square)
            } else {
                x
            }
        };
        let step = position - self.position;
        let halfway = reflect(self.tangent, step);
        let normal = reflect(reflect(self.normal, step), tangent - halfway);
        Self {
            position,
            tangent,
            normal,
        }
        .orthonormal()
    }

    /// Removes the rounding that would let the normal lean.
    fn orthonormal(self) -> Self {
        let normal = (self.normal - self.tangent * self.tangent.dot(self.normal))
            .try_normalize()
            .unwrap_or_else(|| self.tangent.any_orthonormal_vector());
        Self { normal, ..self }
    }
}
