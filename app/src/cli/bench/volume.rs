//! `balayage bench volume`: visibility against exact rays per resolution and number of rays, beside spherical harmonics; what building
//! the volume and painting in it costs; strands drawn in two ways.

use std::path::{Path, PathBuf};
use std::time::Instant;

use balayage_render::gpu::{Gpu, Transmittance, VisibilitySource};
use balayage_render::groom::Groom;
use balayage_render::light::SrbfLight;
use balayage_render::volume::{SegmentGrid, Strands, VolumeSettings, lobe};
use clap::{Args, ValueEnum};
use glam::Vec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use super::plot::{Plot, Series};
use super::report::{Cell, Report, Table};
use super::{volume_build, volume_drawing};
use crate::cli::groom_options::GroomOptions;
use crate::cli::light_options::LightOptions;
use crate::cli::{CliError, Console, open, render::load_light};
use crate::document::{Document, Edit};

/// Voxel sizes in fibre spacings.
const SPACINGS: [f32; 3] = [1.0, 1.5, 2.0];
/// Exact rays per point and light.
const RAYS: [u32; 5] = [4, 8, 16, 32, 64];
/// Lights where none are given, and the narrowest and widest bandwidth.
const LIGHTS: u32 = 40;
const BANDWIDTHS: [f32; 2] = [0.1, 0.6];

#[derive(Args)]
pub(super) struct VolumeArgs {
    /// Projects or grooms; the built-in sample if absent. Heads are left out.
    inputs: Vec<PathBuf>,
    /// Folder for tables and plots.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    #[command(flatten)]
    light: LightOptions,
    /// Random points of the hair whose visibility is measured.
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u32).range(10..=100_000))]
    points: u32,
    /// Exact rays that the truth of a point and light comes from.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(16..=65_536))]
    truth_rays: u32,
    /// Seed of the points and rays.
    #[arg(long, default_value_t = 5)]
    seed: u64,
    /// One part of the benchmark.
    #[arg(long, value_enum)]
    only: Option<Part>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Part {
    /// Error and time of visibility.
    Visibility,
    /// Time and work of building and painting.
    Build,
    /// Time and coverage of the strand rasterizer beside hardware ribbons.
    Drawing,
}

pub(super) fn run(args: &VolumeArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let gpu = Gpu::headless()?;
    let mut report = Report {
        name: "volume",
        notes: vec![format!("device: {}", gpu.adapter_name)],
        tables: Vec::new(),
        plots: Vec::new(),
    };
    let wants = |part| args.only.is_none_or(|only| only == part);
    if wants(Part::Visibility) {
        visibility(args, &gpu, &mut report, console)?;
    }
    if wants(Part::Build) {
        volume_build::measure(&gpu, &mut report, console)?;
    }
    if wants(Part::Drawing) {
        volume_drawing::measure(&gpu, &mut report, console)?;
    }
    report.write(&args.output)?;
    Ok(console.result(report.json(), &report.text())?)
}

