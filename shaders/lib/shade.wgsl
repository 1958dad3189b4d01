// What single and multiple strand shading share (Rust: gpu::shade::ShadeUniform).
//!use lib/types.wgsl
//!use lib/refined.wgsl

struct ShadeUniform {
    camera_position: vec3f,
    vertex_count: u32,
    constant: vec3f,           // radiance of the uniform environment that these lights stand for; 0: they are what they are
    point_count: u32,
    terms: u32,                // TERM_ bits
    first_light: u32,
    light_count: u32,
    first_record: u32,         // of first_light in the batch
    adds: u32,                 // 0: the first dispatch of the frame
    multiple: u32,             // 0: M3, 1: Zinke 2008, 2: M2
    together_first: u32,       // the lights that are weighed with those of the dispatch: they themselves, or all that stand for
    together_count: u32,       // the uniform environment, whose other records other batches hold
}

// A light of which less than this share arrives at a point is not evaluated there, nor one whose share of all lights' power, as far as it
// arrives, is less than LITTLE.
const NOTHING_ARRIVES: f32 = 3e-4;
const LITTLE: f32 = 2e-4;

const TERM_R: u32 = 1u;
const TERM_TT: u32 = 2u;
const TERM_TRT: u32 = 4u;
const TERM_D: u32 = 8u;
const TERM_L: u32 = 16u;
const TERM_U: u32 = 32u;
const TERMS_MULTIPLE: u32 = 56u;

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
        mix(a.eccentricity, b.eccentricity, t),
        mix(a.alpha_ratios, b.alpha_ratios, t),
        mix(a.beta_ratios, b.beta_ratios, t));
}

// A fibre's frame: u along it, v the axis that eccentricity is measured from.
fn fibre_from_world(vertex: RefinedVertex) -> mat3x3f {
    return transpose(mat3x3f(vertex.tangent, vertex.normal, cross(vertex.tangent, vertex.normal)));
}
