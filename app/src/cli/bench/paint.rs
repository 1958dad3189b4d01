//! `balayage bench paint`: what lies between the pointer and the picture, step by step, in milliseconds and in work.

use std::{collections::BTreeMap, path::PathBuf, time::Instant};

use balayage_render::{
    gpu::{Camera, Gpu, RenderSettings, Renderer},
    param::Channel,
    volume::VolumeSettings,
};
use clap::Args;
use glam::Vec2;
use serde_json::json;

use super::{
    plot::{Plot, Series},
    report::{Cell, Report, Table},
};
use crate::{
    cli::{
        CliError, Console,
        groom_options::GroomOptions,
        light_options::LightOptions,
        render::{load_light, scene, size},
    },
    document::{Document, Edit},
    paint::{Dab, Operation, OperationId, Shape, StrandIndex},
    tool::{PickFrame, dab_at},
};

#[derive(Args)]
pub(super) struct PaintArgs {
    /// Folder for tables and plots.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Project or groom that is painted; the built-in sample if absent.
    #[arg(long, value_name = "FILE")]
    groom: Option<PathBuf>,
    #[command(flatten)]
    light: LightOptions,
    /// Width and height of the refined picture, pixels; while painting it has half of both.
    #[arg(long, value_name = "WxH", default_value = "1120x800", value_parser = size)]
    size: [u32; 2],
    /// Share of the hair's points that a dab covers, percent.
    #[arg(long, value_name = "PERCENT", default_value_t = 5.0, value_parser = percent)]
    dab: f32,
    /// Strokes.
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=1000))]
    strokes: u32,
    /// Steps of the pointer in a stroke.
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(2..=1000))]
    steps: u32,
}

/// A share in percent, above 0 and at most 100.
fn percent(text: &str) -> Result<f32, String> {
    let x: f32 = text.parse().map_err(|e| format!("{e}"))?;
    if x > 0.0 && x <= 100.0 {
        Ok(x)
    } else {
        Err("give a share above 0 and up to 100".to_owned())
    }
}

/// Dabs of the plot, percent of the points.
const DABS: [f32; 6] = [0.3, 1.0, 3.0, 10.0, 30.0, 80.0];
/// While painting the picture has that share of its pixels per side.
const DRAFT_SHARE: u32 = 2;
/// Exact rays per point and light of the refined picture.
const REFINED_RAYS: u32 = 16;

/// A column of one figure per step of the pointer.
#[derive(Default)]
struct Samples(Vec<f64>);

impl Samples {
    /// Median, 90th percentile and greatest.
    fn quantiles(&self) -> [f64; 3] {
        let mut sorted = self.0.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| {
            let last = sorted.len().saturating_sub(1);
            sorted
                .get((share * last as f64).round() as usize)
                .copied()
                .unwrap_or(f64::NAN)
        };
        [at(0.5), at(0.9), at(1.0)]
    }
}

/// Names of the timed steps, in their order.
const STEPS: [&str; 8] = [
    "pick",
    "index query",
    "layer maps",
    "composite",
    "copy for the drawing thread",
    "upload",
    "pointer to parameter buffer",
    "frame while painting",
];

/// Names of what is counted in a step.
const WORK: [&str; 6] = [
    "vertices measured by the brush",
    "vertices evaluated by the brush",
    "vertices composited",
    "vertices changed",
    "bytes uploaded",
    "vertices shaded",
];

/// What one run of strokes cost, a sample each step.
#[derive(Default)]
struct Run {
    ms: [Samples; STEPS.len()],
    work: [Samples; WORK.len()],
    refined_ms: Samples,
    /// Passes of the frame while painting.
    passes: BTreeMap<String, Samples>,
}

/// A document with its picture on the GPU, as the editor has it.
struct Bench {
    gpu: Gpu,
    renderer: Renderer,
    document: Document,
    camera: Camera,
    size: [u32; 2],
}

impl Bench {
    /// The picture while painting, as the editor draws it where it would else keep the hand waiting: fewer pixels, nothing but painted
    /// vertices is shaded.
    fn quick(&self) -> ([u32; 2], RenderSettings) {
        let settings = RenderSettings {
            interactive: true,
            ..RenderSettings::default()
        };
        (self.size.map(|side| (side / DRAFT_SHARE).max(1)), settings)
    }

