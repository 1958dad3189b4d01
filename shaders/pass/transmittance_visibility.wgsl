// Visibility of one light at every listed point: T(w) = a + b . (w - A w_j), fitted to exp(-n) along the light's directions.
// Depends on geometry and lights only.
//!use lib/volume.wgsl
//!use lib/light_run.wgsl
//!use lib/work_list.wgsl

@group(0) @binding(0) var<uniform> volume_grid: VolumeGrid;
@group(0) @binding(1) var<storage, read> volume_bricks: array<u32>;
@group(0) @binding(2) var<storage, read> volume_density: array<vec2u>;
@group(0) @binding(3) var<storage, read> points: array<vec4f>;          // position (grid space), diameter in voxels
@group(0) @binding(4) var<storage, read> point_ends: array<u32>;        // bit 0: root, bit 1: tip
@group(0) @binding(5) var<storage, read> lights: array<LobeLight>;
@group(0) @binding(6) var<storage, read> directions: array<LobeDirection>;
@group(0) @binding(7) var<storage, read> runs: array<LightRun>;
@group(0) @binding(8) var<storage, read_write> visibility: array<vec2u>; // 4 x f16: a, b (world space)
@group(0) @binding(9) var<storage, read> work: WorkList;            // points to march from

// Transmittances below e^-6 count as zero.
const N_MAX: f32 = 6.0;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * 65535u * 64u;
    if index >= work.count * arrayLength(&runs) { return; }
    let run = runs[index / work.count];
    let point = work.items[index % work.count];
    let light = lights[run.light];
    let here = points[point];
    let ends = point_ends[point];
    let own = own_strand(here, points[max(point, 1u) - 1u].xyz, points[min(point + 1u, run.point_count - 1u)].xyz, ends);
    let angle = turn_angle(point, run.light);
    let turn = vec2f(cos(angle), sin(angle));

    var a = 0.0;
    var b = vec3f(0.0);
    for (var k = 0u; k < light.visibility_count; k++) {
        let direction = directions[light.first_visibility + k];
        let n = march(here.xyz, world_from_lobe(light, direction.local, turn), own, N_MAX);
        let transmittance = select(exp(-n), 0.0, n >= N_MAX);
        a += direction.weight_a * transmittance;
        b += direction.weight_b * transmittance;
    }
    let world_b = world_from_lobe(light, b, turn);
    visibility[run.first_record + point] = vec2u(pack2x16float(vec2f(a, world_b.x)), pack2x16float(world_b.yz));
}
