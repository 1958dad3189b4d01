//! Timestamps of compute passes: what the GPU itself spent in each shader, waiting and transfers aside.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::{Gpu, GpuError};

/// Passes that are timed between two looks; those after them are not.
const CAPACITY: u32 = wgpu::QUERY_SET_MAX_QUERIES / 2;

/// Two timestamps a pass.
pub(super) struct GpuTimer {
    queries: wgpu::QuerySet,
    /// u64 a query.
    resolved: wgpu::Buffer,
    ms_per_tick: f64,
    passes: Mutex<Passes>,
}

#[derive(Default)]
struct Passes {
    /// Shader of each pass that was timed.
    labels: Vec<String>,
    /// Passes for which there was no room.
    missed: usize,
}

impl GpuTimer {
    /// None where the device has no timestamps.
    pub(super) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Option<Self> {
        device
            .features()
            .contains(wgpu::Features::TIMESTAMP_QUERY)
            .then(|| Self {
                queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("pass times"),
                    ty: wgpu::QueryType::Timestamp,
                    count: 2 * CAPACITY,
                }),
                resolved: device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("pass times"),
                    size: 16 * u64::from(CAPACITY),
                    usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                    mapped_at_creation: false,
                }),
                ms_per_tick: 1e-6 * f64::from(queue.get_timestamp_period()),
                passes: Mutex::default(),
            })
    }

    /// Where the next pass, of shader `label`, leaves its timestamps.
    pub(super) fn writes(&self, label: &str) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let mut passes = self.passes();
        let pass = passes.labels.len() as u32;
        if pass == CAPACITY {
            passes.missed += 1;
            return None;
        }
        passes.labels.push(label.to_owned());
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(2 * pass),
            end_of_pass_write_index: Some(2 * pass + 1),
        })
    }

    /// Nothing was timed yet.
    pub(super) fn forget(&self) {
        *self.passes() = Passes::default();
    }

    /// Milliseconds of each shader since the last look, slowest first; blocks until its passes are done. Nothing where there were more
    /// passes than there is room for: a part would pass for the whole.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    pub(super) fn take(&self, gpu: &Gpu) -> Result<Vec<(String, f64)>, GpuError> {
        let passes = std::mem::take(&mut *self.passes());
        let queries = 2 * passes.labels.len();
        if queries == 0 || passes.missed > 0 {
            return Ok(Vec::new());
        }
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.resolve_query_set(&self.queries, 0..queries as u32, &self.resolved, 0);
        gpu.queue.submit([encoder.finish()]);
        let ticks: Vec<u64> = gpu.read(&self.resolved, queries)?;
        let mut sums: Vec<(String, f64)> = Vec::new();
        for (label, ends) in passes.labels.into_iter().zip(ticks.chunks_exact(2)) {
            let ms = self.ms_per_tick * ends[1].saturating_sub(ends[0]) as f64;
            match sums.iter_mut().find(|(name, _)| *name == label) {
                Some((_, sum)) => *sum += ms,
                None => sums.push((label, ms)),
            }
        }
        sums.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        Ok(sums)
    }

    fn passes(&self) -> MutexGuard<'_, Passes> {
        self.passes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
