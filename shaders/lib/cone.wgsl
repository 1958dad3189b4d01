//!use lib/longitudinal.wgsl
// The longitudinal factor of d'Eon 2011: a spherical Gaussian around the specular cone. Against an SRBF light both exponents are
// linear in cos theta_i and sin theta_i, so their product is one circular Gaussian in theta_i, in closed form.

// M_p(v, theta_i, theta_r) of d'Eon 2011, Eq 7; integrates with cos(theta_i) to one. All exponents joined, so that nothing overflows.
fn m_p(v: f32, theta_i: f32, theta_r: f32) -> f32 {
    let at = folded(theta_r);
    let s = sin(0.5 * (theta_i + at));
    return cone_scale(v, cos(theta_i), cos(at)) * exp(-2.0 * s * s / v);
}

// What stands before the exponential of m_p.
fn cone_scale(v: f32, cos_theta_i: f32, cos_theta_r: f32) -> f32 {
    return i0e(max(cos_theta_i * cos_theta_r, 0.0) / v) / (v * (1.0 - exp(-2.0 / v)));
}

// exp(-x) I_0(x) for x >= 0 within 2e-7 (Abramowitz and Stegun, 9.8.1 and 9.8.2).
fn i0e(x: f32) -> f32 {
    let t = x / 3.75;
    let t2 = min(t * t, 1.0);
    let small = exp(-min(x, 3.75)) * (1.0 + t2 * (3.5156229 + t2 * (3.0899424 + t2 * (1.2067492 + t2 * (0.2659732 + t2 * (0.0360768 + t2 * 0.0045813))))));
    let s = 1.0 / max(t, 1.0);
    let large = inverseSqrt(max(x, 3.75)) * (0.39894228 + s * (0.01328592 + s * (0.00225319 + s * (-0.00157565 + s * (0.00916281
        + s * (-0.02057706 + s * (0.02635537 + s * (-0.01647633 + s * 0.00392377))))))));
    return select(large, small, x < 3.75);
}

// An inclination that a tilt carried beyond a pole: the cone there comes in from the other side.
fn folded(theta: f32) -> f32 {
    return atan2(sin(theta), abs(cos(theta)));
}

// v of a lobe of standard deviation beta in theta_h: twice as wide in theta_i.
fn cone_variance(beta: f32) -> f32 {
    return 4.0 * beta * beta;
}

// Cone times the light's share exp(-inv_lambda_sq (2 sin((theta_i - theta_j)/2))^2): R exp(i centre) is the sum of the two as phasors.
fn cone_product(v: f32, theta_r: f32, theta_j: f32, inv_lambda_sq: f32) -> ProductGaussian {
    let light = 2.0 * inv_lambda_sq;
    let cone = 1.0 / v;
    let x = light * cos(theta_j) + cone * cos(theta_r);
    let y = light * sin(theta_j) - cone * sin(theta_r);
    let concentration = sqrt(x * x + y * y);
    let apart = sin(0.5 * (theta_j + theta_r));
    let peak_exponent = -4.0 * light * apart * (cone / (concentration + light + cone)) * apart;
    // What is left of the cosine is its root beside a narrow cone, exp(-theta_i^2 / 4), and all of it beside a wide one, cut off at both
    // poles: the second share keeps the nodes between them.
    let total_precision = 0.5 * concentration + 0.25 + 1.25 / (1.0 + concentration);
    let width = inverseSqrt(total_precision);
    let centre = atan2(y, x) * 0.5 * concentration / total_precision;
    let reach = HALF_PI - TRUNCATION_MIN * width;
    let inside = clamp(centre, -reach, reach);
    return ProductGaussian(inside, width, select(-1.0, 1.0, inside >= 0.0), (HALF_PI - abs(inside)) / width, peak_exponent);
}

// Node k of n for the integral of M_p cos(theta_i) times the light; theta_r is folded.
fn cone_node(g: ProductGaussian, n: u32, k: u32, v: f32, theta_r: f32, theta_o: f32, theta_j: f32, inv_lambda_sq: f32) -> OuterNode {
    let rule = truncated_gauss(n, k, g.truncation);
    let theta = g.centre + g.side * g.width * rule.x;
    let theta_i = clamp(theta, -HALF_PI, HALF_PI);
    let cos_theta_i = max(cos(theta_i), 0.0);
    let chord = 2.0 * sin(0.5 * (theta_i - theta_j));
    let from_cone = sin(0.5 * (theta_i + theta_r));
    let exponent = rule.x * rule.x - inv_lambda_sq * chord * chord - 2.0 * from_cone * from_cone / v;
    let weight = rule.y * g.width * exp(min(exponent, 40.0)) * cos_theta_i * cone_scale(v, cos_theta_i, cos(theta_r));
    return OuterNode(theta_i, cos_theta_i, max(cos(0.5 * (theta_o - theta_i)), 1e-4), select(0.0, weight, abs(theta) <= HALF_PI));
}