/// Error and time of every way to visibility, per groom.
fn visibility(
    args: &VolumeArgs,
    gpu: &Gpu,
    report: &mut Report,
    console: &mut Console<'_>,
) -> Result<(), CliError> {
    report.notes.push(format!(
        "visibility: mean over a light's lobe at {} random points, against the share of {} exact rays drawn from the lobe that cross no other fibre; \
         `noise` is what so many rays leave to chance",
        args.points, args.truth_rays
    ));
    report
        .notes
        .push("seconds: of all points and lights of the groom, scaled up from the points measured; harmonics with their samples".to_owned());
    let mut table = Table::new(
        "visibility",
        [
            "groom",
            "voxel, spacings",
            "method",
            "RMSE",
            "bias",
            "noise",
            "us per point and light",
            "seconds",
        ],
    );
    let mut series: Vec<Series> = Vec::new();
    let inputs: Vec<Option<&Path>> = match &args.inputs[..] {
        [] => vec![None],
        inputs => inputs.iter().map(|path| Some(path.as_path())).collect(),
    };
    let progress_steps = (inputs.len() * SPACINGS.len()) as u64;
    for (index, input) in inputs.into_iter().enumerate() {
        let mut document = match input {
            Some(path) => open(path, &GroomOptions::default(), console)?,
            None => Document::sample()?.document,
        };
        let lights = if args.light.is_given() {
            document.apply(Edit::SetLight(args.light.applied_to(&document)))?;
            load_light(&document, console)?.lights.lights
        } else {
            spread_lights()
        };
        let name = input
            .and_then(|path| path.file_stem())
            .map_or("sample".into(), |name| name.to_string_lossy());
        let progress = console.progress(progress_steps, "visibility");
        let truth = Truth::new(document.groom(), &lights, args);
        let mut transmittance = Transmittance::new(gpu)?;
        // Shaders are compiled when they first run: that is not measured.
        all_ways(
            gpu,
            &mut transmittance,
            document.groom(),
            &lights,
            &truth,
            SPACINGS[2],
        )?;
        for (step, spacings) in SPACINGS.into_iter().enumerate() {
            let mut of_size = Series {
                name: format!("{name}, voxels of {spacings} spacings"),
                points: Vec::new(),
            };
            for way in all_ways(
                gpu,
                &mut transmittance,
                document.groom(),
                &lights,
                &truth,
                spacings,
            )? {
                of_size.points.push((way.seconds, way.rmse));
                table.row([
                    Cell::from(name.as_ref()),
                    f64::from(spacings).into(),
                    way.name.into(),
                    way.rmse.into(),
                    way.bias.into(),
                    truth.noise().into(),
                    way.us_per_record.into(),
                    way.seconds.into(),
                ]);
            }
            // Harmonics are a point of their own.
            let harmonics = of_size.points.pop();
            series.push(of_size);
            series.push(Series {
                name: format!("{name}, harmonics, {spacings} spacings"),
                points: harmonics.into_iter().collect(),
            });
            progress.at((index * SPACINGS.len() + step) as u64 + 1);
        }
    }
    report.tables.push(table);
    report.plots.push(Plot {
        name: "visibility",
        title: "Visibility of lights inside hair".to_owned(),
        x_label: "time of all points and lights, s",
        y_label: "RMSE of the lobe's mean",
        series,
    });
    Ok(())
}

/// Lights of equal power from all sides, of all widths that a fit makes.
fn spread_lights() -> Vec<SrbfLight> {
    let light = |k: u32| {
        let y = 1.0 - (2.0 * k as f32 + 1.0) / LIGHTS as f32;
        let (sin, cos) = (2.399_963 * k as f32).sin_cos();
        let r = (1.0 - y * y).sqrt();
        // Neighbours differ in width: 17 has no factor in common with 40.
        let share = (k * 17 % LIGHTS) as f32 / (LIGHTS - 1) as f32;
        let bandwidth = BANDWIDTHS[0] * (BANDWIDTHS[1] / BANDWIDTHS[0]).powf(share);
        SrbfLight {
            direction: Vec3::new(r * cos, y, r * sin),
            bandwidth,
            radiance: Vec3::splat(1.0 / lobe::solid_angle(bandwidth) as f32),
        }
    };
    (0..LIGHTS).map(light).collect()
}

/// Exact visibility of all lights at some points.
struct Truth {
    points: Vec<usize>,
    /// Point after point, all lights of each.
    free_share: Vec<f32>,
    rays: u32,
}

impl Truth {
    fn new(groom: &Groom, lights: &[SrbfLight], args: &VolumeArgs) -> Self {
        let grid = SegmentGrid::new(&Strands::from(groom));
        let mut random = Pcg64Mcg::seed_from_u64(args.seed);
        let points: Vec<usize> = (0..args.points)
            .map(|_| random.random_range(0..groom.point_count()))
            .collect();
        let free_share = points
            .par_iter()
            .enumerate()
            .flat_map_iter(|(i, &point)| {
                let strand = groom
                    .first_point()
                    .partition_point(|&first| first as usize <= point) as u32
                    - 1;
                let mut random = Pcg64Mcg::seed_from_u64(args.seed ^ (i as u64 + 1) << 20);
                let at = groom.positions()[point];
                let share = |light| grid.free_share(at, strand, light, args.truth_rays, &mut random);
                lights.iter().map(share).collect::<Vec<_>>()
            })
            .collect();
        Self {
            points,
            free_share,
            rays: args.truth_rays,
        }
    }

