//! `balayage bench frame`: what each edit costs, what each saving saves, and how cost grows.

use std::path::PathBuf;

use balayage_render::gpu::{
    Camera, FrameReport, Gpu, Method, Quality, RenderSettings, Renderer, Saving, Savings, Scheme,
};
use balayage_render::image::Picture;
use balayage_render::light::{LightSet, SrbfLight};
use balayage_render::param::VertexParams;
use clap::{Args, ValueEnum};
use glam::{Quat, Vec3};
use serde_json::json;

use super::plot::{Plot, Series};
use super::report::{Cell, Report, Table};
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
    #[command(flatten)]
    light: LightOptions,
    /// Width and height of the picture, pixels.
    #[arg(long, value_name = "WxH", default_value = "1024x1024", value_parser = render::size)]
    size: [u32; 2],
    /// Frames of every edit, whose median counts.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    frames: u32,
    /// What is measured; the methods (the published one and brute force) take minutes in software.
    #[arg(long, value_enum, value_name = "WHAT,WHAT", value_delimiter = ',', default_values_t = [Part::Edits, Part::Savings, Part::Growth])]
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
    /// Shading and drawing by each method against the finest.
    Methods,
}

/// Share of the strands and of the pixels' sides while the view moves.
const MOVING_SHARE: f32 = 0.25;

