// What one fibre does on average to light from a direction of inclination theta: a table over absorption and inclination.
// Written by pass/averages.wgsl. A pass that looks values up declares
//   var<storage, read> averages_table: array<vec4f>;
// Three entries per (absorption, inclination): (a_f, a_b, beta_f, beta_b), (alpha_f, alpha_b, k, 0) and lib/backward.wgsl's
// (A_b, Delta_b, sigma_b^2, A_b as printed); after them one per absorption: (rho, 0, 0, 0).

const AVERAGES_SIGMAS: u32 = 32u;
const AVERAGES_THETAS: u32 = 64u;
const AVERAGES_ENTRY: u32 = 3u;

// Absorption of node s: SIGMA_SCALE (exp(SIGMA_GROWTH s) - 1), from 0 to 30 per fibre radius.
const SIGMA_SCALE: f32 = 0.05;
const SIGMA_GROWTH: f32 = 0.20641;

// Smallest k: keeps the limit of fibres without loss within reach of f32.
const K_MIN: f32 = 3e-4;

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

// An absorption as a coordinate of the table.
fn averages_sigma_place(sigma_a: f32) -> f32 {
    return clamp(log(1.0 + max(sigma_a, 0.0) / SIGMA_SCALE) / SIGMA_GROWTH, 0.0, f32(AVERAGES_SIGMAS - 1u) - 1e-3);
}

// An inclination as a coordinate of the table.
fn averages_theta_place(theta: f32) -> f32 {
    return clamp((theta / 3.14159265 + 0.5) * f32(AVERAGES_THETAS) - 0.5, 0.0, f32(AVERAGES_THETAS - 1u) - 1e-3);
}

// Entry `part` at coordinates (sigma, theta), bilinear.
fn averages_entry(sigma: f32, theta: f32, part: u32) -> vec4f {
    let at = AVERAGES_ENTRY * (u32(sigma) * AVERAGES_THETAS + u32(theta)) + part;
    let above = at + AVERAGES_ENTRY * AVERAGES_THETAS;
    return mix(mix(averages_table[at], averages_table[at + AVERAGES_ENTRY], fract(theta)),
        mix(averages_table[above], averages_table[above + AVERAGES_ENTRY], fract(theta)), fract(sigma));
}

// The averages of a fibre of absorption sigma_a (one channel) at inclination theta.
fn fibre_averages(sigma_a: f32, theta: f32) -> FibreAverages {
    let s = averages_sigma_place(sigma_a);
    let t = averages_theta_place(theta);
    let low = averages_entry(s, t, 0u);
    let high = averages_entry(s, t, 1u);
    return FibreAverages(low.x, low.y, low.z, low.w, high.x, high.y, high.z);
}

// A_b, Delta_b, sigma_b^2 and the printed A_b; `sigma_place` is averages_sigma_place of one channel's absorption.
fn backward_averages(sigma_place: f32, theta: f32) -> vec4f {
    return averages_entry(sigma_place, averages_theta_place(theta), 2u);
}

// rho of a half space of fibres of absorption sigma_a: the share that comes back, mean over the inclination weighted by its cosine.
fn half_space_reflectance(sigma_a: f32) -> f32 {
    let s = averages_sigma_place(sigma_a);
    let first = AVERAGES_ENTRY * AVERAGES_SIGMAS * AVERAGES_THETAS + u32(s);
    return mix(averages_table[first].x, averages_table[first + 1u].x, fract(s));
}
