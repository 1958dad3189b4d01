//! `balayage bench picture`: what the renderer draws, held against path tracing of the same hair, light and camera.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use balayage_render::gpu::{Camera, Gpu, Method, Model, RenderSettings, Renderer, ShadeSettings, Terms};
use balayage_render::image::{Picture, write_png};
use balayage_render::light::EnvironmentMap;
use balayage_render::trace::{Scene, TraceSettings, Traced};
use clap::Args;

use super::report::{Cell, Report, Table};
use crate::Problem;
use crate::cli::groom_options::GroomOptions;
use crate::cli::hair_option::HairOption;
use crate::cli::light_options::LightOptions;
use crate::cli::method_options::{MethodOptions, ModelName, MultipleName};
use crate::cli::{CliError, Console, open, render};
use crate::document::{Document, Edit};

/// Side of the tiles whose means are compared, pixels.
const TILE: usize = 16;
/// Height of the map that lights without a map are traced as.
const LIGHT_ROWS: usize = 1024;

#[derive(Args)]
pub(super) struct PictureArgs {
    /// Project (.json) or groom; the built-in sample if absent. A head is left out.
    input: Option<PathBuf>,
    /// Folder for table and pictures.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    #[command(flatten)]
    light: LightOptions,
    /// Width and height of the picture, pixels.
    #[arg(long, value_name = "WxH", default_value = "256x256", value_parser = render::size)]
    size: [u32; 2],
    /// Camera; otherwise the project's, otherwise one that frames the hair.
    #[arg(long, value_name = "FILE.json")]
    camera: Option<PathBuf>,
    /// Unpainted parameters, as eumelanin=1.3; repeat for more.
    #[arg(long = "set", value_name = "CHANNEL=VALUE")]
    settings: Vec<HairOption>,
    /// What a fibre does to light (the path tracer knows marschner and deon).
    #[arg(long, value_enum)]
    model: Option<ModelName>,
    #[command(flatten)]
    method: MethodOptions,
    /// How light that has crossed other fibres is added.
    #[arg(long, value_enum, default_value_t = MultipleName::Traced)]
    multiple: MultipleName,
    /// Exact rays per point and light of the refined picture.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=1024))]
    visibility_rays: u32,
    /// Traced paths a pixel.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..=65536))]
    paths: u32,
    /// Instead of tracing: the traced picture of single scattering.
    #[arg(long, value_name = "REFERENCE.exr", requires = "all")]
    single: Option<PathBuf>,
    /// Instead of tracing: the traced picture of all orders.
    #[arg(long, value_name = "REFERENCE.exr", requires = "single")]
    all: Option<PathBuf>,
    /// Seed of the paths.
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

pub(super) fn run(args: &PictureArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let mut document = match &args.input {
        Some(path) => open(path, &GroomOptions::default(), console)?,
        None => Document::sample()?.document,
    };
    let mut hair = document.project().hair.clone();
    for option in &args.settings {
        option.apply(&mut hair).map_err(CliError::Usage)?;
    }
    document.apply(Edit::SetHair(hair))?;
    document.apply(Edit::SetLight(args.light.applied_to(&document)))?;
    let camera = render::camera(args.camera.as_deref(), args.size, &document)?;
    let gpu = Gpu::headless()?;
    let lighting = render::load_light(&document, console)?;
    let lights = lighting.exposed(&document.project().light);
    let groom = document.groom_as_drawn()?;
    let model = args.model.map_or(document.project().hair.model, Model::from);

    // The reference: pictures that are there, or two independent runs, whose difference tells the noise.
    let (reference, noise, seconds) = if let (Some(single), Some(all)) = (&args.single, &args.all) {
        let read = |path: &Path| read_reference(path, args.size);
        let read = Traced {
            single: read(single)?,
            all: read(all)?,
        };
        (read, None, None)
    } else {
        let environment = EnvironmentMap::from_fn(2 * LIGHT_ROWS, LIGHT_ROWS, |w| lights.radiance(w)).0;
        let scene = Scene::new(&groom, document.params(), &environment);
        let start = Instant::now();
        let [a, b] = traced(&scene, &camera, model, args, console);
        let noise =
            [(&a.single, &b.single), (&a.all, &b.all)].map(|(a, b)| 0.5 * a.difference(b, TILE).tile_rmse);
        let both = Traced {
            single: mean(&a.single, &b.single),
            all: mean(&a.all, &b.all),
        };
        (both, Some(noise), Some(start.elapsed().as_secs_f64()))
    };

    let mut renderer = Renderer::new(&gpu)?;
    renderer.set_groom(&groom, None)?;
    renderer.set_params(document.params(), &[])?;
    renderer.set_lights(&lights);
    let mut table = Table::new(
        "picture",
        [
            "light",
            "shadows",
            "red",
            "green",
            "blue",
            "radiance",
            "tile RMSE",
            "noise of the reference",
            "seconds",
        ],
    );
    let wanted = [&reference.single, &reference.all];
    let mut shown = wanted.map(|picture| vec![picture.clone()]);
    // Exact rays come last: shadows that were refined stay so.
    for rays in [0, args.visibility_rays] {
        for (which, (name, terms)) in [("single", Terms::SINGLE), ("all", Terms::ALL)]
            .into_iter()
            .enumerate()
        {
            let settings = RenderSettings {
                shade: ShadeSettings {
                    method: Method {
                        model,
                        ..args.method.method(document.project().hair.scheme)
                    },
                    terms,
                    multiple: args.multiple.into(),
                    ..ShadeSettings::default()
                },
                samples: 4,
                visibility_rays: rays,
                ..RenderSettings::default()
            };
            let start = Instant::now();
            renderer.render(&camera, args.size, &settings)?;
            let seconds = start.elapsed().as_secs_f64();
            let picture = renderer.picture()?;
            let found = picture.difference(wanted[which], TILE);
            let shadows = if rays == 0 {
                "first frame".to_owned()
            } else {
                format!("{rays} exact rays")
            };
            table.row([
                Cell::from(name),
                shadows.into(),
                found.ratio[0].into(),
                found.ratio[1].into(),
                found.ratio[2].into(),
                picture.mean()[1].into(),
                found.tile_rmse.into(),
                noise.map_or(Cell::None, |noise| noise[which].into()),
                seconds.into(),
            ]);
            shown[which].push(picture);
        }
    }
    let mut notes = vec![
        format!("device: {}", gpu.adapter_name),
        "red, green, blue: mean radiance over the path tracer's; radiance: mean of the covered part (green); \
         tile RMSE: of the means of 16 x 16 pixels, relative"
            .to_owned(),
        "picture.png: path traced, first frame, refined; single scattering above, all orders below".to_owned(),
    ];
    if let Some(seconds) = seconds {
        notes.push(format!("{} paths a pixel: {seconds:.0} s", args.paths));
    }
    let report = Report {
        name: "picture",
        notes,
        tables: vec![table],
        plots: Vec::new(),
    };
    report.write(&args.output)?;
    reference.single.write_exr(&args.output.join("single.exr"))?;
    reference.all.write_exr(&args.output.join("all.exr"))?;
    let (width, height, bytes) = side_by_side(&shown);
    write_png(&args.output.join("picture.png"), width, height, &bytes)?;
    Ok(console.result(report.json(), &report.text())?)
}

fn read_reference(path: &Path, size: [u32; 2]) -> Result<Picture, CliError> {
    let picture = Picture::read_exr(path)?;
    if [picture.width, picture.height] != size.map(|side| side as usize) {
        let reason = format!("the picture has {} x {} pixels", picture.width, picture.height);
        let problem = Problem::at("", reason, "give its size with --size");
        return Err(problem.in_file(path).into());
    }
    Ok(picture)
}

/// Two runs of half the paths each.
fn traced(
    scene: &Scene<'_>,
    camera: &Camera,
    model: Model,
    args: &PictureArgs,
    console: &mut Console<'_>,
) -> [Traced; 2] {
    let progress = console.progress(2 * u64::from(args.size[1]), "tracing");
    let rows = AtomicU64::new(0);
    [0, 1].map(|half| {
        let settings = TraceSettings {
            samples: args.paths / 2,
            seed: 2 * args.seed + half,
            is_deon: model == Model::Deon,
            ..TraceSettings::default()
        };
        let on_row = || {
            progress.at(rows.fetch_add(1, Ordering::Relaxed) + 1);
            ControlFlow::Continue(())
        };
        scene
            .trace(camera, args.size, &settings, &on_row)
            .unwrap_or_else(|| unreachable!("nothing stops it"))
    })
}

fn mean(a: &Picture, b: &Picture) -> Picture {
    let pixels = a.pixels.iter().zip(&b.pixels);
    Picture {
        pixels: pixels
            .map(|(a, b)| std::array::from_fn(|c| 0.5 * (a[c] + b[c])))
            .collect(),
        ..*a
    }
}

/// Rows of pictures of one size as sRGB bytes, exposed so that the brightest hundredth of the first picture's values is white.
fn side_by_side(rows: &[Vec<Picture>]) -> (usize, usize, Vec<u8>) {
    let first = &rows[rows.len() - 1][0];
    let mut values: Vec<f32> = first
        .pixels
        .iter()
        .filter(|p| p[3] > 0.0)
        .map(|p| p[0].max(p[1]).max(p[2]))
        .collect();
    values.sort_unstable_by(f32::total_cmp);
    let white = values
        .get(values.len() * 99 / 100)
        .copied()
        .unwrap_or(1.0)
        .max(1e-6);
    let encode = |value: f32| {
        let value = (value / white).clamp(0.0, 1.0);
        let encoded = if value <= 0.003_130_8 {
            12.92 * value
        } else {
            1.055 * value.powf(1.0 / 2.4) - 0.055
        };
        (encoded * 255.0).round() as u8
    };
    let (width, height) = (first.width * rows[0].len(), first.height * rows.len());
    let mut bytes = Vec::with_capacity(4 * width * height);
    for row in rows {
        for y in 0..first.height {
            for picture in row {
                let line = &picture.pixels[y * first.width..][..first.width];
                bytes.extend(
                    line.iter()
                        .flat_map(|p| [encode(p[0]), encode(p[1]), encode(p[2]), 255]),
                );
            }
        }
    }
    (width, height, bytes)
}