pub(super) fn run(args: &FrameArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let mut document = match &args.input {
        Some(path) => open(path, &GroomOptions::default(), console)?,
        None => Document::sample()?.document,
    };
    document.apply(Edit::SetLight(args.light.applied_to(&document)))?;
    let gpu = Gpu::headless()?;
    let lighting = render::load_light(&document, console)?;
    let lights = lighting.exposed(&document.project().light);
    let mut bench = Bench {
        renderer: render::scene(&gpu, &document, &lighting, false)?,
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

/// Passes and counters of the tables, with their units.
const PASSES: [&str; 5] = [
    "transmittance",
    "head shading",
    "strand shading",
    "strand drawing",
    "view",
];
const WORK: [&str; 9] = [
    "parameter bytes uploaded",
    "voxels painted",
    "visibility rays",
    "path rays",
    "vertices shaded",
    "single scattering evaluations",
    "multiple scattering evaluations",
    "hidden lights skipped",
    "fragments",
];

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

    /// The camera turned about the hair.
    fn orbited(&self, degrees: f32) -> Camera {
        let turn = Quat::from_rotation_y(degrees.to_radians());
        let eye = self.centre + turn * (self.camera.position() - self.centre);
        Camera::look_at(eye, self.centre, self.camera.fov_y_rad)
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

    /// What each kind of edit costs.
    fn edits(&mut self) -> Result<Vec<Table>, CliError> {
        let full = RenderSettings::default();
        let moving = RenderSettings {
            interactive: true,
            ..full
        };
        let mut draft = moving;
        draft.shade.method.quality = Quality::Draft;
        let everything = RenderSettings {
            savings: Savings::ALL.without(Saving::Untouched),
            ..full
        };
        let mut costs: Vec<(String, Cost)> = Vec::new();
        self.frame(&full)?;
        costs.push(("everything anew".into(), Cost::of(&[self.frame(&everything)?])));
        self.frame(&full)?;
        costs.push(("nothing".into(), self.cost(&full, |_, _| Ok(()))?));
        let mut ev = full;
        let mut reports = Vec::new();
        for k in 0..self.frames {
            ev.view_exposure_ev = 0.1 * (k + 1) as f32;
            reports.push(self.frame(&ev)?);
        }
        costs.push(("exposure of the display".into(), Cost::of(&reports)));
        self.frame(&full)?;
        let lights = self.lights.clone();
        let scaled = |k: u32| {
            let mut set = lights.clone();
            for light in &mut set.lights {
                light.radiance *= 1.0 + 0.1 * (k + 1) as f32;
            }
            set
        };
        costs.push((
            "exposure of the light".into(),
            self.cost(&full, |bench, k| {
                bench.renderer.set_lights(&scaled(k));
                Ok(())
            })?,
        ));
        let one = |k: u32, change: &dyn Fn(&mut SrbfLight, f32)| {
            let mut set = lights.clone();
            if let Some(light) = set.lights.first_mut() {
                change(light, (k + 1) as f32);
            }
            set
        };
        self.frame(&moving)?;
        costs.push((
            "colour of one light".into(),
            self.cost(&moving, |bench, k| {
                let set = one(k, &|light, k| light.radiance *= 1.0 + 0.1 * k);
                bench.renderer.set_lights(&set);
                Ok(())
            })?,
        ));
        costs.push((
            "one light moved".into(),
            self.cost(&moving, |bench, k| {
                let set = one(k, &|light, k| {
                    light.direction = Quat::from_rotation_y(0.05 * k) * light.direction;
                });
                bench.renderer.set_lights(&set);
                Ok(())
            })?,
        ));
        costs.push((
            "light turned by 3 degrees".into(),
            self.cost(&moving, |bench, k| {
                let turn = 3f32.to_radians() * (k + 1) as f32;
                bench.renderer.set_lights(&lights.rotated(turn));
                Ok(())
            })?,
        ));
        self.renderer.set_lights(&lights);
        self.frame(&full)?;
        self.frame(&draft)?;
        for share in [0.01, 0.05, 0.2] {
            costs.push((
                format!("dye on {:.0} % of the points, draft", 100.0 * share),
                self.cost(&draft, |bench, k| bench.dye(share, k))?,
            ));
        }
        self.frame(&full)?;
        let (camera, size) = (self.camera, self.size);
        for (name, settings, share) in [
            ("view turned by 3 degrees", full, 1.0),
            ("view turned by 1 degree, draft", draft, 1.0),
            (
                "the same with a quarter of strands and pixels",
                draft,
                MOVING_SHARE,
            ),
        ] {
            let settings = RenderSettings {
                strand_share: share,
                ..settings
            };
            if share < 1.0 {
                self.size = size.map(|side| side.div_ceil(2));
            }
            let step = if settings.interactive { 1.0 } else { 3.0 };
            self.frame(&settings)?;
            let cost = self.cost(&settings, |bench, _| {
                bench.camera = bench.orbited(step);
                Ok(())
            })?;
            costs.push((name.into(), cost));
            (self.camera, self.size) = (camera, size);
        }
        let columns = ["edit", "all ms"].into_iter().chain(PASSES);
        let mut times = Table::new("frame_ms", columns);
        let mut work = Table::new("frame_work", ["edit"].into_iter().chain(WORK));
        for (name, cost) in &costs {
            let passes = PASSES.map(|pass| Cell::Number(cost.pass(pass)));
            times.row(
                [Cell::from(name.as_str()), cost.total().into()]
                    .into_iter()
                    .chain(passes),
            );
            let counts = WORK.map(|counter| Cell::Count(cost.report.counter(counter)));
            work.row([Cell::from(name.as_str())].into_iter().chain(counts));
        }
        Ok(vec![times, work])
    }

    fn picture(&mut self, settings: &RenderSettings) -> Result<(Cost, Picture), CliError> {
        let report = self.frame(settings)?;
        Ok((Cost::of(&[report]), self.renderer.picture()?))
    }

    /// Shading and drawing anew with each saving, against none of them.
    fn savings(&mut self) -> Result<Table, CliError> {
        let mut table = Table::new(
            "frame_savings",
            [
                "savings",
                "all ms",
                "shading ms",
                "vertices shaded",
                "lights evaluated",
                "image difference",
                "bound",
            ],
        );
        // Other savings than the frame before had: what was marched stays, everything is shaded again.
        let with = |savings: Savings| RenderSettings {
            savings: savings.with(Saving::Untouched),
            ..RenderSettings::default()
        };
        let (_, reference) = self.picture(&with(Savings::NONE))?;
        let mut rows = vec![
            ("all".to_owned(), Savings::ALL, None),
            ("none".into(), Savings::NONE, None),
        ];
        for saving in [
            Saving::Unseen,
            Saving::Hidden,
            Saving::Circular,
            Saving::Absorbed,
            Saving::Straight,
            Saving::Levels,
        ] {
            let only = Savings::NONE.with(saving);
            rows.push((format!("only {}", saving.name()), only, Some(saving.bound())));
        }
        for (name, savings, bound) in rows {
            // The first picture of a variant compiles it.
            self.frame(&with(savings))?;
            self.frame(&with(Savings::NONE.with(Saving::Gain)))?;
            let (cost, picture) = self.picture(&with(savings))?;
            let work = &cost.report;
            let lights = work.counter("single scattering evaluations")
                + work.counter("multiple scattering evaluations");
            table.row([
                Cell::from(name),
                cost.total().into(),
                cost.pass("strand shading").into(),
                Cell::Count(work.counter("vertices shaded")),
                Cell::Count(lights),
                picture.difference(&reference, 1).tile_rmse.into(),
                bound.map_or(Cell::None, Cell::Number),
            ]);
        }
        Ok(table)
    }

    /// Cost against lights, strands and painted points, with the exponents of the power laws between.
    fn growth(&mut self) -> Result<(Table, Vec<Series>), CliError> {
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

    /// Shading and drawing anew by each method against the finest: what an error costs. What was marched stays.
    fn methods(&mut self, directions: &[u32]) -> Result<Table, CliError> {
        let mut table = Table::new(
            "frame_methods",
            ["method", "savings", "all ms", "shading ms", "image difference"],
        );
        let settings = |scheme, quality, savings: Savings| {
            let mut settings = RenderSettings {
                savings: savings.with(Saving::Untouched),
                ..RenderSettings::default()
            };
            settings.shade.method = Method {
                scheme,
                quality,
                ..Method::default()
            };
            settings
        };
        let finest = settings(Scheme::Nodes, Quality::High, Savings::NONE);
        let (_, reference) = self.picture(&finest)?;
        let mut rows = vec![
            (
                "nodes, draft".to_owned(),
                Scheme::Nodes,
                Quality::Draft,
                Savings::ALL,
            ),
            (
                "nodes, standard".into(),
                Scheme::Nodes,
                Quality::Standard,
                Savings::ALL,
            ),
            ("nodes, high".into(), Scheme::Nodes, Quality::High, Savings::ALL),
            (
                "xu2011, m = 4".into(),
                Scheme::Xu2011 { segments: 4 },
                Quality::Standard,
                Savings::NONE,
            ),
        ];
        for n in directions {
            rows.push((
                format!("directional, N = {n}"),
                Scheme::Directional { directions: *n },
                Quality::Standard,
                Savings::NONE,
            ));
        }
        for (name, scheme, quality, savings) in rows {
            let settings = settings(scheme.checked().map_err(CliError::Usage)?, quality, savings);
            // The first picture of a variant compiles it; where that is nothing beside the picture it is spared.
            if !matches!(scheme, Scheme::Directional { directions: 100.. }) {
                self.frame(&settings)?;
                self.frame(&finest)?;
            }
            let (cost, picture) = self.picture(&settings)?;
            table.row([
                Cell::from(name),
                if savings == Savings::NONE { "none" } else { "all" }.into(),
                cost.total().into(),
                cost.pass("strand shading").into(),
                picture.difference(&reference, 1).tile_rmse.into(),
            ]);
        }
        Ok(table)
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
