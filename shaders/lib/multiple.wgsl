// Multiple scattering at a point of a fibre, from the path sums towards one light (pass/transmittance_path.wgsl) and the table of averages.
// A pass that uses it declares `tables` (lib/tables.wgsl) and `averages_table` (lib/averages_table.wgsl).
//
// D: light scattered forward on its way (global). L: light sent back by the neighbourhood (local). U: light sent back by the hair behind
// (M2) or turned round any number of times (M3).
// All values are radiance per L dw: radiance of the light times the solid angle that the direction stands for.
//!use lib/forward.wgsl
//!use lib/averages_table.wgsl

// M2 = S + 1.1 D + 0.2 L + 0.25 U: weights held against path tracing of a groom of 3,000 strands.
const M2_WEIGHTS: vec3f = vec3f(1.1, 0.2, 0.25);

// M3 = S + D + U: no weights. Light that turned round has been scattered about so often that it spreads over theta_i by this variance more
// than light that goes on; beyond it the inclinations are as good as mixed.
const M3_TURNED_MOST: f32 = 1.0;

// d_f and d_b of Zinke 2008.
const ZINKE_DENSITY: f32 = 0.7;

// 1 / cos(theta) of a light direction stops growing here.
const MULTIPLE_MIN_COS: f32 = 0.05;

// The path sums of one (point, light).
struct PathRecord {
    s_f: vec3f,              // sum of 1 - a_f: -ln of the mean of exp(-S_f) over the lobe
    spread: f32,             // sum of beta_f^2 over the fibres crossed / (1 - exp(-n)), theta_h
    kappa: vec3f,            // 2 sum of k behind the point
    n: f32,                  // -ln of the mean of exp(-n)
}

struct MultipleTerms {
    d: vec3f,
    l: vec3f,
    u: vec3f,
}

// What the terms need of fibre and view, whatever the light.
struct MultipleView {
    fibre: Fibre,
    theta_o: f32,
    phi_o: f32,
    forward: ForwardView,
    sigma_place: vec3f,      // the absorption's place in the table of averages
    a_f: vec3f,              // at theta_o
    a_b: vec3f,
    rho: vec3f,              // reflectance of a half space of such fibres
    turned_variance: f32,    // by which turning round widens light in theta_i
    share: f32,              // least k / (1 - a_f): light that was turned round dies away that much slower than light scattered forward
}

// What a neighbourhood sends back at one inclination.
struct Backward {
    a_b: vec3f,              // A_b
    delta_b: vec3f,          // mean shift, theta_i
    variance: vec3f,         // sigma_b^2, theta_i
}

fn unpack_path(words: vec4u) -> PathRecord {
    let head = unpack2x16float(words.y);
    let tail = unpack2x16float(words.w);
    return PathRecord(vec3f(unpack2x16float(words.x), head.x), head.y, vec3f(unpack2x16float(words.z), tail.x), tail.y);
}

fn prepare_multiple(f: Fibre, theta_o: f32, phi_o: f32) -> MultipleView {
    var v = MultipleView(f, theta_o, phi_o, prepare_forward(f, theta_o), vec3f(0.0), vec3f(0.0), vec3f(0.0), vec3f(0.0), 0.0, 1.0);
    for (var c = 0u; c < 3u; c++) {
        let at_view = fibre_averages(f.sigma_a[c], theta_o);
        v.sigma_place[c] = averages_sigma_place(f.sigma_a[c]);
        v.a_f[c] = at_view.a_f;
        v.a_b[c] = at_view.a_b;
        v.share = min(v.share, at_view.k / max(1.0 - at_view.a_f, K_MIN));
        v.rho[c] = half_space_reflectance(f.sigma_a[c]);
        v.turned_variance += min(turned_variance(at_view), M3_TURNED_MOST) / 3.0;
    }
    return v;
}

