//! What a frame cost: milliseconds a pass, work counted.

use std::time::Instant;

use serde::Serialize;

use super::shade::ShadeReport;
use super::{Gpu, GpuError};

/// What a frame cost.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FrameReport {
    /// Passes that ran and their milliseconds, wall clock with the GPU waited for.
    pub passes: Vec<(String, f64)>,
    /// Shaders that ran and the milliseconds that the GPU itself spent in them, slowest first; empty where it was not timed
    /// ([`Gpu::time_passes`]).
    pub shaders: Vec<(String, f64)>,
    /// Named work counters.
    pub counters: Vec<(String, u64)>,
}

impl FrameReport {
    pub(super) fn time<T>(
        &mut self,
        gpu: &Gpu,
        pass: &str,
        run: impl FnOnce(&mut Self) -> Result<T, GpuError>,
    ) -> Result<T, GpuError> {
        let _scope = scope(pass).entered();
        let start = Instant::now();
        let result = run(self)?;
        gpu.wait()?;
        self.add_time(pass, start.elapsed().as_secs_f64() * 1e3);
        Ok(result)
    }

    /// Milliseconds of all passes so far.
    pub(super) fn total_ms(&self) -> f64 {
        self.passes.iter().map(|(_, ms)| ms).sum()
    }

    pub(super) fn add_time(&mut self, pass: &str, ms: f64) {
        match self.passes.iter_mut().find(|(name, _)| name == pass) {
            Some((_, sum)) => *sum += ms,
            None => self.passes.push((pass.to_owned(), ms)),
        }
    }

    pub(super) fn count(&mut self, counter: &str, value: u64) {
        match self.counters.iter_mut().find(|(name, _)| name == counter) {
            Some((_, sum)) => *sum += value,
            None => self.counters.push((counter.to_owned(), value)),
        }
    }

    pub(super) fn count_shading(&mut self, done: &ShadeReport) {
        self.count("vertices shaded", done.vertices);
        self.count("single scattering evaluations", done.single);
        self.count("elliptic evaluations", done.elliptic);
        self.count("multiple scattering evaluations", done.multiple);
        self.count("hidden lights skipped", done.hidden);
        if done.compiled > 0 {
            self.count("shader variants compiled", done.compiled);
        }
    }

    /// The counter of that name, 0 where the work was not done.
    pub fn counter(&self, name: &str) -> u64 {
        self.counters
            .iter()
            .filter(|(n, _)| n == name)
            .map(|(_, v)| v)
            .sum()
    }
}

/// The scope of a pass; its name has to be known to the compiler.
fn scope(pass: &str) -> tracing::Span {
    macro_rules! named {
        ($($name:literal),*) => {
            match pass {
                $($name => tracing::info_span!($name),)*
                other => tracing::info_span!("pass", name = other),
            }
        };
    }
    named!("head shading", "transmittance", "strand shading", "view")
}
