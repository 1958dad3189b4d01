//! `balayage probe`: the scattering model at single points, JSON lines in, JSON lines out, so that anyone can check it.

use std::io::{self, BufRead, Write};

use balayage_render::optics::dual::Backward;
use balayage_render::optics::{
    Direction, Fibre, Lobes, OpticsError, Rgb, SrbfLight, deon, global_scattering, kajiya_kay,
    scattering_averages, single_scattering,
};
use clap::{Args, ValueEnum};
use rayon::prelude::*;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

/// Relative tolerance of every number of the reference; estimates are pessimistic, true errors are some 1e-8.
const TOLERANCE: f64 = 1e-6;
/// Orders p = 0 .. 3 of the model of d'Eon.
const DEON_ORDERS: u32 = 4;
/// Lines that are held and evaluated at a time.
const BATCH: usize = 512;

/// Options of `balayage probe`.
#[derive(Args, Clone, Debug)]
pub struct Arguments {
    /// What evaluates the cases.
    #[arg(long, value_enum, default_value_t = Backend::Reference)]
    pub backend: Backend,
}

/// What evaluates the cases.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// Numerical integration in float64.
    Reference,
}

/// What a run came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Lines answered, refused ones included.
    pub lines: usize,
    /// Lines that were answered by an error.
    pub refused: usize,
}

/// One point of the model, validated no further than its JSON.
#[derive(Clone, Debug, PartialEq)]
pub enum Case {
    /// Marschner's model as Xu 2011 lights it (no "model", or "marschner").
    Marschner(MarschnerCase),
    /// The energy-conserving model of d'Eon 2011.
    Deon(DeonCase),
    /// The diffuse term of Kajiya and Kay.
    KajiyaKay(KajiyaKayCase),
}

/// Inputs of Marschner's model: angles in radians unless their name ends in `_deg`.
#[derive(Clone, Debug, Deserialize, PartialEq)]
pub struct MarschnerCase {
    /// Index of refraction.
    pub eta: f64,
    /// Eccentricity a.
    pub eccentricity: f64,
    /// Absorption per fibre radius.
    pub sigma_a: Rgb,
    /// Shifts of R, TT, TRT.
    pub alpha_deg: [f64; 3],
    /// Standard deviations of R, TT, TRT in theta_h.
    pub beta_deg: [f64; 3],
    /// Bandwidth w_c.
    pub azimuthal_width: f64,
    /// View inclination.
    pub theta_o: f64,
    /// View azimuth.
    pub phi_o: f64,
    /// Light inclination.
    pub theta_j: f64,
    /// Light azimuth.
    pub phi_j: f64,
    /// Light bandwidth.
    pub lambda_j: f64,
    /// Bandwidth of the forward-scattered light of the global term.
    pub sigma_f: f64,
}

/// Inputs of d'Eon's model.
#[derive(Clone, Debug, Deserialize, PartialEq)]
pub struct DeonCase {
    /// Index of refraction.
    pub eta: f64,
    /// Absorption per fibre radius.
    pub sigma_a: Rgb,
    /// Shifts of p = 0, 1 and all above.
    pub alpha_deg: [f64; 3],
    /// Standard deviation in theta_i, the same for every p.
    pub deon_beta_long: f64,
    /// Standard deviation in azimuth.
    pub deon_beta_azimuth: f64,
    /// View inclination.
    pub theta_o: f64,
    /// View azimuth.
    pub phi_o: f64,
    /// Light inclination.
    pub theta_j: f64,
    /// Light azimuth.
    pub phi_j: f64,
    /// Light bandwidth.
    pub lambda_j: f64,
}

/// Inputs of Kajiya and Kay's diffuse term.
#[derive(Clone, Debug, Deserialize, PartialEq)]
pub struct KajiyaKayCase {
    /// Light inclination.
    pub theta_j: f64,
    /// Light bandwidth.
    pub lambda_j: f64,
}

/// Answers every line of `input` by one line of `output`, in order; blank lines are passed over.
///
/// # Errors
/// Reading and writing only: a line that is not valid is answered by {"id", "error"} and counted.
pub fn run(arguments: &Arguments, input: impl BufRead, output: &mut impl Write) -> io::Result<Report> {
    let mut report = Report::default();
    let mut lines = input.split(b'\n').enumerate();
    loop {
        let batch: Vec<(usize, Vec<u8>)> = lines
            .by_ref()
            .map(|(index, line)| line.map(|line| (index + 1, line)))
            .filter(|line| !matches!(line, Ok((_, line)) if line.trim_ascii().is_empty()))
            .take(BATCH)
            .collect::<io::Result<_>>()?;
        if batch.is_empty() {
            output.flush()?;
            return Ok(report);
        }
        let answers: Vec<Result<Value, Value>> = batch
            .par_iter()
            .map(|(number, line)| answer(arguments.backend, *number, line))
            .collect();
        for answer in answers {
            report.lines += 1;
            report.refused += usize::from(answer.is_err());
            let (Ok(line) | Err(line)) = answer;
            writeln!(output, "{line}")?;
        }
    }
}

