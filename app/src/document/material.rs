//! What a document's hair is in other renderers: a sidecar file for look development.
//!
//! Balayage's sigma_a is the absorption per fibre RADIUS, its widths are standard deviations in degrees. Others differ:
//!
//! | renderer | absorption | roughness | tilt |
//! |---|---|---|---|
//! | Blender `ShaderNodeBsdfHairPrincipled` (Chiang) | Absorption Coefficient per fibre radius | width fraction: v(r) = (0.726 r + 0.812 r^2 + 3.7 r^20)^2 is the longitudinal variance; azimuthal logistic scale s(r) = sqrt(pi / 8) (0.265 r + 1.194 r^2 + 5.372 r^22) | Offset, radians; positive tilts as our negative alpha |
//! | MaterialX `chiang_hair_bsdf` | `absorption_coefficient` per fibre radius | `roughness_R`, `_TT`, `_TRT`: (longitudinal variance, azimuthal logistic scale) | `cuticle_angle`: 0.5 is none, times pi minus pi/2 is radians |
//! | Arnold `standard_hair` | `melanin` 0, colour from sigma_a | `roughness`, `roughness_azimuthal`: the width fractions above | `shift`: degrees, positive as our negative alpha |
//! | Karma Hair | as MaterialX | as MaterialX | as MaterialX |
//! | RenderMan `PxrMarschnerHair` | colour from sigma_a | lobe widths in degrees, as ours | `specularShift`, degrees as ours |
//!
//! Source of the widths and the colour: Chiang et al. 2016, Eqs 7 to 9. A logistic of scale s has the standard deviation
//! pi s / sqrt(3). The formulas are tested; the sidecar was not rendered in the other programs. Names are checked by tests against
//! Blender 4.5.15 and MaterialX 1.39.5, whose shader source also has these meanings of absorption, roughness and tilt; MaterialX keeps the
//! tilts of TT and TRT at -1/2 and -2 times R's. The names of Arnold, Karma and RenderMan stand unchecked: compare them with the version
//! you use.

use balayage_render::param::VertexParams;
use serde_json::{Value, json};

use super::Document;

/// The longitudinal variance of width fraction `r` (Chiang 2016, Eq 7).
pub fn longitudinal_variance(r: f64) -> f64 {
    (0.726 * r + 0.812 * r * r + 3.7 * r.powi(20)).powi(2)
}

/// The logistic scale of azimuthal width fraction `r` (Chiang 2016, Eq 8, times the sqrt(pi / 8) that pbrt and Cycles apply).
pub fn azimuthal_scale(r: f64) -> f64 {
    (0.265 * r + 1.194 * r * r + 5.372 * r.powi(22)) * (std::f64::consts::PI / 8.0).sqrt()
}

