//! The scattering functions of the shaders at single points, many cases in one dispatch.

use std::mem::offset_of;

use bytemuck::{Pod, Zeroable};

use super::{Gpu, GpuError, Kernel, Method, operations, shader, tables::scattering_tables};

/// One point at which the model is evaluated. Angles in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeCase {
    /// Index of refraction.
    pub eta: f64,
    /// Eccentricity a, 1 = circular.
    pub eccentricity: f64,
    /// Absorption per fibre radius, rgb.
    pub sigma_a: [f64; 3],
    /// Cuticle tilt of R, TT, TRT.
    pub alpha: [f64; 3],
    /// Standard deviation in theta_h of R, TT, TRT.
    pub beta: [f64; 3],
    /// Azimuthal bandwidth w_c of TRT.
    pub azimuthal_width: f64,
    /// Inclination of the view.
    pub theta_o: f64,
    /// Azimuth of the view.
    pub phi_o: f64,
    /// Inclination of the light's centre.
    pub theta_j: f64,
    /// Azimuth of the light's centre.
    pub phi_j: f64,
    /// Bandwidth of the light.
    pub lambda_j: f64,
    /// Bandwidth in theta_i of forward-scattered light.
    pub sigma_f: f64,
}

/// What the shaders answer; lobes in the order R, TT, TRT, then rgb.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeResult {
    /// Single scattering of the light.
    pub single: [[f64; 3]; 3],
    /// Global multiple scattering (Xu 2011, Eq 27).
    pub global: [[f64; 3]; 3],
    /// Single scattering of a uniform environment of radiance 1.
    pub uniform_light: [[f64; 3]; 3],
    /// Share scattered forward at inclination theta_j, rgb.
    pub a_f: [f64; 3],
    /// Share scattered backward, rgb.
    pub a_b: [f64; 3],
    /// Mean tilt of what goes forward and backward, rgb.
    pub alpha: [[f64; 3]; 2],
    /// Root mean squared width of what goes forward and backward, rgb.
    pub beta: [[f64; 3]; 2],
    /// Backward share of a cluster (Zinke 2008, one and three backward events), rgb.
    pub a_bar_b: [f64; 3],
}

/// `ProbeCase` of `shaders/pass/probe.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct GpuCase {
    sigma_a: [f32; 3],
    eta: f32,
    alpha: [f32; 3],
    eccentricity: f32,
    beta: [f32; 3],
    azimuthal_width: f32,
    theta_o: f32,
    phi_o: f32,
    theta_j: f32,
    phi_j: f32,
    lambda_j: f32,
    sigma_f: f32,
    padding: [f32; 2],
}

/// `ProbeResult` of `shaders/pass/probe.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct GpuResult {
    single: [[f32; 4]; 3],
    global: [[f32; 4]; 3],
    uniform_light: [[f32; 4]; 3],
    averages: [[f32; 6]; 3],
    padding: [f32; 2],
}

impl From<&ProbeCase> for GpuCase {
    fn from(c: &ProbeCase) -> Self {
        let three = |v: [f64; 3]| v.map(|x| x as f32);
        Self {
            sigma_a: three(c.sigma_a),
            eta: c.eta as f32,
            alpha: three(c.alpha),
            eccentricity: c.eccentricity as f32,
            beta: three(c.beta),
            azimuthal_width: c.azimuthal_width as f32,
            theta_o: c.theta_o as f32,
            phi_o: c.phi_o as f32,
            theta_j: c.theta_j as f32,
            phi_j: c.phi_j as f32,
            lambda_j: c.lambda_j as f32,
            sigma_f: c.sigma_f as f32,
            padding: [0.0; 2],
        }
    }
}

impl From<&GpuResult> for ProbeResult {
    fn from(r: &GpuResult) -> Self {
        let lobes = |v: &[[f32; 4]; 3]| v.map(|t| [f64::from(t[0]), f64::from(t[1]), f64::from(t[2])]);
        let average = |field: usize| std::array::from_fn(|channel| f64::from(r.averages[channel][field]));
        let (a_f, a_b): ([f64; 3], [f64; 3]) = (average(0), average(1));
        Self {
            single: lobes(&r.single),
            global: lobes(&r.global),
            uniform_light: lobes(&r.uniform_light),
            a_f,
            a_b,
            alpha: [average(2), average(3)],
            beta: [average(4), average(5)],
            a_bar_b: std::array::from_fn(|channel| backward_of_cluster(a_f[channel], a_b[channel])),
        }
    }
}