    /// A stroke across the picture, `from` to `to` in [0, 1]^2; with `draws` each step is drawn, and a refined picture at the end.
    fn stroke(
        &mut self,
        operation: Operation,
        [from, to]: [Vec2; 2],
        steps: u32,
        draws: bool,
        run: &mut Run,
    ) -> Result<(), CliError> {
        let radius = operation.radius_m / self.document.groom().metres_per_unit();
        let (quick_size, quick) = self.quick();
        self.renderer.render(&self.camera, quick_size, &quick)?;
        let picks = PickFrame {
            camera: self.camera,
            picks: self.renderer.picks()?,
        };
        self.document.begin_stroke(operation)?;
        for step in 0..steps {
            let at = from.lerp(to, step as f32 / (steps - 1) as f32);
            let start = Instant::now();
            let dab = picks
                .place(at)
                .and_then(|place| dab_at(self.document.index(), place, radius, 1.0));
            let Some(dab) = dab else { continue };
            let picked = start.elapsed();
            let before = self.document.paint_work();
            let dirty = self.document.extend_stroke(vec![dab])?;
            let work = self.document.paint_work();
            if dirty.is_empty() {
                continue;
            }
            let copying = Instant::now();
            let params = self.document.params().to_vec();
            let copied = copying.elapsed();
            let uploading = Instant::now();
            self.renderer.set_params(&params, dirty.ranges())?;
            self.gpu.wait()?;
            let uploaded = uploading.elapsed();
            let total = start.elapsed();
            let (mut frame_ms, mut sent, mut shaded) = (f64::NAN, f64::NAN, f64::NAN);
            if draws {
                let drawing = Instant::now();
                let report = self.renderer.render(&self.camera, quick_size, &quick)?;
                self.renderer.shown_bytes()?;
                for (pass, ms) in report.passes.iter().cloned() {
                    run.passes.entry(pass).or_default().0.push(ms);
                }
                frame_ms = 1e3 * drawing.elapsed().as_secs_f64();
                sent = report.counter("parameter bytes uploaded") as f64;
                shaded = report.counter("vertices shaded") as f64;
            }
            let times = [
                picked,
                work.query - before.query,
                work.blend - before.blend,
                work.compose - before.compose,
                copied,
                uploaded,
                total,
            ];
            let times = times.into_iter().map(|time| 1e3 * time.as_secs_f64());
            for (samples, ms) in run.ms.iter_mut().zip(times.chain([frame_ms])) {
                samples.0.push(ms);
            }
            let work = [
                work.measured - before.measured,
                work.blended - before.blended,
                work.composed - before.composed,
                work.changed - before.changed,
            ];
            let work = work.into_iter().map(|n| n as f64).chain([sent, shaded]);
            for (samples, n) in run.work.iter_mut().zip(work) {
                samples.0.push(n);
            }
        }
        self.document.commit_stroke();
        if draws {
            let settings = RenderSettings {
                visibility_rays: REFINED_RAYS,
                ..RenderSettings::default()
            };
            let start = Instant::now();
            self.renderer.render(&self.camera, self.size, &settings)?;
            self.renderer.shown_bytes()?;
            run.refined_ms.0.push(1e3 * start.elapsed().as_secs_f64());
        }
        Ok(())
    }
}

pub(super) fn run(args: &PaintArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let mut document = match &args.groom {
        Some(path) => crate::cli::open(path, &GroomOptions::default(), console)?,
        None => Document::sample()?.document,
    };
    document.apply(Edit::SetLight(args.light.applied_to(&document)))?;
    let gpu = Gpu::headless()?;
    let lighting = load_light(&document, console)?;
    let renderer = scene(&gpu, &document, &lighting, false, VolumeSettings::default())?;
    let [width, height] = args.size;
    let camera = Camera::framing(document.groom().bounds(), width as f32 / height as f32);
    let mut bench = Bench {
        gpu,
        renderer,
        document,
        camera,
        size: args.size,
    };

    // The first pictures compile shaders and fill caches.
    let (quick_size, quick) = bench.quick();
    for (size, settings) in [(args.size, RenderSettings::default()), (quick_size, quick)] {
        bench.renderer.render(&bench.camera, size, &settings)?;
    }
    let progress = console.progress(u64::from(args.strokes) + DABS.len() as u64, "painting");
    let mut run = Run::default();
    for stroke in 0..args.strokes {
        let operation = bench.operation(args.dab);
        let path = bench.path(stroke, args.strokes);
        bench.stroke(operation, path, args.steps, true, &mut run)?;
        progress.at(u64::from(stroke) + 1);
    }
    if run.ms[0].0.is_empty() {
        let text = "no step of the pointer met hair; give another groom, or a larger --size";
        return Err(CliError::Input(text.to_owned()));
    }

    // The same path with smaller and larger dabs, without pictures.
    let mut points = Vec::new();
    for (i, share) in DABS.into_iter().enumerate() {
        let mut sized = Run::default();
        let (operation, path) = (bench.operation(share), bench.path(0, 1));
        bench.stroke(operation, path, args.steps, false, &mut sized)?;
        points.push((sized.work[2].quantiles()[0], sized.ms[6].quantiles()[0]));
        progress.at(u64::from(args.strokes) + i as u64 + 1);
    }
    drop(progress);
    let radius_mm = 1e3 * bench.operation(args.dab).radius_m;
    let groom = bench.document.groom();
    let report = Report {
        name: "paint",
        notes: vec![
            format!("device: {}", bench.gpu.adapter_name),
            format!(
                "{} strands, {} points, {} lights; {} strokes of {} steps; a dab of {:.1} mm radius covers {} % of the points",
                groom.strand_count(),
                groom.point_count(),
                lighting.lights.lights.len(),
                args.strokes,
                args.steps,
                radius_mm,
                args.dab
            ),
            format!(
                "picture while painting {}x{}, refined {width}x{height} with {REFINED_RAYS} exact rays per point and light",
                quick_size[0], quick_size[1]
            ),
        ],
        tables: tables(&run),
        plots: vec![Plot {
            name: "paint_dabs",
            title: "Pointer to parameter buffer".to_owned(),
            x_label: "vertices composited a dab, median",
            y_label: "milliseconds, median",
            series: vec![Series {
                name: "dabs of 0.3 to 80 %".to_owned(),
                points,
            }],
        }],
    };
    let written = report.write(&args.output)?;
    let mut value = report.json();
    value["files"] = json!(written);
    console.result(value, &report.text())?;
    Ok(())
}

