//! Exact crossings of rays with fibres: the reference for everything that is marched.

use glam::{IVec3, Vec3};
use rand::Rng;

use super::grid::fibre_spacing;
use super::{Strands, lobe};
use crate::light::SrbfLight;

/// Longest side of the cell grid.
const MAX_CELLS_PER_AXIS: f32 = 400.0;

/// A uniform grid of the segments of all strands, each a straight round fibre of its mean diameter.
///
/// A ray crosses a segment where the nearest point of its axis line lies on the segment, ahead of the ray's origin and less than half a diameter away. Every segment
/// is listed in all cells within half a diameter of it, so nothing is missed.
pub struct SegmentGrid {
    low: Vec3,
    cell: f32,
    cells: IVec3,
    first: Vec<u32>,
    members: Vec<u32>,
    segments: Vec<Segment>,
}

struct Segment {
    start: Vec3,
    step: Vec3,
    radius: f32,
    strand: u32,
    point: u32,
}

/// Where a ray meets a fibre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray to the place nearest to the fibre's axis.
    pub distance: f32,
    /// The point of the strands before that place.
    pub point: u32,
    /// The place between that point (0) and the next (1).
    pub fraction: f32,
    /// The strand.
    pub strand: u32,
}

impl SegmentGrid {
    /// Sorts all segments into cells of one fibre spacing.
    pub fn new(strands: &Strands<'_>) -> Self {
        let (low, high) = strands.bounds();
        let widest = strands.diameters.iter().copied().fold(0.0, f32::max);
        let (low, high) = (low - widest, high + widest);
        let cell = fibre_spacing(strands).max((high - low).max_element() / MAX_CELLS_PER_AXIS);
        let cells = ((high - low) / cell).ceil().as_ivec3().max(IVec3::ONE);
        let segments: Vec<Segment> = (0..strands.strand_count())
            .flat_map(|strand| strands.segments(strand).map(move |i| (strand, i)))
            .map(|(strand, i)| Segment {
                start: strands.positions[i],
                step: strands.positions[i + 1] - strands.positions[i],
                radius: 0.25 * (strands.diameters[i] + strands.diameters[i + 1]),
                strand: strand as u32,
                point: i as u32,
            })
            .collect();

        let mut listed: Vec<(u32, u32)> = Vec::new();
        for (index, segment) in segments.iter().enumerate() {
            // Pieces of one cell's length keep the boxes around long slanted segments small.
            let pieces = (segment.step.length() / cell).ceil().max(1.0);
            for piece in 0..pieces as u32 {
                let a = segment.start + segment.step * (piece as f32 / pieces);
                let b = segment.start + segment.step * ((piece + 1) as f32 / pieces);
                let margin = segment.radius + 1e-3 * cell;
                let from = ((a.min(b) - margin - low) / cell)
                    .floor()
                    .as_ivec3()
                    .max(IVec3::ZERO);
                let to = ((a.max(b) + margin - low) / cell)
                    .floor()
                    .as_ivec3()
                    .min(cells - 1);
                for z in from.z..=to.z {
                    for y in from.y..=to.y {
                        for x in from.x..=to.x {
                            listed.push(((x + cells.x * (y + cells.y * z)) as u32, index as u32));
                        }
                    }
                }
            }
        }
        listed.sort_unstable();
        listed.dedup();
        let mut first = vec![0; (cells.x * cells.y * cells.z) as usize + 1];
        for (cell, _) in &listed {
            first[*cell as usize + 1] += 1;
        }
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        let members = listed.into_iter().map(|(_, segment)| segment).collect();
        Self {
            low,
            cell,
            cells,
            first,
            members,
            segments,
        }
    }

    /// Number of fibres that the ray from `origin` along the unit vector `direction` crosses, those of `own_strand` left out;
    /// stops counting at `most`.
    pub fn crossings(&self, origin: Vec3, direction: Vec3, own_strand: Option<u32>, most: u32) -> u32 {
        let mut count = 0;
        self.walk(origin, direction, |cell, t0, t1| {
            let members = self.first[cell] as usize..self.first[cell + 1] as usize;
            for &member in &self.members[members] {
                let segment = &self.segments[member as usize];
                let own = own_strand == Some(segment.strand);
                // A segment listed in several cells counts in the one that holds the crossing.
                if !own
                    && segment
                        .crossed_at(origin, direction)
                        .is_some_and(|(t, _)| t0 <= t && t < t1)
                {
                    count += 1;
                    if count >= most {
                        return false;
                    }
                }
            }
            true
        });
        count
    }

