//!use lib/averages_table.wgsl
// What a neighbourhood of fibres sends back (Zinke 2008, section 4.1.2), from what one fibre does.

// Largest a_f in Zinke's series, which diverge at one.
const ZINKE_MOST_FORWARD: f32 = 0.99;

// A_b by adding layers, Delta_b and sigma_b^2 in theta_i by Zinke's series, A_b as Zinke prints it.
fn backward_of(m: FibreAverages) -> vec4f {
    let f2 = min(m.a_f, ZINKE_MOST_FORWARD) * min(m.a_f, ZINKE_MOST_FORWARD);
    let b2 = m.a_b * m.a_b;
    let open = 1.0 - f2;
    let printed = m.a_b * f2 / open * (1.0 + b2 / (open * open));
    let sigma = 2.0 * sigma_b(m);
    return vec4f(adding_a_b(m.a_f, m.a_b), 2.0 * delta_b(m, f2, b2, open), max(0.5 * sigma * sigma, 1e-6), printed);
}

// A_b = r - a_b with r the smaller root of a_b r^2 - (1 + a_b^2 - a_f^2) r + a_b = 0: what a half space sends back beyond its first fibre.
fn adding_a_b(a_f: f32, a_b: f32) -> f32 {
    let half_sum = 1.0 + a_b * a_b - a_f * a_f;
    let discriminant = (1.0 - a_b - a_f) * (1.0 - a_b + a_f) * (1.0 + a_b - a_f) * (1.0 + a_b + a_f);
    return 2.0 * a_b / max(half_sum + sqrt(max(discriminant, 0.0)), 1e-6) - a_b;
}

// Zinke 2008 Eq 16, theta_h.
fn delta_b(m: FibreAverages, f2: f32, b2: f32, open: f32) -> f32 {
    return m.alpha_b * (1.0 - 2.0 * b2 / (open * open))
        + m.alpha_f * (2.0 * open * open + 4.0 * f2 * b2) / (open * open * open);
}

// Zinke 2008 Eq 17 as a bandwidth in theta_h; the printed formula adds a number to widths, so it wants Xu's bandwidths sqrt 2 beta.
fn sigma_b(m: FibreAverages) -> f32 {
    let beta_f = sqrt(2.0) * m.beta_f;
    let beta_b = sqrt(2.0) * m.beta_b;
    let b2 = m.a_b * m.a_b;
    let once = sqrt(2.0 * beta_f * beta_f + beta_b * beta_b);
    let thrice = sqrt(2.0 * beta_f * beta_f + 3.0 * beta_b * beta_b);
    // A common factor a_b of numerator and denominator is cancelled.
    return (1.0 + 0.7 * m.a_f * m.a_f) * (once + b2 * thrice) / (1.0 + b2 * (2.0 * beta_f + 3.0 * beta_b));
}
