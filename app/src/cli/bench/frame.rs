//! `balayage bench frame`: what each edit costs, what each saving saves, and how cost grows.

mod compare;
mod edits;
mod growth;
mod orbit;

use std::path::PathBuf;

use balayage_render::gpu::{Camera, FrameReport, Gpu, RenderSettings, Renderer};
use balayage_render::image::Picture;
use balayage_render::light::LightSet;
use balayage_render::param::VertexParams;
use balayage_render::volume::VolumeSettings;
use clap::{Args, ValueEnum};
use glam::Vec3;
use serde_json::json;

use super::generated::generated;
use super::plot::Plot;
use super::report::Report;
use crate::cli::groom_options::GroomOptions;
use crate::cli::light_options::LightOptions;
use crate::cli::{CliError, Console, open, render};
use crate::document::{Document, Edit};

#[derive(Args)]
pub(super) struct FrameArgs {
    /// Project (.json) or groom; the built-in sample if absent.
    input: Option<PathBuf>,
    /// Folder for tables and plots.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Generated straight hair of so many strands, 16 points each, in place of INPUT.
    #[arg(long, value_name = "N", conflicts_with = "input", value_parser = clap::value_parser!(u32).range(1..=500_000))]
    strands: Option<u32>,
    #[command(flatten)]
    light: LightOptions,
    /// Width and height of the picture, pixels.
    #[arg(long, value_name = "WxH", default_value = "1024x1024", value_parser = render::size)]
    size: [u32; 2],
    /// Frames of every edit, whose median counts.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    frames: u32,
    /// What is measured; the methods (the published one and brute force) take minutes in software.
    #[arg(long, value_enum, value_name = "WHAT,WHAT", value_delimiter = ',', default_values_t = [Part::Edits, Part::Savings, Part::Growth, Part::Orbit])]
    only: Vec<Part>,
    /// Directions a light of brute force, for the methods.
    #[arg(long, value_name = "N,N", value_delimiter = ',', default_values_t = [16, 64, 256])]
    directions: Vec<u32>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Part {
    /// What each kind of edit costs.
    Edits,
    /// Shading and drawing with each saving against none.
    Savings,
    /// Cost against lights, vertices and painted points.
    Growth,
    /// The view turned by a hand: pictures within their budget.
    Orbit,
    /// Shading and drawing by each method against the finest.
    Methods,
}

pub(super) fn run(args: &FrameArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let mut document = match (&args.input, args.strands) {
        (Some(path), _) => open(path, &GroomOptions::default(), console)?,
        (None, Some(strands)) => generated(&args.output, strands, console)?,
        (None, None) => Document::sample()?.document,
    };
    document.apply(Edit::SetLight(args.light.applied_to(&document)))?;
    let gpu = Gpu::headless()?;
    let lighting = render::load_light(&document, console)?;
    let lights = lighting.exposed(&document.project().light);
    let mut bench = Bench {
        renderer: render::scene(&gpu, &document, &lighting, false, VolumeSettings::default())?,
        params: document.params().to_vec(),
        camera: render::camera(None, args.size, &document)?,
        size: args.size,
        lights,
        frames: args.frames,
        centre: {
            let (low, high) = document.groom().bounds();
            0.5 * (low + high)
        },
    };
    let progress = console.progress(args.only.len() as u64, "measuring");
    let (mut tables, mut plots) = (Vec::new(), Vec::new());
    for (step, part) in args.only.iter().enumerate() {
        match part {
            Part::Edits => tables.extend(bench.edits()?),
            Part::Savings => tables.push(bench.savings()?),
            Part::Growth => {
                let (table, series) = bench.growth()?;
                tables.push(table);
                plots.push(Plot {
                    name: "frame_growth",
                    title: "Shading against what is shaded".to_owned(),
                    x_label: "share of the whole (lights, strands, painted points)",
                    y_label: "milliseconds of shading",
                    series,
                });
            }
            Part::Orbit => tables.extend(bench.orbit(gpu.is_software)?),
            Part::Methods => tables.push(bench.methods(&args.directions)?),
        }
        progress.at(step as u64 + 1);
    }
    drop(progress);
    let groom = document.groom();
    let [width, height] = args.size;
    let report = Report {
        name: "frame",
        notes: vec![
            format!("device: {}", gpu.adapter_name),
            format!(
                "{} strands, {} points, {} lights, {width}x{height}, median of {} frames",
                groom.strand_count(),
                groom.point_count(),
                bench.lights.lights.len(),
                args.frames
            ),
            "image difference: root mean square over the covered pixels, relative to theirs".to_owned(),
        ],
        tables,
        plots,
    };
    let written = report.write(&args.output)?;
    let mut value = report.json();
    value["files"] = json!(written);
    console.result(value, &report.text())?;
    Ok(())
}

struct Bench {
    renderer: Renderer,
    params: Vec<VertexParams>,
    lights: LightSet,
    camera: Camera,
    centre: Vec3,
    size: [u32; 2],
    frames: u32,
}

/// Median milliseconds a pass, and the work of the last frame.
#[derive(Default)]
struct Cost {
    report: FrameReport,
    passes: Vec<(String, f64)>,
}

impl Cost {
    fn of(reports: &[FrameReport]) -> Self {
        let report = reports.last().cloned().unwrap_or_default();
        let median = |name: &str| {
            let mut ms: Vec<f64> = reports.iter().map(|r| milliseconds(r, name)).collect();
            ms.sort_unstable_by(f64::total_cmp);
            ms[ms.len() / 2]
        };
        let passes = report.passes.iter().map(|(name, _)| (name.clone(), median(name)));
        Self {
            passes: passes.collect(),
            report,
        }
    }

    fn total(&self) -> f64 {
        self.passes.iter().map(|(_, ms)| ms).sum()
    }

    fn pass(&self, name: &str) -> f64 {
        self.passes
            .iter()
            .filter(|(n, _)| n == name)
            .map(|(_, ms)| ms)
            .sum()
    }
}

fn milliseconds(report: &FrameReport, pass: &str) -> f64 {
    report
        .passes
        .iter()
        .filter(|(n, _)| n == pass)
        .map(|(_, ms)| ms)
        .sum()
}

impl Bench {
    fn frame(&mut self, settings: &RenderSettings) -> Result<FrameReport, CliError> {
        Ok(self.renderer.render(&self.camera, self.size, settings)?)
    }

    /// Frames after `change`, which gets the number of the frame.
    fn cost(
        &mut self,
        settings: &RenderSettings,
        mut change: impl FnMut(&mut Self, u32) -> Result<(), CliError>,
    ) -> Result<Cost, CliError> {
        let mut reports = Vec::new();
        for k in 0..self.frames {
            change(self, k)?;
            reports.push(self.frame(settings)?);
        }
        Ok(Cost::of(&reports))
    }

    /// Dyes the first `share` of the points in a tone of their own.
    fn dye(&mut self, share: f32, tone: u32) -> Result<(), CliError> {
        let count = ((share * self.params.len() as f32) as usize).max(1);
        for point in &mut self.params[..count] {
            point.sigma_a = [0.2 + 0.01 * tone as f32, 0.5, 0.9];
        }
        let dirty = 0..count as u32;
        Ok(self.renderer.set_params(&self.params, &[dirty])?)
    }

    fn picture(&mut self, settings: &RenderSettings) -> Result<(Cost, Picture), CliError> {
        let report = self.frame(settings)?;
        Ok((Cost::of(&[report]), self.renderer.picture()?))
    }
}
