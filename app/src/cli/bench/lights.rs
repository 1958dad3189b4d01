//! `balayage bench lights`: how few lights stand for a map, against least squares and spherical harmonics.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use balayage_render::gpu::Gpu;
use balayage_render::light::{
    EnvironmentMap, FitSettings, HairKernel, HairProbe, Harmonics, MAX_LIGHTS, Objective, fit_lights,
};
use balayage_render::param::{LobeRatios, PigmentSet, PointValues};
use clap::Args;
use glam::{DVec3, Vec3};

use super::end_to_end;
use super::light_steps;
use super::plot::{Plot, Series};
use super::report::{Cell, Report, Table};
use crate::Problem;
use crate::cli::{CliError, Console};
use crate::document::{builtin_environments, map_warnings};

/// Light counts of both fits.
const COUNTS: [usize; 5] = [5, 10, 20, 40, 80];
/// Orders of the spherical harmonics: 25 and 64 coefficients.
const ORDERS: [usize; 2] = [4, 7];

#[derive(Args)]
pub(super) struct LightsArgs {
    /// Folder for tables and plots.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Environment maps (.hdr, .exr) [default: those inside the program].
    #[arg(long, value_name = "MAP", num_args = 1..)]
    maps: Vec<PathBuf>,
    /// Fits of each kind of which the fastest counts.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    runs: u32,
    /// Instead of the table of methods: every map turned by 3 degrees and blended into the next, each step fitted from the lights before.
    #[arg(long, conflicts_with = "end_to_end")]
    sequence: bool,
    /// Lights of --end-to-end and --sequence.
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_LIGHTS as u32)))]
    light_count: u32,
    /// Instead of the table of methods: radiance of N random fibres under fitted lights (standard quality, R, TT and TRT, on the
    /// GPU) against the float64 reference integrated over the map's pixels.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    end_to_end: Option<u32>,
    /// All these fibres with the parameters of a new project's hair instead of random ones.
    #[arg(long, requires = "end_to_end")]
    new_hair: bool,
    /// Seed of the fits.
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

/// A way to stand for a map.
#[derive(Clone, Copy)]
enum Way {
    Lights(Objective, usize),
    Harmonics(usize),
}

impl Way {
    fn all() -> Vec<Self> {
        let fits = [Objective::Relative, Objective::L2].into_iter();
        fits.flat_map(|objective| COUNTS.map(|count| Self::Lights(objective, count)))
            .chain(ORDERS.map(Self::Harmonics))
            .collect()
    }

    fn family(self) -> &'static str {
        match self {
            Self::Lights(Objective::Relative, _) => "SRBF, relative",
            Self::Lights(Objective::L2, _) => "SRBF, L2",
            Self::Harmonics(_) => "spherical harmonics",
        }
    }

    /// Lights or coefficients.
    fn count(self) -> usize {
        match self {
            Self::Lights(_, count) => count,
            Self::Harmonics(order) => (order + 1) * (order + 1),
        }
    }
}

/// What one way makes of one map.
struct Found {
    hair: f64,
    sharp: f64,
    /// Worst channel.
    energy: f64,
    seconds: f64,
}

