//!use lib/global.wgsl
//!use lib/window_series.wgsl
// Eq 27 of Xu 2011 for many light directions and one view: what the fibre does to forward-scattered light is a cosine series in azimuth
// that is prepared per view, and Gaussians in theta_i that multiply in closed form. Circular fibre; lib/global.wgsl is the accurate one.

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

// A ray that exits at azimuth Phi, blurred by a Gaussian of
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
            let m = harmonic_order(i);
            harmonic[i] += pow(blur, m * m) * cos(m * path.azimuth) * energy;
        }
    }
    return series_of(mean, harmonic);
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

// What each lobe catches along theta of light that arrived from inclination theta and was scattered on by fibres of this direction: the sum
// over lobes and their windows is radiance per L dw. Scattering at fibres keeps detailed balance with cos^2 theta, the measure of uniform
// light; widening that keeps it too is diffusion on the three-sphere, whose heat kernel is a normal and its images at the poles:
// I(theta_i) = L dw exp(v/2) (N(theta_i - theta) - N(theta_i - image)) / cos(theta_i). No light is lost or won at any inclination.
fn diffused_lobes(v: ForwardView, theta: f32, light_variance: f32) -> vec3f {
    let centre = theta + (v.mean - theta) * light_variance / (v.variance + light_variance);
    let image = select(vec3f(-PI), vec3f(PI), centre > vec3f(0.0)) - theta;
    let lobes = lobes_at(v, vec3f(theta), light_variance) - lobes_at(v, image, light_variance);
    return exp(0.5 * light_variance) * max(lobes, vec3f(0.0));
}

// The lobes over cos^2 theta_d against cos(theta_i) times a normal around `at`: cosines are means over the product of the two normals.
fn lobes_at(v: ForwardView, at: vec3f, light_variance: f32) -> vec3f {
    let variance = v.variance + light_variance;
    let distance = v.mean - at;
    let normal = exp(-0.5 * distance * distance / variance) * inverseSqrt(TWO_PI * variance);
    let product = v.variance * light_variance / variance;
    let theta_i = at + distance * light_variance / variance;
    let cos_i = cos(theta_i) * exp(-0.5 * product);
    let cos2_d = 0.5 * (1.0 + cos(v.theta_o - theta_i) * exp(-0.5 * product));
    return normal * cos_i / max(cos2_d, vec3f(0.05));
}

// The integral of the lobes against light from one direction over all directions.
fn lobe_integrals(v: ForwardView) -> vec3f {
    let cos2_i = 0.5 * (1.0 + cos(2.0 * v.mean) * exp(-2.0 * v.variance));
    let cos2_d = 0.5 * (1.0 + cos(v.theta_o - v.mean) * exp(-0.5 * v.variance));
    return TWO_PI * cos2_i / max(cos2_d, vec3f(0.05));
}
