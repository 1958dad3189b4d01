//! Where paint changed voxels: boxes that a way has to cross for its sums to change.

use std::collections::BTreeMap;

use bytemuck::{Pod, Zeroable};
use glam::UVec3;

use crate::volume::{BRICK_SIDE, BRICK_VOXELS};

/// A box in grid space; layout of `DirtyBox` in `shaders/lib/dirty_box.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct DirtyBox {
    low: [f32; 3],
    pad: f32,
    high: [f32; 3],
    pad_end: f32,
}

/// Every way is held against each box: more boxes than these cost more than they save.
const MOST_BOXES: usize = 16;

/// Edge of the cells that voxels are gathered in, voxels, where they are few.
const CELL: u32 = 8;

/// What a sample of a march may lie outside of its voxel by rounding, voxels.
const ROUNDING: f32 = 0.02;

/// Boxes around stored voxels; `stored_bricks` are the places of the bricks that are stored, in bricks.
pub(super) fn boxes_around(stored_bricks: &[UVec3], voxels: &[u32]) -> Vec<DirtyBox> {
    let place = |voxel: u32| {
        let inside = voxel % BRICK_VOXELS;
        let inside = UVec3::new(
            inside % BRICK_SIDE,
            inside / BRICK_SIDE % BRICK_SIDE,
            inside / (BRICK_SIDE * BRICK_SIDE),
        );
        BRICK_SIDE * stored_bricks[(voxel / BRICK_VOXELS) as usize] + inside
    };
    let mut cell = CELL;
    loop {
        let mut boxes = BTreeMap::new();
        for at in voxels.iter().map(|voxel| place(*voxel)) {
            let (low, high) = boxes.entry((at / cell).to_array()).or_insert((at, at));
            (*low, *high) = (low.min(at), high.max(at));
        }
        if boxes.len() <= MOST_BOXES {
            let of_corners = |(low, high): (UVec3, UVec3)| DirtyBox {
                low: (low.as_vec3() - ROUNDING).to_array(),
                pad: 0.0,
                high: (high.as_vec3() + 1.0 + ROUNDING).to_array(),
                pad_end: 0.0,
            };
            return boxes.into_values().map(of_corners).collect();
        }
        cell *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_voxel_is_in_a_box_and_boxes_are_few_and_tight() {
        // Two dabs far apart in a row of bricks, then a stroke along all of it.
        let bricks: Vec<UVec3> = (0..400).map(|x| UVec3::new(x, 0, 0)).collect();
        let dabs: Vec<u32> = (0..128).chain(300 * 64..302 * 64).collect();
        let boxes = boxes_around(&bricks, &dabs);
        let length: f32 = boxes.iter().map(|b| b.high[0] - b.low[0]).sum();
        assert!(boxes.len() <= MOST_BOXES && length < 17.0, "{boxes:?}");
        let stroke: Vec<u32> = (0..400 * 64).collect();
        let boxes = boxes_around(&bricks, &stroke);
        assert!(boxes.len() <= MOST_BOXES && boxes.len() > 1);
        for x in [0.5, 800.5, 1599.5] {
            let holds = |b: &&DirtyBox| b.low[0] < x && x < b.high[0] && b.high[1] > 3.9;
            assert_eq!(boxes.iter().filter(holds).count(), 1, "{x}");
        }
        assert!(boxes_around(&bricks, &[]).is_empty());
    }
}
