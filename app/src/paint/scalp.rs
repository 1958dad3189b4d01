//! What an operation may know of a strand beside its points: where it is rooted, how long it is, which lot it draws.
//!
//! Everything here depends on places in space alone, never on the index of a strand: the same head with fewer strands or
//! other points along them draws the same lots and falls into the same sections.

use glam::{IVec3, Vec2, Vec3};

/// A strand as operations and masks see it, in millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrandFacts {
    /// The root in the groom's own unit, exactly as in the file.
    pub root: Vec3,
    /// The root.
    pub root_mm: Vec3,
    /// Length along the strand.
    pub length_mm: f32,
}

/// Mixes 64 bits well (Steele, Lea and Flood 2014, as SplitMix64's finaliser).
fn mixed(x: u64) -> u64 {
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// A number in [0, 1) for three words, a seed and a purpose.
fn lot(words: [u32; 3], seed: u64, purpose: u32) -> f32 {
    let start = mixed(seed.wrapping_add(0x9e37_79b9_7f4a_7c15)) ^ u64::from(purpose);
    let hash = words
        .into_iter()
        .fold(mixed(start), |hash, word| mixed(hash ^ u64::from(word)));
    (hash >> 40) as f32 / (1u64 << 24) as f32
}

impl StrandFacts {
    /// The strand's lot in [0, 1) for a seed; different purposes draw independently.
    pub fn lot(&self, seed: u64, purpose: u32) -> f32 {
        // Adding zero turns -0 into 0, which is the same place.
        lot(self.root.to_array().map(|x| (x + 0.0).to_bits()), seed, purpose)
    }

    /// The section of the scalp that the root belongs to.
    pub fn section(&self, size_mm: f32, seed: u64) -> Section {
        section_of(self.root_mm, size_mm, seed)
    }
}

/// A sub-section of the scalp: one cell of a cellular pattern (Worley 1996), about as wide as it was asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// The cell of the section's centre.
    cell: IVec3,
    /// 0 in the middle of the section, 1 where it meets the next one.
    pub rim: f32,
}

impl Section {
    /// The section's lot in [0, 1).
    pub fn lot(&self, seed: u64, purpose: u32) -> f32 {
        lot(self.cell.to_array().map(|i| i as u32), seed, purpose)
    }
}

/// The section of `place`: the nearest of one centre per cube, each somewhere in its cube.
fn section_of(place: Vec3, size: f32, seed: u64) -> Section {
    let place = place / size;
    let home = place.floor().as_ivec3();
    let (mut nearest, mut second) = ((f32::INFINITY, home), f32::INFINITY);
    for i in 0..27 {
        let cell = home + IVec3::new(i % 3, i / 3 % 3, i / 9) - 1;
        let words = cell.to_array().map(|i| i as u32);
        let offset = Vec3::from_array(std::array::from_fn(|axis| lot(words, seed, 100 + axis as u32)));
        let distance = place.distance(cell.as_vec3() + offset);
        if distance < nearest.0 {
            second = nearest.0;
            nearest = (distance, cell);
        } else {
            second = second.min(distance);
        }
    }
    let sum = nearest.0 + second;
    Section {
        cell: nearest.1,
        rim: if sum > 0.0 { 2.0 * nearest.0 / sum } else { 0.0 },
    }
}

/// A closed outline on the scalp, laid flat: which places are inside, and how far from its rim.
#[derive(Clone, Debug)]
pub struct Outline {
    centre: Vec3,
    right: Vec3,
    up: Vec3,
    corners: Vec<Vec2>,
    radius: f32,
}

impl Outline {
    /// Lays `places` flat on the plane that fits them best (Newell's normal); none where they enclose nothing.
    pub fn new(places: &[Vec3]) -> Option<Self> {
        let centre = places.iter().sum::<Vec3>() / places.len().max(1) as f32;
        let normal = places
            .iter()
            .zip(places.iter().cycle().skip(1))
            .map(|(a, b)| (*a - centre).cross(*b - centre))
            .sum::<Vec3>()
            .try_normalize()?;
        let right = normal.any_orthonormal_vector();
        let up = normal.cross(right);
        let flat = |p: &Vec3| Vec2::new((*p - centre).dot(right), (*p - centre).dot(up));
        let corners: Vec<Vec2> = places.iter().map(flat).collect();
        let radius = corners.iter().map(|c| c.length()).fold(0.0, f32::max);
        Some(Self {
            centre,
            right,
            up,
            corners,
            radius,
        })
    }

    /// Distance of `place` from the rim, positive inside; the other side of the head, beyond the outline's own radius from its
    /// plane, is outside.
    pub fn depth(&self, place: Vec3) -> f32 {
        let from_centre = place - self.centre;
        let flat = Vec2::new(from_centre.dot(self.right), from_centre.dot(self.up));
        if (from_centre.length_squared() - flat.length_squared())
            .max(0.0)
            .sqrt()
            > self.radius
        {
            return f32::NEG_INFINITY;
        }
        let (mut inside, mut distance) = (false, f32::INFINITY);
        for (a, b) in self.corners.iter().zip(self.corners.iter().cycle().skip(1)) {
            let edge = *b - *a;
            let t = ((flat - *a).dot(edge) / edge.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
            distance = distance.min(flat.distance(*a + t * edge));
            // A ray to the right crosses the edge.
            if (a.y > flat.y) != (b.y > flat.y) && flat.x < a.x + (flat.y - a.y) / (b.y - a.y) * edge.x {
                inside = !inside;
            }
        }
        if inside { distance } else { -distance }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lots_are_even_and_independent() {
        let facts = |i: u32| StrandFacts {
            root: Vec3::new(i as f32 * 0.01, 0.0, 1.0),
            root_mm: Vec3::ZERO,
            length_mm: 1.0,
        };
        let lots: Vec<[f32; 2]> = (0..4000)
            .map(|i| [facts(i).lot(7, 0), facts(i).lot(7, 1)])
            .collect();
        let share = lots.iter().filter(|l| l[0] < 0.2).count() as f32 / 4000.0;
        let both = lots.iter().filter(|l| l[0] < 0.5 && l[1] < 0.5).count() as f32 / 4000.0;
        assert!(
            (share - 0.2).abs() < 0.03 && (both - 0.25).abs() < 0.03,
            "{share} {both}"
        );
        assert!(facts(3).lot(7, 0) != facts(3).lot(8, 0));
    }

    #[test]
    fn sections_are_connected_patches_of_their_size() {
        let at = |x: f32| section_of(Vec3::new(x, 3.0, 5.0), 20.0, 1);
        let changes = (0..4000)
            .filter(|i| at(0.25 * *i as f32).cell != at(0.25 * (*i + 1) as f32).cell)
            .count();
        assert!((20..120).contains(&changes), "{changes} borders in a metre");
        assert!((0..400).all(|i| (0.0..=1.0).contains(&at(2.5 * i as f32).rim)));
    }

    #[test]
    fn outlines_know_their_inside() {
        let square = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)].map(|(x, z)| Vec3::new(x, 7.0, z));
        let outline = Outline::new(&square).unwrap();
        assert!((outline.depth(Vec3::new(1.0, 7.2, 2.0)) - 1.0).abs() < 1e-5);
        assert!((outline.depth(Vec3::new(5.0, 7.0, 2.0)) + 1.0).abs() < 1e-5);
        assert!(
            outline.depth(Vec3::new(2.0, -7.0, 2.0)) < 0.0,
            "the other side of the head"
        );
        assert!(Outline::new(&[Vec3::ONE; 5]).is_none() && Outline::new(&[]).is_none());
    }
}
