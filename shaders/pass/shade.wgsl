// Strand shading: the radiance that every refined vertex sends to the camera under one batch of lights. One thread a vertex; batches add up.
// Lights that stand for a uniform environment only weigh its exact integral by the share of them that is seen.

//!use lib/types.wgsl
//!use lib/refined.wgsl
//!use lib/light.wgsl
//!use lib/single.wgsl
//!use lib/lobe_light.wgsl
//!use lib/multiple.wgsl

struct ShadeUniform {
    camera_position: vec3f,
    vertex_count: u32,
    constant: vec3f,           // radiance of the uniform environment that these lights stand for; 0: they are what they are
    point_count: u32,
    alpha_ratios: vec2f,       // TT, TRT to R
    beta_ratios: vec2f,
    terms: u32,                // TERM_ bits
    first_light: u32,
    light_count: u32,
    first_record: u32,         // of first_light in the batch
    adds: u32,                 // 0: the first dispatch of the frame
    multiple: u32,             // 0: M2, 1: Zinke 2008
}

const TERM_R: u32 = 1u;
const TERM_TT: u32 = 2u;
const TERM_TRT: u32 = 4u;
const TERM_D: u32 = 8u;
const TERM_L: u32 = 16u;
const TERM_U: u32 = 32u;
const TERMS_MULTIPLE: u32 = 56u;

@group(0) @binding(0) var<uniform> shade: ShadeUniform;
@group(0) @binding(1) var<storage, read> vertices: array<RefinedVertex>;
@group(0) @binding(2) var<storage, read> params: array<VertexParams>;
@group(0) @binding(3) var<storage, read> lights: array<Light>;
@group(0) @binding(4) var<storage, read> frames: array<LobeLight>;
@group(0) @binding(5) var<storage, read> directions: array<LobeDirection>;
@group(0) @binding(6) var<storage, read> visibility: array<vec2u>;
@group(0) @binding(7) var<storage, read> paths: array<vec4u>;
@group(0) @binding(8) var<storage, read> averages_table: array<vec4f>;
@group(0) @binding(9) var<storage, read_write> radiance: array<vec4f>;
@group(0) @binding(10) var<storage, read> tables: array<vec4f>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * 65535u * 64u;
    if index >= shade.vertex_count { return; }
    let vertex = vertices[index];
    let point = vertex.source_point;
    let next = min(point + 1u, shade.point_count - 1u);
    let fraction = vertex.source_fraction;

    // The fibre and its frame: u along it, v the axis that eccentricity is measured from.
    let fibre = fibre_from_params(mixed_params(params[point], params[next], fraction), shade.alpha_ratios, shade.beta_ratios);
    let local_from_world = transpose(mat3x3f(vertex.tangent, vertex.normal, cross(vertex.tangent, vertex.normal)));
    let view_angles = angles(local_from_world * normalize(shade.camera_position - vertex.position));
    let view = prepare_view(fibre, view_angles.x, view_angles.y);

    let multiple_view = prepare_multiple(fibre, view_angles.x, view_angles.y);

    var out = vec3f(0.0);
    var seen = Lobes(vec3f(0.0), vec3f(0.0), vec3f(0.0));
    var unshadowed = Lobes(vec3f(0.0), vec3f(0.0), vec3f(0.0));
    for (var j = 0u; j < shade.light_count; j++) {
        let light = lights[shade.first_light + j];
        let record = shade.first_record + j * shade.point_count;
        let light_local = local_from_world * light.direction;
        let at = angles(light_local);
        let lobes = single_scattering(view, at.x, at.y, light.bandwidth);

        // Visibility varies inside the light: it is asked for where each lobe gets its light from.
        let seen_at = mix(unpacked(visibility[record + point]), unpacked(visibility[record + next]), fraction);
        let slope = local_from_world * seen_at.yzw;
        let mean = frames[shade.first_light + j].mean_cosine * light_local;
        let asked = lobe_mean_directions(view, at.x, at.y, light.bandwidth);
        let r = lobes.r * saturate(seen_at.x + dot(slope, direction(asked[0]) - mean));
        let tt = lobes.tt * saturate(seen_at.x + dot(slope, direction(asked[1]) - mean));
        let trt = lobes.trt * saturate(seen_at.x + dot(slope, direction(asked[2]) - mean));
        if any(shade.constant > vec3f(0.0)) {
            seen = Lobes(seen.r + r, seen.tt + tt, seen.trt + trt);
            unshadowed = Lobes(unshadowed.r + lobes.r, unshadowed.tt + lobes.tt, unshadowed.trt + lobes.trt);
        } else {
            out += light.radiance * chosen(Lobes(r, tt, trt));
        }
        if (shade.terms & TERMS_MULTIPLE) != 0u {
            let path = mixed_paths(unpack_path(paths[record + point]), unpack_path(paths[record + next]), fraction);
            out += light.radiance * multiple(multiple_view, local_from_world, shade.first_light + j, at, path);
        }
    }
    if any(shade.constant > vec3f(0.0)) {
        let exact = single_scattering_constant(fibre, view_angles.x);
        out += shade.constant * chosen(Lobes(
            exact.r * share(seen.r, unshadowed.r),
            exact.tt * share(seen.tt, unshadowed.tt),
            exact.trt * share(seen.trt, unshadowed.trt)));
    }
    let before = select(vec3f(0.0), radiance[index].rgb, shade.adds != 0u);
    radiance[index] = vec4f(before + out, 1.0);
}

