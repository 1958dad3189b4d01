//!use lib/fibre.wgsl
// A ray through a circular fibre, whatever its order p: what one more internal reflection does to energy and exit azimuth.

struct Ray {
    reflected: f32,     // f, exact unpolarised Fresnel
    chord: vec3f,       // T, what absorption leaves along one chord
    enter: vec2f,       // cos and sin of -2 gamma
    turn: vec2f,        // cos and sin of 2 gamma_t + pi
    turn_slope: f32,    // d(2 gamma_t) / dgamma
}

// A ray of some order p >= 1 where it leaves; the mirror image at -gamma leaves at the mirrored azimuth.
struct Exit {
    energy: vec3f,      // A_p = (1 - f)^2 T (f T)^(p - 1)
    azimuth: vec2f,     // cos and sin of Phi(p, gamma) = p (2 gamma_t + pi) - 2 gamma
    slope: f32,         // dPhi / dgamma
}

fn ray_at(r: Refraction, sigma_a: vec3f, sin_gamma: f32, cos_gamma: f32) -> Ray {
    let sin_t = min(sin_gamma / r.eta_p, 1.0);
    let cos_t = sqrt(1.0 - sin_t * sin_t);
    return Ray(
        fresnel_dielectric(r.cos_theta_d * cos_gamma, r.eta),
        exp(-2.0 * cos_t * r.inv_cos_theta_t * sigma_a),
        vec2f(1.0 - 2.0 * sin_gamma * sin_gamma, -2.0 * sin_gamma * cos_gamma),
        vec2f(2.0 * sin_t * sin_t - 1.0, -2.0 * sin_t * cos_t),
        2.0 * cos_gamma / (r.eta_p * max(cos_t, 1e-3)));
}

// The ray of order 1, that passes through.
fn first_exit(ray: Ray) -> Exit {
    let transmitted = 1.0 - ray.reflected;
    return Exit(transmitted * transmitted * ray.chord, turned(ray.enter, ray.turn), ray.turn_slope - 2.0);
}

// The same ray after one more internal reflection.
fn next_exit(ray: Ray, e: Exit) -> Exit {
    return Exit(ray.reflected * ray.chord * e.energy, turned(e.azimuth, ray.turn), e.slope + ray.turn_slope);
}

// A_p of all orders above the one of `e` together: their ratio is f T.
fn energy_beyond(ray: Ray, e: Exit) -> vec3f {
    let kept = ray.reflected * ray.chord;
    return e.energy * kept / max(vec3f(1.0) - kept, vec3f(1e-6));
}

// Product of two complex numbers.
fn turned(a: vec2f, b: vec2f) -> vec2f {
    return vec2f(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}
