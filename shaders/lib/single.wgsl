//!use lib/lobes.wgsl
//!use lib/longitudinal.wgsl
//!use lib/azimuth_r.wgsl
//!use lib/azimuth_tt.wgsl
//!use lib/azimuth_trt.wgsl
// Single scattering of one SRBF light (Xu 2011, Eq 11, exact separation): integral of G S_t cos(theta_i) over the sphere per lobe.

// A lobe whose product with the light stays below exp of this is not evaluated.
const NEGLIGIBLE_EXPONENT: f32 = -20.0;

// What depends on fibre and view alone.
struct PreparedView {
    f: Fibre,
    theta_o: f32,
    phi_o: f32,
    mean: vec3f,                 // centres of the lobes in theta_i, 2 alpha - theta_o
    fresnel: FresnelPolynomial,
}

// `theta_o` inclination and `phi_o` azimuth of the view, radians.
fn prepare_view(f: Fibre, theta_o: f32, phi_o: f32) -> PreparedView {
    let theta = guarded(theta_o, -HALF_PI, HALF_PI, 0.0);
    return PreparedView(f, theta, guarded_azimuth(phi_o), 2.0 * f.alpha - theta, fresnel_polynomial(f.eta));
}

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
    let across = v.phi_o - phi_j;
    let azimuth = vec2f(cos(across), sin(across));
    let half_cos = sqrt(max(0.5 + 0.5 * azimuth.x, 0.0));
    // The light's azimuthal concentration 2 / lambda'^2 is this times cos theta_i.
    let kappa_scale = 2.0 * max(cos(theta_j), 0.0) * inv_lambda_sq;
    var out = Lobes(vec3f(0.0), vec3f(0.0), vec3f(0.0));

    let g_r = product_gaussian(v.mean.x, v.f.beta.x, v.theta_o, theta_j, inv_lambda_sq);
    for (var k = 0u; k < counts.x && g_r.peak_exponent > NEGLIGIBLE_EXPONENT; k++) {
        let node = outer_node(g_r, counts.x, k, v.mean.x, v.f.beta.x, v.theta_o, theta_j, inv_lambda_sq, false);
        out.r += vec3f(node.weight * azimuth_r(v.fresnel, node.cos_theta_d, kappa_scale * node.cos_theta_i, half_cos));
    }

    let g_tt = product_gaussian(v.mean.y, v.f.beta.y, v.theta_o, theta_j, inv_lambda_sq);
    for (var k = 0u; k < counts.y && g_tt.peak_exponent > NEGLIGIBLE_EXPONENT; k++) {
        let node = outer_node(g_tt, counts.y, k, v.mean.y, v.f.beta.y, v.theta_o, theta_j, inv_lambda_sq, false);
        out.tt += node.weight * azimuth_tt(refraction(v.f.eta, node.cos_theta_d), v.f.sigma_a, kappa_scale * node.cos_theta_i, azimuth);
    }

    let g_trt = product_gaussian(v.mean.z, v.f.beta.z, v.theta_o, theta_j, inv_lambda_sq);
    for (var k = 0u; k < counts.z && g_trt.peak_exponent > NEGLIGIBLE_EXPONENT; k++) {
        let node = outer_node(g_trt, counts.z, k, v.mean.z, v.f.beta.z, v.theta_o, theta_j, inv_lambda_sq, false);
        let kappa = kappa_scale * node.cos_theta_i;
        if v.f.eccentricity == 1.0 {
            out.trt += node.weight * azimuth_trt(refraction(v.f.eta, node.cos_theta_d), v.f.sigma_a, v.f.azimuthal_width, kappa, azimuth);
        } else {
            out.trt += node.weight * azimuth_trt_elliptic(v.f, node.cos_theta_d, kappa, v.phi_o, phi_j);
        }
    }
    return out;
}

// Mean direction of the light that each lobe sends to the view, a vector of the fibre's frame no longer than one: a function that is linear
// in the direction has its mean over that light there.
fn lobe_mean_directions(v: PreparedView, theta_j: f32, phi_j: f32, lambda: f32) -> array<vec3f, 3> {
    let inv_lambda_sq = 1.0 / (lambda * lambda);
    let kappa = lobe_concentrations(v.f);
    var out: array<vec3f, 3>;
    for (var t = 0u; t < 3u; t++) {
        let g = product_gaussian(v.mean[t], v.f.beta[t], v.theta_o, theta_j, inv_lambda_sq);
        let theta = clamp(g.centre, -HALF_PI, HALF_PI);
        let light = 2.0 * max(cos(theta) * cos(theta_j), 0.0) * inv_lambda_sq;
        out[t] = mean_direction(theta, g.width, light, phi_j, kappa[t], v.phi_o - phi_j);
    }
    return out;
}
