//!use lib/tables.wgsl
// A light's azimuthal factor exp(kappa (cos x - 1)) seen through a Gaussian detector (d'Eon 2011, Eq 11, a normal density wrapped
// around the circle): a circular Gaussian, and what its first three harmonics lack to those of the true convolution.

// Above this concentration the circular Gaussian is all; the correction fades in over the half below it.
const DETECTED_NARROW: f32 = 40.0;

struct DetectedLight {
    kappa: f32,           // concentration of the circular Gaussian
    mass: f32,            // integral over the circle / 2 pi
    amplitude: f32,       // peak of the circular Gaussian
    correction: vec4f,    // coefficients of 1, cos x, cos^2 x, cos^3 x
}

// `variance` is the detector's.
fn detected_light(kappa: f32, variance: f32) -> DetectedLight {
    let light = von_mises(kappa);
    let blurred = convolved(kappa, light.convolution, 1.0 / variance);
    // The detector multiplies harmonic m by exp(-m^2 variance / 2).
    let b = exp(-0.5 * variance);
    let b4 = b * b * b * b;
    let lacking = vec3f(b, b4, b4 * b4 * b) * harmonics(kappa) - harmonics(blurred);
    let share = clamp(2.0 - 2.0 * blurred / DETECTED_NARROW, 0.0, 1.0);
    // cos 2x = 2 c^2 - 1, cos 3x = 4 c^3 - 3 c.
    let d = 2.0 * share * light.i0e * lacking;
    return DetectedLight(blurred, light.i0e, light.i0e / von_mises(blurred).i0e,
        vec4f(-d.y, d.x - 3.0 * d.z, 2.0 * d.y, 4.0 * d.z));
}

// Its value at an azimuth of cosine `c` off the centre. A node that stands for azimuths spread by `footprint` radians is blurred by
// at least that; the concentration is limited, and the mass kept, for density scales with sqrt(kappa).
fn detected_at(l: DetectedLight, c: f32, footprint: f32) -> f32 {
    let limited = min(l.kappa, 1.0 / (footprint * footprint + 1e-5));
    let scale = select(1.0, sqrt(limited / max(l.kappa, 1e-20)), limited < l.kappa);
    let correction = l.correction.x + c * (l.correction.y + c * (l.correction.z + c * l.correction.w));
    return max(scale * l.amplitude * exp(limited * (c - 1.0)) + correction, 0.0);
}

// I_1, I_2 and I_3 over I_0 at kappa: the means of cos x, cos 2x and cos 3x over a von Mises density. Backwards by the recurrence from
// Amos' bound of I_8 / I_7 (1974, Eq 16), whose error each step divides.
fn harmonics(kappa: f32) -> vec3f {
    var ratio = kappa / (7.5 + sqrt(kappa * kappa + 72.25));
    for (var m = 7.0; m > 3.5; m -= 1.0) {
        ratio = kappa / (2.0 * m + kappa * ratio);
    }
    let r3 = kappa / (6.0 + kappa * ratio);
    let r2 = kappa / (4.0 + kappa * r3);
    let r1 = kappa / (2.0 + kappa * r2);
    return vec3f(r1, r1 * r2, r1 * r2 * r3);
}