    /// The first fibre that the ray from `origin` along the unit vector `direction` meets, those of `own_strand` left out.
    pub fn first(&self, origin: Vec3, direction: Vec3, own_strand: Option<u32>) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        self.walk(origin, direction, |cell, t0, t1| {
            let members = self.first[cell] as usize..self.first[cell + 1] as usize;
            for &member in &self.members[members] {
                let segment = &self.segments[member as usize];
                if own_strand == Some(segment.strand) {
                    continue;
                }
                if let Some((t, fraction)) = segment.crossed_at(origin, direction)
                    && (t0..t1).contains(&t)
                    && nearest.is_none_or(|hit| t < hit.distance)
                {
                    nearest = Some(Hit {
                        distance: t,
                        point: segment.point,
                        fraction,
                        strand: segment.strand,
                    });
                }
            }
            nearest.is_none()
        });
        nearest
    }

    /// All places where the ray from `origin` along the unit vector `direction` crosses fibres, those of `own_strand` left out, cell after cell.
    pub fn hits(&self, origin: Vec3, direction: Vec3, own_strand: Option<u32>) -> Vec<Hit> {
        let mut hits = Vec::new();
        self.walk(origin, direction, |cell, t0, t1| {
            let members = self.first[cell] as usize..self.first[cell + 1] as usize;
            for &member in &self.members[members] {
                let segment = &self.segments[member as usize];
                let crossed = segment.crossed_at(origin, direction);
                if let Some((t, fraction)) = crossed.filter(|(t, _)| t0 <= *t && *t < t1)
                    && own_strand != Some(segment.strand)
                {
                    hits.push(Hit {
                        distance: t,
                        point: segment.point,
                        fraction,
                        strand: segment.strand,
                    });
                }
            }
            true
        });
        hits
    }

    /// Share of `rays` directions drawn from a light's lobe, stratified in the cosine, that meet no fibre but those of `own_strand`.
    pub fn free_share(
        &self,
        origin: Vec3,
        own_strand: u32,
        light: &SrbfLight,
        rays: u32,
        random: &mut impl Rng,
    ) -> f32 {
        let axis = light.direction.normalize();
        let (tangent, bitangent) = lobe::frame(axis);
        let free = (0..rays).filter(|&i| {
            let u = (f64::from(i) + random.random::<f64>()) / f64::from(rays);
            let cos = lobe::cosine_quantile(light.bandwidth, u) as f32;
            let (sin_phi, cos_phi) = (random.random::<f32>() * std::f32::consts::TAU).sin_cos();
            let across = (tangent * cos_phi + bitangent * sin_phi) * (1.0 - cos * cos).max(0.0).sqrt();
            self.is_free(origin, axis * cos + across, Some(own_strand))
        });
        free.count() as f32 / rays as f32
    }

    /// True where no fibre but those of `own_strand` stops the ray.
    pub fn is_free(&self, origin: Vec3, direction: Vec3, own_strand: Option<u32>) -> bool {
        self.crossings(origin, direction, own_strand, 1) == 0
    }

    /// Calls `visit(cell, t0, t1)` for the cells along the ray until it returns false.
    fn walk(&self, origin: Vec3, direction: Vec3, mut visit: impl FnMut(usize, f32, f32) -> bool) {
        let inverse = direction.recip();
        let size = self.cells.as_vec3() * self.cell;
        let (a, b) = (
            (self.low - origin) * inverse,
            (self.low + size - origin) * inverse,
        );
        let (enter, leave) = (a.min(b), a.max(b));
        let start = enter.max_element().max(0.0);
        if start >= leave.min_element() {
            return;
        }
        let p = (origin + direction * start - self.low) / self.cell;
        let mut cell = p.floor().as_ivec3().clamp(IVec3::ZERO, self.cells - 1);
        let forward = direction.cmpge(Vec3::ZERO);
        let step = IVec3::select(forward, IVec3::ONE, IVec3::NEG_ONE);
        let face = (cell.as_vec3() + Vec3::select(forward, Vec3::ONE, Vec3::ZERO)) * self.cell + self.low;
        let delta = inverse.abs() * self.cell;
        let mut next = Vec3::select(
            direction.cmpeq(Vec3::ZERO),
            Vec3::INFINITY,
            (face - origin) * inverse,
        );
        // The first interval reaches back to the origin, so that a crossing at t = 0 is not lost to rounding.
        let mut t0 = 0.0;
        loop {
            let axis = (0..3).min_by(|&i, &j| next[i].total_cmp(&next[j])).unwrap_or(0);
            let index = (cell.x + self.cells.x * (cell.y + self.cells.y * cell.z)) as usize;
            if !visit(index, t0, next[axis]) {
                return;
            }
            t0 = next[axis];
            next[axis] += delta[axis];
            cell[axis] += step[axis];
            if cell[axis] < 0 || cell[axis] >= self.cells[axis] {
                return;
            }
        }
    }
}

