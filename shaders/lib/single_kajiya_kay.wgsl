//!use lib/lobes.wgsl
//!use lib/cone.wgsl
//!use lib/kajiya_kay_table.wgsl
//!use lib/quality.wgsl
// Kajiya and Kay 1989 under one SRBF light: integral of G S cos(theta_i) over the sphere, with
// S = K_d + K_s cos^n(theta_i + theta_o - 2 alpha_R) / cos(theta_i) (Ren 2010, section 3). Stands in for lib/single.wgsl: the specular
// term is R, the diffuse one TRT, TT is dark. Single scattering is all: K_d is a colour of hair in its neighbourhood.
//
// n = 1 / (2 beta_R)^2, so that the highlight is as wide in theta_i as Marschner's. K_s holds the mean reflectance of a fibre seen across,
// K_d what is left of the light, coloured by kajiya_kay_colour.

// A highlight whose product with the light stays below exp of this is not evaluated.
const NEGLIGIBLE_EXPONENT: f32 = -20.0;

// Growth of the absorbance of hair with the root of a fibre's absorption: fits what a half space of d'Eon's fibres sends back.
const COLOUR_GROWTH: f32 = 4.0;

// What depends on fibre and view alone.
struct PreparedView {
    theta_o: f32,
    phi_o: f32,
    axis: f32,          // theta_o - 2 alpha_R
    exponent: f32,      // n
    specular: f32,      // K_s
    diffuse: vec3f,     // K_d
}

// `theta_o` inclination and `phi_o` azimuth of the view, radians.
fn prepare_view(f: Fibre, theta_o: f32, phi_o: f32) -> PreparedView {
    let theta = guarded(theta_o, -HALF_PI, HALF_PI, 0.0);
    let n = 1.0 / cone_variance(f.beta.x);
    let reflected = mean_reflectance(fresnel_polynomial(f.eta));
    // Over all directions cos^n integrates with its cosine to nearly 2 pi sqrt(2 pi / (n + 3/2)) for a view from the side.
    let specular = reflected * sqrt((n + 1.5) / TWO_PI) / TWO_PI;
    return PreparedView(theta, guarded_azimuth(phi_o), theta - 2.0 * f.alpha.x, n, specular,
        (1.0 - reflected) / (PI * PI) * kajiya_kay_colour(f.sigma_a));
}

// Colour of much hair whose fibres absorb `sigma_a` per radius: exp(-c sqrt(sigma_a)).
fn kajiya_kay_colour(sigma_a: vec3f) -> vec3f {
    return exp(-COLOUR_GROWTH * sqrt(sigma_a));
}

// Mean over the offset h of the reflectance at cosine sqrt(1 - h^2): moments of cos^(k + 1) over [0, pi/2].
fn mean_reflectance(fresnel: FresnelPolynomial) -> f32 {
    let low = vec4f(1.0, 0.78539816, 0.66666667, 0.58904862);
    let high = vec4f(0.53333333, 0.49087385, 0.45714286, 0.42951462);
    return clamp(dot(fresnel.low, low) + dot(fresnel.high, high), 0.0, 1.0);
}

// A light exp(2 (w . w_j - 1) / lambda^2) of radiance 1 at its centre (theta_j, phi_j), bandwidth `lambda`; the azimuth makes no difference.
fn single_scattering(v: PreparedView, theta_j: f32, phi_j: f32, lambda: f32) -> Lobes {
    let at_theta = guarded(theta_j, -HALF_PI, HALF_PI, 0.0);
    let width = guarded(lambda, 1e-3, 1e3, 1.0);
    let specular = kajiya_kay_specular(v.exponent, v.axis, at_theta, 1.0 / (width * width), outer_counts().x);
    return Lobes(vec3f(v.specular * specular), vec3f(0.0), kajiya_kay_diffuse(at_theta, width) * v.diffuse);
}

// A uniform environment of radiance 1: the light of infinite bandwidth; the cosine integrates to pi^2.
fn single_scattering_constant(v: PreparedView) -> Lobes {
    return Lobes(vec3f(v.specular * kajiya_kay_specular(v.exponent, v.axis, 0.0, 0.0, 6u)), vec3f(0.0), PI * PI * v.diffuse);
}

// Integral of G cos^n(theta_i + axis) over the sphere: the light's azimuth integrates to 2 pi i0e, theta_i at the nodes of the Gaussian
// that cos^n resembles times the light.
fn kajiya_kay_specular(n: f32, axis: f32, theta_j: f32, inv_lambda_sq: f32, count: u32) -> f32 {
    let g = cone_product(1.0 / n, axis, theta_j, inv_lambda_sq);
    let kappa_scale = 2.0 * max(cos(theta_j), 0.0) * inv_lambda_sq;
    var sum = 0.0;
    for (var k = 0u; k < count && g.peak_exponent > NEGLIGIBLE_EXPONENT; k++) {
        let rule = truncated_gauss(count, k, g.truncation);
        let theta = g.centre + g.side * g.width * rule.x;
        let theta_i = clamp(theta, -HALF_PI, HALF_PI);
        let cos_theta_i = max(cos(theta_i), 0.0);
        let chord = 2.0 * sin(0.5 * (theta_i - theta_j));
        let exponent = rule.x * rule.x - inv_lambda_sq * chord * chord + n * ln_cos(theta_i + axis);
        let value = rule.y * g.width * exp(min(exponent, 40.0)) * cos_theta_i * von_mises(kappa_scale * cos_theta_i).i0e;
        sum += select(0.0, value, abs(theta) <= HALF_PI);
    }
    return TWO_PI * sum;
}

// ln cos x; far below zero where the cosine is not positive.
fn ln_cos(x: f32) -> f32 {
    let s = sin(x);
    let s2 = s * s;
    let far = 0.5 * log(max(1.0 - s2, 1e-30));
    let near = -0.5 * s2 * (1.0 + s2 * (0.5 + s2 / 3.0));
    return select(-1e6, select(far, near, s2 < 0.02), cos(x) > 0.0);
}

// Mean visibility of the light that each lobe sends to the view; neither depends on the azimuth.
fn lobe_means(v: PreparedView, theta_j: f32, phi_j: f32, lambda: f32, seen: SeenLight) -> vec3f {
    let inv_lambda_sq = 1.0 / (lambda * lambda);
    let g = cone_product(1.0 / v.exponent, v.axis, theta_j, inv_lambda_sq);
    let theta = clamp(g.centre, -HALF_PI, HALF_PI);
    let around = 2.0 * cosine(theta_j) * inv_lambda_sq * azimuth_vector(phi_j);
    let specular = mean_seen(seen, theta, g.width, cosine(theta) * around);
    let diffuse = mean_seen(seen, theta_j, lambda, cosine(theta_j) * around);
    return vec3f(specular, diffuse, diffuse);
}