/// Zinke 2008, Eq 14 to 16: paths with one and with three backward events, shares clamped to 0.99.
fn backward_of_cluster(a_f: f64, a_b: f64) -> f64 {
    let forward = a_f.min(0.99).powi(2);
    let once_more = 1.0 - forward;
    a_b * forward / once_more + a_b.powi(3) * forward / once_more.powi(3)
}

/// Offsets of the named fields of the shader's `ProbeCase` and its size, for the layout test.
pub const CASE_LAYOUT: ([(&str, usize); 7], usize) = (
    [
        ("fibre", offset_of!(GpuCase, sigma_a)),
        ("theta_o", offset_of!(GpuCase, theta_o)),
        ("phi_o", offset_of!(GpuCase, phi_o)),
        ("theta_j", offset_of!(GpuCase, theta_j)),
        ("phi_j", offset_of!(GpuCase, phi_j)),
        ("lambda_j", offset_of!(GpuCase, lambda_j)),
        ("sigma_f", offset_of!(GpuCase, sigma_f)),
    ],
    size_of::<GpuCase>(),
);

/// Offsets of the fields of the shader's `Fibre`, which begins a case.
pub const FIBRE_LAYOUT: [(&str, usize); 6] = [
    ("sigma_a", offset_of!(GpuCase, sigma_a)),
    ("eta", offset_of!(GpuCase, eta)),
    ("alpha", offset_of!(GpuCase, alpha)),
    ("eccentricity", offset_of!(GpuCase, eccentricity)),
    ("beta", offset_of!(GpuCase, beta)),
    ("azimuthal_width", offset_of!(GpuCase, azimuthal_width)),
];

/// Offsets of the fields of the shader's `ProbeResult` and its size.
pub const RESULT_LAYOUT: ([(&str, usize); 4], usize) = (
    [
        ("single", offset_of!(GpuResult, single)),
        ("global", offset_of!(GpuResult, global)),
        ("uniform_light", offset_of!(GpuResult, uniform_light)),
        ("averages", offset_of!(GpuResult, averages)),
    ],
    size_of::<GpuResult>(),
);

/// Cases per dispatch: bounds the result buffer to 30 MB.
const CHUNK: usize = 1 << 17;

/// Evaluates the cases on the GPU, [`CHUNK`] in a dispatch. Values outside the model's range are moved to its edge by the shaders.
///
/// # Errors
/// [`GpuError`] when the shader is refused, the cases exceed a buffer, or the device is lost.
pub fn run(gpu: &Gpu, cases: &[ProbeCase], method: &Method) -> Result<Vec<ProbeResult>, GpuError> {
    let kernel = Kernel::scattering(gpu, "pass/probe.wgsl", method)?;
    let tables = gpu.storage_of("scattering tables", &scattering_tables())?;
    let mut results = Vec::with_capacity(cases.len());
    for chunk in cases.chunks(CHUNK) {
        let packed: Vec<GpuCase> = chunk.iter().map(GpuCase::from).collect();
        let inputs = gpu.storage_of("probe cases", &packed)?;
        let outputs = gpu.storage("probe results", (chunk.len() * size_of::<GpuResult>()) as u64)?;
        let bindings = kernel.bind(gpu, &[(0, &tables), (1, &inputs), (2, &outputs)]);
        kernel.run(gpu, &bindings, chunk.len() as u32);
        results.extend(
            gpu.read::<GpuResult>(&outputs, chunk.len())?
                .iter()
                .map(ProbeResult::from),
        );
    }
    Ok(results)
}

/// Transcendental operations (exponentials, logarithms, powers, trigonometric and hyperbolic functions and their inverses, square roots;
/// per component of a vector) that `single_scattering` executes at each case, counted by the shader itself. What is prepared per
/// vertex and view, whatever the light, is not counted.
///
/// # Errors
/// As [`run`].
pub fn operations(gpu: &Gpu, cases: &[ProbeCase], method: &Method) -> Result<Vec<u32>, GpuError> {
    let text =
        shader::compose("pass/operations.wgsl", method.files()).map_err(|reason| GpuError::Refused {
            what: "shaders/pass/operations.wgsl".to_owned(),
            reason,
        })?;
    let tables = scattering_tables();
    let mut counts = Vec::with_capacity(cases.len());
    for chunk in cases.chunks(CHUNK) {
        let packed: Vec<GpuCase> = chunk.iter().map(GpuCase::from).collect();
        let inputs = [bytemuck::cast_slice(&tables), bytemuck::cast_slice(&packed)];
        counts.extend(operations::run(
            gpu,
            &text,
            &method.constants(&text),
            &inputs,
            chunk.len() as u32,
        )?);
    }
    Ok(counts)
}
