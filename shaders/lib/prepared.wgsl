//!use lib/longitudinal.wgsl
//!use lib/azimuth_r.wgsl
// What every way to integrate single scattering shares: its result, what is prepared per view, where the lobes look.

struct Lobes { r: vec3f, tt: vec3f, trt: vec3f }

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

// Mean direction of the light that each lobe sends to the view, a vector of the fibre's frame no longer than one: a function that is linear
// in the direction has its mean over that light there.
fn lobe_mean_directions(v: PreparedView, theta_j: f32, phi_j: f32, lambda: f32) -> array<vec3f, 3> {
    let inv_lambda_sq = 1.0 / (lambda * lambda);
    // Where each lobe is brightest in phi_i, and how concentrated: R faint and towards the view, TT behind, TRT towards the view.
    let kappa = vec3f(0.4, -2.5, 1.0 / (0.06 + 0.5 * v.f.azimuthal_width * v.f.azimuthal_width));
    let across = v.phi_o - phi_j;
    var out: array<vec3f, 3>;
    for (var t = 0u; t < 3u; t++) {
        let g = product_gaussian(v.mean[t], v.f.beta[t], v.theta_o, theta_j, inv_lambda_sq);
        let theta = clamp(g.centre, -HALF_PI, HALF_PI);
        let light = 2.0 * max(cos(theta) * cos(theta_j), 0.0) * inv_lambda_sq;
        // The product of two von Mises densities; its mean vector has the length I1/I0 of its concentration, here within 0.01.
        let sum = vec2f(light + kappa[t] * cos(across), kappa[t] * sin(across));
        let shrunk = sum / (0.5 + sqrt(dot(sum, sum) + 2.25));
        let around = vec2f(shrunk.x * cos(phi_j) - shrunk.y * sin(phi_j), shrunk.x * sin(phi_j) + shrunk.y * cos(phi_j));
        // Sine and cosine have their means over a Gaussian of bandwidth w at its centre, times exp(-w^2/4).
        out[t] = exp(-0.25 * g.width * g.width) * vec3f(sin(theta), cos(theta) * around);
    }
    return out;
}