impl Segment {
    /// Where along the ray and along the segment it passes the axis, if it does within the fibre.
    fn crossed_at(&self, origin: Vec3, direction: Vec3) -> Option<(f32, f32)> {
        let to_start = self.start - origin;
        let normal = direction.cross(self.step);
        let sine2 = normal.length_squared();
        let distance = to_start.dot(normal);
        if distance * distance >= self.radius * self.radius * sine2 {
            return None;
        }
        let s = to_start.cross(direction).dot(normal) / sine2;
        let t = to_start.cross(self.step).dot(normal) / sine2;
        (t > 0.0 && (0.0..1.0).contains(&s)).then_some((t, s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall of `n` strands along z, one unit apart along x, at y = 0.
    fn wall(n: usize) -> (Vec<Vec3>, Vec<f32>, Vec<u32>) {
        let positions = (0..n)
            .flat_map(|i| [Vec3::new(i as f32, 0.0, -5.0), Vec3::new(i as f32, 0.0, 5.0)])
            .collect();
        (
            positions,
            vec![0.5; 2 * n],
            (0..=n as u32).map(|i| 2 * i).collect(),
        )
    }

    #[test]
    fn a_row_of_fibres_is_counted_once_each() {
        let (positions, diameters, first_point) = wall(10);
        let grid = SegmentGrid::new(&Strands {
            positions: &positions,
            diameters: &diameters,
            first_point: &first_point,
        });
        assert_eq!(
            grid.crossings(Vec3::new(-3.0, 0.1, 0.3), Vec3::X, None, u32::MAX),
            10
        );
        assert_eq!(
            grid.crossings(Vec3::new(4.5, 0.1, 0.3), Vec3::X, None, u32::MAX),
            5
        );
        let hit = grid.first(Vec3::new(4.5, 0.1, 0.3), Vec3::X, None).unwrap();
        assert_eq!((hit.strand, hit.point), (5, 10));
        assert!((hit.distance - 0.5).abs() < 1e-6 && (hit.fraction - 0.53).abs() < 1e-6);
        assert_eq!(grid.first(Vec3::new(4.5, 0.1, 0.3), Vec3::Y, None), None);
        assert_eq!(
            grid.crossings(Vec3::new(4.0, 0.0, 0.3), Vec3::NEG_X, Some(4), u32::MAX),
            4
        );
        assert_eq!(
            grid.crossings(Vec3::new(-3.0, 0.3, 0.3), Vec3::X, None, u32::MAX),
            0
        );
    }

    #[test]
    fn a_ray_through_the_wall_is_free_only_between_fibres() {
        let (positions, diameters, first_point) = wall(10);
        let grid = SegmentGrid::new(&Strands {
            positions: &positions,
            diameters: &diameters,
            first_point: &first_point,
        });
        let free = (0..1000)
            .filter(|i| grid.is_free(Vec3::new(2.0 + *i as f32 / 200.0, -3.0, 0.1), Vec3::Y, None))
            .count();
        assert!(
            (free as f32 - 500.0).abs() <= 10.0,
            "{free} of 1000 are free, half of the wall is open"
        );
    }
}
