//!use lib/fibre.wgsl
// What single scattering by any model gives, lobe by lobe, and where the lobes' light comes from.

struct Lobes { r: vec3f, tt: vec3f, trt: vec3f }

// Where each lobe is brightest in phi_i, and how concentrated: R faint and towards the view, TT behind, TRT towards the view.
fn lobe_concentrations(f: Fibre) -> vec3f {
    return vec3f(0.4, -2.5, 1.0 / (0.06 + 0.5 * f.azimuthal_width * f.azimuthal_width));
}

// Mean direction, a vector of the fibre's frame, of a Gaussian of bandwidth `width` around inclination `theta` whose azimuth is the product
// of a light of concentration `light` around phi_j and a lobe of concentration `lobe` around an azimuth `across` off that.
fn mean_direction(theta: f32, width: f32, light: f32, phi_j: f32, lobe: f32, across: f32) -> vec3f {
    // The product of two von Mises densities; its mean vector has the length I1/I0 of its concentration, here within 0.01.
    let sum = vec2f(light + lobe * cos(across), lobe * sin(across));
    let shrunk = sum / (0.5 + sqrt(dot(sum, sum) + 2.25));
    let around = vec2f(shrunk.x * cos(phi_j) - shrunk.y * sin(phi_j), shrunk.x * sin(phi_j) + shrunk.y * cos(phi_j));
    // Sine and cosine have their means over a Gaussian of bandwidth w at its centre, times exp(-w^2/4).
    return exp(-0.25 * width * width) * vec3f(sin(theta), cos(theta) * around);
}
