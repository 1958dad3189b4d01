//!use lib/lobe_averages.wgsl
//!use lib/half_circle.wgsl
//!use lib/cone.wgsl
//!use lib/ray.wgsl
// Forward and backward averages of the fibre of d'Eon 2011, all orders: Xu 2011, Eq 32 with S_p = M_p N_p. Stands in for lib/averages.wgsl.
// The tilt goes with the light, so that the cone integrates to one and a fibre without absorption loses nothing.

// A fibre that absorbs nothing sends out what it gets.
const IS_LOSSLESS: bool = true;

const AVERAGE_OUTER: u32 = 6u;
const AVERAGE_GAMMA: u32 = 16u;

// `sigma_a` of one colour channel, `theta` the inclination of the light.
fn scattering_averages(f: Fibre, sigma_a: f32, theta: f32) -> Averages {
    let theta_i = guarded(theta, -HALF_PI, HALF_PI, 0.0);
    let sigma = vec3f(guarded(sigma_a, 0.0, 1e4, 0.0));
    let detector = 0.70710678 * f.azimuthal_width;
    var shares = array<vec2f, 3>(vec2f(0.0), vec2f(0.0), vec2f(0.0));
    for (var t = 0u; t < 3u; t++) {
        let v = cone_variance(f.beta[t]);
        let axis = folded(theta_i - 2.0 * f.alpha[t]);
        let g = cone_product(v, axis, 0.0, 0.0);
        var sum = vec2f(0.0);
        var whole = 0.0;
        for (var k = 0u; k < AVERAGE_OUTER; k++) {
            let node = cone_node(g, AVERAGE_OUTER, k, v, axis, theta_i, 0.0, 0.0);
            sum += node.weight * azimuth_split(refraction(f.eta, node.cos_theta_d), sigma, t, detector);
            whole += node.weight;
        }
        shares[t] = sum / max(whole, 1e-6);
    }
    return averages_of(shares, f);
}

// Energy that leaves forward and backward at one theta_d; t = 2 is p = 2, p = 3 and all above.
fn azimuth_split(r: Refraction, sigma: vec3f, t: u32, detector: f32) -> vec2f {
    var split = vec2f(0.0);
    for (var j = 0u; j < AVERAGE_GAMMA; j++) {
        let node = gamma_node(AVERAGE_GAMMA, j);
        let ray = ray_at(r, sigma, node.x, node.y);
        if t == 0u {
            let forward = forward_share(ray.enter, detector);
            split += 2.0 * node.z * ray.reflected * vec2f(forward, 1.0 - forward);
            continue;
        }
        let first = first_exit(ray);
        if t == 1u {
            let forward = forward_share(first.azimuth, detector);
            split += 2.0 * node.z * first.energy.x * vec2f(forward, 1.0 - forward);
            continue;
        }
        let second = next_exit(ray, first);
        let third = next_exit(ray, second);
        let forward = vec2f(forward_share(second.azimuth, detector), forward_share(third.azimuth, detector));
        let energy = vec2f(second.energy.x, third.energy.x);
        // Orders above leave at all azimuths alike.
        split += 2.0 * node.z * (vec2f(dot(energy, forward), dot(energy, vec2f(1.0) - forward)) + vec2f(0.5 * energy_beyond(ray, third).x));
    }
    return split;
}
