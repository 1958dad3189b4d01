//! How much of a stroke each point takes: the largest coverage that any dab gives it.

use glam::Vec3;

use super::{Dab, Falloff, Nearest, Operation, Reach, Shape, StrandIndex};

/// Coverage of a dab at `x` radii from its centre: 1 in the hard core, 0 from the rim outwards.
pub fn profile(falloff: Falloff, hardness: f32, x: f32) -> f32 {
    if x >= 1.0 {
        return 0.0;
    }
    if x <= hardness {
        return 1.0;
    }
    let t = (1.0 - x) / (1.0 - hardness);
    match falloff {
        Falloff::Smooth => t * t * (3.0 - 2.0 * t),
        Falloff::Linear => t,
        Falloff::Round => (t * (2.0 - t)).max(0.0).sqrt(),
        Falloff::Sharp => t * t,
        Falloff::Constant => 1.0,
    }
}

/// The coverage of one stroke over all points, and which points it touches.
#[derive(Clone, Debug, Default)]
pub struct Coverage {
    of_point: Vec<f32>,
    touched: Vec<u32>,
    measured: u64,
}

impl Coverage {
    /// No coverage on `point_count` points.
    pub fn new(point_count: usize) -> Self {
        Self {
            of_point: vec![0.0; point_count],
            touched: Vec::new(),
            measured: 0,
        }
    }

    /// Coverage of `point` in [0, 1].
    pub fn of(&self, point: u32) -> f32 {
        self.of_point[point as usize]
    }

    /// The points with coverage, in the order in which they were touched first.
    pub fn touched(&self) -> &[u32] {
        &self.touched
    }

    /// Points that dabs were held against so far.
    pub fn measured(&self) -> u64 {
        self.measured
    }

    /// Forgets the stroke in time linear in the touched points.
    pub fn clear(&mut self) {
        for point in self.touched.drain(..) {
            self.of_point[point as usize] = 0.0;
        }
    }

    /// Adds `dabs` of `operation`; returns the points whose coverage grew, ascending, each once.
    pub fn add_dabs(&mut self, index: &StrandIndex, operation: &Operation, dabs: &[Dab]) -> Vec<u32> {
        let mut raised = Vec::new();
        for dab in dabs {
            let full = operation.strength * dab.pressure;
            let mut raise = |point: u32, coverage: f32| {
                let old = &mut self.of_point[point as usize];
                if coverage > *old {
                    if *old == 0.0 {
                        self.touched.push(point);
                    }
                    // Full flow takes the coverage itself, so that a stroke does not depend on the order of its dabs.
                    *old = if operation.flow < 1.0 {
                        *old + operation.flow * (coverage - *old)
                    } else {
                        coverage
                    };
                    raised.push(point);
                }
            };
            self.measured +=
                for_each_covered(index, operation, dab, |point, share| raise(point, full * share));
        }
        raised.sort_unstable();
        raised.dedup();
        raised
    }
}

/// What an operation with a shape covers: points ascending, with their coverage.
fn of_shape(index: &StrandIndex, operation: &Operation, shape: &Shape) -> Vec<(u32, f32)> {
    let groom = index.groom();
    let mut covered = Vec::new();
    for strand in 0..groom.strand_count() {
        let facts = index.facts(strand);
        let Some(along) = shape.along(&facts, operation.seed) else {
            continue;
        };
        let points = groom.strand(strand).map(|point| {
            let point = point as u32;
            (point, operation.strength * along(index.along_mm(point)))
        });
        covered.extend(points.filter(|(_, coverage)| *coverage > 0.0));
    }
    covered
}

/// What a whole operation covers: points ascending, with their coverage. `scratch` is as it was afterwards.
pub fn of_operation(index: &StrandIndex, operation: &Operation, scratch: &mut Coverage) -> Vec<(u32, f32)> {
    if operation.hidden {
        return Vec::new();
    }
    if let Some(shape) = &operation.shape {
        return of_shape(index, operation, shape);
    }
    let points = scratch.add_dabs(index, operation, &operation.dabs);
    let covered = points
        .into_iter()
        .map(|point| (point, scratch.of(point)))
        .collect();
    scratch.clear();
    covered
}

/// Calls `visit(point, coverage)` for every point that `dab` reaches, at full strength; returns how many points were looked at.
fn for_each_covered(
    index: &StrandIndex,
    operation: &Operation,
    dab: &Dab,
    mut visit: impl FnMut(u32, f32),
) -> u64 {
    let radius = operation.radius_m / index.groom().metres_per_unit();
    let across = |distance: f32| profile(operation.falloff, operation.hardness, distance / radius);
    let position = Vec3::from(dab.position);
    if operation.reach != Reach::Strand {
        return index.for_each_near(position, radius, |point, distance| visit(point, across(distance)));
    }

    // A strand is covered by its nearest place, wherever its points lie: one end of that segment is no further than half of it. Strokes of
    // before counted from its points. Along the strand coverage falls off towards both ends of the stretch.
    let mut strands: Vec<(u32, f32)> = Vec::new();
    let by_place = operation.nearest == Nearest::Place;
    let reach = if by_place {
        radius + 0.5 * index.longest_segment()
    } else {
        radius
    };
    let measured = index.for_each_near(position, reach, |point, to_point| {
        let distance = if by_place {
            index.distance_to_strand(point, position)
        } else {
            to_point
        };
        if distance < radius {
            strands.push((index.strand_of(point), across(distance)));
        }
    });
    strands.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    strands.dedup_by_key(|(strand, _)| *strand);
    for (strand, share) in strands {
        for point in index.groom().strand(strand as usize) {
            let arc = index.arc(point as u32);
            let mut along = operation.arc_reach.map_or(1.0, |reach| {
                let distance = (arc - dab.arc).abs();
                profile(operation.falloff, operation.hardness, distance / reach)
            });
            if let Some(range) = operation.arc_range {
                along *= within_arcs(operation, range, arc);
            }
            visit(point as u32, share * along);
        }
    }
    measured
}

/// Coverage at `arc` of a stretch between two arcs: it falls towards both ends, but not at a root or a tip that it includes.
fn within_arcs(operation: &Operation, [from, to]: [f32; 2], arc: f32) -> f32 {
    if arc < from || arc > to {
        return 0.0;
    }
    let half = 0.5 * (to - from);
    let middle = from + half;
    let open = (arc < middle && from <= 0.0) || (arc > middle && to >= 1.0);
    if open || half <= 0.0 {
        1.0
    } else {
        profile(operation.falloff, operation.hardness, (arc - middle).abs() / half)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profiles_fall_from_core_to_rim() {
        for falloff in [
            Falloff::Smooth,
            Falloff::Linear,
            Falloff::Round,
            Falloff::Sharp,
            Falloff::Constant,
        ] {
            for hardness in [0.0, 0.5, 1.0] {
                let samples: Vec<f32> = (0..=100)
                    .map(|i| profile(falloff, hardness, i as f32 / 100.0))
                    .collect();
                assert_eq!(samples[0], 1.0, "{falloff:?} {hardness}");
                assert_eq!(samples[100], 0.0, "{falloff:?} {hardness}");
                assert!(samples.windows(2).all(|w| w[0] >= w[1]), "{falloff:?} {hardness}");
            }
        }
        assert_eq!(profile(Falloff::Linear, 0.5, 0.75), 0.5);
    }
}
