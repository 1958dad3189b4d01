//!use lib/fibre.wgsl
// What single scattering by any model gives, lobe by lobe, and where the lobes' light comes from.

struct Lobes { r: vec3f, tt: vec3f, trt: vec3f }

// Where each lobe is brightest in phi_i, and how concentrated: von Mises densities with the mean vectors of N_R, N_TT and N_TRT at
// eta = 1.55. R is as bright behind, at grazing incidence, as towards the view; TT is behind, the less concentrated the steeper the view; TRT
// towards the view.
fn lobe_concentrations(f: Fibre, theta_o: f32) -> vec3f {
    return vec3f(-0.14, -0.6 - 3.4 * cosine(theta_o), 1.0 / (0.06 + 0.5 * f.azimuthal_width * f.azimuthal_width));
}

// How much of a light is seen from a fibre, by direction: Phi(t + s . w) for the normal distribution Phi, of which the light's mean and its
// regression on w are known. A step for a light that a half-space hides, linear where little changes.
struct SeenLight {
    change: vec3f,      // b of the regression a + b . w, fibre's frame
    at_middle: f32,     // b . w at the light's mean direction
    variance: f32,      // of b . w over the light
    logit: f32,         // of the mean
    per_change: f32,    // change of the logit with b . w
    per_square: f32,    // and of the normal's variance with the square
}

// Phi(x) is near the logistic of this times x, within 0.01.
const LOGISTIC: f32 = 1.702;

// A mean this near to none or all of the light.
const SEEN_LEAST: f32 = 1e-4;

// Most of a half-space's regression that is believed: noise may give more.
const SEEN_STEEPEST: f32 = 0.9;

// `mean` and `change` (fibre's frame) of visibility over an SRBF light of bandwidth lambda around the unit vector `light`, of whose mean direction
// `mean_cosine` is the length.
fn seen_light(mean: f32, change: vec3f, light: vec3f, lambda: f32, mean_cosine: f32) -> SeenLight {
    // E cos^2 = 1 - 2 A / kappa of a von Mises-Fisher density.
    let across_variance = 0.5 * mean_cosine * lambda * lambda;
    let along = dot(change, light);
    let along_square = along * along;
    let variance = max(dot(change, change) - along_square, 0.0) * across_variance
        + along_square * max(1.0 - 2.0 * across_variance - mean_cosine * mean_cosine, 0.0);
    // No number stays none, to be counted in the picture.
    let seen = guarded(mean, SEEN_LEAST, 1.0 - SEEN_LEAST, mean);
    let steep = seen * (1.0 - seen);
    let density_square = LOGISTIC * LOGISTIC * steep * steep;
    let share = min(1.0, SEEN_STEEPEST * density_square / max(variance, 1e-30));
    return SeenLight(change, mean_cosine * along, variance, log(seen / (1.0 - seen)), sqrt(share) / steep, share / density_square);
}

// Mean visibility over directions w of the fibre's frame: normal of bandwidth `width` around inclination `theta` in
// [-pi/2, pi/2], their azimuth the product of von Mises densities, `around` the sum of their unit vectors, each times its concentration.
fn mean_seen(seen: SeenLight, theta: f32, width: f32, around: vec2f) -> f32 {
    // The product is a von Mises density; its mean vector has the length I1/I0 of its concentration, here within 0.01, and
    // I2 = I0 - 2 I1 / kappa.
    let kappa = length(around);
    let per_kappa = 1.0 / (0.5 + sqrt(kappa * kappa + 2.25));
    let first = kappa * per_kappa;
    let second = 1.0 - 2.0 * per_kappa;
    let axis = select(vec2f(1.0, 0.0), around / kappa, kappa > 1e-6);
    let b = seen.change;
    let along = dot(b.yz, axis);
    let across = dot(b.yz, vec2f(-axis.y, axis.x));
    // Means of sine and cosine, of their squares and their product over the normal.
    let once = exp(-0.25 * width * width);
    let twice = once * once * once * once;
    let s = sine(theta);
    let c = cosine(theta);
    let cos_2 = twice * (c * c - s * s);
    let mean = once * (b.x * s + along * first * c);
    let square = 0.5 * b.x * b.x * (1.0 - cos_2) + 2.0 * b.x * along * first * twice * s * c
        + 0.25 * (1.0 + cos_2) * (along * along * (1.0 + second) + across * across * (1.0 - second));
    // The mean of Phi over a normal is Phi again, of the argument's mean over the root of one plus its variance.
    let narrower = seen.variance - max(square - mean * mean, 0.0);
    let argument = (seen.logit + seen.per_change * (mean - seen.at_middle)) * inverseSqrt(1.0 - seen.per_square * narrower);
    return 1.0 / (1.0 + exp(-argument));
}

// Unit vector of an azimuth.
fn azimuth_vector(phi: f32) -> vec2f {
    return vec2f(cos(phi), sin(phi));
}
