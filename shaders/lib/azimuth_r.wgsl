//!use lib/fibre.wgsl
//!use lib/tables.wgsl
// R: N_R = 1/4 |cos(phi/2)| F (Xu 2011, section 4.2.1, with exact Fresnel in place of Schlick's).

// Mean of N_R from the means of the powers of abs(cos(phi/2)): a polynomial of X = cos theta_d abs(cos(phi/2)) times abs(cos(phi/2)) / 4.
fn mean_n_r(fresnel: FresnelPolynomial, cos_theta_d: f32, powers: CosinePowers) -> f32 {
    let x = cos_theta_d;
    let x2 = x * x;
    let x_powers = vec4f(1.0, x, x2, x2 * x);
    // The polynomial can dip below zero by its own error.
    return 0.25 * max(dot(fresnel.low * x_powers, powers.low) + x2 * x2 * dot(fresnel.high * x_powers, powers.high), 0.0);
}

// Integral of N_R times exp(kappa (cos(phi_i - phi_j) - 1)) over phi_i; y = abs(cos((phi_o - phi_j)/2)).
fn azimuth_r(fresnel: FresnelPolynomial, cos_theta_d: f32, kappa: f32, y: f32) -> f32 {
    return TWO_PI * von_mises(kappa).i0e * mean_n_r(fresnel, cos_theta_d, mean_cosine_powers(kappa, y));
}