pub(super) fn run(args: &LightsArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let maps = if args.maps.is_empty() {
        builtin_environments()?
    } else {
        let mut maps = Vec::new();
        for path in &args.maps {
            let (map, report) = EnvironmentMap::read(path).map_err(Problem::from)?;
            for warning in map_warnings(&report, path) {
                console.warn(&warning);
            }
            let name = path.file_stem().unwrap_or(path.as_os_str());
            maps.push((name.to_string_lossy().into_owned(), map));
        }
        maps
    };

    if let Some(count) = args.end_to_end {
        return run_end_to_end(args, count, &maps, console);
    }
    if args.sequence {
        let report = light_steps::run(&maps, args.light_count as usize, args.seed, console)?;
        report.write(&args.output)?;
        return Ok(console.result(report.json(), &report.text())?);
    }
    let ways = Way::all();
    let progress = console.progress((maps.len() * ways.len()) as u64, "fitting");
    let mut table = Table::new(
        "lights",
        [
            "map",
            "method",
            "lights or coefficients",
            "hair error",
            "hair error, sharp kernel",
            "energy error",
            "seconds",
        ],
    );
    let mut found: Vec<Vec<Found>> = ways.iter().map(|_| Vec::new()).collect();
    for (m, (name, map)) in maps.iter().enumerate() {
        let sharp = HairKernel {
            longitudinal_deg: 4.0,
            azimuthal_deg: 12.0,
            ..HairKernel::default()
        };
        let probes = [HairKernel::default(), sharp].map(|kernel| HairProbe::new(map, kernel));
        for (w, way) in ways.iter().enumerate() {
            let one = measured(map, &probes, *way, args)?;
            table.row([
                Cell::from(name.as_str()),
                way.family().into(),
                Cell::Count(way.count() as u64),
                one.hair.into(),
                one.sharp.into(),
                one.energy.into(),
                one.seconds.into(),
            ]);
            found[w].push(one);
            progress.at((m * ways.len() + w + 1) as u64);
        }
    }
    drop(progress);

    let report = Report {
        name: "lights",
        notes: vec![
            format!(
                "hair error: RMS over {} random fibres of the relative difference of single-scattered radiance (rgb norm), lobe of 8 \
                 degrees and forward peak of 25; sharp kernel: 4 and 12",
                HairKernel::default().fibres
            ),
            "energy error: of the worst channel, relative".to_owned(),
            format!(
                "seconds: fastest of {} fits, reading excluded, {} threads; seed {}",
                args.runs,
                std::thread::available_parallelism().map_or(1, usize::from),
                args.seed
            ),
        ],
        tables: vec![summary(&ways, &found), table],
        plots: vec![Plot {
            name: "lights",
            title: "Lights for a map".to_owned(),
            x_label: "time of a fit, s (median of maps)",
            y_label: "hair error (geometric mean of maps)",
            series: series(&ways, &found),
        }],
    };
    report.write(&args.output)?;
    Ok(console.result(report.json(), &report.text())?)
}

fn run_end_to_end(
    args: &LightsArgs,
    count: u32,
    maps: &[(String, EnvironmentMap)],
    console: &mut Console<'_>,
) -> Result<(), CliError> {
    let gpu = Gpu::headless()?;
    let mut scenes = Vec::new();
    for (name, map) in maps {
        let settings = FitSettings {
            count: args.light_count as usize,
            seed: args.seed,
            ..FitSettings::default()
        };
        let lights = fit_lights(map, &settings, &|_| ControlFlow::Continue(()))
            .map_err(|e| CliError::Input(e.to_string()))?;
        let remedy = "leave it out of --maps";
        if lights.lights.is_empty() {
            let reason = "the map is uniform or black, there is no light to compare";
            return Err(CliError::Input(format!("{name}: {reason}; {remedy}")));
        }
        if (map.width, map.height) != (maps[0].1.width, maps[0].1.height) {
            let reason = format!("{} x {} pixels, unlike {}", map.width, map.height, maps[0].0);
            return Err(CliError::Input(format!("{name}: {reason}; {remedy}")));
        }
        let map = map.clone();
        scenes.push(end_to_end::Scene { map, lights });
    }

    let progress = console.progress(u64::from(count), "integrating");
    let done = AtomicU64::new(0);
    let on_done = || progress.at(1 + done.fetch_add(1, Ordering::Relaxed));
    let new_hair = PointValues::default().vertex_params(PigmentSet::default(), &LobeRatios::default());
    let like = args.new_hair.then_some(&new_hair);
    let errors = end_to_end::errors(&gpu, count as usize, like, &scenes, on_done)?;
    let mut table = Table::new(
        "lights_end_to_end",
        [
            "map",
            "RMS of the relative error of a fibre",
            "of the fit alone",
            "of the scattering alone",
            "median",
            "RMS of fibres with beta_R of 5 to 10 degrees",
            "RMS error over RMS radiance",
        ],
    );
    for ((name, _), errors) in maps.iter().zip(errors) {
        table.row([
            Cell::from(name.as_str()),
            errors.all.into(),
            errors.fit.into(),
            errors.scattering.into(),
            errors.median.into(),
            errors.usual.into(),
            errors.overall.into(),
        ]);
    }
    drop(progress);
    let report = Report {
        name: "lights_end_to_end",
        notes: vec![
            format!("device: {}", gpu.adapter_name),
            format!(
                "{count} random places and views of {}, {} lights, standard quality, R + TT + TRT, rgb norm",
                if args.new_hair {
                    "a new project's hair (beta_R of 5.5 degrees)"
                } else {
                    "random circular hair (beta_R from 1.7 to 14 degrees)"
                },
                args.light_count
            ),
            "reference: the float64 scattering function integrated over every pixel; fit alone: the reference under the lights against \
             the reference under the map; scattering alone: the shaders against the reference, both under the lights"
                .to_owned(),
        ],
        tables: vec![table],
        plots: Vec::new(),
    };
    report.write(&args.output)?;
    Ok(console.result(report.json(), &report.text())?)
}

