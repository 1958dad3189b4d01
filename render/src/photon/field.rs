//! Radiance in cells of the hair, by direction.

use std::f32::consts::{FRAC_2_PI, FRAC_PI_4};

use bytemuck::{Pod, Zeroable};
use glam::{IVec3, Vec3};
use half::f16;

use super::pool::Pool;
use crate::volume::{Strands, clip_segment, occupied_cells};

/// Parts of the sphere per side of the octahedral map.
const SIDE: u32 = 8;
/// Parts that the sphere of directions is divided into; the same constant stands in `shaders/lib/part.wgsl`.
pub const DIRECTIONS: u32 = SIDE * SIDE;

/// Entry of a cell without fibres.
const EMPTY: u32 = u32::MAX;

/// Most cells along one axis.
const MAX_CELLS: i32 = 256;
/// Most cells with fibres, about: their radiance takes 64 MiB.
const MOST_CELLS: usize = 1 << 17;

/// Largest stored value: half floats end at 65,504.
const LARGEST: f32 = 1024.0;

/// Placement and scale of a field, same layout as `LightFieldGrid` in `shaders/pass/shade_field.wgsl`.
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
    /// Of the fibres' projected area what beams from each part meet in the mean, groom's unit squared: [`DIRECTIONS`] a cell.
    met: Vec<f32>,
    /// Radiance times solid angle of each part, summed over photons: [`DIRECTIONS`] a cell.
    sums: Vec<Vec3>,
    pool: Pool,
}

