//! The model of Kajiya and Kay at single points, many cases in one dispatch.

use std::mem::offset_of;

use bytemuck::{Pod, Zeroable};

use super::probe::{ProbeCase, run_pass};
use super::{Gpu, GpuError, Method, Model};

/// What the shaders answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KajiyaKayResult {
    /// Single scattering of the light as it is drawn: specular (R), nothing (TT), diffuse (TRT), then rgb.
    pub single: [[f64; 3]; 3],
    /// The same of a uniform environment of radiance 1.
    pub uniform_light: [[f64; 3]; 3],
    /// The diffuse term with K_d = 1.
    pub diffuse: f64,
    /// The specular term with K_s = 1.
    pub specular: f64,
}

/// `KajiyaKayResult` of `shaders/pass/probe_kajiya_kay.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct GpuKajiyaKayResult {
    single: [[f32; 4]; 3],
    uniform_light: [[f32; 4]; 3],
    diffuse: f32,
    specular: f32,
    padding: [f32; 2],
}

/// Offsets of the fields of the shader's `KajiyaKayResult` and its size, for the layout test.
pub const RESULT_LAYOUT: ([(&str, usize); 4], usize) = (
    [
        ("single", offset_of!(GpuKajiyaKayResult, single)),
        ("uniform_light", offset_of!(GpuKajiyaKayResult, uniform_light)),
        ("diffuse", offset_of!(GpuKajiyaKayResult, diffuse)),
        ("specular", offset_of!(GpuKajiyaKayResult, specular)),
    ],
    size_of::<GpuKajiyaKayResult>(),
);

impl From<&GpuKajiyaKayResult> for KajiyaKayResult {
    fn from(r: &GpuKajiyaKayResult) -> Self {
        let lobes = |v: [[f32; 4]; 3]| v.map(|t| [f64::from(t[0]), f64::from(t[1]), f64::from(t[2])]);
        Self {
            single: lobes(r.single),
            uniform_light: lobes(r.uniform_light),
            diffuse: f64::from(r.diffuse),
            specular: f64::from(r.specular),
        }
    }
}

/// Evaluates the cases on the GPU by the quality of `method`. Values outside the model's range are moved to its edge by the shaders;
/// only theta_o, theta_j, lambda_j, eta, sigma_a and R's alpha and beta are read.
///
/// # Errors
/// As [`super::probe::run`].
pub fn run(gpu: &Gpu, cases: &[ProbeCase], method: &Method) -> Result<Vec<KajiyaKayResult>, GpuError> {
    let method = Method {
        model: Model::KajiyaKay,
        ..*method
    };
    let results = run_pass::<GpuKajiyaKayResult>(gpu, "pass/probe_kajiya_kay.wgsl", cases, &method)?;
    Ok(results.iter().map(KajiyaKayResult::from).collect())
}
