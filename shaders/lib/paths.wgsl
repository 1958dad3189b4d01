//!use lib/fibre.wgsl
// Light paths through a circular fibre, p = 0 (R), 1 (TT), 2 (TRT): energy and exit azimuth of the ray at gamma.

// A path without its absorption.
struct Passage {
    cos_t: f32,         // cos gamma_t: the path crosses p chords of 2 cos gamma_t / cos theta_t
    surface: f32,       // Fresnel factors of A_p (Xu 2011, Eq 10)
    exit: vec2f,        // cosine and sine of the exit azimuth; the mirror image at -gamma exits at -Phi
    spread: f32,        // abs(dPhi/dgamma)
}

fn passage_at(r: Refraction, p: u32, sin_gamma: f32, cos_gamma: f32) -> Passage {
    let sin_t = min(sin_gamma / r.eta_p, 1.0);
    let cos_t = sqrt(1.0 - sin_t * sin_t);
    let reflected = fresnel_at(r.cos_theta_d * cos_gamma, cos_t / r.inv_cos_theta_t, r.eta);
    let transmitted = 1.0 - reflected;
    let through = transmitted * transmitted * select(1.0, reflected, p == 2u);
    // exp(i Phi) is the square of exp(i (p gamma_t - gamma)), turned by p pi.
    let turned = select(vec2f(1.0, 0.0), select(vec2f(cos_t, sin_t), vec2f(1.0 - 2.0 * sin_t * sin_t, 2.0 * sin_t * cos_t), p == 2u), p > 0u);
    let half = vec2f(turned.x * cos_gamma + turned.y * sin_gamma, turned.y * cos_gamma - turned.x * sin_gamma);
    let exit = select(1.0, -1.0, p == 1u) * vec2f(half.x * half.x - half.y * half.y, 2.0 * half.x * half.y);
    let spread = abs(2.0 * f32(p) * cos_gamma / (r.eta_p * max(cos_t, 1e-3)) - 2.0);
    return Passage(cos_t, select(through, reflected, p == 0u), exit, spread);
}

struct Path {
    energy: vec3f,      // A_p of Xu 2011 Eq 10
    azimuth: f32,       // exit azimuth Phi(p, gamma), not wrapped (Xu 2011, Eq 8)
    exit: vec2f,        // its cosine and sine, without trigonometry
    spread: f32,        // abs(dPhi/dgamma)
}

fn path_at(r: Refraction, sigma_a: vec3f, p: u32, sin_gamma: f32, cos_gamma: f32) -> Path {
    let passage = passage_at(r, p, sin_gamma, cos_gamma);
    let order = f32(p);
    // sigma_a of zero is a factor of one for any order.
    let energy = passage.surface * exp(-2.0 * order * passage.cos_t * r.inv_cos_theta_t * sigma_a);
    let azimuth = 2.0 * order * atan2(min(sin_gamma / r.eta_p, 1.0), passage.cos_t) - 2.0 * atan2(sin_gamma, cos_gamma) + order * PI;
    return Path(energy, azimuth, passage.exit, passage.spread);
}

// Absorption along the paths of order p at one theta_d. Their cos gamma_t lies between sqrt(1 - 1/eta'^2) and 1: the exponential is taken
// once, in the middle, and what is left is small.
struct Absorption {
    middle: f32,              // a cos gamma_t
    per_cosine: vec3f,        // optical depth is this times cos gamma_t
    at_middle: vec3f,         // exp(-per_cosine * middle)
}

fn absorption(r: Refraction, sigma_a: vec3f, p: u32) -> Absorption {
    let middle = 1.0 - 0.25 / (r.eta_p * r.eta_p);
    let per_cosine = 2.0 * f32(p) * r.inv_cos_theta_t * sigma_a;
    return Absorption(middle, per_cosine, exp(-middle * per_cosine));
}

// exp(-per_cosine * cos_t): (1 + x + x^2/2)^8 is exp(8 x) within 8 x^3 / 6, and where x is large nothing arrives.
fn absorbed(a: Absorption, cos_t: f32) -> vec3f {
    let x = clamp(0.125 * (a.middle - cos_t) * a.per_cosine, vec3f(-1.0), vec3f(1.0));
    let e = 1.0 + x * (1.0 + 0.5 * x);
    let e2 = e * e;
    let e4 = e2 * e2;
    return a.at_middle * e4 * e4;
}
