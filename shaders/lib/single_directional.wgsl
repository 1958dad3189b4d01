//!use lib/prepared.wgsl
//!use lib/azimuth_tt.wgsl
//!use lib/azimuth_trt.wgsl
// Single scattering of one SRBF light by brute force: the light is spread over directions, each scattered at a point. In the place of
// lib/single.wgsl; what Xu 2011 compares with (1,536 directions).

// Directions per light, 16 to 4096.
override directions: u32 = 1024u;

// Nodes over gamma of TRT at a point.
const DIRECTIONAL_GAMMAS: u32 = 12u;

// The golden ratio's fractional part.
const GOLDEN: f32 = 0.61803398875;

fn single_scattering(v: PreparedView, theta_j: f32, phi_j: f32, lambda: f32) -> Lobes {
    return scattered(v, guarded(theta_j, -HALF_PI, HALF_PI, 0.0), guarded_azimuth(phi_j), guarded(lambda, 1e-3, 1e3, 1.0));
}

// A uniform environment of radiance 1: as good as the light of the largest bandwidth.
fn single_scattering_constant(v: PreparedView) -> Lobes {
    return scattered(v, 0.0, 0.0, 1e3);
}

fn scattered(v: PreparedView, theta_j: f32, phi_j: f32, lambda: f32) -> Lobes {
    // The light's frame: its centre, and the directions in which theta and phi grow.
    let s = vec2f(sin(theta_j), sin(phi_j));
    let c = vec2f(cosine(theta_j), cos(phi_j));
    let axis = vec3f(s.x, c.x * c.y, c.x * s.y);
    let towards_theta = vec3f(c.x, -s.x * c.y, -s.x * s.y);
    let towards_phi = vec3f(0.0, -s.y, c.y);
    let lobe = lobe_span(lambda);
    let lobe_kappa = 2.0 / (v.f.azimuthal_width * v.f.azimuthal_width);
    let smoothing = von_mises(lobe_kappa);

    var out = Lobes(vec3f(0.0), vec3f(0.0), vec3f(0.0));
    for (var k = 0u; k < directions; k++) {
        // A Fibonacci lattice, warped to the light's density: every direction has the same share of the light.
        let one_minus_cos = lobe_sample(lobe, (f32(k) + 0.5) / f32(directions));
        let turn = TWO_PI * fract(GOLDEN * f32(k));
        let across = sqrt(max(one_minus_cos * (2.0 - one_minus_cos), 0.0));
        let w = (1.0 - one_minus_cos) * axis + across * (cos(turn) * towards_theta + sin(turn) * towards_phi);
        let theta_i = asin(clamp(w.x, -1.0, 1.0));
        let phi_i = atan2(w.z, w.y);
        let lobes = scattered_from(v, theta_i, phi_i, lobe_kappa, smoothing);
        out.r += lobes.r;
        out.tt += lobes.tt;
        out.trt += lobes.trt;
    }
    let share = PI * lobe.lambda_sq * lobe.span / f32(directions);
    return Lobes(share * out.r, share * out.tt, share * out.trt);
}

// An SRBF light as a density over 1 - cos of the angle to its centre.
struct LobeSpan {
    lambda_sq: f32,
    span: f32,        // 1 - exp(-4 / lambda^2): the light's integral is pi lambda^2 times it
}

fn lobe_span(lambda: f32) -> LobeSpan {
    let x = 4.0 / (lambda * lambda);
    // The series where the subtraction would cancel.
    return LobeSpan(lambda * lambda, select(1.0 - exp(-x), x * (1.0 - 0.5 * x * (1.0 - x / 3.0)), x < 0.02));
}

// 1 - cos of the angle at which the share `u` of the light is reached.
fn lobe_sample(lobe: LobeSpan, u: f32) -> f32 {
    let y = u * lobe.span;
    let depth = select(-log(1.0 - y), y * (1.0 + y * (0.5 + y / 3.0)), y < 0.02);
    return clamp(0.5 * lobe.lambda_sq * depth, 0.0, 2.0);
}

// S_t cos(theta_i) for light from one direction (Xu 2011, Eq 6), TRT smoothed by w_c and with eta*(phi_h) of an elliptic section.
fn scattered_from(v: PreparedView, theta_i: f32, phi_i: f32, lobe_kappa: f32, smoothing: VonMises) -> Lobes {
    let cos_theta_i = cosine(theta_i);
    let cos_theta_d = max(cosine(0.5 * (v.theta_o - theta_i)), 1e-4);
    let half_across = 0.5 * (v.phi_o - phi_i);
    let half = vec2f(cos(half_across), sin(half_across));
    let from_lobe = (theta_i - v.mean) / v.f.beta;
    let m = 0.5 * INV_SQRT_TWO_PI / v.f.beta * exp(-0.125 * from_lobe * from_lobe) * cos_theta_i / (cos_theta_d * cos_theta_d);

    let y = abs(half.x);
    let n_r = 0.25 * y * fresnel_dielectric(cos_theta_d * y, v.f.eta);
    let r = refraction(v.f.eta, cos_theta_d);
    let tt = n_tt(r, absorption(r, v.f.sigma_a, 1u), abs(half.y));
    var r_trt = r;
    if v.f.eccentricity != 1.0 {
        let index = eccentric_index(v.f.eta, v.f.eccentricity);
        r_trt = refraction(max(index.x + index.y * cos(v.phi_o + phi_i), 1.0), cos_theta_d);
    }
    let trt = trt_paths(r_trt, v.f.sigma_a, lobe_kappa, smoothing.root, half, DIRECTIONAL_GAMMAS) / (TWO_PI * smoothing.i0e);
    return Lobes(vec3f(m.x * n_r), m.y * tt, m.z * trt);
}
