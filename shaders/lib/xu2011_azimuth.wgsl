//!use lib/azimuth_r.wgsl
// The inner integrals of Xu 2011, R and TT: Schlick's reflectance, one circular Gaussian per colour for N_TT.

// What the inner integrals need of light and view azimuths.
struct XuLight {
    kappa_scale: f32,     // 2 / lambda'^2 = kappa_scale cos(theta_i)
    half: vec2f,          // cos and sin of (phi_o - phi_j)/2
    sum_half_cos: f32,    // abs(cos((phi_o + phi_j)/2))
}

// Narrowest circular Gaussian, radians.
const XU_MIN_WIDTH: f32 = 1e-3;

// Reflectance at normal incidence.
fn schlick_f0(eta: f32) -> f32 {
    let root = (1.0 - eta) / (1.0 + eta);
    return root * root;
}

// Schlick 1994.
fn schlick(f0: f32, cos_i: f32) -> f32 {
    let x = 1.0 - cos_i;
    let x2 = x * x;
    return f0 + (1.0 - f0) * x2 * x2 * x;
}

// The same as a polynomial of the cosine (Xu 2011, Eq 13).
fn schlick_polynomial(eta: f32) -> FresnelPolynomial {
    let f0 = schlick_f0(eta);
    let rest = 1.0 - f0;
    return FresnelPolynomial(vec4f(1.0, -5.0 * rest, 10.0 * rest, -10.0 * rest), vec4f(5.0 * rest, -rest, 0.0, 0.0));
}

// Integral over a circle of two circular Gaussians of peak one, concentrations a and b, whose centres differ by x, from sin^2(x/2): again
// a circular Gaussian, of concentration R.
fn circular_product(a: f32, b: f32, sin2_half: f32) -> f32 {
    let missing = 4.0 * a * b * sin2_half;
    let r = sqrt(max((a + b) * (a + b) - missing, 0.0));
    return TWO_PI * von_mises(r).i0e * exp(-missing / (r + a + b + 1e-20));
}

// T and its expansion to the fourth power of h (Eq 18, and Eq 22 with twice the absorption): T(0), and the integral of half of it times
// the Fresnel factors, whose moments are `h` (Eq 19, 23).
struct XuEnergy { through: vec3f, energy: vec3f }

fn xu_energy(r: Refraction, sigma_a: vec3f, p: u32, h: vec3f) -> XuEnergy {
    let sigma = f32(p) * r.inv_cos_theta_t * sigma_a;
    let through = exp(-2.0 * sigma);
    let x = 1.0 / (r.eta_p * r.eta_p);
    return XuEnergy(through, 0.5 * through * (h.x + sigma * x * (h.y + (0.25 + 0.5 * sigma) * x * h.z)));
}

// Eq 16 and 17.
fn xu_azimuth_tt(f: Fibre, theta_d: f32, cos_theta_d: f32, kappa: f32, light: XuLight) -> vec3f {
    let r = refraction(f.eta, cos_theta_d);
    let e = xu_energy(r, f.sigma_a, 1u, xu_moments(f.eta, theta_d, 1u));
    let transmitted = 1.0 - schlick(schlick_f0(f.eta), cos_theta_d);
    // N_TT at phi = pi, where h = 0 and abs(dphi/dh) = 2 - 2/eta'.
    let b = e.through * transmitted * transmitted * 0.25 / max(1.0 - 1.0 / r.eta_p, 1e-3);
    return xu_lobe(b, xu_bandwidth(e.energy, b), kappa, light.half.x * light.half.x);
}

// A circular Gaussian of height b and the given bandwidth per colour, under the light.
fn xu_lobe(b: vec3f, bandwidth: vec3f, kappa: f32, sin2_half: f32) -> vec3f {
    let width = max(bandwidth, vec3f(XU_MIN_WIDTH));
    var out: vec3f;
    for (var c = 0u; c < 3u; c++) {
        out[c] = b[c] * circular_product(kappa, 2.0 / (width[c] * width[c]), sin2_half);
    }
    return out;
}

// The bandwidth that keeps the energy of a circular Gaussian of height b, whose integral is about sqrt(pi) times its bandwidth (Eq 17).
fn xu_bandwidth(energy: vec3f, b: vec3f) -> vec3f {
    return energy / max(1.77245385 * b, vec3f(1e-30));
}