// What light that a half space sends back spreads over theta_i. It is scattered d ln(rho) / d ln(a) times on average, a being the power that
// each fibre passes on: once backward, otherwise forward.
fn turned_variance(m: FibreAverages) -> f32 {
    let growth = (m.a_f * (1.0 - m.a_f) + m.a_b * m.a_b) / m.k;
    let forward = (m.a_f + growth) / (1.0 - m.a_f + m.k);
    return 4.0 * (m.beta_b * m.beta_b + forward * m.beta_f * m.beta_f);
}

// What both M2 and M3 need of a light's direction and path.
struct Arriving {
    direct: f32,             // crosses no fibre
    t_f: vec3f,              // does not turn round
    scattered: vec3f,        // does not turn round, crosses fibres
    phi_d: f32,
    variance: f32,           // of what was scattered, theta_i
}

fn arriving(v: MultipleView, phi: f32, path: PathRecord) -> Arriving {
    let direct = exp(-path.n);
    let t_f = exp(-path.s_f);
    // beta_f is a standard deviation in theta_h, a deviation in theta_i is twice as wide.
    return Arriving(direct, t_f, max(t_f - direct, vec3f(0.0)), abs(wrapped(v.phi_o - phi)), 4.0 * max(path.spread, 1e-5));
}

// The terms of M2 without their weights, for light from (theta, phi).
fn m2_terms(v: MultipleView, theta: f32, phi: f32, path: PathRecord) -> MultipleTerms {
    let light = arriving(v, phi, path);
    var terms: MultipleTerms;
    terms.d = light.scattered * forward_scattering(v.forward, theta, cos(light.phi_d), light.variance);

    // b = exp(-kappa); with 1 - b from its series where the subtraction would cancel.
    let b = exp(-path.kappa);
    let one_minus_b = select(1.0 - b, path.kappa * (1.0 - 0.5 * path.kappa), path.kappa < vec3f(1e-2));
    // What a layer of finite depth sends back over what a half space does: A_b is a half space's, a lone fibre has no neighbours.
    let depth_share = one_minus_b / max(1.0 - v.rho * v.rho * b, vec3f(1e-6));

    let lit = select(0.0, 1.0 / PI, light.phi_d < HALF_PI);
    let around = (PI - light.phi_d) / (PI * PI);
    let back = backward(v, theta, false);
    terms.l = depth_share * (light.direct * lit * local_scattering(v, back, theta, 0.0)
        + light.scattered * around * local_scattering(v, back, theta, light.variance));
    terms.u = v.rho * depth_share * light.t_f * mix(v.a_f, v.a_b, light.phi_d / PI) / PI;
    return terms;
}

// The terms of M3. D: what did not turn round, within the half circle around the light's azimuth. U: what two streams along the light's line
// carry to the point, there and back, beyond it; at any azimuth.
fn m3_terms(v: MultipleView, theta: f32, phi: f32, path: PathRecord) -> MultipleTerms {
    let light = arriving(v, phi, path);
    let cos_x = cos(light.phi_d);
    let series = v.forward.series;
    let onward = diffused_lobes(v.forward, theta, min(light.variance, M3_TURNED_MOST));
    let turned = diffused_lobes(v.forward, theta, min(light.variance + v.turned_variance, M3_TURNED_MOST));

    var terms: MultipleTerms;
    terms.d = light.scattered
        * (onward.x * window_at(series[0], cos_x) + onward.y * window_at(series[1], cos_x) + onward.z * window_at(series[2], cos_x));
    terms.u = max(two_streams(v, theta, path) - light.t_f, vec3f(0.0))
        * (turned.x * series[0].mean + turned.y * series[1].mean + turned.z * series[2].mean);
    return terms;
}

