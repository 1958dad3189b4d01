// Path sums of one light at every listed point: what crosses the hair towards the point by forward scattering, how far it spreads, and how
// much hair lies behind. Depends on geometry, lights and paint.
//!use lib/volume.wgsl
//!use lib/light_run.wgsl
//!use lib/work_list.wgsl
//!use lib/dirty_box.wgsl
//!use lib/marks.wgsl

@group(0) @binding(0) var<uniform> volume_grid: VolumeGrid;
@group(0) @binding(1) var<storage, read> volume_bricks: array<u32>;
@group(0) @binding(2) var<storage, read> volume_density: array<vec2u>;
@group(0) @binding(3) var<storage, read> points: array<vec4f>;          // position (grid space), diameter in voxels
@group(0) @binding(4) var<storage, read> point_ends: array<u32>;        // bit 0: root, bit 1: tip
@group(0) @binding(5) var<storage, read> lights: array<LobeLight>;
@group(0) @binding(6) var<storage, read> directions: array<LobeDirection>;
@group(0) @binding(7) var<storage, read> runs: array<LightRun>;
@group(0) @binding(8) var<storage, read> voxel_forward: array<vec4u>;
@group(0) @binding(9) var<storage, read> voxel_behind: array<vec4u>;
@group(0) @binding(10) var<storage, read_write> paths: array<vec4u>;    // 8 x f16: S_f rgb, spread, 2 sum k rgb, n
@group(0) @binding(11) var<storage, read> work: WorkList;            // points to march from
@group(0) @binding(12) var<storage, read> boxes: array<DirtyBox>;       // new paint, where records are written again
@group(0) @binding(13) var<storage, read_write> marks: Marks;           // rays marched and points whose record changed, where records are written again

// Sums above stand for nothing that could be seen: towards the light, behind. Light that was turned round dies away with k, in white hair far slower than
// with S_f; no hair is deeper than DEEPEST.
const SUM_MAX: f32 = 6.0;
const BEHIND_MAX: f32 = 3.0;
const DEEPEST: f32 = 80.0;

// How far S_f of a lobe deep in hair goes from -ln of the mean of exp(-S_f) towards its plain mean: at this a white furnace stays level to its
// middle (bench furnace).
const DEEP_MEAN: f32 = 0.25;

struct PathSums {
    s_f: vec3f,              // sum of (1 - a_f)
    spread: f32,             // sum of beta_f^2
    n: f32,                  // optical depth: exp(-n) cross no fibre
    blocked: bool,
}

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

    if (run.is_again != 0u) {
        if (!meets_paint(here.xyz, light, turn)) {
            return;
        }
        atomicAdd(&marks.count, light.path_count + 1u);
    }

    // Towards the light: means of exp(-S_f) and exp(-n) over the lobe, and of the spread where light is scattered forward at all.
    var t_f = vec3f(0.0);
    var all_f = vec3f(0.0);
    var t_direct = 0.0;
    var spread = 0.0;
    var spread_weight = 0.0;
    for (var k = 0u; k < light.path_count; k++) {
        let w = world_from_lobe(light, directions[light.first_path + k].local, turn);
        let sums = march_forward(here.xyz, w, own);
        all_f += select(sums.s_f, vec3f(DEEPEST), sums.blocked);
        if (!sums.blocked) {
            let direct = exp(-sums.n);
            let arriving = exp(-sums.s_f);
            t_f += arriving;
            t_direct += direct;
            let scattered = max(dot(arriving, vec3f(1.0 / 3.0)) - direct, 1e-6);
            spread += scattered * sums.spread / max(1.0 - direct, 1e-6);
            spread_weight += scattered;
        }
    }
    let count = f32(light.path_count);
    let n = -log(max(t_direct / count, exp(-SUM_MAX)));
    // Far too small for a 16-bit float themselves.
    let arriving_f = -log(max(t_f / count, vec3f(exp(-DEEPEST))));
    // Where nothing arrives but what turned round, and dies away with k, S_f stands for the sum of k.
    let deep = smoothstep(vec3f(0.5 * SUM_MAX), vec3f(SUM_MAX), arriving_f);
    let s_f = mix(arriving_f, min(all_f / count, vec3f(DEEPEST)), DEEP_MEAN * deep);
    let kappa = 2.0 * march_behind(here.xyz, -light.axis, own);
    let record = vec4u(
        pack2x16float(s_f.xy),
        pack2x16float(vec2f(s_f.z, spread / max(spread_weight, 1e-6))),
        pack2x16float(kappa.xy),
        pack2x16float(vec2f(kappa.z, n)),
    );
    let at = run.first_record + point;
    if (run.is_again != 0u && any(record != paths[at])) {
        marks.items[point] = 1u;
    }
    paths[at] = record;
}

// Whether a way of the record, towards the light or behind, meets new paint.
fn meets_paint(start: vec3f, light: LobeLight, turn: vec2f) -> bool {
    for (var b = 0u; b < arrayLength(&boxes); b++) {
        if (meets_box(boxes[b], start, -light.axis)) {
            return true;
        }
        for (var k = 0u; k < light.path_count; k++) {
            if (meets_box(boxes[b], start, world_from_lobe(light, directions[light.first_path + k].local, turn))) {
                return true;
            }
        }
    }
    return false;
}

fn march_forward(start: vec3f, w: vec3f, own: OwnStrand) -> PathSums {
    var m = march_begin(start, w, own, 0.0);
    var crossing: Crossing;
    var sums: PathSums;
    var turned = vec3f(0.0);
    while (any((sums.s_f < vec3f(SUM_MAX)) | (turned < vec3f(SUM_MAX))) && any(sums.s_f < vec3f(DEEPEST)) && march_next(&m, &crossing)) {
        if (crossing.blocked) {
            sums.blocked = true;
            break;
        }
        let words = voxel_forward[crossing.voxel];
        let across = vec4f(unpack2x16float(words.x), unpack2x16float(words.y));
        let slope = vec4f(unpack2x16float(words.z), unpack2x16float(words.w));
        let loss = max(across + crossing.sin2_theta * slope, vec4f(0.0));
        let lost = min(loss.xyz, vec3f(1.0));
        sums.s_f += vec3f(optical_depth(crossing, lost.x), optical_depth(crossing, lost.y), optical_depth(crossing, lost.z));
        turned += crossing.expected * decay_in(crossing);
        sums.spread += crossing.expected * loss.w;
        sums.n += optical_depth(crossing, 1.0);
    }
    return sums;
}

// Sum of k per channel; the occluder ends the path.
fn march_behind(start: vec3f, w: vec3f, own: OwnStrand) -> vec3f {
    var m = march_begin(start, w, own, 0.0);
    var crossing: Crossing;
    var sum = vec3f(0.0);
    while (min(sum.x, min(sum.y, sum.z)) < BEHIND_MAX && march_next(&m, &crossing) && !crossing.blocked) {
        sum += crossing.expected * decay_in(crossing);
    }
    return sum;
}

// k of a fibre of the voxel that is crossed.
fn decay_in(crossing: Crossing) -> vec3f {
    let words = voxel_behind[crossing.voxel];
    let across = vec3f(unpack2x16float(words.x), unpack2x16float(words.y).x);
    let slope = vec3f(unpack2x16float(words.z), unpack2x16float(words.w).x);
    return clamp(across + crossing.sin2_theta * slope, vec3f(0.0), vec3f(1.0));
}
