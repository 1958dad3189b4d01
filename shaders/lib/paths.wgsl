//!use lib/fibre.wgsl
// Light paths through a circular fibre, p = 0 (R), 1 (TT), 2 (TRT): energy and exit azimuth of the ray at gamma.

struct Path {
    energy: vec3f,      // A_p of Xu 2011 Eq 10
    azimuth: f32,       // exit azimuth Phi(p, gamma), not wrapped (Xu 2011, Eq 8)
    exit: vec2f,        // its cosine and sine, without trigonometry; the mirror image at -gamma exits at -Phi
    spread: f32,        // abs(dPhi/dgamma)
}

fn path_at(r: Refraction, sigma_a: vec3f, p: u32, sin_gamma: f32, cos_gamma: f32) -> Path {
    let sin_t = min(sin_gamma / r.eta_p, 1.0);
    let cos_t = sqrt(1.0 - sin_t * sin_t);
    let reflected = fresnel_dielectric(r.cos_theta_d * cos_gamma, r.eta);
    let transmitted = 1.0 - reflected;
    let order = f32(p);
    let chord = 2.0 * cos_t * r.inv_cos_theta_t;
    // sigma_a of zero is a factor of one for any order.
    let inside = transmitted * transmitted * select(1.0, reflected, p == 2u) * exp(-order * chord * sigma_a);
    let azimuth = 2.0 * order * atan2(sin_t, cos_t) - 2.0 * atan2(sin_gamma, cos_gamma) + order * PI;
    // exp(i Phi) is the square of exp(i (p gamma_t - gamma)), turned by p pi.
    let turned = select(vec2f(1.0, 0.0), select(vec2f(cos_t, sin_t), vec2f(1.0 - 2.0 * sin_t * sin_t, 2.0 * sin_t * cos_t), p == 2u), p > 0u);
    let half = vec2f(turned.x * cos_gamma + turned.y * sin_gamma, turned.y * cos_gamma - turned.x * sin_gamma);
    let exit = select(1.0, -1.0, p == 1u) * vec2f(half.x * half.x - half.y * half.y, 2.0 * half.x * half.y);
    let spread = abs(2.0 * order * cos_gamma / (r.eta_p * max(cos_t, 1e-3)) - 2.0);
    return Path(select(inside, vec3f(reflected), p == 0u), azimuth, exit, spread);
}
