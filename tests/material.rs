//! The sidecar of materials: each renderer's numbers, put back into its own formulas as its manual has them, are ours.

use std::path::Path;

use balayage::document::{Document, material};
use balayage_render::param::{LobeRatios, PigmentSet, PointValues};
use balayage_tests::{python_with, script};

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * b.abs().max(1e-9)
}

#[test]
fn conversions_invert_each_renderers_own_formulas() {
    let values = PointValues {
        beta_deg: 7.0,
        azimuthal_deg: 12.0,
        alpha_deg: -3.0,
        ..PointValues::default()
    };
    let params = values.vertex_params(PigmentSet::Deon2011, &LobeRatios::default());
    let all = material::renderers(&params, [1.0, 0.5, 2.0]);
    let number = |path: &str| all.pointer(path).unwrap().as_f64().unwrap();

    // Blender: bsdf->v = sqr(0.726 r + 0.812 r^2 + 3.7 r^20) is the variance in theta_o, which moves by twice theta_h.
    let r = number("/blender_principled_hair/inputs/Roughness");
    let deviation = 0.726 * r + 0.812 * r * r + 3.7 * r.powf(20.0);
    assert!(
        close(deviation.to_degrees(), 14.0, 1e-5),
        "{}",
        deviation.to_degrees()
    );
    assert!(!close(deviation.to_degrees(), 14.0 * 1.001, 1e-5));

    // The standard deviation of a logistic, by integration, at the scale that Cycles makes of the radial roughness.
    let n = number("/blender_principled_hair/inputs/Radial Roughness");
    let s = (0.265 * n + 1.194 * n.powf(2.0) + 5.372 * n.powf(22.0)) * 0.626_657_068_657_750_1;
    let step = s / 200.0;
    let variance: f64 = (-20_000..20_000)
        .map(|i| {
            let x = f64::from(i) * step;
            let e = (-x.abs() / s).exp();
            x * x * e / (s * (1.0 + e).powi(2)) * step
        })
        .sum();
    assert!(
        close(variance.sqrt().to_degrees(), 12.0, 1e-4),
        "{}",
        variance.sqrt().to_degrees()
    );

    // Absorption per radius everywhere; the way through the middle of a fibre is two radii.
    for (c, expected) in [
        0.419 * 1.3 + 0.187 * 0.2,
        0.697 * 1.3 + 0.4 * 0.2,
        1.37 * 1.3 + 1.05 * 0.2,
    ]
    .iter()
    .enumerate()
    {
        assert!(close(
            number(&format!(
                "/blender_principled_hair/inputs/Absorption Coefficient/{c}"
            )),
            *expected,
            1e-6
        ));
        let kept = number(&format!(
            "/renderman_pxr_marschner_hair/colour_of_transmission_per_diameter/{c}"
        ));
        assert!(close(kept, (-2.0 * expected).exp(), 1e-6));
        // Arnold's colour through Chiang's sigma_a = (ln C / f(beta_n))^2.
        let colour = number(&format!("/arnold_standard_hair/base_color/{c}"));
        let f = 5.969 + n * (-0.215 + n * (2.532 + n * (-10.73 + n * (5.574 + n * 0.245))));
        assert!(close((colour.ln() / f).powi(2), *expected, 1e-6));
    }

    // Tilts: three degrees towards the root.
    assert!(close(number("/arnold_standard_hair/shift"), 3.0, 1e-6));
    assert!(close(
        number("/materialx_chiang_hair/inputs/cuticle_angle") * 180.0 - 90.0,
        3.0,
        1e-5
    ));
    // Variances of the lobes: half and twice R's width are a quarter and four times its variance.
    let v = number("/materialx_chiang_hair/inputs/roughness_R/0");
    assert!(close(
        number("/materialx_chiang_hair/inputs/roughness_TT/0"),
        v / 4.0,
        1e-9
    ));
    assert!(close(
        number("/materialx_chiang_hair/inputs/roughness_TRT/0"),
        v * 4.0,
        1e-9
    ));
}

/// The inputs of the two nodes whose definitions can be had, from the programs themselves.
#[test]
fn names_are_those_of_blender_and_materialx() {
    let params = PointValues::default().vertex_params(PigmentSet::Deon2011, &LobeRatios::default());
    let all = material::renderers(&params, [1.0, 0.5, 2.0]);
    for (module, renderer) in [
        ("bpy", "blender_principled_hair"),
        ("MaterialX", "materialx_chiang_hair"),
    ] {
        let Some(python) = python_with(module) else {
            continue;
        };
        let known = script(&python, "tests/material_inputs.py", &[Path::new(module)]);
        let known: Vec<&str> = known
            .as_array()
            .unwrap()
            .iter()
            .map(|name| name.as_str().unwrap())
            .collect();
        assert!(known.len() > 5 && !known.contains(&"absorption"));
        let inputs = all[renderer]["inputs"].as_object().unwrap();
        for name in inputs.keys() {
            assert!(
                known.contains(&name.as_str()),
                "{renderer}: {name} is none of {known:?}"
            );
        }
    }
}

#[test]
fn sidecar_names_its_conventions() {
    let sidecar = material::sidecar(&Document::sample().unwrap().document);
    assert_eq!(sidecar["conventions"]["pigment_set"], "deon2011");
    let text = sidecar["conventions"]["sigma_a"].as_str().unwrap();
    assert!(text.contains("per fibre radius"));
    for of in ["base", "mean"] {
        assert_eq!(sidecar[of]["renderers"].as_object().unwrap().len(), 6);
    }
}
