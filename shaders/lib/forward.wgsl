//!use lib/global.wgsl
// Eq 27 of Xu 2011 for many light directions and one view: what the fibre does to forward-scattered light is a cosine series in azimuth
// that is prepared per view, and Gaussians in theta_i that multiply in closed form. Circular fibre; lib/global.wgsl is the accurate one.

// Odd harmonics of the half circle that are kept: 1, 3, 5, 7.
const FORWARD_HARMONICS: u32 = 4u;
const FORWARD_GAMMAS: u32 = 8u;

// Mean of N_p over the half circle around an azimuth x off the view: mean + cos x (a polynomial of cos^2 x).
struct WindowSeries {
    mean: vec3f,
    odd: array<vec3f, FORWARD_HARMONICS>,
}

// What depends on fibre and view alone, for R, TT and TRT.
struct ForwardView {
    theta_o: f32,
    mean: vec3f,             // centres of the lobes in theta_i
    variance: vec3f,         // of the lobes in theta_i
    series: array<WindowSeries, 3>,
}

fn prepare_forward(f: Fibre, theta_o: f32) -> ForwardView {
    var v = ForwardView(theta_o, 2.0 * f.alpha - theta_o, 4.0 * f.beta * f.beta, array<WindowSeries, 3>());
    for (var p = 0u; p < 3u; p++) {
        // Light arrives around the lobe's centre: its refraction stands for all.
        let cos_theta_d = max(cos(theta_o - f.alpha[p]), 0.05);
        v.series[p] = window_series(refraction(f.eta, cos_theta_d), f, p);
    }
    return v;
}

// The half circle's cosine series is 1/2 + 2/pi (cos x - cos 3x / 3 + ...); a ray that exits at azimuth Phi, blurred by a Gaussian of
// bandwidth b, multiplies harmonic m by cos(m Phi) exp(-m^2 b^2 / 4).
fn window_series(r: Refraction, f: Fibre, p: u32) -> WindowSeries {
    var mean = vec3f(0.0);
    var harmonic = array<vec3f, FORWARD_HARMONICS>();
    let smooth_sq = select(0.0, f.azimuthal_width * f.azimuthal_width, p == 2u);
    for (var k = 0u; k < FORWARD_GAMMAS; k++) {
        let node = gamma_node(FORWARD_GAMMAS, k);
        let path = path_at(r, f.sigma_a, p, node.x, node.y);
        let energy = node.z / PI * path.energy;
        let span = 0.5 * path.spread * node.w;
        let blur = exp(-0.25 * (smooth_sq + span * span));
        mean += energy;
        for (var i = 0u; i < FORWARD_HARMONICS; i++) {
            let m = f32(2u * i + 1u);
            harmonic[i] += pow(blur, m * m) * cos(m * path.azimuth) * energy;
        }
    }
    // cos 3x, cos 5x and cos 7x as polynomials of c = cos x, sorted by the power of c.
    let h1 = 4.0 / PI * harmonic[0];
    let h3 = -4.0 / (3.0 * PI) * harmonic[1];
    let h5 = 4.0 / (5.0 * PI) * harmonic[2];
    let h7 = -4.0 / (7.0 * PI) * harmonic[3];
    return WindowSeries(mean, array(
        h1 - 3.0 * h3 + 5.0 * h5 - 7.0 * h7,
        4.0 * h3 - 20.0 * h5 + 56.0 * h7,
        16.0 * h5 - 112.0 * h7,
        64.0 * h7));
}

fn window_at(s: WindowSeries, cos_x: f32) -> vec3f {
    let c2 = cos_x * cos_x;
    // A series that was cut off swings a little below zero.
    return max(s.mean + cos_x * (s.odd[0] + c2 * (s.odd[1] + c2 * (s.odd[2] + c2 * s.odd[3]))), vec3f(0.0));
}

// Eq 27 for light that arrives normal around inclination theta with the given variance in theta_i, at an azimuth whose difference to the
// view's has the cosine `cos_x`. The cosines are means over the product of light and lobe.
fn forward_scattering(v: ForwardView, theta: f32, cos_x: f32, light_variance: f32) -> vec3f {
    let variance = v.variance + light_variance;
    let distance = v.mean - theta;
    let normal = exp(-0.5 * distance * distance / variance) * inverseSqrt(TWO_PI * variance);
    let product = v.variance * light_variance / variance;
    let theta_i = clamp(theta + distance * light_variance / variance, vec3f(-HALF_PI), vec3f(HALF_PI));
    let cos2_i = 1.0 + cos(2.0 * theta_i) * exp(-2.0 * product);
    let cos2_d = 1.0 + cos(v.theta_o - theta_i) * exp(-0.5 * product);
    let lobes = normal * cos2_i / max(cos2_d, vec3f(0.01));
    let sum = lobes.x * window_at(v.series[0], cos_x) + lobes.y * window_at(v.series[1], cos_x) + lobes.z * window_at(v.series[2], cos_x);
    return sum / max(cos(theta), GLOBAL_MIN_COS);
}
