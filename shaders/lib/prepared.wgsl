//!use lib/lobes.wgsl
//!use lib/longitudinal.wgsl
//!use lib/azimuth_r.wgsl
//!use lib/quality.wgsl
// What every way to integrate single scattering shares: what is prepared per view, where the lobes look.

// What depends on fibre and view alone.
struct PreparedView {
    f: Fibre,
    theta_o: f32,
    phi_o: f32,
    mean: vec3f,                 // centres of the lobes in theta_i, 2 alpha - theta_o
    fresnel: FresnelPolynomial,
    followed: vec2<bool>,        // TT, TRT: whether more than next to nothing comes through the fibre on that path
}

// Optical depth of a path through which next to nothing comes: 1e-4.
const ABSORBED: f32 = 9.21;


// `theta_o` inclination and `phi_o` azimuth of the view, radians.
fn prepare_view(f: Fibre, theta_o: f32, phi_o: f32) -> PreparedView {
    let theta = guarded(theta_o, -HALF_PI, HALF_PI, 0.0);
    // No chord is shorter than that of a grazing ray in the normal plane.
    let shortest = 2.0 * sqrt(max(1.0 - 1.0 / (f.eta * f.eta), 0.0)) * min(f.sigma_a.r, min(f.sigma_a.g, f.sigma_a.b));
    let followed = vec2<bool>(follows_absorbed || shortest < ABSORBED, follows_absorbed || 2.0 * shortest < ABSORBED);
    return PreparedView(f, theta, guarded_azimuth(phi_o), 2.0 * f.alpha - theta, fresnel_polynomial(f.eta), followed);
}

// Mean visibility of the light that each lobe sends to the view.
fn lobe_means(v: PreparedView, theta_j: f32, phi_j: f32, lambda: f32, seen: SeenLight) -> vec3f {
    let inv_lambda_sq = 1.0 / (lambda * lambda);
    let kappa = lobe_concentrations(v.f, v.theta_o);
    let scale = 2.0 * cosine(theta_j) * inv_lambda_sq;
    let light = azimuth_vector(phi_j);
    let view = azimuth_vector(v.phi_o);
    var out: vec3f;
    for (var t = 0u; t < 3u; t++) {
        let g = product_gaussian(v.mean[t], v.f.beta[t], v.theta_o, theta_j, inv_lambda_sq);
        let theta = clamp(g.centre, -HALF_PI, HALF_PI);
        out[t] = mean_seen(seen, theta, g.width, scale * cosine(theta) * light + kappa[t] * view);
    }
    return out;
}