/// The width fraction in [0, 1] at which the rising function `width` is `target`, else the nearer end.
pub fn width_fraction(width: impl Fn(f64) -> f64, target: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if width(middle) < target {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// The multiple-scattering colour that a renderer turns into absorption `sigma` at azimuthal width fraction `r` (Chiang 2016, Eq 9).
pub fn albedo_of(sigma: f64, r: f64) -> f64 {
    let root =
        5.969 - 0.215 * r + 2.532 * r.powi(2) - 10.73 * r.powi(3) + 5.574 * r.powi(4) + 0.245 * r.powi(5);
    (-sigma.max(0.0).sqrt() * root).exp()
}

/// The sidecar of a document: the base hair and the means of the painted points, for every renderer.
pub fn sidecar(document: &Document) -> Value {
    let hair = &document.project().hair;
    let ratios = hair.ratios.known;
    let base = hair.base.known.vertex_params(hair.pigments, &ratios);
    let lobes = [1.0, f64::from(ratios.beta_tt), f64::from(ratios.beta_trt)];
    json!({
        "format": "balayage materials",
        "version": 1,
        "program": env!("CARGO_PKG_VERSION"),
        "conventions": {
            "colour_space": "linear Rec.709",
            "sigma_a": "absorption per fibre radius; per diameter it is twice this, per metre this over the radius in metres",
            "roughness": "standard deviation, degrees",
            "alpha": "tilt of R, degrees, negative towards the root",
            "pigment_set": hair.pigments.name(),
            "eumelanin_sigma_a_per_radius": hair.pigments.eumelanin(),
            "pheomelanin_sigma_a_per_radius": hair.pigments.pheomelanin(),
        },
        "names_checked_against": {
            "blender_principled_hair": "Blender 4.5.15",
            "materialx_chiang_hair": "MaterialX 1.39.5",
            "karma_hair": null,
            "arnold_standard_hair": null,
            "renderman_pxr_marschner_hair": null,
        },
        "lobe_ratios": ratios,
        "base": { "channels": hair.base.known, "renderers": renderers(&base, lobes) },
        "mean": { "renderers": renderers(&mean(document.params()), lobes) },
        "per_point": "primvars:balayage:* of the project's .usda (balayage convert PROJECT.json HAIR.usda)",
    })
}

/// The mean of the points' parameters.
fn mean(params: &[VertexParams]) -> VertexParams {
    let mean = |of: &dyn Fn(&VertexParams) -> f32| {
        let sum: f64 = params.iter().map(|p| f64::from(of(p))).sum();
        (sum / params.len().max(1) as f64) as f32
    };
    VertexParams {
        sigma_a: std::array::from_fn(|c| mean(&|p| p.sigma_a[c])),
        alpha_rad: mean(&|p| p.alpha_rad),
        beta_rad: mean(&|p| p.beta_rad),
        azimuthal_width: mean(&|p| p.azimuthal_width),
        eta: mean(&|p| p.eta),
        eccentricity: mean(&|p| p.eccentricity),
        alpha_ratios: std::array::from_fn(|t| mean(&|p| p.alpha_ratios[t])),
        beta_ratios: std::array::from_fn(|t| mean(&|p| p.beta_ratios[t])),
    }
}

/// The parameters of one point in every renderer; `lobes` are the widths of R, TT and TRT relative to R's.
pub fn renderers(params: &VertexParams, lobes: [f64; 3]) -> Value {
    let sigma_a = params.sigma_a.map(f64::from);
    // Chiang's longitudinal variable is theta_o - theta_i, twice ours at theta_h.
    let deviation = 2.0 * f64::from(params.beta_rad);
    let azimuthal_deviation = f64::from(params.azimuthal_width) / std::f64::consts::SQRT_2;
    let scale = azimuthal_deviation * 3.0_f64.sqrt() / std::f64::consts::PI;
    let longitudinal = width_fraction(longitudinal_variance, deviation * deviation);
    let azimuthal = width_fraction(azimuthal_scale, scale);
    let colour = sigma_a.map(|s| albedo_of(s, azimuthal));
    let (alpha, eta) = (f64::from(params.alpha_rad), f64::from(params.eta));
    let variances = lobes.map(|lobe| (lobe * deviation).powi(2));
    let materialx = json!({
        "absorption_coefficient": sigma_a,
        "ior": eta,
        "roughness_R": [variances[0], scale],
        "roughness_TT": [variances[1], scale],
        "roughness_TRT": [variances[2], scale],
        "cuticle_angle": 0.5 - alpha / std::f64::consts::PI,
    });
    json!({
        "balayage": {
            "sigma_a_per_radius": sigma_a,
            "sigma_a_per_diameter": sigma_a.map(|s| 2.0 * s),
            "alpha_deg": alpha.to_degrees(),
            "beta_deg": f64::from(params.beta_rad).to_degrees(),
            "azimuthal_deg": azimuthal_deviation.to_degrees(),
            "eta": eta,
            "eccentricity": params.eccentricity,
        },
        "blender_principled_hair": {
            "node": "ShaderNodeBsdfHairPrincipled",
            "model": "CHIANG",
            "parametrization": "ABSORPTION",
            "inputs": {
                "Absorption Coefficient": sigma_a,
                "Roughness": longitudinal,
                "Radial Roughness": azimuthal,
                "Coat": 0.0,
                "IOR": eta,
                "Offset": -alpha,
            },
        },
        "materialx_chiang_hair": { "node": "chiang_hair_bsdf", "inputs": materialx },
        "karma_hair": materialx,
        "arnold_standard_hair": {
            "base": 1.0,
            "base_color": colour,
            "melanin": 0.0,
            "roughness": longitudinal,
            "roughness_azimuthal": azimuthal,
            "roughness_anisotropic": true,
            "ior": eta,
            "shift": -alpha.to_degrees(),
        },
        "renderman_pxr_marschner_hair": {
            "colour_of_transmission_per_diameter": sigma_a.map(|s| (-2.0 * s).exp()),
            "specularConeAngle_deg": f64::from(params.beta_rad).to_degrees(),
            "specularShift_deg": alpha.to_degrees(),
            "specularIor": eta,
        },
    })
}
