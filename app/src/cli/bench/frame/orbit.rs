//! The view turned by a hand.

use balayage_render::gpu::RenderSettings;

use super::super::report::{Cell, Table};
use super::Bench;
use crate::cli::CliError;
use crate::pace::Pace;

/// Pictures after which the pace knows the scene, and pictures that count then.
const LEARNING: usize = 16;
const COUNTED: usize = 64;

/// Degrees between two pictures.
const STEP_DEG: f32 = 1.5;

impl Bench {
    /// Pictures as the editor draws them while a hand turns the view: what they hold is what fits into the budget.
    pub(super) fn orbit(&mut self, is_software: bool) -> Result<Vec<Table>, CliError> {
        let mut pace = Pace::unknown(is_software);
        let (camera, size) = (self.camera, self.size);
        let mut ms = Vec::new();
        let mut shaders: Vec<(String, f64)> = Vec::new();
        for k in 0..LEARNING + COUNTED {
            self.camera = self.orbited(STEP_DEG);
            self.size = pace.size(size);
            let start = std::time::Instant::now();
            let report = self.frame(&pace.settings(RenderSettings::default()))?;
            // What the editor fetches with every picture.
            self.renderer.shown_bytes()?;
            self.renderer.picks()?;
            let milliseconds = start.elapsed().as_secs_f64() * 1e3;
            pace.learn(milliseconds);
            ms.push(milliseconds);
            for (name, ms) in report.shaders.into_iter().filter(|_| k >= LEARNING) {
                match shaders.iter_mut().find(|(known, _)| *known == name) {
                    Some((_, sum)) => *sum += ms,
                    None => shaders.push((name, ms)),
                }
            }
        }
        (self.camera, self.size) = (camera, size);

        let mut counted = ms.split_off(LEARNING);
        counted.sort_unstable_by(f64::total_cmp);
        let within = |factor: f64| {
            let count = counted
                .iter()
                .filter(|ms| **ms <= factor * pace.budget_ms)
                .count();
            Cell::Number(count as f64 / COUNTED as f64)
        };
        let [width, height] = pace.size(size);
        let mut table = Table::new(
            "frame_orbit",
            [
                "budget ms",
                "median ms",
                "90 % ms",
                "share within the budget",
                "share within 1.5 budgets",
                "strands",
                "picture",
            ],
        );
        table.row([
            Cell::Number(pace.budget_ms),
            counted[COUNTED / 2].into(),
            counted[COUNTED * 9 / 10].into(),
            within(1.0),
            within(1.5),
            Cell::Number(f64::from(pace.strand_share)),
            format!("{width}x{height}").into(),
        ]);
        if shaders.is_empty() {
            return Ok(vec![table]);
        }
        let mut times = Table::new("frame_orbit_shaders", ["shader", "ms a picture"]);
        shaders.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        for (name, ms) in shaders {
            times.row([Cell::from(name), (ms / COUNTED as f64).into()]);
        }
        Ok(vec![table, times])
    }
}
