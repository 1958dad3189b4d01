//!use lib/volume.wgsl
// Sampled visibility: one sample in the middle of every block of 2 x 2 x 2 voxels that holds fibres (Rust: gpu::sh9).

const BLOCK_SIDE: i32 = 2;
const BLOCKS_OF_BRICK: u32 = 8u;

// Per block nine coefficients, each with its gradient along the grid's axes (per voxel), then (1, 0, 0, 0) where the block was sampled.
const SAMPLE_ENTRIES: u32 = 10u;

// First entry of block number `inside` (x first) of a stored brick.
fn sample_at(slot: u32, inside: vec3u) -> u32 {
    return SAMPLE_ENTRIES * (slot * BLOCKS_OF_BRICK + inside.x + 2u * (inside.y + 2u * inside.z));
}
