//! Shader texts: every composed pass is valid WGSL, host and shader agree on layouts and constants. No GPU needed.

use std::mem::offset_of;

use balayage_render::gpu::{
    DIRECTIONAL_GAMMAS, Method, Model, Scheme, probe, probe_deon, probe_kajiya_kay, shader, tables,
};
use balayage_render::param::VertexParams;
use naga::valid::{Capabilities, ValidationFlags, Validator};

fn validated(text: &str) -> Result<naga::Module, String> {
    let module = naga::front::wgsl::parse_str(text).map_err(|e| e.emit_to_string(text))?;
    Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(&module)
        .map_err(|e| e.emit_to_string(text))?;
    Ok(module)
}

fn composed(path: &str) -> naga::Module {
    let text = shader::compose(path, &[]).unwrap();
    validated(&text).unwrap_or_else(|e| panic!("shaders/{path}: {e}"))
}

#[test]
fn every_pass_is_valid_wgsl() {
    let passes: Vec<_> = shader::SOURCES
        .iter()
        .filter(|(path, _)| path.starts_with("pass/"))
        .collect();
    assert!(!passes.is_empty());
    for (path, _) in passes {
        let module = composed(path);
        assert!(
            !module.entry_points.is_empty(),
            "shaders/{path} has no entry point"
        );
    }
    // Passes that scatter, with the files of every scheme.
    for scheme in [
        Scheme::Xu2011 { segments: 4 },
        Scheme::Directional { directions: 64 },
    ] {
        let method = Method {
            scheme,
            ..Method::default()
        };
        for path in ["pass/probe.wgsl", "pass/shade.wgsl", "pass/shade_multiple.wgsl"] {
            let text = shader::compose(path, method.files()).unwrap();
            validated(&text).unwrap_or_else(|e| panic!("shaders/{path}, {scheme:?}: {e}"));
        }
    }
    // The check can fail: a type error in a composed pass is found.
    let broken =
        shader::compose("pass/probe.wgsl", &[]).unwrap() + "fn broken() -> f32 { return vec2f(1.0); }";
    assert!(validated(&broken).is_err());
}

/// Offsets of a struct's members and its size, as the shader sees them.
fn layout(module: &naga::Module, name: &str) -> (Vec<(String, usize)>, usize) {
    let (_, ty) = module
        .types
        .iter()
        .find(|(_, ty)| ty.name.as_deref() == Some(name))
        .unwrap();
    let naga::TypeInner::Struct { members, span } = &ty.inner else {
        panic!("{name} is no struct")
    };
    (
        members
            .iter()
            .map(|m| (m.name.clone().unwrap(), m.offset as usize))
            .collect(),
        *span as usize,
    )
}

fn owned(fields: &[(&str, usize)]) -> Vec<(String, usize)> {
    fields
        .iter()
        .map(|(name, offset)| ((*name).to_owned(), *offset))
        .collect()
}

#[test]
fn probe_layouts_agree_with_the_host() {
    let module = composed("pass/probe.wgsl");
    assert_eq!(
        layout(&module, "ProbeCase"),
        (owned(&probe::CASE_LAYOUT.0), probe::CASE_LAYOUT.1)
    );
    assert_eq!(
        layout(&module, "ProbeResult"),
        (owned(&probe::RESULT_LAYOUT.0), probe::RESULT_LAYOUT.1)
    );
    assert_eq!(layout(&module, "Fibre").0, owned(&probe::FIBRE_LAYOUT));
    let params = [
        ("sigma_a", offset_of!(VertexParams, sigma_a)),
        ("alpha_rad", offset_of!(VertexParams, alpha_rad)),
        ("beta_rad", offset_of!(VertexParams, beta_rad)),
        ("azimuthal_width", offset_of!(VertexParams, azimuthal_width)),
        ("eta", offset_of!(VertexParams, eta)),
        ("eccentricity", offset_of!(VertexParams, eccentricity)),
        ("alpha_ratios", offset_of!(VertexParams, alpha_ratios)),
        ("beta_ratios", offset_of!(VertexParams, beta_ratios)),
    ];
    assert_eq!(
        layout(&module, "VertexParams"),
        (owned(&params), size_of::<VertexParams>())
    );
}

