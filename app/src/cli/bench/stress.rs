//! `balayage bench stress`: edges of every range and poison values through the shaders; nothing may come out that is not light.

use std::path::PathBuf;

use balayage_render::gpu::probe::{self, ProbeCase};
use balayage_render::gpu::probe_cases::{self, Defect};
use balayage_render::gpu::probe_kajiya_kay::{self, KajiyaKayResult};
use balayage_render::gpu::{Gpu, GpuError, Method, Model, Scheme};
use clap::Args;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::methods;
use super::report::{Cell, Report, Table};
use crate::cli::{CliError, Console};

/// Points that are drawn and evaluated at a time.
const CHUNK: usize = 1 << 16;

#[derive(Args)]
pub(super) struct StressArgs {
    /// Folder for the table.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Points per method.
    #[arg(long, default_value_t = 2_000_000)]
    points: u64,
    /// Seed of the points.
    #[arg(long, default_value_t = 14)]
    seed: u64,
}

/// What became of the points of one method.
#[derive(Default)]
struct Counts {
    points: u64,
    repaired_points: u64,
    repaired_values: u64,
    not_finite: u64,
    negative: u64,
    too_large: u64,
}

pub(super) fn run(args: &StressArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let gpu = Gpu::headless()?;
    let methods = methods::every_shader();
    let progress = console.progress(args.points * methods.len() as u64, "stressing");
    let mut table = Table::new(
        "stress",
        [
            "scheme or model",
            "level",
            "points",
            "points repaired at the door",
            "values repaired",
            "not finite",
            "negative",
            "too much energy",
        ],
    );
    let mut defects = 0;
    for (index, (family, level, method)) in methods.into_iter().enumerate() {
        let before = index as u64 * args.points;
        let counts = counted(&gpu, args, &method, |done| progress.at(before + done))?;
        // A sample on the peak of a sharp lobe stands for a share of the light: few of them say nothing about energy.
        let is_sampled = matches!(method.scheme, Scheme::Directional { .. });
        let energy = if is_sampled {
            Cell::None
        } else {
            Cell::Count(counts.too_large)
        };
        let too_large = if is_sampled { 0 } else { counts.too_large };
        defects += counts.not_finite + counts.negative + too_large;
        let cells = [
            counts.points,
            counts.repaired_points,
            counts.repaired_values,
            counts.not_finite,
            counts.negative,
        ];
        let names = [Cell::from(family), level.into()];
        table.row(names.into_iter().chain(cells.map(Cell::Count)).chain([energy]));
    }
    drop(progress);
    let report = Report {
        name: "stress",
        notes: vec![
            format!("device: {}", gpu.adapter_name),
            format!(
                "seed {}; every value uniform, log-uniform, an edge of its range, a pole of a formula, or poison",
                args.seed
            ),
        ],
        tables: vec![table],
        plots: Vec::new(),
    };
    report.write(&args.output)?;
    console.result(report.json(), &report.text())?;
    if defects > 0 {
        return Err(CliError::Input(format!(
            "{defects} points gave values that are not light; see the table and report the adapter"
        )));
    }
    Ok(())
}

/// What is wrong with the answer to each case.
fn defects(gpu: &Gpu, cases: &[ProbeCase], method: &Method) -> Result<Vec<Option<Defect>>, GpuError> {
    if method.model != Model::KajiyaKay {
        let results = probe::run(gpu, cases, method)?;
        return Ok(results.iter().map(probe_cases::defect).collect());
    }
    let results = probe_kajiya_kay::run(gpu, cases, method)?;
    let most = 2.0;
    let defect = |r: &KajiyaKayResult| {
        probe_cases::defect_in(&[
            ("single", r.single.as_flattened(), most),
            ("uniform light", r.uniform_light.as_flattened(), most),
        ])
    };
    Ok(results.iter().map(defect).collect())
}

fn counted(
    gpu: &Gpu,
    args: &StressArgs,
    method: &Method,
    mut progress: impl FnMut(u64),
) -> Result<Counts, CliError> {
    let mut random = Pcg64Mcg::seed_from_u64(args.seed);
    let mut counts = Counts::default();
    while counts.points < args.points {
        let size = CHUNK.min((args.points - counts.points) as usize);
        let cases: Vec<ProbeCase> = (0..size).map(|_| probe_cases::stress(&mut random)).collect();
        for (case, defect) in cases.iter().zip(defects(gpu, &cases, method)?) {
            let repairs = probe_cases::repairs(case) as u64;
            counts.repaired_points += u64::from(repairs > 0);
            counts.repaired_values += repairs;
            match defect {
                None => {}
                Some(Defect::NotFinite(_)) => counts.not_finite += 1,
                Some(Defect::Negative(_)) => counts.negative += 1,
                Some(Defect::TooLarge(_)) => counts.too_large += 1,
            }
        }
        counts.points += size as u64;
        progress(counts.points);
    }
    Ok(counts)
}
