//!use lib/paths.wgsl
//!use lib/tables.wgsl
//!use lib/quality.wgsl
// TT, unsmoothed: a closed form at an azimuth for narrow lights, a sum over gamma for wide ones.

// N_TT at an azimuth (Xu 2011, Eq 15) with cos_a = abs(sin(phi/2)). With a = gamma_i - gamma_t = (pi - phi)/2,
// sin gamma_i = eta' sin gamma_t gives tan gamma_i = eta' sin a / (eta' cos a - 1).
fn n_tt(r: Refraction, a: Absorption, cos_a: f32) -> vec3f {
    let inv_hypotenuse = inverseSqrt(max((r.eta_p - 1.0) * (r.eta_p - 1.0) + 2.0 * r.eta_p * (1.0 - cos_a), 1e-12));
    let cos_gamma = (r.eta_p * cos_a - 1.0) * inv_hypotenuse;
    let cos_gamma_t = (r.eta_p - cos_a) * inv_hypotenuse;
    let transmitted = 1.0 - fresnel_at(r.cos_theta_d * max(cos_gamma, 0.0), cos_gamma_t / r.inv_cos_theta_t, r.eta);
    // |dphi/dh| = 2 / cos gamma_i - 2 / (eta' cos gamma_t), and eta' cos gamma_t - cos gamma_i > 0.
    let spread = max(r.eta_p * cos_gamma_t - cos_gamma, 1e-3);
    let density = 0.25 * cos_gamma * r.eta_p * cos_gamma_t / spread;
    let n = density * transmitted * transmitted * absorbed(a, cos_gamma_t);
    return select(vec3f(0.0), n, cos_gamma > 0.0);
}

// Integral of N_TT times exp(kappa (cos(phi_i - phi_j) - 1)) over phi_i; `half` holds cos and sin of (phi_o - phi_j)/2.
fn azimuth_tt(r: Refraction, sigma_a: vec3f, kappa: f32, half: vec2f) -> vec3f {
    let a = absorption(r, sigma_a, 1u);
    // TT spans 1 - cos a up to 1 - 1/eta': the light is narrow when it is much narrower than that.
    if kappa * (1.0 - 1.0 / r.eta_p) > TT_NARROW {
        // Three nodes of the light: exact for trigonometric polynomials of order two.
        let light = von_mises(kappa);
        let even = half.y * light.half.x;
        let odd = half.x * light.half.y;
        let middle = (1.0 - 2.0 * light.outer_weight) * n_tt(r, a, abs(half.y));
        let outer = n_tt(r, a, abs(even - odd)) + n_tt(r, a, abs(even + odd));
        return TWO_PI * light.i0e * (middle + light.outer_weight * outer);
    }
    let across = doubled_angle(half);
    var sum = vec3f(0.0);
    let count = tt_gamma_count();
    for (var k = 0u; k < count; k++) {
        let node = gamma_node(count, k);
        let passage = passage_at(r, 1u, node.x, node.y);
        let even = across.x * passage.exit.x - 1.0;
        let odd = across.y * passage.exit.y;
        sum += node.z * passage.surface * (exp(kappa * (even + odd)) + exp(kappa * (even - odd))) * absorbed(a, passage.cos_t);
    }
    return sum;
}