// D, L and U of one light of radiance 1, as many directions as its width wants.
fn multiple(v: MultipleView, local_from_world: mat3x3f, light: u32, centre: vec2f, path: PathRecord) -> vec3f {
    let frame = frames[light];
    if shade.multiple == 1u {
        let terms = zinke2008_terms(v, centre.x, centre.y, frame.bandwidth, path);
        return frame.solid_angle * weighted(terms, vec3f(1.0));
    }
    var sum = vec3f(0.0);
    for (var k = 0u; k < frame.path_count; k++) {
        let spread = directions[frame.first_path + k];
        let at = angles(local_from_world * world_from_lobe(frame, spread.local, vec2f(1.0, 0.0)));
        sum += spread.solid_angle * weighted(m2_terms(v, at.x, at.y, path), M2_WEIGHTS);
    }
    return sum;
}

fn weighted(terms: MultipleTerms, weights: vec3f) -> vec3f {
    return select(vec3f(0.0), weights.x * terms.d, (shade.terms & TERM_D) != 0u)
        + select(vec3f(0.0), weights.y * terms.l, (shade.terms & TERM_L) != 0u)
        + select(vec3f(0.0), weights.z * terms.u, (shade.terms & TERM_U) != 0u);
}

fn mixed_paths(a: PathRecord, b: PathRecord, t: f32) -> PathRecord {
    return PathRecord(mix(a.t_f, b.t_f, t), mix(a.spread, b.spread, t), mix(a.kappa, b.kappa, t), mix(a.n, b.n, t));
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

// (theta, phi) of a unit vector of the fibre's frame.
fn angles(w: vec3f) -> vec2f {
    return vec2f(asin(clamp(w.x, -1.0, 1.0)), atan2(w.z, w.y));
}

// Unit vector of (theta, phi) in the fibre's frame.
fn direction(at: vec2f) -> vec3f {
    return vec3f(sin(at.x), cos(at.x) * cos(at.y), cos(at.x) * sin(at.y));
}

fn mixed_params(a: VertexParams, b: VertexParams, t: f32) -> VertexParams {
    return VertexParams(
        mix(a.sigma_a, b.sigma_a, t),
        mix(a.alpha_rad, b.alpha_rad, t),
        mix(a.beta_rad, b.beta_rad, t),
        mix(a.azimuthal_width, b.azimuthal_width, t),
        mix(a.eta, b.eta, t),
        mix(a.eccentricity, b.eccentricity, t));
}
