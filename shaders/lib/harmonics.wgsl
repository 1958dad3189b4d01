// Nine real spherical harmonics, of mean square one over the sphere: the coefficient of a function is the mean of its product with one.

// Y_i(w) for l = 0, 1, 2; w is a unit vector.
fn harmonics(w: vec3f) -> array<f32, 9> {
    return array<f32, 9>(
        1.0,
        1.7320508 * w.x, 1.7320508 * w.y, 1.7320508 * w.z,
        3.8729833 * w.y * w.z, 3.8729833 * w.x * w.z, 3.8729833 * w.x * w.y,
        1.9364917 * (w.x * w.x - w.y * w.y),
        1.1180340 * (2.0 * w.z * w.z - w.x * w.x - w.y * w.y));
}

// Mean over a lobe (axis, mean cosine A of its von Mises-Fisher density, kappa = 2 / lambda^2) of the function with coefficients c:
// degree l is weighed by the lobe's own l-th coefficient, 1, A and 1 - 3 A / kappa.
fn lobe_mean(c: array<f32, 9>, axis: vec3f, mean_cosine: f32, bandwidth: f32) -> f32 {
    let y = harmonics(axis);
    let second = 1.0 - 1.5 * mean_cosine * bandwidth * bandwidth;
    let linear = c[1] * y[1] + c[2] * y[2] + c[3] * y[3];
    let quadratic = c[4] * y[4] + c[5] * y[5] + c[6] * y[6] + c[7] * y[7] + c[8] * y[8];
    return c[0] + mean_cosine * linear + second * quadratic;
}

// Gradient of the same function, as a harmonic polynomial, at w (not longer than one).
fn harmonics_slope(c: array<f32, 9>, w: vec3f) -> vec3f {
    let linear = 1.7320508 * vec3f(c[1], c[2], c[3]);
    let mixed = 3.8729833 * vec3f(c[5] * w.z + c[6] * w.y, c[4] * w.z + c[6] * w.x, c[4] * w.y + c[5] * w.x);
    let squares = vec3f(3.8729833 * c[7] * w.x, -3.8729833 * c[7] * w.y, 0.0) + 2.2360680 * c[8] * vec3f(-w.x, -w.y, 2.0 * w.z);
    return linear + mixed + squares;
}
