// What the paint adds to stored voxels, all or those of a list: losses per crossed fibre, from the mean absorption of the fibres in it.
// A loss is kept as its value across the fibre and its change with sin^2 theta.
//!use lib/types.wgsl
//!use lib/averages_table.wgsl

struct Share {
    point: u32,              // first point of the segment
    fraction_weight: u32,    // 2 x f16: place on the segment, share of the voxel's projected area
}

// Which voxels.
struct PaintRun {
    count: u32,
    is_listed: u32,          // 0: the first `count` voxels
}

@group(0) @binding(0) var<storage, read> first_share: array<u32>;
@group(0) @binding(1) var<storage, read> shares: array<Share>;
@group(0) @binding(2) var<storage, read> params: array<VertexParams>;
@group(0) @binding(3) var<storage, read> averages_table: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> voxel_forward: array<vec4u>;  // 8 x f16: 1 - a_f (rgb) and beta_f^2 at theta 0; their slopes
@group(0) @binding(5) var<storage, read_write> voxel_behind: array<vec4u>;   // 8 x f16: k (rgb) and 0 at theta 0; their slopes

@group(0) @binding(6) var<uniform> run: PaintRun;
@group(0) @binding(7) var<storage, read> listed: array<u32>;

// The second inclination that the slopes are taken from, and its squared sine.
const THETA_STEEP: f32 = 0.9599311;
const SIN2_STEEP: f32 = 0.6710101;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * 65535u * 64u;
    if (index >= run.count) {
        return;
    }
    let voxel = select(index, listed[min(index, arrayLength(&listed) - 1u)], run.is_listed != 0u);
    let begin = first_share[voxel];
    let end = first_share[voxel + 1u];
    if (begin == end) {
        return;
    }
    var sigma_a = vec3f(0.0);
    for (var i = begin; i < end; i++) {
        let share = shares[i];
        let place = unpack2x16float(share.fraction_weight);
        sigma_a += place.y * mix(params[share.point].sigma_a, params[share.point + 1u].sigma_a, place.x);
    }

    var forward = vec4f(0.0);
    var forward_steep = vec4f(0.0);
    var behind = vec3f(0.0);
    var behind_steep = vec3f(0.0);
    for (var c = 0; c < 3; c++) {
        let across = fibre_averages(sigma_a[c], 0.0);
        let up = fibre_averages(sigma_a[c], THETA_STEEP);
        let down = fibre_averages(sigma_a[c], -THETA_STEEP);
        forward[c] = 1.0 - across.a_f;
        forward_steep[c] = 1.0 - 0.5 * (up.a_f + down.a_f);
        behind[c] = across.k;
        behind_steep[c] = 0.5 * (up.k + down.k);
        forward.w += across.beta_f * across.beta_f / 3.0;
        forward_steep.w += (up.beta_f * up.beta_f + down.beta_f * down.beta_f) / 6.0;
    }
    voxel_forward[voxel] = pack8(forward, (forward_steep - forward) / SIN2_STEEP);
    voxel_behind[voxel] = pack8(vec4f(behind, 0.0), vec4f((behind_steep - behind) / SIN2_STEEP, 0.0));
}

fn pack8(a: vec4f, b: vec4f) -> vec4u {
    return vec4u(pack2x16float(a.xy), pack2x16float(a.zw), pack2x16float(b.xy), pack2x16float(b.zw));
}
