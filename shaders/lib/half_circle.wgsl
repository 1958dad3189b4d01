//!use lib/maths.wgsl
// Shares of Gaussians in azimuth.

// Share of a Gaussian around an azimuth of cosine `c` that lies where the cosine is positive.
fn half_circle_share(c: f32, inv_bandwidth: f32) -> f32 {
    // Distance to the edge, asin(c), by its series: exact where it matters, near the edge.
    let inside = c * (1.0 + c * c * (0.1667 + 0.4 * c * c));
    return 0.5 + 0.5 * error_function(inside * inv_bandwidth);
}

// erf(x) within 4e-4: tanh of an odd cubic.
fn error_function(x: f32) -> f32 {
    let y = clamp(x, -4.0, 4.0);
    return tanh(y * (1.1283792 + 0.1009 * y * y));
}

// Share of light scattered forward, the mean of abs(x)/pi, when it leaves around an azimuth of cosine and sine `exit` through a Gaussian
// detector of standard deviation `width`: blurring moves azimuths near the light outwards and those near its far side back.
fn forward_share(exit: vec2f, width: f32) -> f32 {
    let x = min(abs(atan2(exit.y, exit.x)), PI);
    return clamp((x + outward_shift(x, width) - outward_shift(PI - x, width)) / PI, 0.0, 1.0);
}

// Mean of abs(x + n) - x over a normal n of standard deviation `width`, x >= 0.
fn outward_shift(x: f32, width: f32) -> f32 {
    let z = x / width;
    return max(width * 0.79788456 * exp(-0.5 * z * z) - x * (1.0 - error_function(0.70710678 * z)), 0.0);
}
