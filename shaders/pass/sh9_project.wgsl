// Visibility of every block of voxels that holds fibres, as nine spherical harmonics and their gradients in space (Xing 2012, section 5).
// Some of the directions a dispatch; dispatches add up. One thread a block of the brick table.
//!use lib/sh9_samples.wgsl
//!use lib/harmonics.wgsl

struct Projection {
    first_direction: u32,
    direction_count: u32,     // of this dispatch
    all_directions: u32,
    diameter: f32,            // mean of the fibres, voxels
}

@group(0) @binding(0) var<uniform> volume_grid: VolumeGrid;
@group(0) @binding(1) var<storage, read> volume_bricks: array<u32>;
@group(0) @binding(2) var<storage, read> volume_density: array<vec2u>;
@group(0) @binding(3) var<uniform> projection: Projection;
@group(0) @binding(4) var<storage, read> directions: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> samples: array<vec4f>;

// Transmittances below e^-6 count as zero.
const N_MAX: f32 = 6.0;

// Four starts around a block's middle, a regular tetrahedron: means and slopes come from the same marches.
const STARTS = array<vec3f, 4>(vec3f(0.5, 0.5, 0.5), vec3f(0.5, -0.5, -0.5), vec3f(-0.5, 0.5, -0.5), vec3f(-0.5, -0.5, 0.5));

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * 65535u * 64u;
    let number = index / BLOCKS_OF_BRICK;
    if number >= volume_grid.bricks.x * volume_grid.bricks.y * volume_grid.bricks.z { return; }
    let slot = volume_bricks[number];
    let inside = (vec3u(index) >> vec3u(0u, 1u, 2u)) & vec3u(1u);
    if slot >= SOLID_BRICK || !holds_fibres(slot, inside) { return; }
    let brick = vec3u(number, number / volume_grid.bricks.x, number / (volume_grid.bricks.x * volume_grid.bricks.y)) % volume_grid.bricks;
    let middle = f32(BLOCK_SIDE) * (vec3f(2u * brick + inside) + 0.5);

    // A fibre of no direction is not left out of the march; its width is what fibres have.
    let nothing = OwnStrand(vec3f(0.0), vec3f(0.0), projection.diameter);
    var starts = STARTS;
    var sums: array<vec4f, 9>;
    for (var k = 0u; k < projection.direction_count; k++) {
        let w = directions[projection.first_direction + k].xyz;
        var seen = vec4f(0.0);
        for (var s = 0; s < 4; s++) {
            let offset = starts[s];
            let n = march(middle + offset, w, nothing, N_MAX);
            let transmittance = select(exp(-n), 0.0, n >= N_MAX);
            // The starts' offsets have sum 0 and second moments 1.
            seen += transmittance * vec4f(0.25, offset);
        }
        let y = harmonics(w);
        for (var i = 0; i < 9; i++) {
            sums[i] += y[i] * seen / f32(projection.all_directions);
        }
    }
    let first = sample_at(slot, inside);
    for (var i = 0u; i < 9u; i++) {
        samples[first + i] += sums[i];
    }
    samples[first + 9u] = vec4f(1.0, 0.0, 0.0, 0.0);
}

// True where one of the block's eight voxels holds hair (those inside an occluder hold none).
fn holds_fibres(slot: u32, inside: vec3u) -> bool {
    for (var k = 0u; k < 8u; k++) {
        let at = 2u * inside + ((vec3u(k) >> vec3u(0u, 1u, 2u)) & vec3u(1u));
        let voxel = slot * BRICK_VOXELS + at.x + u32(BRICK_SIDE) * (at.y + u32(BRICK_SIDE) * at.z);
        let rho = unpack2x16float(volume_density[voxel].x).x;
        if rho > 0.0 && rho < SOLID_RHO { return true; }
    }
    return false;
}