    /// Root mean square error and mean error of light-major records.
    fn error(&self, records: &[[f32; 4]], point_count: usize, light_count: usize) -> (f64, f64) {
        let errors = self.points.iter().enumerate().flat_map(|(i, &point)| {
            (0..light_count).map(move |j| {
                let seen = records[j * point_count + point][0].clamp(0.0, 1.0);
                f64::from(seen - self.free_share[i * light_count + j])
            })
        });
        let (square, sum) = errors.fold((0.0, 0.0), |(square, sum), e| (square + e * e, sum + e));
        let count = self.free_share.len() as f64;
        ((square / count).sqrt(), sum / count)
    }

    /// Root mean square error that the truth itself has: that of counting independent rays (stratified ones are better).
    fn noise(&self) -> f64 {
        let variance = |&share: &f32| f64::from(share * (1.0 - share)) / f64::from(self.rays);
        (self.free_share.iter().map(variance).sum::<f64>() / self.free_share.len() as f64).sqrt()
    }
}

/// One way to visibility.
struct Way {
    name: String,
    rmse: f64,
    bias: f64,
    us_per_record: f64,
    seconds: f64,
}

/// Every way to visibility in voxels of that many spacings; harmonics come last.
fn all_ways(
    gpu: &Gpu,
    transmittance: &mut Transmittance,
    groom: &Groom,
    lights: &[SrbfLight],
    truth: &Truth,
    voxel_spacings: f32,
) -> Result<Vec<Way>, CliError> {
    let settings = VolumeSettings {
        voxel_spacings,
        ..VolumeSettings::default()
    };
    transmittance.set_strands(gpu, &Strands::from(groom), None, &settings)?;
    let mut flags = vec![0_u32; groom.point_count()];
    truth.points.iter().for_each(|&point| flags[point] = 1);
    let listed = f64::from(flags.iter().sum::<u32>());
    let wanted = gpu.storage_of("wanted points", &flags)?;
    let update = |transmittance: &mut Transmittance, rays: u32| {
        // No lights and then these again: everything that was traced for them is stale.
        transmittance.set_lights(gpu, &[])?;
        transmittance.set_lights(gpu, lights)?;
        let start = Instant::now();
        transmittance.update(gpu, Some(&wanted), false, rays)?;
        gpu.wait()?;
        Ok::<_, CliError>(start.elapsed().as_secs_f64())
    };
    let way = |transmittance: &Transmittance, name: String, seconds: f64, once: f64| {
        let records = transmittance.visibility_records(gpu, groom.point_count())?;
        let (rmse, bias) = truth.error(&records, groom.point_count(), lights.len());
        let per_record = seconds / (listed * lights.len() as f64);
        Ok::<_, CliError>(Way {
            name,
            rmse,
            bias,
            us_per_record: 1e6 * per_record,
            seconds: once + per_record * (groom.point_count() * lights.len()) as f64,
        })
    };

    let mut ways = Vec::new();
    transmittance.set_visibility_source(gpu, VisibilitySource::Voxel)?;
    let seconds = update(transmittance, 0)?;
    ways.push(way(transmittance, "first frame".to_owned(), seconds, 0.0)?);
    for rays in RAYS {
        let seconds = update(transmittance, rays)?;
        ways.push(way(transmittance, format!("{rays} rays"), seconds, 0.0)?);
    }
    transmittance.set_visibility_source(gpu, VisibilitySource::Sh9)?;
    let with_samples = update(transmittance, 0)?;
    let seconds = update(transmittance, 0)?;
    let once = (with_samples - seconds).max(0.0);
    ways.push(way(transmittance, "sh9".to_owned(), seconds, once)?);
    Ok(ways)
}
