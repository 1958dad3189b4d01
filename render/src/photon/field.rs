//! Radiance in cells of the hair, by direction.

use bytemuck::{Pod, Zeroable};
use glam::{IVec3, Mat3, Vec3};
use half::f16;

use super::pool::Pool;
use crate::volume::{Strands, clip_segment};

/// Parts of the sphere per side of the octahedral map.
const SIDE: u32 = 8;
/// Parts that the sphere of directions is divided into; the same constant stands in `shaders/lib/light_field.wgsl`.
pub const DIRECTIONS: u32 = SIDE * SIDE;

/// Entry of a cell without fibres.
const EMPTY: u32 = u32::MAX;

/// Most cells along one axis.
const MAX_CELLS: i32 = 256;

/// Largest stored value: half floats end at 65,504.
const LARGEST: f32 = 1024.0;

/// Least share of the fibres' area that a direction meets: along fibres that are all parallel nothing is met, and nothing arrives.
const LEAST_MET: f32 = 0.01;

/// Placement and scale of a field, same layout as `LightFieldGrid` in `shaders/lib/light_field.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct FieldGrid {
    /// Lower corner, groom's unit.
    pub low: Vec3,
    /// Edge of a cell, groom's unit.
    pub cell: f32,
    /// Cells along each axis.
    pub cells: IVec3,
    /// Factor on the stored values.
    pub scale: f32,
}

/// A field as the shaders read it.
pub struct Packed<'a> {
    /// Placement and scale.
    pub grid: FieldGrid,
    /// Number of every cell among those with fibres, x fastest, or `u32::MAX`.
    pub numbers: &'a [u32],
    /// Mean place (in cells from the lower corner) and area (mean 1) of every such cell's fibres.
    pub fibres: Vec<[f32; 4]>,
    /// [`DIRECTIONS`] a cell: radiance times solid angle, rgb as half floats in units of the scale.
    pub radiance: Vec<[u32; 2]>,
}

/// Power that meets the fibres of every cell, by direction.
pub struct LightField {
    low: Vec3,
    cell: f32,
    cells: IVec3,
    /// Number of every cell among those with fibres, or [`EMPTY`].
    numbers: Vec<u32>,
    /// Projected area of the fibres (diameter times length) of those, groom's unit squared.
    area: Vec<f32>,
    /// The same times the fibres' mean place, in cells from the lower corner.
    places: Vec<Vec3>,
    /// The same times the mean of t t^T, t the unit tangent.
    along: Vec<Mat3>,
    /// [`part_direction`] of every part.
    middles: Vec<Vec3>,
    /// Radiance times solid angle of each part, summed over photons: [`DIRECTIONS`] a cell.
    sums: Vec<Vec3>,
    pool: Pool,
}

impl LightField {
    /// Dark cells of edge `cell` around the strands, larger ones where more than 256 would stand along an axis.
    pub fn new(strands: &Strands<'_>, cell: f32) -> Self {
        let (low, high) = strands.bounds();
        let cell = cell.max((high - low).max_element() / (MAX_CELLS - 1) as f32);
        let cells = ((high - low) / cell).ceil().as_ivec3().max(IVec3::ONE);
        let mut field = Self {
            low,
            cell,
            cells,
            numbers: vec![EMPTY; (cells.x * cells.y * cells.z) as usize],
            area: Vec::new(),
            places: Vec::new(),
            along: Vec::new(),
            middles: (0..DIRECTIONS).map(part_direction).collect(),
            sums: Vec::new(),
            pool: Pool::new(Vec::new()),
        };
        let mut places = Vec::new();
        let in_cells = |p: Vec3| (p - low) / cell;
        for i in (0..strands.strand_count()).flat_map(|strand| strands.segments(strand)) {
            let (a, b) = (strands.positions[i], strands.positions[i + 1]);
            let area = 0.5 * (strands.diameters[i] + strands.diameters[i + 1]) * a.distance(b);
            let t = (b - a).normalize_or_zero();
            let (a, b) = (in_cells(a), in_cells(b));
            clip_segment(a.as_dvec3(), b.as_dvec3(), |voxel, t0, t1| {
                let at = field.index(IVec3::from_array(voxel));
                if field.numbers[at] == EMPTY {
                    field.numbers[at] = field.area.len() as u32;
                    places.push(IVec3::from_array(voxel).clamp(IVec3::ZERO, cells - 1));
                    field.area.push(0.0);
                    field.places.push(Vec3::ZERO);
                    field.along.push(Mat3::ZERO);
                }
                let number = field.numbers[at] as usize;
                let share = area * (t1 - t0) as f32;
                field.area[number] += share;
                field.places[number] += a.lerp(b, 0.5 * (t0 + t1) as f32) * share;
                field.along[number] += Mat3::from_cols(t * t.x, t * t.y, t * t.z) * share;
            });
        }
        field.pool = Pool::new(places);
        field.forget();
        field
    }

