//!use lib/types.wgsl
//!use lib/maths.wgsl
// The fibre that scatters, and its refraction at one inclination.

struct Fibre {
    sigma_a: vec3f,         // absorption per fibre radius
    eta: f32,               // index of refraction, 1 to 3
    alpha: vec3f,           // cuticle tilt of R, TT, TRT, radians
    eccentricity: f32,      // a of Xu 2011 Eq 24, 0.5 to 2
    beta: vec3f,            // standard deviation in theta_h of R, TT, TRT, radians
    azimuthal_width: f32,   // bandwidth w_c of TRT, radians
}

// TT's and TRT's tilt and width come from R's by the point's ratios (Marschner 2003: -1/2, -3/2 and 1/2, 2).
fn fibre_from_params(p: VertexParams) -> Fibre {
    return guarded_fibre(Fibre(
        p.sigma_a, p.eta, p.alpha_rad * vec3f(1.0, p.alpha_ratios), p.eccentricity,
        p.beta_rad * vec3f(1.0, p.beta_ratios), p.azimuthal_width));
}

// Every field inside the range that the scattering functions are built for.
fn guarded_fibre(f: Fibre) -> Fibre {
    var g = f;
    for (var c = 0u; c < 3u; c++) {
        g.sigma_a[c] = guarded(f.sigma_a[c], 0.0, 1e4, 0.0);
        g.alpha[c] = guarded(f.alpha[c], -HALF_PI, HALF_PI, 0.0);
        g.beta[c] = guarded(f.beta[c], 1e-3, 1.5, 0.1);
    }
    g.eta = guarded(f.eta, 1.0, 3.0, 1.55);
    g.eccentricity = guarded(f.eccentricity, 0.5, 2.0, 1.0);
    g.azimuthal_width = guarded(f.azimuthal_width, 1e-3, 4.0, 0.2);
    return g;
}

// eta* of an elliptic section: mean and amplitude of eta*(phi_h) = x + y cos(2 phi_h) (Xu 2011, Eq 24).
fn eccentric_index(eta: f32, a: f32) -> vec2f {
    let eta_1 = 2.0 * (eta - 1.0) * a * a - eta + 2.0;
    let eta_2 = 2.0 * (eta - 1.0) / (a * a) - eta + 2.0;
    return 0.5 * vec2f(eta_1 + eta_2, eta_1 - eta_2);
}

// Refraction at one theta_d.
struct Refraction {
    eta: f32,
    cos_theta_d: f32,
    eta_p: f32,             // eta' of Marschner 2003
    inv_cos_theta_t: f32,   // a chord's length over its projection
}

fn refraction(eta: f32, cos_theta_d: f32) -> Refraction {
    // eta cos theta_t, written so that nothing cancels at eta = 1 and at grazing angles.
    let eta_cos_t = sqrt((eta - 1.0) * (eta + 1.0) + cos_theta_d * cos_theta_d);
    return Refraction(eta, cos_theta_d, max(eta_cos_t / cos_theta_d, 1.0), eta / eta_cos_t);
}

// Exact reflectance of unpolarised light at cosine `cos_i` outside a dielectric of index `eta` >= 1.
fn fresnel_dielectric(cos_i: f32, eta: f32) -> f32 {
    return fresnel_at(cos_i, sqrt(max(1.0 - (1.0 - cos_i * cos_i) / (eta * eta), 0.0)), eta);
}

// The same where the cosine inside is known: in a fibre it is cos theta_t cos gamma_t.
fn fresnel_at(cos_i: f32, cos_t: f32, eta: f32) -> f32 {
    let s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t + 1e-20);
    let p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t + 1e-20);
    return 0.5 * (s * s + p * p);
}
