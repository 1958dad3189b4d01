//! Where the points of a groom are: a uniform grid for brushes, and each point's place on its strand.

use std::{ops::Range, sync::Arc};

use balayage_render::groom::Groom;
use glam::Vec3;

use super::StrandFacts;

/// A groom with what a brush asks of it. Positions and distances are in the groom's unit.
pub struct StrandIndex {
    groom: Arc<Groom>,
    strand_of: Vec<u32>,
    along: Vec<f32>,
    longest_segment: f32,
    arc: Vec<f32>,
    origin: Vec3,
    cell: f32,
    size: [usize; 3],
    cell_start: Vec<u32>,
    cell_points: Vec<u32>,
}

/// Points that an average cell of the bounding box would hold if they filled it evenly.
const POINTS_PER_CELL: f32 = 2.0;

impl StrandIndex {
    /// Sorts the groom's points into cells; time and memory are linear in the point count.
    pub fn new(groom: Arc<Groom>) -> Self {
        let shared = groom.clone();
        let positions = shared.positions();
        let mut strand_of = vec![0; groom.point_count()];
        let mut along = vec![0.0; groom.point_count()];
        for strand in 0..groom.strand_count() {
            let points = groom.strand(strand);
            strand_of[points.clone()].fill(strand as u32);
            for p in points.skip(1) {
                along[p] = along[p - 1] + positions[p].distance(positions[p - 1]);
            }
        }

        let longest_segment = (1..positions.len())
            .map(|p| along[p] - along[p - 1])
            .fold(0.0, f32::max);

        // Cells are cubes; a flat or thin bounding box counts with at least a hundredth of its longest side.
        let (low, high) = positions
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| {
                (low.min(*p), high.max(*p))
            });
        let extent = (high - low).max(Vec3::ZERO);
        let longest = extent.max_element().max(f32::MIN_POSITIVE);
        let volume = extent
            .max(Vec3::splat(0.01 * longest))
            .to_array()
            .map(f64::from)
            .iter()
            .product::<f64>();
        let cells = f64::from(positions.len().max(1) as f32 / POINTS_PER_CELL).max(1.0);
        let cell = ((volume / cells).cbrt() as f32).max(longest / 512.0);
        let size = extent.to_array().map(|side| (side / cell) as usize + 1);

        // A counting sort keeps the points of a cell in ascending order.
        let mut index = Self {
            strand_of,
            along,
            longest_segment,
            arc: shared.arc(),
            origin: low,
            cell,
            size,
            cell_start: vec![0; size.iter().product::<usize>() + 1],
            cell_points: vec![0; positions.len()],
            groom,
        };
        let cell_of: Vec<usize> = positions
            .iter()
            .map(|p| index.cell_index(index.cell_of(*p)))
            .collect();
        for cell in &cell_of {
            index.cell_start[cell + 1] += 1;
        }
        for cell in 1..index.cell_start.len() {
            index.cell_start[cell] += index.cell_start[cell - 1];
        }
        let mut next = index.cell_start.clone();
        for (point, cell) in cell_of.iter().enumerate() {
            index.cell_points[next[*cell] as usize] = point as u32;
            next[*cell] += 1;
        }
        index
    }

    /// The groom.
    pub fn groom(&self) -> &Arc<Groom> {
        &self.groom
    }

    /// The strand of a point.
    pub fn strand_of(&self, point: u32) -> u32 {
        self.strand_of[point as usize]
    }

    /// Root-to-tip coordinate of the point in [0, 1], by length.
    pub fn arc(&self, point: u32) -> f32 {
        self.arc[point as usize]
    }

    /// Length from the strand's root to the point.
    pub fn along(&self, point: u32) -> f32 {
        self.along[point as usize]
    }

    /// Length from the strand's root to the point, millimetres.
    pub fn along_mm(&self, point: u32) -> f32 {
        self.along(point) * 1000.0 * self.groom.metres_per_unit()
    }

    /// Greatest distance between two neighbouring points of a strand.
    pub fn longest_segment(&self) -> f32 {
        self.longest_segment
    }

    /// Distance from `place` to the strand's segments that meet in `point`.
    pub fn distance_to_strand(&self, point: u32, place: Vec3) -> f32 {
        let p = point as usize;
        let positions = self.groom.positions();
        let strand = self.groom.strand(self.strand_of(point) as usize);
        let to_segment = |a: usize, b: usize| {
            let along = positions[b] - positions[a];
            let from_a = place - positions[a];
            let t = from_a.dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
            from_a.distance(t.clamp(0.0, 1.0) * along)
        };
        let before = if p > strand.start { p - 1 } else { p };
        let after = if p + 1 < strand.end { p + 1 } else { p };
        to_segment(before, p).min(to_segment(p, after))
    }

    /// What operations and masks know of a strand.
    pub fn facts(&self, strand: usize) -> StrandFacts {
        let points = self.groom.strand(strand);
        let root = self.groom.positions()[points.start];
        StrandFacts {
            root,
            root_mm: 1000.0 * self.groom.metres_per_unit() * root,
            length_mm: self.along_mm(points.end as u32 - 1),
        }
    }

    /// Side of a cell of the grid: about the distance between neighbouring points where hair is dense.
    pub fn spacing(&self) -> f32 {
        self.cell
    }

    /// Calls `visit(point, distance)` for every point nearer to `centre` than `radius`; returns how many points were looked at.
    pub fn for_each_near(&self, centre: Vec3, radius: f32, mut visit: impl FnMut(u32, f32)) -> u64 {
        let mut measured = 0;
        let positions = self.groom.positions();
        let [low, high] = [centre - radius, centre + radius].map(|corner| self.cell_of(corner));
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                // The cells of a row are neighbours in memory.
                let row = self.cell_index([low[0], y, z])..=self.cell_index([high[0], y, z]);
                let points = self.cell_start[*row.start()] as usize..self.cell_start[*row.end() + 1] as usize;
                measured += points.len() as u64;
                for point in &self.cell_points[points] {
                    let distance = positions[*point as usize].distance(centre);
                    if distance < radius {
                        visit(*point, distance);
                    }
                }
            }
        }
        measured
    }

    /// The points of the same strand within `reach` along it, and at least the two next ones.
    pub fn stretch(&self, point: u32, reach: f32) -> Range<usize> {
        let strand = self.groom.strand(self.strand_of(point) as usize);
        let p = point as usize;
        let centre = self.along[p];
        let first = strand.start + self.along[strand.clone()].partition_point(|s| *s < centre - reach);
        let last = strand.start + self.along[strand.clone()].partition_point(|s| *s <= centre + reach);
        first.min(p.saturating_sub(1).max(strand.start))..last.max((p + 2).min(strand.end))
    }

    /// The cell of a place; places outside the grid belong to the nearest cell.
    fn cell_of(&self, place: Vec3) -> [usize; 3] {
        let cells = ((place - self.origin) / self.cell).to_array();
        // The cast sends negative numbers to zero.
        std::array::from_fn(|axis| (cells[axis] as usize).min(self.size[axis] - 1))
    }

    fn cell_index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.size[1] + y) * self.size[0] + x
    }
}