    /// No light any more.
    pub fn forget(&mut self) {
        self.sums.clear();
        self.sums
            .resize(self.area.len() * DIRECTIONS as usize, Vec3::ZERO);
        self.pool.forget();
    }

    /// Photon number `photon` of `power` (rgb; radiance times solid angle times area) from the unit vector `towards` has met a fibre at `position`.
    pub fn meet(&mut self, photon: u64, position: Vec3, towards: Vec3, power: Vec3) {
        let cell = ((position - self.low) / self.cell).floor().as_ivec3();
        // Rounding may put a meeting beside the cells that the fibre was clipped to.
        let number = self.numbers[self.index(cell)] as usize;
        let Some(&area) = self.area.get(number) else {
            return;
        };
        // Radiance is power over what of the fibres a beam meets (as in the density volume), here one from the middle of the part, where it is
        // looked up from: the fibres get back the power that they met.
        let part = part_of(towards);
        let middle = self.middles[part];
        let across = (area - middle.dot(self.along[number] * middle)).max(LEAST_MET * area);
        let met = (area * across).sqrt();
        if met > 0.0 {
            self.sums[number * DIRECTIONS as usize + part] += power / met;
            self.pool.meet(number, photon);
        }
    }

    /// Mean over the cells' fibres of radiance times solid angle, summed over all directions, after photons of unit weight `1 / photons`.
    pub fn mean(&self, photons: f64) -> Vec3 {
        let parts = self.sums.chunks(DIRECTIONS as usize).zip(&self.area);
        let (sum, area) = parts.fold((Vec3::ZERO, 0.0), |(sum, all), (parts, &area)| {
            (sum + area * parts.iter().sum::<Vec3>(), all + area)
        });
        sum / (area * photons as f32).max(f32::MIN_POSITIVE)
    }

    /// What the shaders look up after so many `photons`: cells that few of them met are joined with those around.
    pub fn packed(&self, photons: f64) -> Packed<'_> {
        let pooled = self.pool.pooled(&self.sums, &self.area);
        let largest = pooled.iter().map(|sum| sum.max_element()).fold(0.0, f32::max);
        let scale = if largest > 0.0 { LARGEST / largest } else { 1.0 };
        let half = |x: f32| u32::from(f16::from_f32(x * scale).to_bits());
        let sums = pooled
            .iter()
            .map(|s| [half(s.x) | half(s.y) << 16, half(s.z)])
            .collect();
        let mean = self.area.iter().sum::<f32>() / self.area.len().max(1) as f32;
        let fibres = self.area.iter().zip(&self.places);
        let fibres = fibres.map(|(&area, place)| {
            let place = place / area.max(f32::MIN_POSITIVE);
            place.extend(area / mean.max(f32::MIN_POSITIVE)).to_array()
        });
        let grid = FieldGrid {
            low: self.low,
            cell: self.cell,
            cells: self.cells,
            scale: (1.0 / (f64::from(scale) * photons.max(1.0))) as f32,
        };
        Packed {
            grid,
            numbers: &self.numbers,
            fibres: fibres.collect(),
            radiance: sums,
        }
    }

    fn index(&self, cell: IVec3) -> usize {
        let cell = cell.clamp(IVec3::ZERO, self.cells - 1);
        (cell.x + self.cells.x * (cell.y + self.cells.y * cell.z)) as usize
    }
}

/// The part that holds the unit vector `d`: the octahedron's faces unfolded onto a square.
fn part_of(d: Vec3) -> usize {
    let d = d / (d.x.abs() + d.y.abs() + d.z.abs());
    let (x, y) = if d.z < 0.0 {
        ((1.0 - d.y.abs()).copysign(d.x), (1.0 - d.x.abs()).copysign(d.y))
    } else {
        (d.x, d.y)
    };
    let place = |x: f32| ((0.5 * x + 0.5) * SIDE as f32).clamp(0.0, (SIDE - 1) as f32) as usize;
    place(x) + SIDE as usize * place(y)
}

/// The middle of a part.
pub fn part_direction(part: u32) -> Vec3 {
    let place = |k: u32| (k as f32 + 0.5) * 2.0 / SIDE as f32 - 1.0;
    let (x, y) = (place(part % SIDE), place(part / SIDE));
    let z = 1.0 - x.abs() - y.abs();
    let below = (-z).max(0.0);
    Vec3::new(x - below.copysign(x), y - below.copysign(y), z).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_holds_its_middle_and_the_sphere_is_covered_evenly() {
        for part in 0..DIRECTIONS {
            assert_eq!(part_of(part_direction(part)), part as usize);
        }
        let mut counts = [0_u32; DIRECTIONS as usize];
        for k in 0..64_000 {
            let z = 1.0 - 2.0 * (k as f32 + 0.5) / 64_000.0;
            let (sin, cos) = (2.399_963_f32 * k as f32).sin_cos();
            let r = (1.0 - z * z).sqrt();
            counts[part_of(Vec3::new(r * cos, r * sin, z))] += 1;
        }
        let (least, most) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
        assert!(*least > 500 && *most < 1800, "{least} to {most} of 1000");
    }
}