impl Bench {
    /// A stroke of dye whose dabs cover `percent` of the points where the hair is as dense as in its middle.
    fn operation(&self, percent: f32) -> Operation {
        let index = self.document.index();
        let radius = covering(index, 0.01 * percent);
        let mut operation = Operation::shaped(
            OperationId::Number(self.document.next_operation_number()),
            self.document.project().layers[0].id.clone(),
            Shape::all()[6].clone(),
            0,
        );
        operation.shape = None;
        operation.channel = Channel::Dye;
        operation.value = crate::paint::StrokeValue::Rgb([0.2, 0.9, 1.5]);
        operation.strength = 0.7;
        operation.radius_m = radius * index.groom().metres_per_unit();
        operation
    }

    /// Stroke `i` of `count`: across the picture, one below the other.
    fn path(&self, i: u32, count: u32) -> [Vec2; 2] {
        let y = 0.3 + 0.4 * (i as f32 + 0.5) / count as f32;
        [Vec2::new(0.38, y), Vec2::new(0.62, y + 0.05)]
    }
}

/// Radius whose ball covers that share of the points round the middle one of them, by halving the interval.
fn covering(index: &StrandIndex, share: f32) -> f32 {
    let groom = index.groom();
    let (low, high) = groom.bounds();
    let wanted = (share * groom.point_count() as f32).max(1.0) as usize;
    let centres: Vec<Dab> = (1..16)
        .filter_map(|i| {
            let point = groom.point_count() * i / 16;
            dab_at(index, groom.positions()[point], f32::INFINITY, 1.0)
        })
        .collect();
    let covered = |radius: f32| {
        let mut counts: Vec<usize> = centres
            .iter()
            .map(|dab| {
                let mut count = 0;
                index.for_each_near(dab.position.into(), radius, |_, _| count += 1);
                count
            })
            .collect();
        counts.sort_unstable();
        counts.get(counts.len() / 2).copied().unwrap_or(0)
    };
    let (mut small, mut large) = (0.0, low.distance(high));
    for _ in 0..24 {
        let middle = 0.5 * (small + large);
        if covered(middle) < wanted {
            small = middle;
        } else {
            large = middle;
        }
    }
    large
}

fn tables(run: &Run) -> Vec<Table> {
    let columns = ["step", "median ms", "90 % ms", "greatest ms"];
    let mut times = Table::new("paint_ms", columns);
    let rows = STEPS.into_iter().zip(&run.ms);
    let rows = rows.map(|(name, samples)| (name.to_owned(), samples));
    let passes = run.passes.iter();
    let passes = passes.map(|(pass, samples)| (format!("of it {pass}"), samples));
    let refined = ("refined frame after a stroke".to_owned(), &run.refined_ms);
    for (name, samples) in rows.chain(passes).chain([refined]) {
        let [median, most, greatest] = samples.quantiles();
        times.row([Cell::from(name), median.into(), most.into(), greatest.into()]);
    }
    let mut work = Table::new("paint_work", ["work a step", "median", "greatest"]);
    for (name, samples) in WORK.into_iter().zip(&run.work) {
        let [median, _, greatest] = samples.quantiles();
        work.row([
            Cell::from(name),
            Cell::Count(median as u64),
            Cell::Count(greatest as u64),
        ]);
    }
    vec![times, work]
}
