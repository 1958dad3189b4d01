//!use lib/fibre.wgsl
// What single scattering by any model gives, lobe by lobe, and where the lobes' light comes from.

struct Lobes { r: vec3f, tt: vec3f, trt: vec3f }

// Where each lobe is brightest in phi_i, and how concentrated: R faint and towards the view, TT behind, TRT towards the view.
fn lobe_concentrations(f: Fibre) -> vec3f {
    return vec3f(0.4, -2.5, 1.0 / (0.06 + 0.5 * f.azimuthal_width * f.azimuthal_width));
}

// Mean direction, a vector of the fibre's frame, of a Gaussian of bandwidth `width` around inclination `theta` in [-pi/2, pi/2] whose azimuth
// is the product of von Mises densities: `around` is the sum of their unit vectors, each times its concentration.
fn mean_direction(theta: f32, width: f32, around: vec2f) -> vec3f {
    // The product is a von Mises density; its mean vector has the length I1/I0 of its concentration, here within 0.01.
    let shrunk = around / (0.5 + sqrt(dot(around, around) + 2.25));
    // Sine and cosine have their means over a Gaussian of bandwidth w at its centre, times exp(-w^2/4).
    return exp(-0.25 * width * width) * vec3f(sine(theta), cosine(theta) * shrunk);
}

// Unit vector of an azimuth.
fn azimuth_vector(phi: f32) -> vec2f {
    return vec2f(cos(phi), sin(phi));
}
