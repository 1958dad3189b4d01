//! `balayage bench scatter`: time of one light against error, for every way to integrate single scattering.

use std::f64::consts::PI;
use std::path::PathBuf;

use balayage_render::gpu::probe::{self, ProbeCase};
use balayage_render::gpu::{Gpu, Method, bench, probe_cases};
use balayage_render::optics::{Direction, Fibre, SrbfLight, single_scattering};
use clap::Args;
use rand::SeedableRng;
use rand_pcg::Pcg64;
use rayon::prelude::*;

use super::methods;
use super::plot::{Plot, Series};
use super::report::{Cell, Report, Table};
use crate::cli::{CliError, Console};

/// Relative tolerance of the reference: a hundredth of the least error that is measured.
const TOLERANCE: f64 = 1e-5;
/// Dispatches of which the fastest counts.
const RUNS: u32 = 3;

#[derive(Args)]
pub(super) struct ScatterArgs {
    /// Folder for tables and plots.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Random cases that the error is measured on.
    #[arg(long, default_value_t = 600, value_parser = clap::value_parser!(u32).range(10..=100_000))]
    cases: u32,
    /// Random views that the time is measured on, 40 lights each.
    #[arg(long, default_value_t = 4096, value_parser = clap::value_parser!(u32).range(64..=100_000))]
    views: u32,
    /// Seed of the cases.
    #[arg(long, default_value_t = 3)]
    seed: u64,
}

/// Lobes, then rgb.
type Scattered = [[f64; 3]; 3];

pub(super) fn run(args: &ScatterArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let gpu = Gpu::headless()?;
    let mut random = Pcg64::seed_from_u64(args.seed);
    let mut drawn = |count: u32, elliptic| -> Vec<ProbeCase> {
        (0..count)
            .map(|_| probe_cases::hair(&mut random, elliptic))
            .collect()
    };
    let circular = drawn(args.cases, false);
    let elliptic = drawn(args.cases / 4, true);
    let views = drawn(args.views, false);
    let methods = methods::marschner();
    let progress = console.progress(methods.len() as u64 + 1, "measuring");
    let want = (reference(&circular)?, reference(&elliptic)?);
    progress.at(1);

    let mut table = Table::new(
        "scatter",
        [
            "scheme",
            "level",
            "ns per light",
            "operations",
            "RMS sum",
            "RMS R",
            "RMS TT",
            "RMS TRT",
            "RMS sum, lights weighed alike",
            "RMS TRT elliptic",
        ],
    );
    let mut series: Vec<Series> = Vec::new();
    for (index, (family, level, method)) in methods.into_iter().enumerate() {
        let seconds = bench::seconds_per_light(&gpu, &views, &method, RUNS)?;
        let got = answers(&gpu, &circular, &method)?;
        let of_ellipses = answers(&gpu, &elliptic, &method)?;
        let lobe = |lobe: usize| move |s: &Scattered| s[lobe];
        let sum = rms(&got, &want.0, total, |_| 1.0);
        table.row([
            Cell::from(family),
            level.into(),
            (1e9 * seconds).into(),
            operations(&gpu, &circular, &method)?.into(),
            sum.into(),
            rms(&got, &want.0, lobe(0), |_| 1.0).into(),
            rms(&got, &want.0, lobe(1), |_| 1.0).into(),
            rms(&got, &want.0, lobe(2), |_| 1.0).into(),
            rms(&got, &want.0, total, |i| {
                1.0 / light_integral(circular[i].lambda_j)
            })
            .into(),
            rms(&of_ellipses, &want.1, lobe(2), |_| 1.0).into(),
        ]);
        if series.last().is_none_or(|last| last.name != family) {
            series.push(Series {
                name: family.to_owned(),
                points: Vec::new(),
            });
        }
        if let Some(series) = series.last_mut() {
            series.points.push((1e9 * seconds, sum));
        }
        progress.at(index as u64 + 2);
    }
    drop(progress);
    let report = Report {
        name: "scatter",
        notes: vec![
            format!("device: {}", gpu.adapter_name),
            format!(
                "error: root mean square over that of the float64 reference, {} circular and {} elliptic cases (seed {}), rgb",
                circular.len(),
                elliptic.len(),
                args.seed
            ),
            format!(
                "time: one light of R, TT and TRT of circular hair, fastest of {RUNS} dispatches of {} views with {} lights",
                views.len(),
                bench::LIGHTS
            ),
            "operations: exp, log, trigonometric functions and roots of one light, rgb together, counted by the shader itself".to_owned(),
        ],
        tables: vec![table],
        plots: vec![Plot {
            name: "scatter",
            title: "Single scattering under an SRBF light".to_owned(),
            x_label: "time per light, ns",
            y_label: "RMS error of R + TT + TRT",
            series,
        }],
    };
    report.write(&args.output)?;
    Ok(console.result(report.json(), &report.text())?)
}

/// Single scattering of the float64 reference.
fn reference(cases: &[ProbeCase]) -> Result<Vec<Scattered>, CliError> {
    cases
        .par_iter()
        .map(|c| {
            let at = |theta, phi| Direction { theta, phi };
            let fibre = Fibre {
                eta: c.eta,
                eccentricity: c.eccentricity,
                sigma_a: c.sigma_a,
                alpha: c.alpha,
                beta: c.beta,
                azimuthal_width: c.azimuthal_width,
            };
            let light = SrbfLight::new(at(c.theta_j, c.phi_j), c.lambda_j)?;
            single_scattering(&fibre, at(c.theta_o, c.phi_o), &light, TOLERANCE).map(|lobes| lobes.to_array())
        })
        .collect::<Result<_, _>>()
        .map_err(|error| CliError::Input(format!("the reference: {error}; choose another --seed")))
}

/// Single scattering of the shaders.
fn answers(gpu: &Gpu, cases: &[ProbeCase], method: &Method) -> Result<Vec<Scattered>, CliError> {
    let results = probe::run(gpu, cases, method)?;
    Ok(results.iter().map(|result| result.single).collect())
}

/// Transcendental operations of one light, mean over the cases.
fn operations(gpu: &Gpu, cases: &[ProbeCase], method: &Method) -> Result<f64, CliError> {
    let counts = probe::operations(gpu, cases, method)?;
    Ok(counts.iter().map(|&count| f64::from(count)).sum::<f64>() / counts.len() as f64)
}

/// R + TT + TRT.
fn total(lobes: &Scattered) -> [f64; 3] {
    std::array::from_fn(|channel| lobes.iter().map(|lobe| lobe[channel]).sum())
}

/// Integral of a light over the sphere.
fn light_integral(lambda: f64) -> f64 {
    PI * lambda.powi(2) * (1.0 - (-4.0 / lambda.powi(2)).exp())
}

/// Root mean square of what `of` sees differently, over that of `want`; case i counts by `weight(i)`. Values that are no numbers make it NaN.
fn rms(
    got: &[Scattered],
    want: &[Scattered],
    of: impl Fn(&Scattered) -> [f64; 3],
    weight: impl Fn(usize) -> f64,
) -> f64 {
    let (mut error, mut size) = (0.0, 0.0);
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        for (got, want) in of(got).into_iter().zip(of(want)) {
            error += (weight(i) * (got - want)).powi(2);
            size += (weight(i) * want).powi(2);
        }
    }
    (error / size).sqrt()
}
