// Visibility of one light at every listed point, refined: T(w) = a + b . (w - A w_j) fitted to exact rays, which another strand stops or
// not, joined with the record of the march through the voxels; a part of the rays at a time. Depends on geometry and lights only.
//!use lib/volume.wgsl
//!use lib/light_run.wgsl
//!use lib/work_list.wgsl

@group(0) @binding(0) var<uniform> volume_grid: VolumeGrid;
@group(0) @binding(1) var<storage, read> volume_bricks: array<u32>;
@group(0) @binding(2) var<storage, read> volume_density: array<vec2u>;
@group(0) @binding(3) var<storage, read> points: array<vec4f>;          // position (grid space), diameter in voxels
@group(0) @binding(4) var<storage, read> point_ends: array<u32>;        // strand * 4, bit 0: root, bit 1: tip
@group(0) @binding(5) var<storage, read> lights: array<LobeLight>;
@group(0) @binding(6) var<storage, read> directions: array<LobeDirection>;
@group(0) @binding(7) var<storage, read> runs: array<LightRun>;
@group(0) @binding(8) var<storage, read_write> visibility: array<vec2u>; // 4 x f16: a, b (world space)
@group(0) @binding(9) var<storage, read> work: WorkList;                // points to trace from
@group(0) @binding(10) var<storage, read> first_share: array<u32>;      // per voxel, its fibres in `shares`
@group(0) @binding(11) var<storage, read> shares: array<vec2u>;         // first point of a segment, its place and weight

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * 65535u * 64u;
    if index >= work.count * arrayLength(&runs) { return; }
    let run = runs[index / work.count];
    let point = work.items[index % work.count];
    let light = lights[run.light];
    let start = points[point].xyz;
    let angle = turn_angle(point, run.light);
    let turn = vec2f(cos(angle), sin(angle));

    var a = 0.0;
    var b = vec3f(0.0);
    for (var k = run.first_ray; k < run.end_ray; k++) {
        let direction = directions[light.first_visibility + k];
        if is_free(start, world_from_lobe(light, direction.local, turn), point_ends[point] >> 2u) {
            a += direction.weight_a;
            b += direction.weight_b;
        }
    }
    // The march saw less noise and less truth: it counts like a few rays.
    let record = run.first_record + point;
    let there = vec4f(unpack2x16float(visibility[record].x), unpack2x16float(visibility[record].y));
    let before = select(1.0, run.prior, run.first_ray == 0u) * there;
    let seen = before + (1.0 - run.prior) * vec4f(a, world_from_lobe(light, b, turn));
    visibility[record] = vec2u(pack2x16float(seen.xy), pack2x16float(seen.zw));
}

// True where neither a fibre of another strand nor the occluder stops the ray from `start` (grid space) along the unit vector w.
fn is_free(start: vec3f, w: vec3f, strand: u32) -> bool {
    let last = vec3i(volume_grid.bricks) * BRICK_SIDE - 1;
    // A vanishing component would make 0 * infinity; its faces are never reached anyway.
    let safe_w = select(w, vec3f(1e-8), abs(w) < vec3f(1e-8));
    let inverse = 1.0 / safe_w;
    let ahead = safe_w > vec3f(0.0);
    let leave = max(-start * inverse, (vec3f(last + 1) - start) * inverse);
    let t_end = min(leave.x, min(leave.y, leave.z));
    var t = 0.0;
    while t < t_end {
        let voxel = clamp(vec3i(floor(start + t * safe_w)), vec3i(0), last);
        let brick = vec3u(voxel) / u32(BRICK_SIDE);
        let slot = volume_bricks[brick.x + volume_grid.bricks.x * (brick.y + volume_grid.bricks.y * brick.z)];
        let stored = slot < SOLID_BRICK;
        let side = select(BRICK_SIDE, 1, stored);
        let low = vec3f(voxel / side * side);
        if stored {
            let inside = vec3u(voxel) % u32(BRICK_SIDE);
            let at = slot * BRICK_VOXELS + inside.x + u32(BRICK_SIDE) * (inside.y + u32(BRICK_SIDE) * inside.z);
            if unpack2x16float(volume_density[at].x).x > SOLID_RHO && t > OCCLUDER_CLEARANCE { return false; }
            for (var i = first_share[at]; i < first_share[at + 1u]; i++) {
                let segment = shares[i].x;
                if point_ends[segment] >> 2u != strand && meets(start, w, segment) { return false; }
            }
        } else if slot == SOLID_BRICK && t > OCCLUDER_CLEARANCE {
            return false;
        }
        // On to the next voxel, or past an empty brick; a nudge takes the ray over the face.
        let exits = (select(low, low + f32(side), ahead) - start) * inverse;
        t = max(min(exits.x, min(exits.y, exits.z)), t) + 1e-4;
    }
    return true;
}

// True where the ray passes the axis of a segment within the fibre: the nearest point lies on the segment and ahead.
fn meets(start: vec3f, w: vec3f, segment: u32) -> bool {
    let begin = points[segment];
    let end = points[segment + 1u];
    let along = end.xyz - begin.xyz;
    let to_segment = begin.xyz - start;
    let normal = cross(w, along);
    let sine2 = dot(normal, normal);
    let distance = dot(to_segment, normal);
    let radius = 0.25 * (begin.w + end.w);
    if distance * distance >= radius * radius * sine2 { return false; }
    let s = dot(cross(to_segment, w), normal);
    return dot(cross(to_segment, along), normal) > 0.0 && s >= 0.0 && s < sine2;
}
