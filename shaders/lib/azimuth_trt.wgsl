//!use lib/paths.wgsl
//!use lib/tables.wgsl
//!use lib/quality.wgsl
// TRT, smoothed by the normalised circular Gaussian of bandwidth w_c: a sum over gamma of energies that leave at an
// exit azimuth (Gaussian detectors, d'Eon 2011, section 4.2), each blurred by light and w_c together.

// A node stands for its share of gamma: its exit azimuths are blurred by at least this part of what the share spans.
const TRT_FOOTPRINT: f32 = 0.4;

// Newton steps for the meeting point of light and lobe in an elliptic fibre.
const ELLIPTIC_STEPS: u32 = 2u;
// Least change of phi_i plus exit azimuth with phi_i.
const ELLIPTIC_SLOPE_MIN: f32 = 0.4;

// Integral of N_TRT times exp(kappa (cos(phi_i - phi_j) - 1)) over phi_i; `half` holds cos and sin of (phi_o - phi_j)/2.
fn azimuth_trt(r: Refraction, sigma_a: vec3f, w_c: f32, kappa: f32, half: vec2f) -> vec3f {
    let light = von_mises(kappa);
    let blurred_kappa = convolved(kappa, light.convolution, 2.0 / (w_c * w_c));
    let blurred = von_mises(blurred_kappa);
    return light.i0e / blurred.i0e * trt_paths(r, sigma_a, blurred_kappa, blurred.root, half, trt_gamma_count());
}

// Sum over gamma of the energies that leave, each times exp(kappa (cos(azimuth - Phi) - 1)); `root` is sqrt(kappa).
fn trt_paths(r: Refraction, sigma_a: vec3f, kappa: f32, root: f32, half: vec2f, count: u32) -> vec3f {
    let a = absorption(r, sigma_a, 2u);
    let across = doubled_angle(half);
    var sum = vec3f(0.0);
    for (var k = 0u; k < count; k++) {
        let node = gamma_node(count, k);
        let passage = passage_at(r, 2u, node.x, node.y);
        // A concentration limited by the footprint keeps the energy: density scales with its root.
        let footprint = max(TRT_FOOTPRINT * node.w * passage.spread, 3e-3);
        let scale = min(1.0, 1.0 / (footprint * root + 1e-6));
        let limited = scale * scale * kappa;
        let even = across.x * passage.exit.x - 1.0;
        let odd = across.y * passage.exit.y;
        sum += node.z * passage.surface * scale * (exp(limited * (even + odd)) + exp(limited * (even - odd))) * absorbed(a, passage.cos_t);
    }
    return sum;
}

// The same for an elliptic section, eta*(phi_h) inside the integral (Xu 2011, Eq 25): per node and mirror image the index is
// taken where light and lobe meet, and the exit azimuth is linear in phi_i about that point.
fn azimuth_trt_elliptic(f: Fibre, cos_theta_d: f32, kappa: f32, phi_o: f32, phi_j: f32) -> vec3f {
    let index = eccentric_index(f.eta, f.eccentricity);
    let light = von_mises(kappa);
    let lobe_kappa = 2.0 / (f.azimuthal_width * f.azimuthal_width);
    var sum = vec3f(0.0);
    let count = trt_gamma_count();
    for (var k = 0u; k < 2u * count; k++) {
        let node = gamma_node(count, k >> 1u);
        let mirror = select(1.0, -1.0, (k & 1u) == 1u);
        let gamma = mirror * 2.0 * atan2(node.x, node.y);
        // Newton's method for the meeting point x = phi_i - phi_j, weighted by the two concentrations.
        var x = 0.0;
        var meeting: Meeting;
        for (var step = 0u; step < ELLIPTIC_STEPS; step++) {
            meeting = meeting_at(index, cos_theta_d, node, mirror, gamma, phi_o, phi_j, x);
            let lobe = lobe_kappa * meeting.slope * meeting.slope;
            x = meeting.centre * lobe / (kappa + lobe);
        }
        meeting = meeting_at(index, cos_theta_d, node, mirror, gamma, phi_o, phi_j, x);
        let footprint = TRT_FOOTPRINT * node.w * meeting.spread;
        let lobe = min(lobe_kappa, 1.0 / (footprint * footprint + 1e-5)) * meeting.slope * meeting.slope;
        let blurred = convolved(kappa, light.convolution, lobe);
        let amplitude = light.i0e / (von_mises(blurred).i0e * meeting.slope);
        let reflected = fresnel_dielectric(cos_theta_d * node.y, meeting.r.eta);
        let transmitted = 1.0 - reflected;
        let half_sin = sin(0.5 * meeting.centre);
        sum += node.z * transmitted * transmitted * reflected * amplitude * exp(-2.0 * blurred * half_sin * half_sin)
            * exp(-4.0 * meeting.cos_t * meeting.r.inv_cos_theta_t * f.sigma_a);
    }
    return sum;
}

// One TRT path of an elliptic fibre, linear in x = phi_i - phi_j about a point.
struct Meeting {
    r: Refraction,
    cos_t: f32,
    centre: f32,      // where the exit azimuth meets phi_o, in [-pi, pi]
    slope: f32,       // change of (phi_i + exit azimuth) with phi_i
    spread: f32,      // abs(dPhi/dgamma)
}

fn meeting_at(index: vec2f, cos_theta_d: f32, node: vec4f, mirror: f32, two_gamma: f32, phi_o: f32, phi_j: f32, x: f32) -> Meeting {
    let sum = phi_o + phi_j + x;
    let r = refraction(max(index.x + index.y * cos(sum), 1.0), cos_theta_d);
    let sin_t = min(node.x / r.eta_p, 1.0);
    let cos_t = sqrt(max(1.0 - sin_t * sin_t, 1e-6));
    let phi = mirror * 4.0 * atan2(sin_t, cos_t) - two_gamma;
    // dgamma_t/deta = -tan gamma_t eta / (eta'^2 cos^2 theta_d).
    let bend = -4.0 * mirror * sin_t / cos_t * r.eta / (r.eta_p * r.eta_p * cos_theta_d * cos_theta_d);
    // A path whose exit azimuth outruns phi_i has no single meeting point: the slope stays positive, the centre on the circle.
    let slope = max(1.0 - bend * index.y * sin(sum), ELLIPTIC_SLOPE_MIN);
    let centre = clamp(x + wrapped(phi_o - phi_j - x - phi) / slope, -PI, PI);
    return Meeting(r, cos_t, centre, slope, abs(4.0 * node.y / (r.eta_p * cos_t) - 2.0));
}
