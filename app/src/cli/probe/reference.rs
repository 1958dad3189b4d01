//! The float64 reference's answers.

use balayage_render::gpu::GpuError;
use balayage_render::optics::dual::Backward;
use balayage_render::optics::{
    Lobes, OpticsError, Rgb, deon, global_scattering, kajiya_kay, scattering_averages, single_scattering,
};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::{
    Case, DEON_NAMES, DeonCase, Evaluator, KajiyaKayCase, MARSCHNER_NAMES, MarschnerCase, in_user_units,
};

/// Relative tolerance of every number of the reference; estimates are pessimistic, true errors are some 1e-8.
const TOLERANCE: f64 = 1e-6;

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

/// d'Eon's model: single scattering per order, and of all above.
fn deon_model(case: &DeonCase) -> Result<Value, OpticsError> {
    let (fibre, view, light) = (case.fibre()?, case.view(), case.light()?);
    let orders = deon::single_scattering(&fibre, view, &light, deon::DRAWN_ORDERS, TOLERANCE)?;
    let remainder = deon::remainder(&fibre, view, &light, deon::DRAWN_ORDERS, TOLERANCE)?;
    let by_order: serde_json::Map<String, Value> = orders
        .iter()
        .enumerate()
        .map(|(p, s)| (p.to_string(), json!(s)))
        .collect();
    Ok(json!({ "single": by_order, "remainder": remainder }))
}

/// Kajiya and Kay's diffuse term with K_d = 1, the same in every channel.
fn kajiya_kay_model(case: &KajiyaKayCase) -> Result<Value, OpticsError> {
    let light = case.light()?;
    let diffuse = kajiya_kay::diffuse(&light, TOLERANCE)?;
    let channels: Rgb = [diffuse; 3];
    Ok(json!({ "diffuse": channels }))
}
