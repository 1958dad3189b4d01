//! The model of d'Eon 2011 at single points, order by order, many cases in one dispatch.

use std::mem::offset_of;

use bytemuck::{Pod, Zeroable};

use super::probe::{ProbeCase, run_pass};
use super::{Gpu, GpuError, Method, Model};

/// What the shaders answer, rgb per order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeonResult {
    /// Integral of G S_p over the sphere, p = 0 .. 3.
    pub orders: [[f64; 3]; 4],
    /// The same of all orders above.
    pub remainder: [f64; 3],
    /// Orders 0 .. 3 and all above of a uniform environment of radiance 1.
    pub uniform_light: [[f64; 3]; 5],
    /// M_p of R between theta_j and the view.
    pub cone: f64,
}

/// `DeonResult` of `shaders/pass/probe_deon.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct GpuDeonResult {
    orders: [[f32; 4]; 5],
    uniform_light: [[f32; 4]; 5],
    cone: f32,
    padding: [f32; 3],
}

/// Offsets of the fields of the shader's `DeonResult` and its size, for the layout test.
pub const RESULT_LAYOUT: ([(&str, usize); 3], usize) = (
    [
        ("orders", offset_of!(GpuDeonResult, orders)),
        ("uniform_light", offset_of!(GpuDeonResult, uniform_light)),
        ("cone", offset_of!(GpuDeonResult, cone)),
    ],
    size_of::<GpuDeonResult>(),
);

impl From<&GpuDeonResult> for DeonResult {
    fn from(r: &GpuDeonResult) -> Self {
        let rgb = |v: [f32; 4]| [f64::from(v[0]), f64::from(v[1]), f64::from(v[2])];
        let [p0, p1, p2, p3, remainder] = r.orders.map(rgb);
        Self {
            orders: [p0, p1, p2, p3],
            remainder,
            uniform_light: r.uniform_light.map(rgb),
            cone: f64::from(r.cone),
        }
    }
}

/// Evaluates the cases on the GPU by the quality of `method`. Values outside the model's range are moved to its edge by the shaders;
/// eccentricity and `sigma_f` are not read.
///
/// # Errors
/// As [`super::probe::run`].
pub fn run(gpu: &Gpu, cases: &[ProbeCase], method: &Method) -> Result<Vec<DeonResult>, GpuError> {
    let method = Method {
        model: Model::Deon,
        ..*method
    };
    let results = run_pass::<GpuDeonResult>(gpu, "pass/probe_deon.wgsl", cases, &method)?;
    Ok(results.iter().map(DeonResult::from).collect())
}
