//!use lib/global.wgsl
//!use lib/window_series.wgsl
// Eq 27 of Xu 2011 for many light directions and one view of the fibre of d'Eon 2011. Stands in for lib/forward.wgsl: a cosine series in
// azimuth prepared per view, and the product of the light's normal with the cone in closed form. lib/global_deon.wgsl is the accurate one.


// What depends on fibre and view alone, for R, TT and TRT (p >= 2).
struct ForwardView {
    theta_o: f32,
    theta_r: vec3f,          // axes of the cones
    variance: vec3f,         // v of the cones
    series: array<WindowSeries, 3>,
}

fn prepare_forward(f: Fibre, theta_o: f32) -> ForwardView {
    let p = prepare_view(f, theta_o, 0.0);
    var v = ForwardView(p.theta_o, p.theta_r, p.variance, array<WindowSeries, 3>());
    for (var t = 0u; t < 3u; t++) {
        // Light arrives around the cone: its refraction stands for all.
        let cos_theta_d = max(cos(p.theta_o - f.alpha[t]), 0.05);
        v.series[t] = window_series(refraction(f.eta, cos_theta_d), f, t);
    }
    return v;
}

// A ray that exits at azimuth Phi through a detector of bandwidth
// b multiplies harmonic m by cos(m Phi) exp(-m^2 b^2 / 4).
fn window_series(r: Refraction, f: Fibre, t: u32) -> WindowSeries {
    var mean = vec3f(0.0);
    var harmonic = array<vec3f, FORWARD_HARMONICS>();
    for (var k = 0u; k < FORWARD_GAMMAS; k++) {
        let node = gamma_node(FORWARD_GAMMAS, k);
        let ray = ray_at(r, f.sigma_a, node.x, node.y);
        var exit = first_exit(ray);
        if t == 0u {
            exit = Exit(vec3f(ray.reflected), ray.enter, -2.0);
        }
        // t = 2 takes the orders 2 and 3; those above count in the mean alone.
        for (var p = min(t, 1u); p <= select(t, 3u, t == 2u); p++) {
            if p > 1u {
                exit = next_exit(ray, exit);
            }
            if p != 1u || t == 1u {
                let energy = node.z / PI * exit.energy;
                let span = 0.5 * exit.slope * node.w;
                let blur = exp(-0.25 * (f.azimuthal_width * f.azimuthal_width + span * span));
                let azimuth = atan2(exit.azimuth.y, exit.azimuth.x);
                mean += energy;
                for (var i = 0u; i < FORWARD_HARMONICS; i++) {
                    let m = harmonic_order(i);
                    harmonic[i] += pow(blur, m * m) * cos(m * azimuth) * energy;
                }
            }
        }
        if t == 2u {
            mean += node.z / PI * energy_beyond(ray, exit);
        }
    }
    return series_of(mean, harmonic);
}

// Eq 27 for light that arrives normal around inclination theta with the given variance in theta_i, at an azimuth whose difference to the
// view's has the cosine `cos_x`. Cone and light multiply to a normal density; what is left of M_p is taken at two nodes of it.
fn forward_scattering(v: ForwardView, theta: f32, cos_x: f32, light_variance: f32) -> vec3f {
    let total = v.variance + light_variance;
    let distance = -v.theta_r - theta;
    let normal = exp(-0.5 * distance * distance / total) * sqrt(v.variance / total);
    let centre = theta + distance * light_variance / total;
    let step = sqrt(v.variance * light_variance / total);
    var sum = vec3f(0.0);
    for (var t = 0u; t < 3u; t++) {
        let low = centre[t] - step[t];
        let high = centre[t] + step[t];
        let cone = 0.5 * (cone_rest(v, t, low) * cos(low) + cone_rest(v, t, high) * cos(high));
        sum += normal[t] * cone * window_at(v.series[t], cos_x);
    }
    return sum / max(cos(theta), GLOBAL_MIN_COS);
}

// The same as lib/forward.wgsl's for cones.
fn diffused_lobes(v: ForwardView, theta: f32, light_variance: f32) -> vec3f {
    let centre = theta - (v.theta_r + theta) * light_variance / (v.variance + light_variance);
    let image = select(vec3f(-PI), vec3f(PI), centre > vec3f(0.0)) - theta;
    let lobes = lobes_at(v, vec3f(theta), light_variance) - lobes_at(v, image, light_variance);
    return exp(0.5 * light_variance) * max(lobes, vec3f(0.0));
}

// The cones against a normal around `at`.
fn lobes_at(v: ForwardView, at: vec3f, light_variance: f32) -> vec3f {
    let total = v.variance + light_variance;
    let distance = -v.theta_r - at;
    let normal = exp(-0.5 * distance * distance / total) * sqrt(v.variance / total);
    let centre = at + distance * light_variance / total;
    let step = sqrt(v.variance * light_variance / total);
    var lobes = vec3f(0.0);
    for (var t = 0u; t < 3u; t++) {
        lobes[t] = normal[t] * 0.5 * (cone_rest(v, t, centre[t] - step[t]) + cone_rest(v, t, centre[t] + step[t]));
    }
    return lobes;
}

// The integral of the cones over all directions.
fn lobe_integrals(v: ForwardView) -> vec3f {
    let step = sqrt(v.variance);
    var sums = vec3f(0.0);
    for (var t = 0u; t < 3u; t++) {
        let low = -v.theta_r[t] - step[t];
        let high = -v.theta_r[t] + step[t];
        sums[t] = 0.5 * (cone_rest(v, t, low) * cos(low) + cone_rest(v, t, high) * cos(high));
    }
    return TWO_PI * sqrt(TWO_PI * v.variance) * sums;
}

// M_p over exp(-(theta_i + theta_r)^2 / (2 v)); nothing beyond the poles.
fn cone_rest(v: ForwardView, t: u32, theta_i: f32) -> f32 {
    let variance = v.variance[t];
    let cosine = max(cos(theta_i), 0.0);
    let from_axis = theta_i + v.theta_r[t];
    let chord = 2.0 * sin(0.5 * from_axis);
    let ratio = exp(min(0.5 * (from_axis * from_axis - chord * chord) / variance, 10.0));
    return select(0.0, ratio * cone_scale(variance, cosine, cos(v.theta_r[t])), abs(theta_i) < HALF_PI);
}
