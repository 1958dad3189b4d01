//! The shaders' answers: all cases of a batch in one dispatch.

use balayage_render::gpu::probe::{self, ProbeCase, ProbeResult};
use balayage_render::gpu::{Gpu, GpuError, Method};
use serde_json::{Value, json};

use super::{Case, Evaluator, MARSCHNER_NAMES, MarschnerCase, in_user_units};

/// The GPU and the method by which it integrates.
pub(super) struct OnGpu {
    gpu: Gpu,
    method: Method,
}

impl OnGpu {
    pub(super) fn new(gpu: Gpu, method: Method) -> Self {
        Self { gpu, method }
    }
}

impl Evaluator for OnGpu {
    const BATCH: usize = 1 << 16;

    fn evaluate(&self, cases: &[Case]) -> Result<Vec<Result<Value, String>>, GpuError> {
        let checked: Vec<Result<ProbeCase, String>> = cases.iter().map(checked).collect();
        let sound: Vec<ProbeCase> = checked.iter().filter_map(|case| case.clone().ok()).collect();
        let mut results = probe::run(&self.gpu, &sound, &self.method)?.into_iter();
        // As many results as sound cases, in their order.
        Ok(checked
            .into_iter()
            .map(|case| {
                case.and_then(|_| {
                    results
                        .next()
                        .as_ref()
                        .map(answer)
                        .ok_or_else(|| "no answer".to_owned())
                })
            })
            .collect())
    }
}

/// What the shaders are asked; what the reference refuses is refused.
fn checked(case: &Case) -> Result<ProbeCase, String> {
    match case {
        Case::Marschner(case) => marschner(case),
        Case::Deon(_) | Case::KajiyaKay(_) => {
            Err("this model has no shader; use --backend reference".to_owned())
        }
    }
}

fn marschner(case: &MarschnerCase) -> Result<ProbeCase, String> {
    let named = |error| in_user_units(&error, &MARSCHNER_NAMES);
    let fibre = case.fibre().map_err(named)?;
    case.light().map_err(named)?;
    Ok(ProbeCase {
        eta: fibre.eta,
        eccentricity: fibre.eccentricity,
        sigma_a: fibre.sigma_a,
        alpha: fibre.alpha,
        beta: fibre.beta,
        azimuthal_width: fibre.azimuthal_width,
        theta_o: case.theta_o,
        phi_o: case.phi_o,
        theta_j: case.theta_j,
        phi_j: case.phi_j,
        lambda_j: case.lambda_j,
        sigma_f: case.sigma_f,
    })
}

fn answer(result: &ProbeResult) -> Value {
    let lobes = |[r, tt, trt]: [[f64; 3]; 3]| json!({"R": r, "TT": tt, "TRT": trt});
    json!({
        "single": lobes(result.single),
        "global": lobes(result.global),
        "a_f": result.a_f,
        "a_b": result.a_b,
        "A_b": result.a_bar_b,
    })
}
