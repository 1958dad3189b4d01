//!use lib/azimuth_r.wgsl
//!use lib/azimuth_tt.wgsl
//!use lib/detector.wgsl
//!use lib/ray.wgsl
// The azimuthal factors N_p of d'Eon 2011 (Eq 10, Gaussian detectors on every order) against a light's factor
// exp(kappa (cos(phi_i - phi_j) - 1)). `azimuth` holds cos and sin of phi_o - phi_j; `l` is the light through the detector.

// A node of the sum over gamma stands for its share of it: its exit azimuths are blurred by at least this part of what the share spans.
const DEON_FOOTPRINT: f32 = 0.4;

// Concentration above which the sum over gamma takes all the nodes that there are.
const DEON_MANY: f32 = 100.0;

// Nodes over gamma.
fn deon_gamma_count(kappa: f32) -> u32 {
    let usual = select(select(12u, 8u, quality == 1u), 5u, quality == 0u);
    return select(usual, 16u, kappa > DEON_MANY && quality > 0u);
}

// p = 0: N_R is smooth, so the circular Gaussian stands for light and detector together.
fn azimuth_deon_r(fresnel: FresnelPolynomial, cos_theta_d: f32, l: DetectedLight, y: f32) -> f32 {
    return TWO_PI * l.mass * mean_n_r(fresnel, cos_theta_d, mean_cosine_powers(l.kappa, y));
}

// p = 1.
fn azimuth_deon_tt(r: Refraction, sigma_a: vec3f, l: DetectedLight, azimuth: vec2f) -> vec3f {
    if l.kappa * (1.0 - 1.0 / r.eta_p) > TT_NARROW && l.kappa > 0.5 * DETECTED_NARROW {
        let half = vec2f(sqrt(max(0.5 + 0.5 * azimuth.x, 0.0)), select(-1.0, 1.0, azimuth.y >= 0.0) * sqrt(max(0.5 - 0.5 * azimuth.x, 0.0)));
        return l.amplitude * azimuth_tt(r, sigma_a, l.kappa, half);
    }
    var sum = vec3f(0.0);
    let count = deon_gamma_count(l.kappa);
    for (var k = 0u; k < count; k++) {
        let node = gamma_node(count, k);
        let exit = first_exit(ray_at(r, sigma_a, node.x, node.y));
        sum += node.z * seen(exit, l, azimuth, node.w);
    }
    return sum;
}

// p = 2, p = 3, and all above.
struct Higher { p2: vec3f, p3: vec3f, remainder: vec3f }

// The remainder p > 3, a geometric series per ray, leaves at all azimuths alike: after three reflections inside it nearly does.
fn azimuth_deon_higher(r: Refraction, sigma_a: vec3f, l: DetectedLight, azimuth: vec2f) -> Higher {
    var sum = Higher(vec3f(0.0), vec3f(0.0), vec3f(0.0));
    let count = deon_gamma_count(l.kappa);
    for (var k = 0u; k < count; k++) {
        let node = gamma_node(count, k);
        let ray = ray_at(r, sigma_a, node.x, node.y);
        let second = next_exit(ray, first_exit(ray));
        let third = next_exit(ray, second);
        sum.p2 += node.z * seen(second, l, azimuth, node.w);
        sum.p3 += node.z * seen(third, l, azimuth, node.w);
        sum.remainder += 2.0 * node.z * l.mass * energy_beyond(ray, third);
    }
    return sum;
}

// Energy of a ray and of its mirror image that light and detector let through; the node stands for `span` of gamma.
fn seen(exit: Exit, l: DetectedLight, azimuth: vec2f, span: f32) -> vec3f {
    let footprint = DEON_FOOTPRINT * span * exit.slope;
    let even = azimuth.x * exit.azimuth.x;
    let odd = azimuth.y * exit.azimuth.y;
    return exit.energy * (detected_at(l, even + odd, footprint) + detected_at(l, even - odd, footprint));
}
