//!use lib/fibre.wgsl
// What single scattering by any model gives, lobe by lobe, and where the lobes' light comes from.

struct Lobes { r: vec3f, tt: vec3f, trt: vec3f }

// Where each lobe is brightest in phi_i, and how concentrated: R faint and towards the view, TT behind, TRT towards the view.
fn lobe_concentrations(f: Fibre) -> vec3f {
    return vec3f(0.4, -2.5, 1.0 / (0.06 + 0.5 * f.azimuthal_width * f.azimuthal_width));
}

// Mean azimuth, from a light's centre, of the product of that light (concentration `light`) and of a lobe of concentration `lobe` around
// an azimuth `across` off.
fn azimuth_towards(lobe: f32, light: f32, across: f32) -> f32 {
    return atan2(lobe * sin(across), light + lobe * cos(across));
}
