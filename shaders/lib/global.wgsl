//!use lib/prepared.wgsl
//!use lib/quality.wgsl
//!use lib/paths.wgsl
// Global multiple scattering: what forward-scattered light, spread over the half circle around phi_j and by a Gaussian in
// theta_i, sends to the view through one fibre (Xu 2011, Eq 27 and 28); circular fibre.

// 1 / cos(theta_j) stops growing here.
const GLOBAL_MIN_COS: f32 = 0.05;

// `sigma_f` is the bandwidth of the Gaussian in theta_i, radians.
fn global_scattering(f: Fibre, theta_o: f32, phi_o: f32, theta_j: f32, phi_j: f32, sigma_f: f32) -> Lobes {
    let v = prepare_view(f, theta_o, phi_o);
    let at_theta = guarded(theta_j, -HALF_PI, HALF_PI, 0.0);
    let width = guarded(sigma_f, 1e-3, 1e2, 1.0);
    let inv_sigma_sq = 1.0 / (width * width);
    let across = v.phi_o - guarded_azimuth(phi_j);
    let azimuth = vec2f(cos(across), sin(across));
    let counts = global_counts();
    // s_f = 1/pi on the half circle makes the azimuthal integral a mean over it.
    let powers = window_cosine_powers(sqrt(max(0.5 + 0.5 * azimuth.x, 0.0)));
    var sums = array<vec3f, 3>(vec3f(0.0), vec3f(0.0), vec3f(0.0));
    for (var t = 0u; t < 3u; t++) {
        let mean = v.mean[t];
        let beta = f.beta[t];
        let g = product_gaussian(mean, beta, v.theta_o, at_theta, inv_sigma_sq);
        let count = select(counts.y, counts.x, t == 0u);
        for (var k = 0u; k < count; k++) {
            let node = outer_node(g, count, k, mean, beta, v.theta_o, at_theta, inv_sigma_sq, true);
            if t == 0u {
                sums[t] += vec3f(node.weight * mean_n_r(v.fresnel, node.cos_theta_d, powers));
            } else {
                sums[t] += node.weight * window_mean(refraction(f.eta, node.cos_theta_d), f, t, azimuth, counts.z);
            }
        }
    }
    // Normalisation of g^u, and the projection of the light.
    let scale = 1.0 / (sqrt(PI) * width * max(cos(at_theta), GLOBAL_MIN_COS));
    return Lobes(scale * sums[0], scale * sums[1], scale * sums[2]);
}

// Mean of N_p over the half circle of phi_i around phi_j; `azimuth` holds cos and sin of phi_o - phi_j. Each node's energy counts by
// the share of its exit azimuth, blurred by w_c (TRT) and by the node's own span, that falls on the half circle.
fn window_mean(r: Refraction, f: Fibre, p: u32, azimuth: vec2f, count: u32) -> vec3f {
    var sum = vec3f(0.0);
    for (var k = 0u; k < count; k++) {
        let node = gamma_node(count, k);
        let path = path_at(r, f.sigma_a, p, node.x, node.y);
        let span = 0.5 * path.spread * node.w;
        let smooth_sq = select(0.0, f.azimuthal_width * f.azimuthal_width, p == 2u);
        let inv_bandwidth = inverseSqrt(smooth_sq + span * span + 1e-8);
        let even = azimuth.x * path.exit.x;
        let odd = azimuth.y * path.exit.y;
        sum += node.z * path.energy * (half_circle_share(even + odd, inv_bandwidth) + half_circle_share(even - odd, inv_bandwidth));
    }
    return sum / PI;
}

// Share of a Gaussian around an azimuth of cosine `c` that lies where the cosine is positive.
fn half_circle_share(c: f32, inv_bandwidth: f32) -> f32 {
    // Distance to the edge, asin(c), by its series: exact where it matters, near the edge.
    let inside = c * (1.0 + c * c * (0.1667 + 0.4 * c * c));
    return 0.5 + 0.5 * error_function(inside * inv_bandwidth);
}

// erf(x) within 4e-4: tanh of an odd cubic.
fn error_function(x: f32) -> f32 {
    let y = clamp(x, -4.0, 4.0);
    return tanh(y * (1.1283792 + 0.1009 * y * y));
}
