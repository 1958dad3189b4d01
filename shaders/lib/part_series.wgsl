//!use lib/maths.wgsl
//!use lib/part.wgsl
// N_p itself as a cosine series, for light from a part of the sphere: stands in for lib/window_series.wgsl.

// Harmonics that are kept: 1 to 4.
const FORWARD_HARMONICS: u32 = 4u;
// Nodes over gamma that the sums are taken at.
const FORWARD_GAMMAS: u32 = 8u;

fn harmonic_order(i: u32) -> f32 {
    return f32(i + 1u);
}

// N_p at an azimuth x off the view, the part's width in it: a polynomial of cos x.
struct WindowSeries {
    mean: vec3f,
    powers: array<vec3f, FORWARD_HARMONICS>,    // of cos x, from the first on
    even: vec3f,                                // what they add to the mean
}

// From the mean and the sums of cos m Phi, 1/pi included.
fn series_of(mean: vec3f, harmonic: array<vec3f, FORWARD_HARMONICS>) -> WindowSeries {
    // cos 2x, cos 3x and cos 4x as polynomials of c = cos x, sorted by the power of c.
    let h1 = 2.0 * exp(-0.5 * PART_VARIANCE) * harmonic[0];
    let h2 = 2.0 * exp(-2.0 * PART_VARIANCE) * harmonic[1];
    let h3 = 2.0 * exp(-4.5 * PART_VARIANCE) * harmonic[2];
    let h4 = 2.0 * exp(-8.0 * PART_VARIANCE) * harmonic[3];
    return WindowSeries(mean, array(
        h1 - 3.0 * h3,
        2.0 * h2 - 8.0 * h4,
        4.0 * h3,
        8.0 * h4), h4 - h2);
}

// A series that was cut off swings a little below zero: what light from all sides adds up to does not.
fn window_at(s: WindowSeries, c: f32) -> vec3f {
    return s.mean + s.even + c * (s.powers[0] + c * (s.powers[1] + c * (s.powers[2] + c * s.powers[3])));
}
