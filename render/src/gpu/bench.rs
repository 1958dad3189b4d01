//! What benchmarks need beyond the product: times of the shaders' functions from long dispatches, the way to draw strands that was not
//! kept, and the truth about a picture's coverage.

mod area;
mod drawing;
mod ribbons;

use std::time::Instant;

pub use area::true_alpha;
pub use drawing::{DrawnBy, draw_strands};
pub use ribbons::Ribbons;

use super::probe::{GpuCase, ProbeCase};
use super::{Gpu, GpuError, Kernel, Method, tables::scattering_tables};

/// Lights of a case, all around its own (`shaders/pass/bench_scatter.wgsl`).
pub const LIGHTS: u32 = 40;

/// Seconds that single scattering by `method` takes for one light of one view: the fastest of `runs` dispatches over all `cases` with
/// [`LIGHTS`] lights each (fewer of a scheme that is too slow for them), after one that warms up. Preparation per view is shared by its lights, as when strands are shaded.
///
/// # Errors
/// [`GpuError`] when the shader is refused, the cases exceed a buffer, or the device is lost.
pub fn seconds_per_light(
    gpu: &Gpu,
    cases: &[ProbeCase],
    method: &Method,
    runs: u32,
) -> Result<f64, GpuError> {
    let lights = LIGHTS.min(method.lights_per_dispatch());
    let kernel = Kernel::scattering_with(
        gpu,
        "pass/bench_scatter.wgsl",
        method,
        &[("lights", f64::from(lights))],
    )?;
    let tables = gpu.storage_of("scattering tables", &scattering_tables())?;
    let packed: Vec<GpuCase> = cases.iter().map(GpuCase::from).collect();
    let inputs = gpu.storage_of("bench cases", &packed)?;
    let outputs = gpu.storage("bench results", 16 * cases.len() as u64)?;
    let bindings = kernel.bind(gpu, &[(0, &tables), (1, &inputs), (2, &outputs)]);
    let mut fastest = f64::INFINITY;
    for run in 0..=runs {
        let start = Instant::now();
        kernel.run(gpu, &bindings, cases.len() as u32);
        gpu.wait()?;
        if run > 0 {
            fastest = fastest.min(start.elapsed().as_secs_f64());
        }
    }
    Ok(fastest / (cases.len() as f64 * f64::from(lights)))
}