// F + B at the point, for light of power 1 that enters the hair in front: dF/dx = -(1 - a_f) F + a_b B, -dB/dx = -(1 - a_f) B + a_b F,
// x counting fibres, nothing entering from behind. Fibres of one sort in front and behind have
// F = exp(-K) (1 - rho^2 b) / c, B = rho exp(-K) (1 - b) / c, c = 1 - rho^2 b exp(-2 K), K = sum of k in front, b = exp(-2 sum of k behind).
fn two_streams(v: MultipleView, theta: f32, path: PathRecord) -> vec3f {
    let b = exp(-path.kappa);
    // 1 - b from its series where the subtraction would cancel.
    let one_minus_b = select(1.0 - b, path.kappa * (1.0 - 0.5 * path.kappa), path.kappa < vec3f(1e-2));
    // The way in front knows the sum of 1 - a_f; k is its share in the fibres here.
    var share: vec3f;
    let place = averages_theta_place(theta);
    for (var c = 0u; c < 3u; c++) {
        let a_f = averages_entry(v.sigma_place[c], place, 0u).x;
        share[c] = averages_entry(v.sigma_place[c], place, 1u).z / max(1.0 - a_f, K_MIN);
    }
    let front = exp(-path.s_f * min(share, vec3f(1.0)));
    let returned = v.rho * v.rho * b;
    let carried = front * (1.0 - returned + v.rho * one_minus_b);
    return carried / max(1.0 - returned * front * front, vec3f(1e-6));
}

// Zinke 2008 under an SRBF light as Xu 2011 prints it (Eq 27, 29, the light's bandwidth inside sigma_f), densities d_f = d_b = 0.7
// included; per L_j times the lobe's solid angle, no term U.
fn zinke2008_terms(v: MultipleView, theta_j: f32, phi_j: f32, lambda_j: f32, path: PathRecord) -> MultipleTerms {
    let direct = exp(-path.n);
    let scattered = ZINKE_DENSITY * max(exp(-path.s_f) - direct, vec3f(0.0));
    let phi_d = abs(wrapped(v.phi_o - phi_j));
    let spread = max(path.spread * (1.0 - direct), 1e-5);
    let sigma_f = sqrt(lambda_j * lambda_j + 2.0 * spread);

    var terms: MultipleTerms;
    terms.d = scattered * all_lobes(global_scattering(v.fibre, v.theta_o, v.phi_o, theta_j, phi_j, sigma_f));
    let lit = select(0.0, 1.0 / PI, phi_d < HALF_PI);
    let around = (PI - phi_d) / (PI * PI);
    let back = backward(v, theta_j, true);
    terms.l = ZINKE_DENSITY * (direct * lit * local_scattering(v, back, theta_j, 0.5 * lambda_j * lambda_j)
        + scattered * around * local_scattering(v, back, theta_j, 0.5 * sigma_f * sigma_f));
    return terms;
}

fn all_lobes(lobes: Lobes) -> vec3f {
    return lobes.r + lobes.tt + lobes.trt;
}

// Eq 29 without its azimuth, for light whose inclination is normal around theta with the given variance (theta_i): the product
// of the two normals is closed form, the cosines are taken at its centre.
fn local_scattering(v: MultipleView, back: Backward, theta: f32, light_variance: f32) -> vec3f {
    let mean = back.delta_b - v.theta_o;
    let variance = back.variance + light_variance;
    let distance = mean - theta;
    let normal = exp(-0.5 * distance * distance / variance) / sqrt(TWO_PI * variance);
    let theta_i = clamp(theta + distance * light_variance / variance, vec3f(-HALF_PI), vec3f(HALF_PI));
    let cos_d = max(cos(0.5 * (v.theta_o - theta_i)), vec3f(MULTIPLE_MIN_COS));
    let cos_i = max(cos(theta_i), vec3f(0.0));
    return 2.0 * back.a_b * normal * cos_i * cos_i / (cos_d * cos_d) / max(cos(theta), MULTIPLE_MIN_COS);
}

// What the neighbourhood sends back at the inclination (theta_o - theta) / 2.
fn backward(v: MultipleView, theta: f32, as_printed: bool) -> Backward {
    var back: Backward;
    for (var c = 0u; c < 3u; c++) {
        let m = backward_averages(v.sigma_place[c], 0.5 * (v.theta_o - theta));
        back.a_b[c] = select(m.x, m.w, as_printed);
        back.delta_b[c] = m.y;
        back.variance[c] = m.z;
    }
    return back;
}
