//!use lib/fibre.wgsl
// What single scattering by any model gives, lobe by lobe, and where the lobes' light comes from.

struct Lobes { r: vec3f, tt: vec3f, trt: vec3f }

// Where each lobe is brightest in phi_i, and how concentrated: von Mises densities with the mean vectors of N_R, N_TT and N_TRT at
// eta = 1.55. R is as bright behind, at grazing incidence, as towards the view; TT is behind, the less concentrated the steeper the view; TRT
// towards the view.
fn lobe_concentrations(f: Fibre, theta_o: f32) -> vec3f {
    return vec3f(-0.14, -0.6 - 3.4 * cosine(theta_o), 1.0 / (0.06 + 0.5 * f.azimuthal_width * f.azimuthal_width));
}

// Mean of clamp(a + b . w, 0, 1) over directions w of the fibre's frame: normal of bandwidth `width` around inclination `theta` in
// [-pi/2, pi/2], their azimuth the product of von Mises densities, `around` the sum of their unit vectors, each times its concentration.
fn mean_clamped(a: f32, b: vec3f, theta: f32, width: f32, around: vec2f) -> f32 {
    // The product is a von Mises density; its mean vector has the length I1/I0 of its concentration, here within 0.01, and
    // I2 = I0 - 2 I1 / kappa.
    let kappa = length(around);
    let per_kappa = 1.0 / (0.5 + sqrt(kappa * kappa + 2.25));
    let first = kappa * per_kappa;
    let second = 1.0 - 2.0 * per_kappa;
    let axis = select(vec2f(1.0, 0.0), around / kappa, kappa > 1e-6);
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
    // The mean of max(x, 0) over a normal is near (m + sqrt(m^2 + 2/pi variance)) / 2, and exact at m = 0; the clamp is a difference of two.
    let spread = 2.0 / PI * max(square - mean * mean, 0.0);
    let m = a + mean;
    return 0.5 * (1.0 + sqrt(m * m + spread) - sqrt((1.0 - m) * (1.0 - m) + spread));
}

// Unit vector of an azimuth.
fn azimuth_vector(phi: f32) -> vec2f {
    return vec2f(cos(phi), sin(phi));
}
