//!use lib/xu2011_azimuth.wgsl
// The inner integral of TRT of Xu 2011 (section 4.2.4 and 4.2.5): three circular Gaussians below eta' = 2, one above.

// The range of eta' above 2 over which the bandwidth goes from w_c to that of the single Gaussian.
const XU_BLEND: f32 = 0.3;

fn xu_azimuth_trt(f: Fibre, theta_d: f32, cos_theta_d: f32, kappa: f32, light: XuLight) -> vec3f {
    var eta = f.eta;
    if f.eccentricity != 1.0 {
        // Eq 26: the mean of eta*(phi_h) under the light, from the mean of cos^2 (Eq 14's table).
        let index = eccentric_index(f.eta, f.eccentricity);
        eta = clamp(index.x + index.y * (2.0 * mean_cosine_powers(kappa, light.sum_half_cos).low.y - 1.0), 1.0, XU_ETA_MAX);
    }
    let r = refraction(eta, cos_theta_d);
    let e = xu_energy(r, f.sigma_a, 2u, xu_moments(eta, theta_d, 2u));
    let at_zero = e.through * xu_trt_surface(eta, cos_theta_d) * 0.25 / max(abs(2.0 / r.eta_p - 1.0), 1e-3);
    if r.eta_p < 2.0 {
        let n_0 = at_zero + xu_oblique(f.sigma_a, r);
        return xu_three(r.eta_p, n_0, e.energy, f.azimuthal_width, kappa, light.half);
    }
    // Above: N_TRT(0) and the energy give the bandwidth, which starts at w_c; the height follows it.
    let width = xu_bandwidth(e.energy, at_zero);
    let blended = max(mix(vec3f(f.azimuthal_width), width, smoothstep(2.0, 2.0 + XU_BLEND, r.eta_p)), vec3f(XU_MIN_WIDTH));
    return xu_lobe(at_zero * width / blended, blended, kappa, light.half.y * light.half.y);
}

// (1 - F)^2 F.
fn xu_trt_surface(eta: f32, cos_i: f32) -> f32 {
    let reflected = schlick(schlick_f0(eta), cos_i);
    return (1.0 - reflected) * (1.0 - reflected) * reflected;
}

// What the two rays with gamma_i = 2 gamma_t, cos gamma_t = eta'/2, add to N_TRT(0) (Eq 9 sums over all h): for sqrt 2 < eta' < 2.
fn xu_oblique(sigma_a: vec3f, r: Refraction) -> vec3f {
    let cos_gamma = 0.5 * r.eta_p * r.eta_p - 1.0;
    if cos_gamma <= 0.0 { return vec3f(0.0); }
    let slope = max(2.0 / cos_gamma - 8.0 / (r.eta_p * r.eta_p), 2e-3);
    return exp(-2.0 * r.eta_p * r.inv_cos_theta_t * sigma_a) * xu_trt_surface(r.eta, r.cos_theta_d * cos_gamma) / slope;
}

// Eq 20 and 21: peaks of bandwidth w_c at the caustics and a residue of bandwidth phi* between them.
fn xu_three(eta_p: f32, n_0: vec3f, energy: vec3f, w_c: f32, kappa: f32, half: vec2f) -> vec3f {
    // The caustic leaves at phi* = 4 gamma_t - 2 gamma_i: half of it from the ray's own sines and cosines.
    let sin_gamma = sqrt(min((4.0 - eta_p * eta_p) / 3.0, 1.0));
    let cos_gamma = sqrt(max((eta_p * eta_p - 1.0) / 3.0, 0.0));
    let sin_t = sin_gamma / eta_p;
    let cos_t = sqrt(max(1.0 - sin_t * sin_t, 0.0));
    let twice_t = doubled_angle(vec2f(cos_t, sin_t));
    let peak = vec2f(twice_t.x * cos_gamma + twice_t.y * sin_gamma, twice_t.y * cos_gamma - twice_t.x * sin_gamma);
    let phi = max(2.0 * atan2(abs(peak.y), peak.x), XU_MIN_WIDTH);

    let sharpness = 2.0 / (w_c * w_c);
    let beside = 1.0 - exp(-2.0 * sharpness * peak.y * peak.y);
    let b_2 = n_0 * beside * beside;
    // Eq 20's b_1 can be negative.
    let b_1 = max(energy - 1.77245385 * phi * b_2, vec3f(0.0)) / (2.0 * 1.77245385 * w_c);
    let even = half.y * peak.x;
    let odd = half.x * peak.y;
    let peaks = circular_product(kappa, sharpness, (even - odd) * (even - odd)) + circular_product(kappa, sharpness, (even + odd) * (even + odd));
    return b_1 * peaks + b_2 * circular_product(kappa, 2.0 / (phi * phi), half.y * half.y);
}
