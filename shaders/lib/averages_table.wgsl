// What one fibre does on average to light from a direction of inclination theta: a table over absorption and inclination.
// Written by pass/averages.wgsl. A pass that looks values up declares
//   var<storage, read> averages_table: array<vec4f>;
// Two entries per (absorption, inclination): (a_f, a_b, beta_f, beta_b), (alpha_f, alpha_b, k, 0); after them one per absorption: (rho, 0, 0, 0).

const AVERAGES_SIGMAS: u32 = 32u;
const AVERAGES_THETAS: u32 = 64u;

// Absorption of node s: SIGMA_SCALE (exp(SIGMA_GROWTH s) - 1), from 0 to 30 per fibre radius.
const SIGMA_SCALE: f32 = 0.05;
const SIGMA_GROWTH: f32 = 0.20641;

// Smallest k: keeps the limit of fibres without loss within reach of f32.
const K_MIN: f32 = 1e-3;

// Xu 2011 Eq 32 and below (a: share of the power scattered forward, backward; alpha: shift, beta: standard deviation, both in theta_h), and k.
struct FibreAverages {
    a_f: f32,
    a_b: f32,
    beta_f: f32,
    beta_b: f32,
    alpha_f: f32,
    alpha_b: f32,
    k: f32,                  // sqrt((1 - a_f - a_b)(1 - a_f + a_b)): decay per fibre of light between two half spaces
}

fn averages_sigma(node: u32) -> f32 {
    return SIGMA_SCALE * (exp(SIGMA_GROWTH * f32(node)) - 1.0);
}

fn averages_theta(node: u32) -> f32 {
    return 3.14159265 * ((f32(node) + 0.5) / f32(AVERAGES_THETAS) - 0.5);
}

// k from a_f and a_b, at least K_MIN.
fn decay_per_fibre(a_f: f32, a_b: f32) -> f32 {
    return sqrt(max((1.0 - a_f - a_b) * (1.0 - a_f + a_b), K_MIN * K_MIN));
}

// Node and fraction of an absorption.
fn averages_sigma_place(sigma_a: f32) -> vec2f {
    let x = clamp(log(1.0 + max(sigma_a, 0.0) / SIGMA_SCALE) / SIGMA_GROWTH, 0.0, f32(AVERAGES_SIGMAS - 1u) - 1e-3);
    return vec2f(floor(x), fract(x));
}

// The averages of a fibre of absorption sigma_a (one channel) at inclination theta, bilinear.
fn fibre_averages(sigma_a: f32, theta: f32) -> FibreAverages {
    let s = averages_sigma_place(sigma_a);
    let x = clamp((theta / 3.14159265 + 0.5) * f32(AVERAGES_THETAS) - 0.5, 0.0, f32(AVERAGES_THETAS - 1u) - 1e-3);
    let first = 2u * (u32(s.x) * AVERAGES_THETAS + u32(x));
    let next_sigma = 2u * AVERAGES_THETAS;
    let u = fract(x);
    let low = mix(mix(averages_table[first], averages_table[first + 2u], u),
        mix(averages_table[first + next_sigma], averages_table[first + next_sigma + 2u], u), s.y);
    let high = mix(mix(averages_table[first + 1u], averages_table[first + 3u], u),
        mix(averages_table[first + next_sigma + 1u], averages_table[first + next_sigma + 3u], u), s.y);
    return FibreAverages(low.x, low.y, low.z, low.w, high.x, high.y, high.z);
}

// rho of a half space of fibres of absorption sigma_a: the share that comes back, mean over the inclination weighted by its cosine.
fn half_space_reflectance(sigma_a: f32) -> f32 {
    let s = averages_sigma_place(sigma_a);
    let first = 2u * AVERAGES_SIGMAS * AVERAGES_THETAS + u32(s.x);
    return mix(averages_table[first].x, averages_table[first + 1u].x, s.y);
}
