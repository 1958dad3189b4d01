// Gives every pixel of the band its part of the fragment buffer. The order of the parts does not matter: lists are sorted by depth.

@group(0) @binding(0) var<uniform> pixel_count: u32;
@group(0) @binding(1) var<storage, read_write> counts: array<u32>;
@group(0) @binding(2) var<storage, read_write> offsets: array<u32>;
@group(0) @binding(3) var<storage, read_write> total: atomic<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let p = id.x + id.y * 65535u * 64u;
    if p >= pixel_count { return; }
    offsets[p] = atomicAdd(&total, counts[p]);
    counts[p] = 0u;
}
