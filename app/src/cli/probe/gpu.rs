//! The shaders' answers: all cases of a model in a batch in one dispatch.

use balayage_render::gpu::probe::{self, ProbeCase, ProbeResult};
use balayage_render::gpu::probe_deon::{self, DeonResult};
use balayage_render::gpu::probe_kajiya_kay::{self, KajiyaKayResult};
use balayage_render::gpu::{Gpu, GpuError, Method, Model};
use serde_json::{Value, json};

use super::{
    Case, DEON_NAMES, DeonCase, Evaluator, KajiyaKayCase, MARSCHNER_NAMES, MarschnerCase, in_user_units,
};

/// The GPU and the method by which it integrates.
pub(super) struct OnGpu {
    gpu: Gpu,
    method: Method,
}

impl OnGpu {
    pub(super) fn new(gpu: Gpu, method: Method) -> Self {
        Self { gpu, method }
    }

    /// Answers to the sound cases of one model, in their order.
    fn answers(
        &self,
        model: Model,
        checked: &[Result<(Model, ProbeCase), String>],
    ) -> Result<std::vec::IntoIter<Value>, GpuError> {
        let cases: Vec<ProbeCase> = checked
            .iter()
            .flatten()
            .filter(|(of, _)| *of == model)
            .map(|(_, case)| *case)
            .collect();
        if cases.is_empty() {
            return Ok(Vec::new().into_iter());
        }
        let answers: Vec<Value> = match model {
            Model::Marschner => {
                let results = probe::run(&self.gpu, &cases, &self.method)?;
                results.iter().map(marschner_answer).collect()
            }
            Model::Deon => {
                let results = probe_deon::run(&self.gpu, &cases, &self.method)?;
                results.iter().map(deon_answer).collect()
            }
            Model::KajiyaKay => {
                let results = probe_kajiya_kay::run(&self.gpu, &cases, &self.method)?;
                results.iter().map(kajiya_kay_answer).collect()
            }
        };
        Ok(answers.into_iter())
    }
}

impl Evaluator for OnGpu {
    const BATCH: usize = 1 << 16;

    fn evaluate(&self, cases: &[Case]) -> Result<Vec<Result<Value, String>>, GpuError> {
        let checked: Vec<_> = cases.iter().map(checked).collect();
        let mut marschner = self.answers(Model::Marschner, &checked)?;
        let mut deon = self.answers(Model::Deon, &checked)?;
        let mut kajiya_kay = self.answers(Model::KajiyaKay, &checked)?;
        // As many results of each model as sound cases, in their order.
        Ok(checked
            .into_iter()
            .map(|case| {
                let (model, _) = case?;
                let answer = match model {
                    Model::Marschner => marschner.next(),
                    Model::Deon => deon.next(),
                    Model::KajiyaKay => kajiya_kay.next(),
                };
                answer.ok_or_else(|| "no answer".to_owned())
            })
            .collect())
    }
}

/// What the shaders are asked; what the reference refuses is refused.
fn checked(case: &Case) -> Result<(Model, ProbeCase), String> {
    match case {
        Case::Marschner(case) => Ok((Model::Marschner, marschner(case)?)),
        Case::Deon(case) => Ok((Model::Deon, deon(case)?)),
        Case::KajiyaKay(case) => Ok((Model::KajiyaKay, kajiya_kay(case)?)),
    }
}

fn marschner(case: &MarschnerCase) -> Result<ProbeCase, String> {
    let named = |error| in_user_units(&error, &MARSCHNER_NAMES);
    let fibre = case.fibre().map_err(named)?;
    case.light().map_err(named)?;
    case.view().check(["theta_o", "phi_o"]).map_err(named)?;
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

fn deon(case: &DeonCase) -> Result<ProbeCase, String> {
    let named = |error| in_user_units(&error, &DEON_NAMES);
    let fibre = case.fibre().map_err(named)?;
    case.light().map_err(named)?;
    case.view().check(["theta_o", "phi_o"]).map_err(named)?;
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
        sigma_f: 1.0,
    })
}

/// The fibre makes no difference to the diffuse term.
fn kajiya_kay(case: &KajiyaKayCase) -> Result<ProbeCase, String> {
    case.light().map_err(|error| error.to_string())?;
    Ok(ProbeCase {
        eta: 1.55,
        eccentricity: 1.0,
        sigma_a: [0.0; 3],
        alpha: [0.0; 3],
        beta: [0.1; 3],
        azimuthal_width: 0.2,
        theta_o: 0.0,
        phi_o: 0.0,
        theta_j: case.theta_j,
        phi_j: 0.0,
        lambda_j: case.lambda_j,
        sigma_f: 1.0,
    })
}

fn marschner_answer(result: &ProbeResult) -> Value {
    let lobes = |[r, tt, trt]: [[f64; 3]; 3]| json!({"R": r, "TT": tt, "TRT": trt});
    json!({
        "single": lobes(result.single),
        "global": lobes(result.global),
        "a_f": result.a_f,
        "a_b": result.a_b,
        "A_b": result.a_bar_b,
    })
}

fn deon_answer(result: &DeonResult) -> Value {
    let [p0, p1, p2, p3] = result.orders;
    json!({"single": {"0": p0, "1": p1, "2": p2, "3": p3}, "remainder": result.remainder})
}

fn kajiya_kay_answer(result: &KajiyaKayResult) -> Value {
    let channels = [result.diffuse; 3];
    json!({ "diffuse": channels })
}