/// The line that answers line `number`: results, or on the other side the error.
fn answer(backend: Backend, number: usize, line: &[u8]) -> Result<Value, Value> {
    let fail = |id: &Value, reason: String| json!({"id": id, "error": format!("line {number}: {reason}")});
    let value: Value = serde_json::from_slice(line)
        .map_err(|error| fail(&Value::Null, format!("not JSON: {error}; send one object a line")))?;
    let id = value.get("id").cloned().unwrap_or(Value::Null);
    let case = parse(value).map_err(|reason| fail(&id, reason))?;
    let mut result = match backend {
        Backend::Reference => evaluate_reference(&case),
    }
    .map_err(|reason| fail(&id, reason))?;
    result["id"] = id;
    Ok(result)
}

/// The case that a JSON object describes.
fn parse(value: Value) -> Result<Case, String> {
    if !value.is_object() {
        return Err("not an object; see design section 6 for the fields".into());
    }
    let model = match value.get("model") {
        None => "marschner".to_owned(),
        Some(Value::String(model)) => model.clone(),
        Some(other) => return Err(format!("`model` is {other}; it must be a string")),
    };
    match model.as_str() {
        "marschner" => fields(value).map(Case::Marschner),
        "deon" => fields(value).map(Case::Deon),
        "kajiya-kay" => fields(value).map(Case::KajiyaKay),
        other => Err(format!(
            "`model` is \"{other}\"; it must be \"marschner\", \"deon\" or \"kajiya-kay\""
        )),
    }
}

/// The fields of one model; names the one that is missing or of the wrong type.
fn fields<T: DeserializeOwned>(value: Value) -> Result<T, String> {
    let Value::Object(map) = &value else {
        return Err("not an object".into());
    };
    let given = map.keys().cloned().collect::<Vec<_>>().join(", ");
    serde_json::from_value(value).map_err(|error| format!("{error} (fields given: {given})"))
}

/// The answer of the float64 reference.
fn evaluate_reference(case: &Case) -> Result<Value, String> {
    match case {
        Case::Marschner(case) => marschner(case).map_err(|error| in_user_units(&error, &MARSCHNER_NAMES)),
        Case::Deon(case) => deon_model(case).map_err(|error| in_user_units(&error, &DEON_NAMES)),
        Case::KajiyaKay(case) => kajiya_kay_model(case).map_err(|error| error.to_string()),
    }
}

/// The reference's name of a field, the probe's, and how many of the probe's units one of the reference's is.
type FieldName = (&'static str, &'static str, f64);

const DEGREES: f64 = 180.0 / std::f64::consts::PI;
const MARSCHNER_NAMES: [FieldName; 6] = [
    ("alpha R", "alpha_deg[0]", DEGREES),
    ("alpha TT", "alpha_deg[1]", DEGREES),
    ("alpha TRT", "alpha_deg[2]", DEGREES),
    ("beta R", "beta_deg[0]", DEGREES),
    ("beta TT", "beta_deg[1]", DEGREES),
    ("beta TRT", "beta_deg[2]", DEGREES),
];
const DEON_NAMES: [FieldName; 5] = [
    ("alpha R", "alpha_deg[0]", DEGREES),
    ("alpha TT", "alpha_deg[1]", DEGREES),
    ("alpha TRT", "alpha_deg[2]", DEGREES),
    ("beta R", "deon_beta_long", 2.0),
    (
        "azimuthal_width",
        "deon_beta_azimuth",
        std::f64::consts::FRAC_1_SQRT_2,
    ),
];

/// The message with the probe's names and units in place of the reference's.
fn in_user_units(error: &OpticsError, names: &[FieldName]) -> String {
    if let OpticsError::Refused {
        field,
        value,
        requirement,
    } = error
        && let Some((_, name, unit)) = names.iter().find(|(of_reference, ..)| of_reference == field)
    {
        return format!(
            "`{name}` is {}; in the reference's unit it must be {requirement}",
            value * unit
        );
    }
    error.to_string()
}

/// Marschner's model: single and global scattering, averages.
fn marschner(case: &MarschnerCase) -> Result<Value, OpticsError> {
    let fibre = Fibre {
        eta: case.eta,
        eccentricity: case.eccentricity,
        sigma_a: case.sigma_a,
        alpha: case.alpha_deg.map(f64::to_radians),
        beta: case.beta_deg.map(f64::to_radians),
        azimuthal_width: case.azimuthal_width,
    };
    let view = Direction {
        theta: case.theta_o,
        phi: case.phi_o,
    };
    let centre = Direction {
        theta: case.theta_j,
        phi: case.phi_j,
    };
    fibre.check()?;
    let light = SrbfLight::new(centre, case.lambda_j)?;
    let single = single_scattering(&fibre, view, &light, TOLERANCE)?;
    let global = global_scattering(&fibre, view, centre, case.sigma_f, TOLERANCE)?;
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