impl LightField {
    /// Dark cells of edge `cell` around the strands, larger ones where more than 256 would stand along an axis or some 131,000 hold fibres.
    pub fn new(strands: &Strands<'_>, cell: f32) -> Self {
        let (low, high) = strands.bounds();
        let mut cell = cell.max((high - low).max_element() / (MAX_CELLS - 1) as f32);
        loop {
            let times = occupied_cells(strands, low, cell.into()) as f32 / MOST_CELLS as f32;
            if times <= 1.0 {
                break;
            }
            cell *= times.cbrt().max(1.02);
        }
        let cells = ((high - low) / cell).ceil().as_ivec3().max(IVec3::ONE);
        let mut field = Self {
            low,
            cell,
            cells,
            numbers: vec![EMPTY; (cells.x * cells.y * cells.z) as usize],
            area: Vec::new(),
            places: Vec::new(),
            met: Vec::new(),
            sums: Vec::new(),
            pool: Pool::new(Vec::new()),
        };
        let mut places = Vec::new();
        let directions: Vec<[Vec3; 4]> = (0..DIRECTIONS).map(part_directions).collect();
        let in_cells = |p: Vec3| (p - low) / cell;
        for i in (0..strands.strand_count()).flat_map(|strand| strands.segments(strand)) {
            let (a, b) = (strands.positions[i], strands.positions[i + 1]);
            let area = 0.5 * (strands.diameters[i] + strands.diameters[i + 1]) * a.distance(b);
            let t = (b - a).normalize_or_zero();
            let across: Vec<f32> = directions
                .iter()
                .map(|quarters| {
                    let sines = quarters.map(|d| (1.0 - d.dot(t) * d.dot(t)).max(0.0).sqrt());
                    0.25 * sines.iter().sum::<f32>()
                })
                .collect();
            let (a, b) = (in_cells(a), in_cells(b));
            clip_segment(a.as_dvec3(), b.as_dvec3(), |voxel, t0, t1| {
                let at = field.index(IVec3::from_array(voxel));
                if field.numbers[at] == EMPTY {
                    field.numbers[at] = field.area.len() as u32;
                    places.push(IVec3::from_array(voxel).clamp(IVec3::ZERO, cells - 1));
                    field.area.push(0.0);
                    field.places.push(Vec3::ZERO);
                    field.met.resize(field.met.len() + directions.len(), 0.0);
                }
                let number = field.numbers[at] as usize;
                let share = area * (t1 - t0) as f32;
                field.area[number] += share;
                field.places[number] += a.lerp(b, 0.5 * (t0 + t1) as f32) * share;
                for (met, across) in field.met[number * directions.len()..].iter_mut().zip(&across) {
                    *met += share * across;
                }
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
        if number >= self.area.len() {
            return;
        }
        // Radiance is power over what of the fibres beams meet, here those that the part is looked up with: the fibres get back the power that they
        // met.
        let at = number * DIRECTIONS as usize + part_of(towards);
        if self.met[at] > 0.0 {
            self.sums[at] += power / self.met[at];
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

/// The part that holds the unit vector `d`: the octahedron's faces unfolded onto a square, all parts of one solid angle (Clarberg 2008, "Fast Equal-Area
/// Mapping of the (Hemi)Sphere using SIMD").
fn part_of(d: Vec3) -> usize {
    let r = (1.0 - d.z.abs()).max(0.0).sqrt();
    let y = r * d.y.abs().atan2(d.x.abs()) * FRAC_2_PI;
    let (x, y) = if d.z < 0.0 {
        (1.0 - y, 1.0 - (r - y))
    } else {
        (r - y, y)
    };
    let place = |x: f32, sign: f32| {
        ((0.5 * x.copysign(sign) + 0.5) * SIDE as f32).clamp(0.0, (SIDE - 1) as f32) as usize
    };
    place(x, d.x) + SIDE as usize * place(y, d.y)
}

/// The middles of a part's quarters, which stand for its directions.
pub fn part_directions(part: u32) -> [Vec3; 4] {
    let place = |k: u32| (k as f32 + 0.5) / SIDE as f32 - 1.0;
    std::array::from_fn(|quarter| {
        let quarter = quarter as u32;
        let (x, y) = (
            place(2 * (part % SIDE) + (quarter & 1)),
            place(2 * (part / SIDE) + (quarter >> 1)),
        );
        let above = 1.0 - x.abs() - y.abs();
        let r = 1.0 - above.abs();
        let (sin, cos) = (((y.abs() - x.abs()) / r + 1.0) * FRAC_PI_4).sin_cos();
        let across = r * (2.0 - r * r).sqrt();
        Vec3::new(
            (across * cos).copysign(x),
            (across * sin).copysign(y),
            (1.0 - r * r).copysign(above),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_wide_hair_are_as_many_as_a_buffer_holds() {
        // Short strands on a lattice of unit pitch, each alone in its cell.
        let positions: Vec<Vec3> = (0..300_000)
            .map(|k| IVec3::new(k % 68, k / 68 % 68, k / (68 * 68)).as_vec3())
            .flat_map(|root| [root, root + 0.2])
            .collect();
        let strands = Strands {
            positions: &positions,
            diameters: &vec![0.1; positions.len()],
            first_point: &(0..=300_000).map(|k| 2 * k).collect::<Vec<_>>(),
        };
        assert!(occupied_cells(&strands, strands.bounds().0, 0.5) > 2 * MOST_CELLS);
        let field = LightField::new(&strands, 0.5);
        let count = field.area.len();
        assert!(
            count > MOST_CELLS / 2 && count < MOST_CELLS + MOST_CELLS / 8,
            "{count}"
        );
    }

    #[test]
    fn every_part_holds_its_middle_and_the_sphere_is_covered_evenly() {
        for part in 0..DIRECTIONS {
            for direction in part_directions(part) {
                assert!((direction.length() - 1.0).abs() < 1e-6);
                assert_eq!(part_of(direction), part as usize);
            }
        }
        let mut counts = [0_u32; DIRECTIONS as usize];
        for k in 0..64_000 {
            let z = 1.0 - 2.0 * (k as f32 + 0.5) / 64_000.0;
            let (sin, cos) = (2.399_963_f32 * k as f32).sin_cos();
            let r = (1.0 - z * z).sqrt();
            counts[part_of(Vec3::new(r * cos, r * sin, z))] += 1;
        }
        let (least, most) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
        assert!(*least > 980 && *most < 1020, "{least} to {most} of 1000");
    }
}
