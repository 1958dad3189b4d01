//! Reflection at the fibre's surface.

/// Unpolarised reflectance of a smooth dielectric of relative index `eta` at the cosine of the true 3D angle of incidence.
///
/// For a fibre the cosine is cos(theta_d) cos(gamma); with gamma_t from eta' this equals Marschner's form with eta' and eta''
/// (2003, section 4.2) where eta'' stands in the formula but not in Snell's law. Total reflection gives one.
pub fn fresnel(eta: f64, cos_i: f64) -> f64 {
    if eta == 1.0 {
        return 0.0;
    }
    let cos_i = cos_i.clamp(0.0, 1.0);
    let excess = (eta - 1.0) * (eta + 1.0);
    let eta_cos_t_squared = excess + cos_i * cos_i;
    if eta_cos_t_squared <= 0.0 {
        return 1.0;
    }

    // Numerators are expanded by their conjugates, so that an index next to one keeps its digits.
    let eta_cos_t = eta_cos_t_squared.sqrt();
    let eta_squared = eta * eta;
    let r_s = excess / (cos_i + eta_cos_t).powi(2);
    let r_p =
        excess * (cos_i * cos_i * (eta_squared + 1.0) - 1.0) / (eta_squared * cos_i + eta_cos_t).powi(2);
    0.5 * (r_s * r_s + r_p * r_p)
}

/// One minus [`fresnel`], with all its digits where nearly everything is reflected.
pub fn transmission(eta: f64, cos_i: f64) -> f64 {
    let cos_i = cos_i.clamp(0.0, 1.0);
    let eta_squared = eta * eta;
    let eta_cos_t_squared = (eta - 1.0) * (eta + 1.0) + cos_i * cos_i;
    if eta_cos_t_squared <= 0.0 {
        return if eta == 1.0 { 1.0 } else { 0.0 };
    }
    let eta_cos_t = eta_cos_t_squared.sqrt();
    let (s, p) = (cos_i + eta_cos_t, eta_squared * cos_i + eta_cos_t);
    2.0 * cos_i * eta_cos_t * ((s * s).recip() + eta_squared / (p * p))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_angles_of_a_dielectric() {
        // Normal incidence, Brewster's angle (only the s half is left), grazing, and total reflection.
        let eta: f64 = 1.55;
        assert!((fresnel(eta, 1.0) - (0.55_f64 / 2.55).powi(2)).abs() < 1e-15);
        let brewster = eta.atan().cos();
        let r_s = (eta * eta - 1.0) / (eta * eta + 1.0);
        assert!((fresnel(eta, brewster) - 0.5 * r_s * r_s).abs() < 1e-15);
        assert!((fresnel(eta, 0.0) - 1.0).abs() < 1e-15);
        assert_eq!(fresnel(1.0 / eta, 0.5), 1.0);
        assert_eq!(fresnel(1.0, 0.0), 0.0);
        let near = fresnel(1.0 + 1e-9, 1.0);
        assert!((near / 0.25e-18 - 1.0).abs() < 1e-6, "{near}");
    }

    #[test]
    fn what_is_not_reflected_passes() {
        for (eta, cos_i) in [
            (1.55, 0.3),
            (1.0, 0.2),
            (1.0, 0.0),
            (0.7, 0.1),
            (0.7, 0.9),
            (3.0, 1.0),
        ] {
            let whole = fresnel(eta, cos_i) + transmission(eta, cos_i);
            assert!((whole - 1.0).abs() < 1e-15, "{eta} {cos_i}: {whole}");
        }
        let grazing = transmission(1.5, 1e-12) / transmission(1.5, 1e-6);
        assert!((grazing * 1e6 - 1.0).abs() < 1e-5, "{grazing}");
    }

    #[test]
    fn both_sides_of_the_surface_reflect_alike() {
        let (eta, cos_i) = (1.55_f64, 0.4_f64);
        let cos_t = (1.0 - (1.0 - cos_i * cos_i) / (eta * eta)).sqrt();
        assert!((fresnel(eta, cos_i) - fresnel(1.0 / eta, cos_t)).abs() < 1e-14);
    }
}
