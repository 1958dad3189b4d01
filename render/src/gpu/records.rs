//! What the marches have left, read back.

use half::f16;

use super::{Gpu, GpuError, Transmittance};

impl Transmittance {
    /// a and b (world space) of T(w) = a + b . (w - A w_j) for every (light, point), light-major; only what an update has made means anything.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    pub fn visibility_records(&self, gpu: &Gpu, point_count: usize) -> Result<Vec<[f32; 4]>, GpuError> {
        let mut records = Vec::new();
        for batch in self.batches() {
            let of_batch = gpu.read::<[f16; 4]>(&batch.visibility, batch.lights.len() * point_count)?;
            records.extend(of_batch.iter().map(|record| record.map(f32::from)));
        }
        Ok(records)
    }

    /// T_f rgb, spread, 2 sum k rgb and n for every (light, point), light-major; only what an update has made means anything.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    pub fn path_records(&self, gpu: &Gpu, point_count: usize) -> Result<Vec<[f32; 8]>, GpuError> {
        let mut records = Vec::new();
        for batch in self.batches() {
            let of_batch = gpu.read::<[f16; 8]>(&batch.path, batch.lights.len() * point_count)?;
            records.extend(of_batch.iter().map(|record| {
                let [r, g, b, rest @ ..] = record.map(f32::from);
                let [spread, k_r, k_g, k_b, n] = rest;
                [(-r).exp(), (-g).exp(), (-b).exp(), spread, k_r, k_g, k_b, n]
            }));
        }
        Ok(records)
    }
}
