// Single scattering of listed refined vertices to the camera under one batch of lights. One thread a vertex; batches add up.
// Lights that stand for a uniform environment only weigh its exact integral by the share of them that is seen.

//!use lib/shade.wgsl
//!use lib/light.wgsl
//!use lib/single.wgsl
//!use lib/lobe_light.wgsl
//!use lib/hot_spot.wgsl
//!use lib/work_list.wgsl
//!use lib/quality.wgsl

@group(0) @binding(0) var<uniform> shade: ShadeUniform;
@group(0) @binding(1) var<storage, read> vertices: array<RefinedVertex>;
@group(0) @binding(2) var<storage, read> params: array<VertexParams>;
@group(0) @binding(3) var<storage, read> lights: array<Light>;
@group(0) @binding(4) var<storage, read> frames: array<LobeLight>;
@group(0) @binding(5) var<storage, read> tables: array<vec4f>;
@group(0) @binding(6) var<storage, read> visibility: array<vec2u>;
@group(0) @binding(7) var<storage, read_write> scattered_once: array<vec4f>;
@group(0) @binding(8) var<storage, read> work: WorkList;
@group(0) @binding(9) var<storage, read_write> evaluated: array<atomic<u32>, 4>;   // lights, and of these of elliptic fibres
@group(0) @binding(10) var<storage, read> neighbours: array<u32>;                  // 2 x f16 a groom point

// Whether lights of which next to nothing arrives are left out.
override skips_hidden: bool = true;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let place = id.x + id.y * 65535u * 64u;
    if place >= work.count { return; }
    let index = work.items[place];
    let vertex = vertices[index];
    let point = vertex.source_point;
    let next = min(point + 1u, shade.point_count - 1u);
    let fraction = vertex.source_fraction;

    let fibre = fibre_from_params(mixed_params(params[point], params[next], fraction));
    let local_from_world = fibre_from_world(vertex);
    let eye = local_from_world * normalize(shade.camera_position - vertex.position);
    let view_angles = angles(eye);
    let view = prepare_view(fibre, view_angles.x, view_angles.y);

    let around = mix(unpack2x16float(neighbours[point]), unpack2x16float(neighbours[next]), fraction);

    let uniform_light = any(shade.constant > vec3f(0.0));
    var out = vec3f(0.0);
    var seen = Lobes(vec3f(0.0), vec3f(0.0), vec3f(0.0));
    var unshadowed = Lobes(vec3f(0.0), vec3f(0.0), vec3f(0.0));
    var light_count = 0u;
    for (var t = 0u; t < shade.together_count; t++) {
        // A light that is hidden all over its lobe; the share of a uniform environment that is seen wants every light, those of other
        // dispatches as if they were hidden.
        let number = shade.together_first + t;
        let j = number - shade.first_light;
        let is_own = number >= shade.first_light && j < shade.light_count;
        var seen_at = vec4f(0.0);
        if is_own {
            let record = shade.first_record + j * shade.point_count;
            seen_at = mix(unpacked(visibility[record + point]), unpacked(visibility[record + next]), fraction);
        }
        let light = lights[number];
        let most = seen_at.x + 2.0 * length(seen_at.yzw);
        if skips_hidden && (most < NOTHING_ARRIVES || most * light.share < LITTLE) && !uniform_light { continue; }
        light_count += u32(is_own);
        let light_local = local_from_world * light.direction;
        let at = angles(light_local);
        let lobes = single_scattering(view, at.x, at.y, light.bandwidth);

        // Visibility varies inside the light: it is asked for where each lobe gets its light from. It is that of places that the eye sees.
        var seen_by = vec3f(seen_at.x);
        if frames[number].visibility_count > 1u {
            let seen_of = seen_light(
                seen_at.x, local_from_world * seen_at.yzw, light_local, light.bandwidth, frames[number].mean_cosine);
            seen_by = lobe_means(view, at.x, at.y, light.bandwidth, seen_of);
        }
        // In a uniform environment hair that is not in the way gives way to light not much brighter than itself.
        if !uniform_light {
            let variance = min(0.5 * light.bandwidth * light.bandwidth, 1.0);
            seen_by = min(seen_by * exp(common_depth(around, eye, light_local, variance)), vec3f(1.0));
        }
        let r = lobes.r * seen_by.x;
        let tt = lobes.tt * seen_by.y;
        let trt = lobes.trt * seen_by.z;
        if uniform_light {
            seen = Lobes(seen.r + r, seen.tt + tt, seen.trt + trt);
            unshadowed = Lobes(unshadowed.r + lobes.r, unshadowed.tt + lobes.tt, unshadowed.trt + lobes.trt);
        } else {
            out += light.radiance * chosen(Lobes(r, tt, trt));
        }
    }
    if uniform_light {
        let exact = single_scattering_constant(view);
        out += shade.constant * chosen(Lobes(
            exact.r * share(seen.r, unshadowed.r),
            exact.tt * share(seen.tt, unshadowed.tt),
            exact.trt * share(seen.trt, unshadowed.trt)));
    }
    let before = select(vec3f(0.0), scattered_once[index].rgb, shade.adds != 0u);
    scattered_once[index] = vec4f(before + out, 1.0);
    atomicAdd(&evaluated[0], light_count);
    if may_be_elliptic && fibre.eccentricity != 1.0 { atomicAdd(&evaluated[1], light_count); }
}

// The lobes that are asked for, added up.
fn chosen(lobes: Lobes) -> vec3f {
    return select(vec3f(0.0), lobes.r, (shade.terms & TERM_R) != 0u)
        + select(vec3f(0.0), lobes.tt, (shade.terms & TERM_TT) != 0u)
        + select(vec3f(0.0), lobes.trt, (shade.terms & TERM_TRT) != 0u);
}

fn share(part: vec3f, whole: vec3f) -> vec3f {
    return select(part / max(whole, vec3f(1e-30)), vec3f(1.0), whole <= vec3f(1e-30));
}

// a, b of T(w) = a + b . (w - A w_j), world space.
fn unpacked(record: vec2u) -> vec4f {
    return vec4f(unpack2x16float(record.x), unpack2x16float(record.y));
}