/// Value of a module-scope constant.
fn constant(module: &naga::Module, name: &str) -> f64 {
    let (_, constant) = module
        .constants
        .iter()
        .find(|(_, c)| c.name.as_deref() == Some(name))
        .unwrap();
    match module.global_expressions[constant.init] {
        naga::Expression::Literal(naga::Literal::U32(v)) => f64::from(v),
        naga::Expression::Literal(naga::Literal::F32(v)) => f64::from(v),
        ref other => panic!("{name} is {other:?}"),
    }
}

#[test]
fn every_model_composes_with_the_passes_that_scatter() {
    let passes = |model: Model| -> &[&str] {
        if model.scatters_often() {
            &[
                "pass/shade.wgsl",
                "pass/shade_multiple.wgsl",
                "pass/averages.wgsl",
                "pass/probe.wgsl",
                "pass/bench_scatter.wgsl",
            ]
        } else {
            &["pass/shade.wgsl", "pass/bench_scatter.wgsl"]
        }
    };
    for model in [Model::Marschner, Model::Deon, Model::KajiyaKay] {
        let method = Method {
            model,
            ..Method::default()
        };
        for path in passes(model) {
            let text = shader::compose(path, method.files()).unwrap();
            validated(&text).unwrap_or_else(|e| panic!("{model:?}, shaders/{path}: {e}"));
        }
    }
}

#[test]
fn other_models_probe_layouts_agree_with_the_host() {
    let deon = composed("pass/probe_deon.wgsl");
    assert_eq!(
        layout(&deon, "DeonResult"),
        (owned(&probe_deon::RESULT_LAYOUT.0), probe_deon::RESULT_LAYOUT.1)
    );
    let kajiya_kay = composed("pass/probe_kajiya_kay.wgsl");
    assert_eq!(
        layout(&kajiya_kay, "KajiyaKayResult"),
        (
            owned(&probe_kajiya_kay::RESULT_LAYOUT.0),
            probe_kajiya_kay::RESULT_LAYOUT.1
        )
    );
    for (name, value) in [
        ("KAJIYA_KAY_STEPS", tables::KAJIYA_KAY_STEPS as f64),
        ("KAJIYA_KAY_OFFSET", tables::KAJIYA_KAY_OFFSET as f64),
    ] {
        assert_eq!(constant(&kajiya_kay, name), value, "{name}");
    }
}

#[test]
fn table_constants_agree_with_the_host() {
    let module = composed("pass/probe.wgsl");
    let expected = [
        ("TRUNCATION_COUNT", tables::TRUNCATION_COUNT as f64),
        ("TRUNCATION_MIN", tables::TRUNCATION_MIN),
        ("TRUNCATION_MAX", tables::TRUNCATION_MAX),
        ("GAMMA_OFFSET", tables::GAMMA_OFFSET as f64),
        ("VON_MISES_STEPS", tables::VON_MISES_STEPS as f64),
        ("VON_MISES_OFFSET", tables::VON_MISES_OFFSET as f64),
        ("COSINE_POWER_STEPS", tables::COSINE_POWER_STEPS as f64),
        ("COSINE_POWER_OFFSET", tables::COSINE_POWER_OFFSET as f64),
        ("WINDOW_OFFSET", tables::WINDOW_OFFSET as f64),
        ("FRESNEL_STEPS", tables::FRESNEL_STEPS as f64),
        ("FRESNEL_ETA_MAX", tables::FRESNEL_ETA_MAX),
        ("FRESNEL_OFFSET", tables::FRESNEL_OFFSET as f64),
        ("XU_ETA_STEPS", tables::XU_ETA_STEPS as f64),
        ("XU_ETA_MAX", tables::XU_ETA_MAX),
        ("XU_THETA_STEPS", tables::XU_THETA_STEPS as f64),
        ("XU_OFFSET", tables::XU_OFFSET as f64),
    ];
    for (name, value) in expected {
        assert_eq!(constant(&module, name), value, "{name}");
    }
    assert_eq!(tables::scattering_tables().len(), tables::TABLE_LEN);
    let directional = shader::compose("lib/single_directional.wgsl", &[]).unwrap();
    let line = format!("const DIRECTIONAL_GAMMAS: u32 = {DIRECTIONAL_GAMMAS}u;");
    assert!(directional.contains(&line));
}
