//!use lib/single.wgsl
//!use lib/half_circle.wgsl
// Global multiple scattering (Xu 2011, Eq 27 and 28) of the fibre of d'Eon 2011: the integral of the forward-scattered light's density
// over solid angle, g(theta_i) s_f / cos theta_j, times S_p = M_p N_p. Stands in for lib/global.wgsl.

// 1 / cos(theta_j) stops growing here.
const GLOBAL_MIN_COS: f32 = 0.05;

// `sigma_f` is the bandwidth of the Gaussian in theta_i, radians; p >= 2 is TRT's.
fn global_scattering(f: Fibre, theta_o: f32, phi_o: f32, theta_j: f32, phi_j: f32, sigma_f: f32) -> Lobes {
    let v = prepare_view(f, theta_o, phi_o);
    let at_theta = guarded(theta_j, -HALF_PI, HALF_PI, 0.0);
    let width = guarded(sigma_f, 1e-3, 1e2, 1.0);
    let inv_sigma_sq = 1.0 / (width * width);
    let across = v.phi_o - guarded_azimuth(phi_j);
    let azimuth = vec2f(cos(across), sin(across));
    let counts = global_counts();
    let powers = window_cosine_powers(sqrt(max(0.5 + 0.5 * azimuth.x, 0.0)));
    var sums = array<vec3f, 3>(vec3f(0.0), vec3f(0.0), vec3f(0.0));
    for (var t = 0u; t < 3u; t++) {
        let g = cone_product(v.variance[t], v.theta_r[t], at_theta, inv_sigma_sq);
        for (var k = 0u; k < counts.x; k++) {
            let node = cone_node(g, counts.x, k, v.variance[t], v.theta_r[t], v.theta_o, at_theta, inv_sigma_sq);
            // The light is a plain Gaussian of the distance, not of the chord.
            let distance = node.theta_i - at_theta;
            let chord = 2.0 * sin(0.5 * distance);
            let weight = node.weight * exp(min(inv_sigma_sq * (chord * chord - distance * distance), 0.0));
            if t == 0u {
                sums[t] += vec3f(weight * mean_n_r(v.fresnel, node.cos_theta_d, powers));
            } else {
                sums[t] += weight * window_mean(refraction(f.eta, node.cos_theta_d), f, t, azimuth, counts.z);
            }
        }
    }
    let scale = 1.0 / (sqrt(PI) * width * max(cos(at_theta), GLOBAL_MIN_COS));
    return Lobes(scale * sums[0], scale * sums[1], scale * sums[2]);
}

// Mean of N_1 (t = 1), or of all higher N_p, over the half circle of phi_i around phi_j; `azimuth` holds cos and sin of phi_o - phi_j.
fn window_mean(r: Refraction, f: Fibre, t: u32, azimuth: vec2f, count: u32) -> vec3f {
    var sum = vec3f(0.0);
    for (var k = 0u; k < count; k++) {
        let node = gamma_node(count, k);
        let ray = ray_at(r, f.sigma_a, node.x, node.y);
        let first = first_exit(ray);
        if t == 1u {
            sum += node.z * window_seen(first, f, azimuth, node.w);
            continue;
        }
        let second = next_exit(ray, first);
        let third = next_exit(ray, second);
        sum += node.z * (window_seen(second, f, azimuth, node.w) + window_seen(third, f, azimuth, node.w) + energy_beyond(ray, third));
    }
    return sum / PI;
}

// Energy of a ray and its mirror image that leaves for the half circle.
fn window_seen(exit: Exit, f: Fibre, azimuth: vec2f, span: f32) -> vec3f {
    let footprint = 0.5 * exit.slope * span;
    let inv_bandwidth = inverseSqrt(f.azimuthal_width * f.azimuthal_width + footprint * footprint + 1e-8);
    let even = azimuth.x * exit.azimuth.x;
    let odd = azimuth.y * exit.azimuth.y;
    return exit.energy * (half_circle_share(even + odd, inv_bandwidth) + half_circle_share(even - odd, inv_bandwidth));
}
