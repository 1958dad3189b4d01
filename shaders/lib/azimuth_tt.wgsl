//!use lib/paths.wgsl
//!use lib/tables.wgsl
//!use lib/quality.wgsl
// TT, unsmoothed: a closed form at an azimuth for narrow lights, a sum over gamma for wide ones.

// N_TT at an azimuth with cosine `cos_phi` (Xu 2011, Eq 15). With a = gamma_i - gamma_t = (pi - phi)/2,
// sin gamma_i = eta' sin gamma_t gives tan gamma_i = eta' sin a / (eta' cos a - 1).
fn n_tt(r: Refraction, sigma_a: vec3f, cos_phi: f32) -> vec3f {
    let cos_a = sqrt(max(0.5 * (1.0 - cos_phi), 0.0));
    let hypotenuse = sqrt(max((r.eta_p - 1.0) * (r.eta_p - 1.0) + 2.0 * r.eta_p * (1.0 - cos_a), 1e-12));
    let cos_gamma = (r.eta_p * cos_a - 1.0) / hypotenuse;
    let cos_gamma_t = (r.eta_p - cos_a) / hypotenuse;
    let transmitted = 1.0 - fresnel_dielectric(r.cos_theta_d * max(cos_gamma, 0.0), r.eta);
    // |dphi/dh| = 2 / cos gamma_i - 2 / (eta' cos gamma_t), and eta' cos gamma_t - cos gamma_i > 0.
    let spread = max(r.eta_p * cos_gamma_t - cos_gamma, 1e-3);
    let density = 0.25 * cos_gamma * r.eta_p * cos_gamma_t / spread;
    let n = density * transmitted * transmitted * exp(-2.0 * cos_gamma_t * r.inv_cos_theta_t * sigma_a);
    return select(vec3f(0.0), n, cos_gamma > 0.0);
}

// Integral of N_TT times exp(kappa (cos(phi_i - phi_j) - 1)) over phi_i; `azimuth` holds cos and sin of phi_o - phi_j.
fn azimuth_tt(r: Refraction, sigma_a: vec3f, kappa: f32, azimuth: vec2f) -> vec3f {
    // TT spans 1 - cos a up to 1 - 1/eta': the light is narrow when it is much narrower than that.
    if kappa * (1.0 - 1.0 / r.eta_p) > TT_NARROW {
        // Three nodes of the light: exact for trigonometric polynomials of order two.
        let light = von_mises(kappa);
        let cos_x = 1.0 - light.one_minus_cos;
        let sin_x = sqrt(max(light.one_minus_cos * (1.0 + cos_x), 0.0));
        let middle = (1.0 - 2.0 * light.outer_weight) * n_tt(r, sigma_a, azimuth.x);
        let outer = n_tt(r, sigma_a, azimuth.x * cos_x - azimuth.y * sin_x) + n_tt(r, sigma_a, azimuth.x * cos_x + azimuth.y * sin_x);
        return TWO_PI * light.i0e * (middle + light.outer_weight * outer);
    }
    var sum = vec3f(0.0);
    let count = tt_gamma_count();
    for (var k = 0u; k < count; k++) {
        let node = gamma_node(count, k);
        let path = path_at(r, sigma_a, 1u, node.x, node.y);
        let even = azimuth.x * path.exit.x - 1.0;
        let odd = azimuth.y * path.exit.y;
        sum += node.z * path.energy * (exp(kappa * (even + odd)) + exp(kappa * (even - odd)));
    }
    return sum;
}
