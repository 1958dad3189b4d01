// Visibility of the lights of one batch at every listed point, from the sampled harmonics around it: T(w) = a + b . (w - A w_j) with the mean
// over the lobe as a and the harmonics' slope at its mean direction as b. One thread a point.
//!use lib/sh9_samples.wgsl
//!use lib/harmonics.wgsl
//!use lib/work_list.wgsl

struct Batch {
    first_light: u32,
    light_count: u32,
    point_count: u32,
}

@group(0) @binding(0) var<uniform> volume_grid: VolumeGrid;
@group(0) @binding(1) var<storage, read> volume_bricks: array<u32>;
@group(0) @binding(2) var<storage, read> volume_density: array<vec2u>; // not read here
@group(0) @binding(8) var<uniform> batch: Batch;
@group(0) @binding(3) var<storage, read> points: array<vec4f>;          // position (grid space), diameter in voxels
@group(0) @binding(4) var<storage, read> samples: array<vec4f>;
@group(0) @binding(5) var<storage, read> lights: array<LobeLight>;
@group(0) @binding(6) var<storage, read> work: WorkList;
@group(0) @binding(7) var<storage, read_write> visibility: array<vec2u>; // 4 x f16: a, b (world space)

// How fast the weight of a sample falls with its distance in blocks (Xing 2012, below Eq 7): one that is two blocks away counts 2 %.
const FALL: f32 = 2.0;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * 65535u * 64u;
    if index >= work.count { return; }
    let point = work.items[index];
    let c = around(points[point].xyz);
    for (var j = 0u; j < batch.light_count; j++) {
        let light = lights[batch.first_light + j];
        let a = clamp(lobe_mean(c, light.axis, light.mean_cosine, light.bandwidth), 0.0, 1.0);
        let b = harmonics_slope(c, light.mean_cosine * light.axis);
        visibility[j * batch.point_count + point] = vec2u(pack2x16float(vec2f(a, b.x)), pack2x16float(b.yz));
    }
}

// Weighted mean with gradient of the eight samples around `position` (Xing 2012, Eq 7); all visible where there is none.
fn around(position: vec3f) -> array<f32, 9> {
    let first = vec3i(floor(position / f32(BLOCK_SIDE) - 0.5));
    let blocks = 2 * vec3i(volume_grid.bricks);
    var sums = array<f32, 9>();
    var total = 0.0;
    for (var k = 0u; k < 8u; k++) {
        let block = first + vec3i((vec3u(k) >> vec3u(0u, 1u, 2u)) & vec3u(1u));
        if any(block < vec3i(0)) || any(block >= blocks) { continue; }
        let brick = vec3u(block) / 2u;
        let slot = volume_bricks[brick.x + volume_grid.bricks.x * (brick.y + volume_grid.bricks.y * brick.z)];
        if slot >= SOLID_BRICK { continue; }
        let at = sample_at(slot, vec3u(block) % 2u);
        if samples[at + 9u].x == 0.0 { continue; }
        let away = position - f32(BLOCK_SIDE) * (vec3f(block) + 0.5);
        let weight = exp(-FALL / f32(BLOCK_SIDE) * length(away));
        for (var i = 0u; i < 9u; i++) {
            let entry = samples[at + i];
            sums[i] += weight * (entry.x + dot(entry.yzw, away));
        }
        total += weight;
    }
    if total == 0.0 {
        sums[0] = 1.0;
        return sums;
    }
    for (var i = 0u; i < 9u; i++) { sums[i] /= total; }
    return sums;
}
