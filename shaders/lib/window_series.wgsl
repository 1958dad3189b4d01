//!use lib/maths.wgsl
// A function of the azimuth between view and light as a cosine series: 1/pi over the half circle, seen through a fibre. The half circle's
// own series is 1/2 + 2/pi (cos x - cos 3x / 3 + ...). lib/part_series.wgsl is the same for a part of the sphere.

// Odd harmonics of the half circle that are kept: 1, 3, 5, 7.
const FORWARD_HARMONICS: u32 = 4u;
// Nodes over gamma that the sums are taken at.
const FORWARD_GAMMAS: u32 = 8u;

fn harmonic_order(i: u32) -> f32 {
    return f32(2u * i + 1u);
}

// Mean of N_p over the half circle around an azimuth x off the view: mean + cos x (a polynomial of cos^2 x).
struct WindowSeries {
    mean: vec3f,
    odd: array<vec3f, FORWARD_HARMONICS>,
}

// From the mean and the sums that replace cos x, cos 3x, cos 5x and cos 7x of the half circle's series, 1/pi included.
fn series_of(mean: vec3f, harmonic: array<vec3f, FORWARD_HARMONICS>) -> WindowSeries {
    // cos 3x, cos 5x and cos 7x as polynomials of c = cos x, sorted by the power of c.
    let h1 = 4.0 / PI * harmonic[0];
    let h3 = -4.0 / (3.0 * PI) * harmonic[1];
    let h5 = 4.0 / (5.0 * PI) * harmonic[2];
    let h7 = -4.0 / (7.0 * PI) * harmonic[3];
    return WindowSeries(mean, array(
        h1 - 3.0 * h3 + 5.0 * h5 - 7.0 * h7,
        4.0 * h3 - 20.0 * h5 + 56.0 * h7,
        16.0 * h5 - 112.0 * h7,
        64.0 * h7));
}

fn window_at(s: WindowSeries, cos_x: f32) -> vec3f {
    let c2 = cos_x * cos_x;
    // A series that was cut off swings a little below zero.
    return max(s.mean + cos_x * (s.odd[0] + c2 * (s.odd[1] + c2 * (s.odd[2] + c2 * s.odd[3]))), vec3f(0.0));
}
