//!use lib/prepared.wgsl
//!use lib/xu2011_azimuth.wgsl
//!use lib/xu2011_trt.wgsl
// Single scattering of one SRBF light as Xu 2011 prints it (section 4.2), with M normalised to one: in the place of lib/single.wgsl.
// theta's share of the light is a plain Gaussian; what it and the lobe multiply is linear between m + 1 samples (section 4.2.2).

// Segments m, 2 to 16.
override segments: u32 = 4u;

fn single_scattering(v: PreparedView, theta_j: f32, phi_j: f32, lambda: f32) -> Lobes {
    let width = guarded(lambda, 1e-3, 1e3, 1.0);
    return scattered(v, guarded(theta_j, -HALF_PI, HALF_PI, 0.0), guarded_azimuth(phi_j), 1.0 / (width * width));
}

// A uniform environment of radiance 1: the light of infinite bandwidth.
fn single_scattering_constant(v: PreparedView) -> Lobes {
    return scattered(v, 0.0, 0.0, 0.0);
}

fn scattered(v: PreparedView, theta_j: f32, phi_j: f32, inv_lambda_sq: f32) -> Lobes {
    let half_across = 0.5 * (v.phi_o - phi_j);
    let half_sum = 0.5 * (v.phi_o + phi_j);
    let light = XuLight(2.0 * cosine(theta_j) * inv_lambda_sq, vec2f(cos(half_across), sin(half_across)), abs(cos(half_sum)));
    return Lobes(
        outer_integral(v, 0u, theta_j, inv_lambda_sq, light),
        outer_integral(v, 1u, theta_j, inv_lambda_sq, light),
        outer_integral(v, 2u, theta_j, inv_lambda_sq, light));
}

// Eq 11's last line: the product of the Gaussians of light and lobe is a Gaussian; the first m - 1 samples lie its bandwidth apart around
// its centre, the others at the poles, where the integrand vanishes. Samples that would lie beyond a pole lie on it.
fn outer_integral(v: PreparedView, lobe: u32, theta_j: f32, inv_lambda_sq: f32, light: XuLight) -> vec3f {
    let beta = v.f.beta[lobe];
    let mean = v.mean[lobe];
    let lobe_precision = 0.125 / (beta * beta);
    let inv_width = sqrt(inv_lambda_sq + lobe_precision);
    let width = 1.0 / inv_width;
    let centre = (inv_lambda_sq * theta_j + lobe_precision * mean) * width * width;
    let apart = mean - theta_j;
    let peak = exp(-apart * apart * inv_lambda_sq * lobe_precision * width * width) * 0.5 * INV_SQRT_TWO_PI / beta;

    var u = (-HALF_PI - centre) * inv_width;
    var share = gaussian_share(u);
    var value = vec3f(0.0);
    var sum = vec3f(0.0);
    for (var k = 0u; k < segments; k++) {
        let theta = select(centre + (f32(k) - 0.5 * f32(segments - 2u)) * width, HALF_PI, k + 1u == segments);
        let theta_i = clamp(theta, -HALF_PI, HALF_PI);
        let next_u = (theta_i - centre) * inv_width;
        let next_share = gaussian_share(next_u);
        let cos_theta_i = cosine(theta_i);
        var next_value = vec3f(0.0);
        if cos_theta_i > 1e-6 {
            let cos_theta_d = max(cosine(0.5 * (v.theta_o - theta_i)), 1e-4);
            let cosines = cos_theta_i / cos_theta_d;
            next_value = cosines * cosines * inner_integral(v, lobe, 0.5 * abs(v.theta_o - theta_i), cos_theta_d, light.kappa_scale * cos_theta_i, light);
        }
        // Integrals of exp(-u^2) and of u exp(-u^2) over the segment.
        let step = next_u - u;
        let zeroth = 0.88622692545 * (next_share.x - share.x);
        let first = 0.5 * (share.y - next_share.y);
        if step > 1e-4 {
            let slope = (next_value - value) / step;
            sum += (value - slope * u) * zeroth + slope * first;
        }
        u = next_u;
        share = next_share;
        value = next_value;
    }
    return max(sum, vec3f(0.0)) * width * peak;
}

// erf(u) and exp(-u^2): Abramowitz and Stegun 7.1.26, within 1.5e-7.
fn gaussian_share(u: f32) -> vec2f {
    let x = min(abs(u), 9.0);
    let e = exp(-x * x);
    let t = 1.0 / (1.0 + 0.3275911 * x);
    let tail = t * (0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429))));
    return vec2f(sign(u) * (1.0 - tail * e), e);
}

fn inner_integral(v: PreparedView, lobe: u32, theta_d: f32, cos_theta_d: f32, kappa: f32, light: XuLight) -> vec3f {
    switch lobe {
        case 0u: { return vec3f(azimuth_r(schlick_polynomial(v.f.eta), cos_theta_d, kappa, abs(light.half.x))); }
        case 1u: { return xu_azimuth_tt(v.f, theta_d, cos_theta_d, kappa, light); }
        default: { return xu_azimuth_trt(v.f, theta_d, cos_theta_d, kappa, light); }
    }
}
