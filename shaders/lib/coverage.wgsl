// Exact coverage of a unit pixel by a strip: the pixel's shadow on an axis is a trapezoid, the convolution of two boxes.

// Share of the pixel's area whose coordinate along `axis` (unit, relative to the pixel's centre) is below x.
fn pixel_cdf(x: f32, axis: vec2f) -> f32 {
    let a = abs(axis);
    let wide = max(a.x, a.y);
    let narrow = max(min(a.x, a.y), 1e-4);
    let outer = 0.5 * (wide + narrow);
    let inner = 0.5 * (wide - narrow);
    // The ramp is quadratic over `narrow`, the plateau linear; both halves are mirror images.
    let d = abs(x);
    let ramp = clamp(outer - d, 0.0, narrow);
    let tail = select(0.5 * ramp * ramp / (wide * narrow), 0.5 - d / wide, d < inner);
    return select(1.0 - tail, tail, x < 0.0);
}

// Half the length of the pixel's shadow on `axis`.
fn pixel_reach(axis: vec2f) -> f32 {
    return 0.5 * (abs(axis.x) + abs(axis.y));
}
