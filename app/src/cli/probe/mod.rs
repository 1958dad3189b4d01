//! `balayage probe`: the scattering model at single points, JSON lines in, JSON lines out, so that anyone can check it.

mod gpu;
mod reference;

use std::io::{self, BufRead, Write};

use balayage_render::gpu::{Gpu, GpuError, Scheme};
use balayage_render::optics::{Direction, Fibre, OpticsError, Rgb, SrbfLight};
use clap::{Args, ValueEnum};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::method_options::MethodOptions;

/// Options of `balayage probe`.
#[derive(Args, Clone, Debug)]
pub struct Arguments {
    /// What evaluates the cases.
    #[arg(long, value_enum, default_value_t = Backend::Reference)]
    pub backend: Backend,
    /// How the GPU integrates.
    #[command(flatten)]
    pub method: MethodOptions,
}

/// What evaluates the cases.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// Numerical integration in float64.
    Reference,
    /// The shaders that draw the picture, in float32.
    Gpu,
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

/// What answers a batch of cases, each on its own.
trait Evaluator {
    /// Cases that are held and evaluated at a time.
    const BATCH: usize;

    /// The answer to each case, without its id, or why there is none.
    fn evaluate(&self, cases: &[Case]) -> Result<Vec<Result<Value, String>>, GpuError>;
}

/// Why a run ended early.
#[derive(Debug, thiserror::Error)]
pub enum ProbeError {
    /// The cases could not be read or the answers not written.
    #[error(transparent)]
    Stream(#[from] io::Error),
    /// The GPU failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

/// Answers every line of `input` by one line of `output`, in order; blank lines are passed over.
///
/// # Errors
/// Reading, writing and the GPU: a line that is not valid is answered by {"id", "error"} and counted.
pub fn run(
    arguments: &Arguments,
    input: impl BufRead,
    output: &mut impl Write,
) -> Result<Report, ProbeError> {
    match arguments.backend {
        Backend::Reference => answer_all(&reference::Reference, input, output),
        Backend::Gpu => {
            let gpu = gpu::OnGpu::new(Gpu::headless()?, arguments.method.method(Scheme::default()));
            answer_all(&gpu, input, output)
        }
    }
}

fn answer_all<E: Evaluator>(
    evaluator: &E,
    input: impl BufRead,
    output: &mut impl Write,
) -> Result<Report, ProbeError> {
    let mut report = Report::default();
    let mut lines = input.split(b'\n').enumerate();
    loop {
        let batch: Vec<(usize, Vec<u8>)> = lines
            .by_ref()
            .map(|(index, line)| line.map(|line| (index + 1, line)))
            .filter(|line| !matches!(line, Ok((_, line)) if line.trim_ascii().is_empty()))
            .take(E::BATCH)
            .collect::<io::Result<_>>()?;
        if batch.is_empty() {
            output.flush()?;
            return Ok(report);
        }
        let parsed: Vec<(Value, Result<Case, String>)> =
            batch.iter().map(|(_, line)| parse_line(line)).collect();
        let cases: Vec<Case> = parsed.iter().filter_map(|(_, case)| case.clone().ok()).collect();
        let mut answers = evaluator.evaluate(&cases)?.into_iter();
        for ((number, _), (id, case)) in batch.iter().zip(parsed) {
            // As many answers as cases, in their order.
            let answer = case.and_then(|_| answers.next().unwrap_or_else(|| Err("no answer".to_owned())));
            let line = match answer {
                Ok(mut answer) => {
                    answer["id"] = id;
                    answer
                }
                Err(reason) => {
                    report.refused += 1;
                    json!({"id": id, "error": format!("line {number}: {reason}")})
                }
            };
            report.lines += 1;
            writeln!(output, "{line}")?;
        }
    }
}

/// A line's id (null if it has none) and the case that it describes.
fn parse_line(line: &[u8]) -> (Value, Result<Case, String>) {
    match serde_json::from_slice::<Value>(line) {
        Ok(value) => (value.get("id").cloned().unwrap_or(Value::Null), parse(value)),
        Err(error) => (
            Value::Null,
            Err(format!("not JSON: {error}; send one object a line")),
        ),
    }
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

impl MarschnerCase {
    /// The fibre, checked.
    fn fibre(&self) -> Result<Fibre, OpticsError> {
        let fibre = Fibre {
            eta: self.eta,
            eccentricity: self.eccentricity,
            sigma_a: self.sigma_a,
            alpha: self.alpha_deg.map(f64::to_radians),
            beta: self.beta_deg.map(f64::to_radians),
            azimuthal_width: self.azimuthal_width,
        };
        fibre.check()?;
        Ok(fibre)
    }

    /// Where the view is.
    fn view(&self) -> Direction {
        Direction {
            theta: self.theta_o,
            phi: self.phi_o,
        }
    }

    /// The light, checked.
    fn light(&self) -> Result<SrbfLight, OpticsError> {
        let centre = Direction {
            theta: self.theta_j,
            phi: self.phi_j,
        };
        SrbfLight::new(centre, self.lambda_j)
    }
}
