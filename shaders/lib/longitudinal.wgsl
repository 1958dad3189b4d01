//!use lib/tables.wgsl
// The outer integral, over theta_i in [-pi/2, pi/2]: a Gauss rule on the Gaussian that the integrand resembles, truncated at
// the nearer pole; the true integrand over that Gaussian is evaluated at its nodes.

const INV_SQRT_TWO_PI: f32 = 0.39894228040143;

// The Gaussian exp(-(theta_i - centre)^2 / width^2), seen towards the nearer pole.
struct ProductGaussian {
    centre: f32,
    width: f32,             // bandwidth
    side: f32,              // 1 or -1: the pole that is nearer
    truncation: f32,        // distance to that pole in widths
    peak_exponent: f32,     // of lobe times light at the centre
}

// Lobe N(theta_i; mean, 2 beta) times a light exp(-(theta_i - theta_j)^2 inv_lambda_sq) times what cos^2 theta_i / cos^2 theta_d
// resembles, exp(-theta_i^2 + theta_d^2).
fn product_gaussian(mean: f32, beta: f32, theta_o: f32, theta_j: f32, inv_lambda_sq: f32) -> ProductGaussian {
    let lobe_precision = 0.125 / (beta * beta);
    let total_precision = inv_lambda_sq + lobe_precision + 0.75;
    let width = inverseSqrt(total_precision);
    let centre = (inv_lambda_sq * theta_j + lobe_precision * mean - 0.25 * theta_o) / total_precision;
    // A centre far beyond a pole moves back to where the rule is tabulated.
    let reach = HALF_PI - TRUNCATION_MIN * width;
    let inside = clamp(centre, -reach, reach);
    // The chord of the light is no longer than the distance, so this bounds SRBF and plain Gaussian from above.
    let chord = 2.0 * sine(0.5 * (inside - theta_j));
    let from_mean = inside - mean;
    let peak_exponent = -inv_lambda_sq * chord * chord - lobe_precision * from_mean * from_mean;
    return ProductGaussian(inside, width, select(-1.0, 1.0, inside >= 0.0), (HALF_PI - abs(inside)) / width, peak_exponent);
}

struct OuterNode {
    theta_i: f32,
    cos_theta_i: f32,
    cos_theta_d: f32,
    weight: f32,            // rule weight * light(theta_i) * M(theta_i) * cos^2 theta_i / cos^2 theta_d
}

// Node k of n. The light is exp(-inv_lambda_sq (2 sin((theta_i - theta_j)/2))^2), theta's share of an SRBF, or with
// `flat` the plain Gaussian of the distance.
fn outer_node(g: ProductGaussian, n: u32, k: u32, mean: f32, beta: f32, theta_o: f32, theta_j: f32, inv_lambda_sq: f32, flat: bool) -> OuterNode {
    let rule = truncated_gauss(n, k, g.truncation);
    let theta = g.centre + g.side * g.width * rule.x;
    let theta_i = clamp(theta, -HALF_PI, HALF_PI);
    let cos_theta_i = cosine(theta_i);
    let cos_theta_d = max(cosine(0.5 * (theta_o - theta_i)), 1e-4);
    let from_light = theta_i - theta_j;
    let chord = select(2.0 * sine(0.5 * from_light), from_light, flat);
    let from_lobe = (theta_i - mean) / beta;
    let exponent = rule.x * rule.x - inv_lambda_sq * chord * chord - 0.125 * from_lobe * from_lobe;
    let cosines = cos_theta_i / cos_theta_d;
    let weight = rule.y * g.width * exp(min(exponent, 40.0)) * (0.5 * INV_SQRT_TWO_PI / beta) * cosines * cosines;
    // A node beyond a pole sees nothing.
    return OuterNode(theta_i, cos_theta_i, cos_theta_d, select(0.0, weight, abs(theta) <= HALF_PI));
}
