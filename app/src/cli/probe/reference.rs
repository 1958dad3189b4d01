//! The float64 reference's answers.

use balayage_render::gpu::GpuError;
use balayage_render::optics::dual::Backward;
use balayage_render::optics::{
    Direction, Fibre, Lobes, OpticsError, Rgb, SrbfLight, deon, global_scattering, kajiya_kay,
    scattering_averages, single_scattering,
};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::{
    Case, DEON_NAMES, DeonCase, Evaluator, KajiyaKayCase, MARSCHNER_NAMES, MarschnerCase, in_user_units,
};

/// Relative tolerance of every number of the reference; estimates are pessimistic, true errors are some 1e-8.
const TOLERANCE: f64 = 1e-6;
/// Orders p = 0 .. 3 of the model of d'Eon.
const DEON_ORDERS: u32 = 4;

/// Numerical integration, all cores.
pub(super) struct Reference;

impl Evaluator for Reference {
    const BATCH: usize = 512;

    fn evaluate(&self, cases: &[Case]) -> Result<Vec<Result<Value, String>>, GpuError> {
        Ok(cases.par_iter().map(answer).collect())
    }
}

fn answer(case: &Case) -> Result<Value, String> {
    match case {
        Case::Marschner(case) => marschner(case).map_err(|error| in_user_units(&error, &MARSCHNER_NAMES)),
        Case::Deon(case) => deon_model(case).map_err(|error| in_user_units(&error, &DEON_NAMES)),
        Case::KajiyaKay(case) => kajiya_kay_model(case).map_err(|error| error.to_string()),
    }
}

/// Marschner's model: single and global scattering, averages.
fn marschner(case: &MarschnerCase) -> Result<Value, OpticsError> {
    let (fibre, view, light) = (case.fibre()?, case.view(), case.light()?);
    let single = single_scattering(&fibre, view, &light, TOLERANCE)?;
    let global = global_scattering(&fibre, view, light.centre, case.sigma_f, TOLERANCE)?;
    let averages = scattering_averages(&fibre, case.theta_j, TOLERANCE)?;
    Ok(json!({
        "single": lobes(&single),
        "global": lobes(&global),
        "a_f": averages.a_f,
        "a_b": averages.a_b,
        "A_b": Backward::of(&averages).a_b_adding,
    }))
}

/// Lobes by name.
fn lobes(lobes: &Lobes) -> Value {
    json!({"R": lobes.r, "TT": lobes.tt, "TRT": lobes.trt})
}

/// d'Eon's model: single scattering per order.
fn deon_model(case: &DeonCase) -> Result<Value, OpticsError> {
    let fibre = Fibre {
        eta: case.eta,
        eccentricity: 1.0,
        sigma_a: case.sigma_a,
        alpha: case.alpha_deg.map(f64::to_radians),
        beta: [0.5 * case.deon_beta_long; 3],
        azimuthal_width: std::f64::consts::SQRT_2 * case.deon_beta_azimuth,
    };
    let view = Direction {
        theta: case.theta_o,
        phi: case.phi_o,
    };
    fibre.check()?;
    let light = SrbfLight::new(
        Direction {
            theta: case.theta_j,
            phi: case.phi_j,
        },
        case.lambda_j,
    )?;
    let orders = deon::single_scattering(&fibre, view, &light, DEON_ORDERS, TOLERANCE)?;
    let by_order: serde_json::Map<String, Value> = orders
        .iter()
        .enumerate()
        .map(|(p, s)| (p.to_string(), json!(s)))
        .collect();
    Ok(json!({ "single": by_order }))
}

/// Kajiya and Kay's diffuse term with K_d = 1, the same in every channel.
fn kajiya_kay_model(case: &KajiyaKayCase) -> Result<Value, OpticsError> {
    let light = SrbfLight::new(
        Direction {
            theta: case.theta_j,
            phi: 0.0,
        },
        case.lambda_j,
    )?;
    let diffuse = kajiya_kay::diffuse(&light, TOLERANCE)?;
    let channels: Rgb = [diffuse; 3];
    Ok(json!({ "diffuse": channels }))
}
