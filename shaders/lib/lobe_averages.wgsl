//!use lib/fibre.wgsl
// What a fibre does to light on average, from the shares that R, TT and TRT scatter forward and backward (Xu 2011, section 4.3.2).

struct Averages {
    a_f: f32,        // share scattered forward
    a_b: f32,        // share scattered backward
    alpha_f: f32,    // mean tilt, radians
    alpha_b: f32,
    beta_f: f32,     // root of the mean of beta^2, radians
    beta_b: f32,
}

// `shares` holds forward and backward share per lobe.
fn averages_of(shares: array<vec2f, 3>, f: Fibre) -> Averages {
    let total = shares[0] + shares[1] + shares[2];
    var tilt = vec2f(0.0);
    var variance = vec2f(0.0);
    for (var t = 0u; t < 3u; t++) {
        tilt += shares[t] * f.alpha[t];
        variance += shares[t] * f.beta[t] * f.beta[t];
    }
    let safe = max(total, vec2f(1e-20));
    let clamped = min(total, vec2f(1.0));
    // A mean is not above the largest.
    let beta = min(sqrt(variance / safe), vec2f(max(max(f.beta.x, f.beta.y), f.beta.z)));
    return Averages(clamped.x, clamped.y, tilt.x / safe.x, tilt.y / safe.y, beta.x, beta.y);
}
