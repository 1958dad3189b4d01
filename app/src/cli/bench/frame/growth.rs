//! How cost grows with lights, vertices and paint.

use balayage_render::gpu::{RenderSettings, Saving, Savings};
use balayage_render::light::LightSet;

use super::super::plot::Series;
use super::super::report::{Cell, Table};
use super::{Bench, Cost};
use crate::cli::CliError;

impl Bench {
    /// Cost against lights, strands and painted points, with the exponents of the power laws between.
    pub(super) fn growth(&mut self) -> Result<(Table, Vec<Series>), CliError> {
        let mut table = Table::new(
            "frame_growth",
            [
                "of",
                "count",
                "shading and transmittance ms",
                "lights evaluated",
                "exponent of ms",
            ],
        );
        let mut series = Vec::new();
        let mut add = |name: &'static str, rows: Vec<(f64, Cost)>, whole: f64| {
            let ms = |cost: &Cost| cost.pass("strand shading") + cost.pass("transmittance");
            let points: Vec<(f64, f64)> = rows.iter().map(|(n, cost)| (*n, ms(cost))).collect();
            let exponent = exponent(&points);
            for (count, cost) in &rows {
                let work = &cost.report;
                let lights = work.counter("single scattering evaluations")
                    + work.counter("multiple scattering evaluations");
                table.row([
                    Cell::from(name),
                    Cell::Count(*count as u64),
                    ms(cost).into(),
                    Cell::Count(lights),
                    exponent.into(),
                ]);
            }
            series.push(Series {
                name: name.to_owned(),
                points: points.into_iter().map(|(n, ms)| (n / whole, ms)).collect(),
            });
        };
        let anew = RenderSettings {
            savings: Savings::ALL.without(Saving::Untouched),
            ..RenderSettings::default()
        };
        let all = self.lights.clone();
        let mut rows = Vec::new();
        let count = all.lights.len();
        for part in [8, 4, 2, 1] {
            let lights = LightSet {
                lights: all.lights[..(count / part).max(1)].to_vec(),
                ..all
            };
            self.renderer.set_lights(&lights);
            rows.push((lights.lights.len() as f64, Cost::of(&[self.frame(&anew)?])));
        }
        add("lights", rows, count.max(1) as f64);

        // A part of the strands: as many vertices are wanted.
        let mut rows = Vec::new();
        for share in [0.125, 0.25, 0.5, 1.0] {
            let settings = RenderSettings {
                strand_share: share,
                ..anew
            };
            let cost = Cost::of(&[self.frame(&settings)?]);
            rows.push((cost.report.counter("vertices shaded") as f64, cost));
        }
        let most = rows.last().map_or(1.0, |(n, _)| *n);
        add("vertices", rows, most);

        let painting = RenderSettings {
            interactive: true,
            ..RenderSettings::default()
        };
        self.frame(&painting)?;
        let mut rows = Vec::new();
        for share in [0.01, 0.03, 0.1, 0.3, 1.0] {
            let cost = self.cost(&painting, |bench, k| bench.dye(share, k))?;
            rows.push((f64::from(share) * self.params.len() as f64, cost));
        }
        let points = self.params.len() as f64;
        add("painted points", rows, points);
        Ok((table, series))
    }
}

/// Exponent p of y = c x^p, least squares over the logarithms.
fn exponent(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let logs = || points.iter().map(|(x, y)| (x.ln(), y.ln()));
    let (mean_x, mean_y) = (
        logs().map(|(x, _)| x).sum::<f64>() / n,
        logs().map(|(_, y)| y).sum::<f64>() / n,
    );
    let across: f64 = logs().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    across / logs().map(|(x, _)| (x - mean_x).powi(2)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    #[test]
    fn exponents_of_power_laws() {
        let points = |p: f64| [1.0, 3.0, 10.0].map(|x: f64| (x, 5.0 * x.powf(p)));
        for p in [0.0, 0.5, 1.0, 2.0] {
            assert!((super::exponent(&points(p)) - p).abs() < 1e-12);
        }
    }
}
