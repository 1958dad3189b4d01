//!use lib/lobe_averages.wgsl
//!use lib/longitudinal.wgsl
//!use lib/paths.wgsl
// Forward and backward averages of one fibre's scattering (Xu 2011, Eq 32 with true cosines), unsmoothed circular fibre.

// R, TT and TRT alone lose what higher orders carry.
const IS_LOSSLESS: bool = false;

const AVERAGE_OUTER: u32 = 6u;
const AVERAGE_GAMMA: u32 = 16u;

// `sigma_a` of one colour channel, `theta` the inclination of the light. The forward weight of an azimuth difference phi is
// abs(phi)/pi, the backward weight 1 - abs(phi)/pi (the printed integral of Eq 33 is the backward one).
fn scattering_averages(f: Fibre, sigma_a: f32, theta: f32) -> Averages {
    let theta_i = guarded(theta, -HALF_PI, HALF_PI, 0.0);
    let sigma = vec3f(guarded(sigma_a, 0.0, 1e4, 0.0));
    var shares = array<vec2f, 3>(vec2f(0.0), vec2f(0.0), vec2f(0.0));
    for (var t = 0u; t < 3u; t++) {
        let mean = 2.0 * f.alpha[t] - theta_i;
        let g = product_gaussian(mean, f.beta[t], theta_i, 0.0, 0.0);
        for (var k = 0u; k < AVERAGE_OUTER; k++) {
            let node = outer_node(g, AVERAGE_OUTER, k, mean, f.beta[t], theta_i, 0.0, 0.0, false);
            let r = refraction(f.eta, node.cos_theta_d);
            var split = vec2f(0.0);
            for (var j = 0u; j < AVERAGE_GAMMA; j++) {
                let ray = gamma_node(AVERAGE_GAMMA, j);
                let path = path_at(r, sigma, t, ray.x, ray.y);
                let forward = min(abs(wrapped(path.azimuth)) / PI, 1.0);
                split += 2.0 * ray.z * path.energy.x * vec2f(forward, 1.0 - forward);
            }
            // The node's weight holds cos^2 of the integration angle; Eq 32 has one cosine of either end. At a pole the cosine is a
            // rounding error of either sign; kept positive, it leaves the means over the lobes defined.
            shares[t] += node.weight * max(cos(theta_i), 1e-6) / max(node.cos_theta_i, 1e-6) * split;
        }
    }
    return averages_of(shares, f);
}
