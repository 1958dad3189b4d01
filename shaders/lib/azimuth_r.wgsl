//!use lib/fibre.wgsl
//!use lib/tables.wgsl
// R: N_R = 1/4 |cos(phi/2)| F (Xu 2011, section 4.2.1, with exact Fresnel in place of Schlick's).

// Integral of N_R times exp(kappa (cos(phi_i - phi_j) - 1)) over phi_i; y = abs(cos((phi_o - phi_j)/2)).
fn azimuth_r(fresnel: FresnelPolynomial, cos_theta_d: f32, kappa: f32, y: f32) -> f32 {
    let powers = mean_cosine_powers(kappa, y);
    // The polynomial of X = cos theta_d |cos(phi/2)|, each power of |cos(phi/2)| replaced by its mean.
    let x = cos_theta_d;
    let x2 = x * x;
    let x_powers = vec4f(1.0, x, x2, x2 * x);
    let mean = dot(fresnel.low * x_powers, powers.low) + x2 * x2 * dot(fresnel.high * x_powers, powers.high);
    return 0.25 * TWO_PI * von_mises(kappa).i0e * max(mean, 0.0);
}
