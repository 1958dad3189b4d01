//!use lib/lobes.wgsl
//!use lib/cone.wgsl
//!use lib/azimuth_deon.wgsl
// Single scattering of one SRBF light by the energy-conserving fibre of d'Eon 2011: integral of G S_p over the sphere, S_p = M_p N_p
// (no cosine: M_p holds it). Stands in for lib/single.wgsl. Circular section.

// A cone whose product with the light stays below exp of this is not evaluated.
const NEGLIGIBLE_EXPONENT: f32 = -20.0;

// Orders p = 0 to 3 and all above.
struct Orders { p0: vec3f, p1: vec3f, p2: vec3f, p3: vec3f, remainder: vec3f }

// What depends on fibre and view alone; p >= 3 shares TRT's cone.
struct PreparedView {
    f: Fibre,
    theta_o: f32,
    phi_o: f32,
    theta_r: vec3f,              // axes of the cones of R, TT, TRT: theta_o - 2 alpha, folded
    variance: vec3f,             // v of the cones
    detector: f32,               // variance of the Gaussian detectors
    fresnel: FresnelPolynomial,
}

// `theta_o` inclination and `phi_o` azimuth of the view, radians.
fn prepare_view(f: Fibre, theta_o: f32, phi_o: f32) -> PreparedView {
    let theta = guarded(theta_o, -HALF_PI, HALF_PI, 0.0);
    let axes = vec3f(folded(theta - 2.0 * f.alpha.x), folded(theta - 2.0 * f.alpha.y), folded(theta - 2.0 * f.alpha.z));
    return PreparedView(f, theta, guarded_azimuth(phi_o), axes,
        vec3f(cone_variance(f.beta.x), cone_variance(f.beta.y), cone_variance(f.beta.z)),
        0.5 * f.azimuthal_width * f.azimuthal_width, fresnel_polynomial(f.eta));
}

// A light exp(2 (w . w_j - 1) / lambda^2) of radiance 1 at its centre (theta_j, phi_j), bandwidth `lambda`; p >= 2 is TRT's.
fn single_scattering(v: PreparedView, theta_j: f32, phi_j: f32, lambda: f32) -> Lobes {
    return lobes_of(scattered_orders(v, theta_j, phi_j, lambda));
}

// A uniform environment of radiance 1: the light of infinite bandwidth.
fn single_scattering_constant(v: PreparedView) -> Lobes {
    return lobes_of(uniform_orders(v));
}

fn uniform_orders(v: PreparedView) -> Orders {
    return scattered(v, 0.0, 0.0, 0.0, vec3u(6u));
}

// Outer nodes of R, TT, TRT.
fn cone_counts() -> vec3u {
    return select(select(vec3u(6u, 5u, 5u), vec3u(4u, 4u, 3u), quality == 1u), vec3u(3u, 2u, 2u), quality == 0u);
}

fn scattered_orders(v: PreparedView, theta_j: f32, phi_j: f32, lambda: f32) -> Orders {
    let width = guarded(lambda, 1e-3, 1e3, 1.0);
    return scattered(v, guarded(theta_j, -HALF_PI, HALF_PI, 0.0), guarded_azimuth(phi_j), 1.0 / (width * width), cone_counts());
}

fn lobes_of(o: Orders) -> Lobes {
    return Lobes(o.p0, o.p1, o.p2 + o.p3 + o.remainder);
}

fn scattered(v: PreparedView, theta_j: f32, phi_j: f32, inv_lambda_sq: f32, counts: vec3u) -> Orders {
    let across = v.phi_o - phi_j;
    let azimuth = vec2f(cos(across), sin(across));
    let half_cos = sqrt(max(0.5 + 0.5 * azimuth.x, 0.0));
    // The light's azimuthal concentration is this times cos theta_i.
    let kappa_scale = 2.0 * max(cos(theta_j), 0.0) * inv_lambda_sq;
    var out = Orders(vec3f(0.0), vec3f(0.0), vec3f(0.0), vec3f(0.0), vec3f(0.0));
    var sums = vec3f(0.0);
    for (var t = 0u; t < 3u; t++) {
        let g = cone_product(v.variance[t], v.theta_r[t], theta_j, inv_lambda_sq);
        for (var k = 0u; k < counts[t] && g.peak_exponent > NEGLIGIBLE_EXPONENT; k++) {
            let node = cone_node(g, counts[t], k, v.variance[t], v.theta_r[t], v.theta_o, theta_j, inv_lambda_sq);
            let light = detected_light(kappa_scale * node.cos_theta_i, v.detector);
            sums[t] += node.weight;
            if t == 0u {
                out.p0 += vec3f(node.weight * azimuth_deon_r(v.fresnel, node.cos_theta_d, light, half_cos));
                continue;
            }
            let r = refraction(v.f.eta, node.cos_theta_d);
            if t == 1u {
                out.p1 += node.weight * azimuth_deon_tt(r, v.f.sigma_a, light, azimuth);
                continue;
            }
            let higher = azimuth_deon_higher(r, v.f.sigma_a, light, azimuth);
            out.p2 += node.weight * higher.p2;
            out.p3 += node.weight * higher.p3;
            out.remainder += node.weight * higher.remainder;
        }
    }
    if inv_lambda_sq > 0.0 {
        return out;
    }
    // In a uniform environment a cone integrates to one, which the rule's own sum replaces.
    let whole = 1.0 / max(sums, vec3f(1e-6));
    return Orders(whole.x * out.p0, whole.y * out.p1, whole.z * out.p2, whole.z * out.p3, whole.z * out.remainder);
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
        let g = cone_product(v.variance[t], v.theta_r[t], theta_j, inv_lambda_sq);
        let theta = clamp(g.centre, -HALF_PI, HALF_PI);
        out[t] = mean_seen(seen, theta, g.width, scale * cosine(theta) * light + kappa[t] * view);
    }
    return out;
}