fn measured(
    map: &EnvironmentMap,
    probes: &[HairProbe<'_>; 2],
    way: Way,
    args: &LightsArgs,
) -> Result<Found, CliError> {
    let mut seconds = f64::INFINITY;
    let mut timed = |start: Instant| seconds = seconds.min(start.elapsed().as_secs_f64());
    match way {
        Way::Lights(objective, count) => {
            let settings = FitSettings {
                count,
                objective,
                seed: args.seed,
                ..FitSettings::default()
            };
            let mut lights = None;
            for _ in 0..args.runs {
                let start = Instant::now();
                let fitted = fit_lights(map, &settings, &|_| ControlFlow::Continue(()));
                timed(start);
                lights = Some(fitted.map_err(|e| CliError::Input(e.to_string()))?);
            }
            let lights = lights.unwrap_or_default();
            Ok(found(map, probes, lights.energy(), seconds, |w| {
                lights.radiance(w)
            }))
        }
        Way::Harmonics(order) => {
            let mut harmonics = None;
            for _ in 0..args.runs {
                let start = Instant::now();
                harmonics = Some(Harmonics::of(map, order));
                timed(start);
            }
            let harmonics = harmonics.unwrap_or_else(|| Harmonics::of(map, order));
            Ok(found(map, probes, harmonics.energy(), seconds, |w| {
                harmonics.radiance(w)
            }))
        }
    }
}

fn found(
    map: &EnvironmentMap,
    probes: &[HairProbe<'_>; 2],
    energy: DVec3,
    seconds: f64,
    radiance: impl Fn(Vec3) -> Vec3 + Sync,
) -> Found {
    let wanted = map.energy();
    let energy = if energy == wanted {
        0.0
    } else {
        (energy / wanted - 1.0).abs().max_element()
    };
    Found {
        hair: probes[0].error_of(&radiance),
        sharp: probes[1].error_of(&radiance),
        energy,
        seconds,
    }
}

/// Geometric means, worst maps and median times of every way.
fn summary(ways: &[Way], found: &[Vec<Found>]) -> Table {
    let mut table = Table::new(
        "lights_summary",
        [
            "method",
            "lights or coefficients",
            "hair error, geometric mean",
            "hair error, worst",
            "sharp kernel, geometric mean",
            "sharp kernel, worst",
            "energy error, worst",
            "seconds, median",
        ],
    );
    for (way, found) in ways.iter().zip(found) {
        let worst = |of: fn(&Found) -> f64| found.iter().map(of).fold(0.0, f64::max);
        table.row([
            Cell::from(way.family()),
            Cell::Count(way.count() as u64),
            geometric_mean(found, |f| f.hair).into(),
            worst(|f| f.hair).into(),
            geometric_mean(found, |f| f.sharp).into(),
            worst(|f| f.sharp).into(),
            worst(|f| f.energy).into(),
            median_seconds(found).into(),
        ]);
    }
    table
}

fn series(ways: &[Way], found: &[Vec<Found>]) -> Vec<Series> {
    let mut series: Vec<Series> = Vec::new();
    for (way, found) in ways.iter().zip(found) {
        let point = (median_seconds(found), geometric_mean(found, |f| f.hair));
        match series.last_mut().filter(|last| last.name == way.family()) {
            Some(last) => last.points.push(point),
            None => series.push(Series {
                name: way.family().to_owned(),
                points: vec![point],
            }),
        }
    }
    series
}

fn geometric_mean(found: &[Found], of: fn(&Found) -> f64) -> f64 {
    let logarithms: f64 = found.iter().map(|f| of(f).ln()).sum();
    (logarithms / found.len() as f64).exp()
}

fn median_seconds(found: &[Found]) -> f64 {
    let mut seconds: Vec<f64> = found.iter().map(|f| f.seconds).collect();
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}
