//! Cells that few photons have met share their light with others around that few have met: light deep inside dense hair comes by few photons, each of which meets many
//! fibres there, and is smooth.

use std::collections::HashMap;

use glam::{IVec3, Vec3};

use super::DIRECTIONS;

/// Photons from which on a cell counts more than its surroundings.
const ENOUGH: f32 = 8.0;

/// No photon yet.
const NONE: u64 = u64::MAX;

/// Groups of cells: the cells themselves, then blocks of twice the edge, up to one that holds all.
pub(super) struct Pool {
    levels: Vec<Level>,
}

struct Level {
    /// Group of the next level that holds each group of this one; empty on the last level.
    parents: Vec<u32>,
    /// Different photons that were met in each group.
    photons: Vec<u32>,
    /// The last of them.
    last: Vec<u64>,
}

impl Pool {
    /// `cells` are the places of all cells with fibres.
    pub(super) fn new(mut cells: Vec<IVec3>) -> Self {
        let mut levels = Vec::new();
        while !cells.is_empty() {
            let mut numbers = HashMap::new();
            let mut blocks = Vec::new();
            let parents = if cells.len() == 1 {
                Vec::new()
            } else {
                let block_of = |cell: &IVec3| {
                    *numbers.entry(*cell >> 1).or_insert_with_key(|block| {
                        blocks.push(*block);
                        blocks.len() as u32 - 1
                    })
                };
                cells.iter().map(block_of).collect()
            };
            levels.push(Level {
                parents,
                photons: vec![0; cells.len()],
                last: vec![NONE; cells.len()],
            });
            cells = blocks;
        }
        Self { levels }
    }

    /// No photon was met.
    pub(super) fn forget(&mut self) {
        for level in &mut self.levels {
            level.photons.fill(0);
            level.last.fill(NONE);
        }
    }

    /// Photon `photon` was met in cell `cell`; a photon's meetings follow each other.
    pub(super) fn meet(&mut self, mut cell: usize, photon: u64) {
        for level in &mut self.levels {
            // Whoever was met in a block last was met in those around it.
            if level.last[cell] == photon {
                return;
            }
            level.last[cell] = photon;
            level.photons[cell] += 1;
            let Some(parent) = level.parents.get(cell) else {
                return;
            };
            cell = *parent as usize;
        }
    }

    /// Values ([`DIRECTIONS`] a cell) of which cells that few photons gave have shared theirs with those around, in proportion to their `area`: the sum
    /// of area times value stays, so that many lit cells beside few dim ones do not brighten them.
    pub(super) fn pooled(&self, values: &[Vec3], area: &[f32]) -> Vec<Vec3> {
        let parts = DIRECTIONS as usize;
        // What the groups of a level put together: mean values and their area. Where trust is whole nothing is left to the next level.
        let mut shared = vec![(values.to_vec(), area.to_vec())];
        for level in &self.levels {
            let (values, area) = &shared[shared.len() - 1];
            let Some(count) = level.parents.iter().max().map(|last| *last as usize + 1) else {
                break;
            };
            let mut sums = vec![Vec3::ZERO; count * parts];
            let mut areas = vec![0.0; count];
            for (group, (values, area)) in values.chunks(parts).zip(area).enumerate() {
                let at = level.parents[group] as usize;
                let left = *area * (1.0 - level.trust(group));
                areas[at] += left;
                for (sum, value) in sums[at * parts..].iter_mut().zip(values) {
                    *sum += left * *value;
                }
            }
            for (sums, area) in sums.chunks_mut(parts).zip(&areas) {
                sums.iter_mut()
                    .for_each(|sum| *sum /= area.max(f32::MIN_POSITIVE));
            }
            shared.push((sums, areas));
        }
        let Some((mut around, _)) = shared.pop() else {
            return Vec::new();
        };
        for (level, (mut values, _)) in self.levels.iter().zip(shared).rev() {
            for (group, values) in values.chunks_mut(parts).enumerate() {
                let trust = level.trust(group);
                let parent = level.parents[group] as usize * parts;
                for (value, around) in values.iter_mut().zip(&around[parent..]) {
                    *value = around.lerp(*value, trust);
                }
            }
            around = values;
        }
        around
    }
}

impl Level {
    /// Share of its own value that a group keeps.
    fn trust(&self, group: usize) -> f32 {
        let photons = self.photons[group] as f32;
        photons * photons / (photons * photons + ENOUGH * ENOUGH)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_few_photons_share_what_they_have_and_others_keep_their_own() {
        let cells = vec![IVec3::ZERO, IVec3::X, 5 * IVec3::X];
        let mut pool = Pool::new(cells);
        let parts = DIRECTIONS as usize;
        let values: Vec<Vec3> = [1.0, 7.0, 4.0]
            .iter()
            .flat_map(|v| vec![Vec3::splat(*v); parts])
            .collect();
        let area = [1.0, 2.0, 3.0];
        let mean = (1.0 + 14.0 + 12.0) / 6.0;
        // Nobody was met: the mean of all.
        let pooled = pool.pooled(&values, &area);
        assert!(pooled.iter().all(|v| (v.x - mean).abs() < 1e-5));
        // Many meetings of one photon are one photon.
        for photon in 0..1000 {
            pool.meet(2, photon);
            pool.meet(2, photon);
        }
        pool.meet(0, 1000);
        assert_eq!(pool.levels[0].photons, [1, 0, 1000]);
        let pooled = pool.pooled(&values, &area);
        assert!((pooled[2 * parts].x - 4.0).abs() < 1e-3);
        // The others share what they have among themselves: nothing is lost, and nothing comes from the one that many photons gave.
        let sum = pooled[0].x + 2.0 * pooled[parts].x;
        assert!((sum - 15.0).abs() < 1e-3, "{sum}");
        assert!(pooled[0].x > 4.0 && pooled[parts].x < 6.0);
        pool.forget();
        assert_eq!(pool.levels[0].photons, [0; 3]);
        assert!(Pool::new(Vec::new()).pooled(&[], &[]).is_empty());
    }
}
