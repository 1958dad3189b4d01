// Multiple scattering (D, L, U) of listed groom points to the camera under one batch of lights: smooth along a strand, so that the refined
// vertices between two points interpolate it. One thread a point; batches add up.

//!use lib/shade.wgsl
//!use lib/light.wgsl
//!use lib/lobe_light.wgsl
//!use lib/multiple.wgsl
//!use lib/work_list.wgsl

@group(0) @binding(0) var<uniform> shade: ShadeUniform;
@group(0) @binding(1) var<storage, read> vertices: array<RefinedVertex>;
@group(0) @binding(2) var<storage, read> params: array<VertexParams>;
@group(0) @binding(3) var<storage, read> lights: array<Light>;
@group(0) @binding(4) var<storage, read> frames: array<LobeLight>;
@group(0) @binding(5) var<storage, read> tables: array<vec4f>;
@group(0) @binding(6) var<storage, read> paths: array<vec4u>;
@group(0) @binding(7) var<storage, read_write> multiple: array<vec4f>;
@group(0) @binding(8) var<storage, read> directions: array<LobeDirection>;
@group(0) @binding(9) var<storage, read> averages_table: array<vec4f>;
@group(0) @binding(10) var<storage, read> point_vertices: array<u32>;    // the refined vertex of each groom point
@group(0) @binding(11) var<storage, read> work: WorkList;
@group(0) @binding(12) var<storage, read_write> evaluated: array<atomic<u32>, 4>;  // its third: lights

// Whether lights of which next to nothing arrives are left out.
override skips_hidden: bool = true;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * 65535u * 64u;
    if index >= work.count { return; }
    let point = work.items[index];
    let vertex = vertices[point_vertices[point]];
    let fibre = fibre_from_params(params[point]);
    let local_from_world = fibre_from_world(vertex);
    let view_angles = angles(local_from_world * normalize(shade.camera_position - vertex.position));
    let view = prepare_multiple(fibre, view_angles.x, view_angles.y);
    var out = select(vec3f(0.0), multiple[point].rgb, shade.adds != 0u);
    var light_count = 0u;
    for (var j = 0u; j < shade.light_count; j++) {
        let light = lights[shade.first_light + j];
        let path = unpack_path(paths[shade.first_record + j * shade.point_count + point]);
        // D and L are parts of what is scattered forward to the point; U dies away slower.
        let most = exp(-view.share * min(path.s_f.r, min(path.s_f.g, path.s_f.b)));
        if skips_hidden && (most < NOTHING_ARRIVES || most * light.share < LITTLE) { continue; }
        light_count++;
        out += light.radiance * terms_of_light(view, local_from_world, shade.first_light + j, light.direction, path);
    }
    multiple[point] = vec4f(out, 1.0);
    atomicAdd(&evaluated[2], light_count);
}

// D, L and U of one light of radiance 1, as many directions as its width wants.
fn terms_of_light(v: MultipleView, local_from_world: mat3x3f, light: u32, towards: vec3f, path: PathRecord) -> vec3f {
    let frame = frames[light];
    if shade.multiple == 1u {
        let centre = angles(local_from_world * towards);
        let terms = zinke2008_terms(v, centre.x, centre.y, frame.bandwidth, path);
        return frame.solid_angle * weighted(terms, vec3f(1.0));
    }
    var sum = vec3f(0.0);
    for (var k = 0u; k < frame.path_count; k++) {
        let spread = directions[frame.first_path + k];
        let at = angles(local_from_world * world_from_lobe(frame, spread.local, vec2f(1.0, 0.0)));
        if shade.multiple == 2u {
            sum += spread.solid_angle * weighted(m2_terms(v, at.x, at.y, path), M2_WEIGHTS);
        } else {
            sum += spread.solid_angle * weighted(m3_terms(v, at.x, at.y, path), vec3f(1.0));
        }
    }
    return sum;
}

fn weighted(terms: MultipleTerms, weights: vec3f) -> vec3f {
    return select(vec3f(0.0), weights.x * terms.d, (shade.terms & TERM_D) != 0u)
        + select(vec3f(0.0), weights.y * terms.l, (shade.terms & TERM_L) != 0u)
        + select(vec3f(0.0), weights.z * terms.u, (shade.terms & TERM_U) != 0u);
}
