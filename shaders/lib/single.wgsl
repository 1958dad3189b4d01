//!use lib/prepared.wgsl
//!use lib/azimuth_tt.wgsl
//!use lib/azimuth_trt.wgsl
// Single scattering of one SRBF light (Xu 2011, Eq 11, exact separation): integral of G S_t cos(theta_i) over the sphere per lobe.

// A lobe whose product with the light stays below exp of this is not evaluated.
const NEGLIGIBLE_EXPONENT: f32 = -20.0;

// A light exp(2 (w . w_j - 1) / lambda^2) of radiance 1 at its centre (theta_j, phi_j), bandwidth `lambda`.
fn single_scattering(v: PreparedView, theta_j: f32, phi_j: f32, lambda: f32) -> Lobes {
    let width = guarded(lambda, 1e-3, 1e3, 1.0);
    return scattered(v, guarded(theta_j, -HALF_PI, HALF_PI, 0.0), guarded_azimuth(phi_j), 1.0 / (width * width), outer_counts());
}

// A uniform environment of radiance 1: the light of infinite bandwidth.
fn single_scattering_constant(v: PreparedView) -> Lobes {
    return scattered(v, 0.0, 0.0, 0.0, vec3u(6u));
}

fn scattered(v: PreparedView, theta_j: f32, phi_j: f32, inv_lambda_sq: f32, counts: vec3u) -> Lobes {
    let half_across = 0.5 * (v.phi_o - phi_j);
    let half = vec2f(cos(half_across), sin(half_across));
    // The light's azimuthal concentration 2 / lambda'^2 is this times cos theta_i.
    let kappa_scale = 2.0 * cosine(theta_j) * inv_lambda_sq;
    var out = Lobes(vec3f(0.0), vec3f(0.0), vec3f(0.0));

    let g_r = product_gaussian(v.mean.x, v.f.beta.x, v.theta_o, theta_j, inv_lambda_sq);
    for (var k = 0u; k < counts.x && g_r.peak_exponent > NEGLIGIBLE_EXPONENT; k++) {
        let node = outer_node(g_r, counts.x, k, v.mean.x, v.f.beta.x, v.theta_o, theta_j, inv_lambda_sq, false);
        out.r += vec3f(node.weight * azimuth_r(v.fresnel, node.cos_theta_d, kappa_scale * node.cos_theta_i, abs(half.x)));
    }

    let g_tt = product_gaussian(v.mean.y, v.f.beta.y, v.theta_o, theta_j, inv_lambda_sq);
    for (var k = 0u; v.followed.x && k < counts.y && g_tt.peak_exponent > NEGLIGIBLE_EXPONENT; k++) {
        let node = outer_node(g_tt, counts.y, k, v.mean.y, v.f.beta.y, v.theta_o, theta_j, inv_lambda_sq, false);
        out.tt += node.weight * azimuth_tt(refraction(v.f.eta, node.cos_theta_d), v.f.sigma_a, kappa_scale * node.cos_theta_i, half);
    }

    let g_trt = product_gaussian(v.mean.z, v.f.beta.z, v.theta_o, theta_j, inv_lambda_sq);
    for (var k = 0u; v.followed.y && k < counts.z && g_trt.peak_exponent > NEGLIGIBLE_EXPONENT; k++) {
        let node = outer_node(g_trt, counts.z, k, v.mean.z, v.f.beta.z, v.theta_o, theta_j, inv_lambda_sq, false);
        let kappa = kappa_scale * node.cos_theta_i;
        if !may_be_elliptic || v.f.eccentricity == 1.0 {
            out.trt += node.weight * azimuth_trt(refraction(v.f.eta, node.cos_theta_d), v.f.sigma_a, v.f.azimuthal_width, kappa, half);
        } else {
            out.trt += node.weight * azimuth_trt_elliptic(v.f, node.cos_theta_d, kappa, v.phi_o, phi_j);
        }
    }
    return out;
}
