//! `balayage bench furnace`: a ball of strands in uniform light, shell by shell. Hair that absorbs nothing should be as bright as its world, inside
//! as outside; hair that absorbs must be darker the more it does.

use std::f32::consts::PI;
use std::path::PathBuf;
use std::time::Instant;

use balayage_render::gpu::{Gpu, Method, Model, RenderSettings, Renderer, ShadeSettings, Terms};
use balayage_render::groom::{BALL_RADIUS, Groom, ball};
use balayage_render::light::LightSet;
use balayage_render::param::{LobeRatios, PigmentSet, PointValues, VertexParams};
use clap::Args;
use glam::Vec3;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;

use super::report::{Cell, Report, Table};
use crate::cli::light_options::finite;
use crate::cli::method_options::{ModelName, MultipleName};
use crate::cli::{CliError, Console};

/// Shells of equal thickness.
const SHELLS: usize = 20;

/// Distance of the eyes from the ball's middle, in radii.
const EYE_DISTANCE: f32 = 100.0;

#[derive(Args)]
pub(super) struct FurnaceArgs {
    /// Folder for the table.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Strands of the ball.
    #[arg(long, default_value_t = 50_000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    strands: u32,
    /// Fibre diameter; the ball has radius 1.25, a strand length 0.5.
    #[arg(long, default_value_t = 0.008)]
    diameter: f32,
    /// Absorptions per fibre radius, the same in all channels.
    #[arg(long, value_delimiter = ',', default_values_t = [0.0, 0.01, 0.1, 1.0])]
    sigma_a: Vec<f32>,
    /// Points of a shell that are looked at.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    points: u32,
    /// Directions that each is looked at from.
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=1000))]
    views: u32,
    /// Cuticle tilt of R, degrees; without tilt a fibre of d'Eon's that does not absorb loses nothing at any inclination.
    #[arg(long, default_value_t = -5.0, allow_negative_numbers = true, value_parser = finite)]
    alpha_deg: f32,
    /// What a fibre does to light.
    #[arg(long, value_enum, default_values_t = [ModelName::Marschner, ModelName::Deon])]
    model: Vec<ModelName>,
    /// How light that has crossed other fibres is added.
    #[arg(long, value_enum, default_value_t = MultipleName::Traced)]
    multiple: MultipleName,
    /// Terms that are added up, as `render` has them.
    #[arg(long, value_name = "TERMS", default_value = "all")]
    terms: Terms,
    /// Rays that visibility is refined by; light between fibres takes more photons with them.
    #[arg(long, default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=4096))]
    visibility_rays: u32,
    /// Seed of the strands and of the points.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

pub(super) fn run(args: &FurnaceArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let groom = ball(args.strands, args.diameter, args.seed)?;
    let shells = shells(&groom, args.points as usize, args.seed);
    let gpu = Gpu::headless()?;
    let mut renderer = Renderer::new(&gpu)?;
    renderer.set_groom(&groom, None)?;
    renderer.set_lights(&LightSet {
        lights: Vec::new(),
        constant: Vec3::ONE,
    });

    let columns: Vec<(Model, f32)> = args
        .model
        .iter()
        .flat_map(|&model| args.sigma_a.iter().map(move |&sigma_a| (model.into(), sigma_a)))
        .collect();
    let progress = console.progress(columns.len() as u64 * u64::from(args.views), "looking");
    let start = Instant::now();
    let mut means = Vec::new();
    for (column, &(model, sigma_a)) in columns.iter().enumerate() {
        renderer.set_params(&vec![params(sigma_a, args.alpha_deg); groom.point_count()], &[])?;
        let settings = RenderSettings {
            shade: ShadeSettings {
                method: Method {
                    model,
                    ..Method::default()
                },
                multiple: args.multiple.into(),
                terms: args.terms,
                ..ShadeSettings::default()
            },
            visibility_rays: args.visibility_rays,
            ..RenderSettings::default()
        };
        let points = shells.concat();
        let mut sums = vec![0.0_f64; points.len()];
        for view in 0..args.views {
            let eye = EYE_DISTANCE * BALL_RADIUS * spread_direction(view, args.views);
            let radiance = renderer.radiance_of_points(&points, eye, &settings)?;
            for (sum, radiance) in sums.iter_mut().zip(radiance) {
                *sum += f64::from(radiance.y);
            }
            progress.at(column as u64 * u64::from(args.views) + u64::from(view) + 1);
        }
        let mut sums = sums.into_iter();
        means.push(
            shells
                .iter()
                .map(|shell| {
                    let sum: f64 = sums.by_ref().take(shell.len()).sum();
                    sum / (shell.len() as f64 * f64::from(args.views))
                })
                .collect::<Vec<_>>(),
        );
    }
    drop(progress);

    let heads = columns
        .iter()
        .map(|(model, sigma_a)| format!("{model:?} {sigma_a}").to_lowercase());
    let mut table = Table::new(
        "furnace",
        ["depth".to_owned(), "points".to_owned()].into_iter().chain(heads),
    );
    for shell in 0..SHELLS {
        let depth = format!("{} to {} %", 100 * shell / SHELLS, 100 * (shell + 1) / SHELLS);
        let cells = means.iter().map(|of_shell| match of_shell[shell] {
            mean if mean.is_nan() && shells[shell].is_empty() => Cell::None,
            mean => mean.into(),
        });
        table.row(
            [Cell::from(depth), Cell::Count(shells[shell].len() as u64)]
                .into_iter()
                .chain(cells),
        );
    }
    let report = Report {
        name: "furnace",
        notes: vec![
            format!("device: {}", gpu.adapter_name),
            format!(
                "{} strands of diameter {} in a ball of radius {BALL_RADIUS}, uniform light of radiance 1; {:.1} s",
                groom.strand_count(),
                args.diameter,
                start.elapsed().as_secs_f64()
            ),
            format!(
                "radiance, mean of {} points a shell and {} views, what lies between point and eye left out; depth: from the surface to the middle",
                args.points, args.views
            ),
        ],
        tables: vec![table],
        plots: Vec::new(),
    };
    report.write(&args.output)?;
    Ok(console.result(report.json(), &report.text())?)
}

/// The usual fibre with that absorption in all channels and that tilt.
fn params(sigma_a: f32, alpha_deg: f32) -> VertexParams {
    let values = PointValues {
        alpha_deg,
        ..PointValues::default()
    };
    VertexParams {
        sigma_a: [sigma_a; 3],
        ..values.vertex_params(PigmentSet::default(), &LobeRatios::default())
    }
}

/// Up to `most` random points of every shell, the outermost first.
fn shells(groom: &Groom, most: usize, seed: u64) -> Vec<Vec<u32>> {
    let mut shells = vec![Vec::new(); SHELLS];
    for (point, position) in groom.positions().iter().enumerate() {
        let depth = 1.0 - position.length() / BALL_RADIUS;
        let shell = (depth.max(0.0) * SHELLS as f32) as usize;
        shells[shell.min(SHELLS - 1)].push(point as u32);
    }
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    for shell in &mut shells {
        shell.shuffle(&mut random);
        shell.truncate(most);
    }
    shells
}

/// Direction `k` of `count` over the sphere, a Fibonacci lattice.
fn spread_direction(k: u32, count: u32) -> Vec3 {
    let y = 1.0 - (2.0 * k as f32 + 1.0) / count as f32;
    let (sin, cos) = (PI * (3.0 - 5f32.sqrt()) * k as f32).sin_cos();
    let r = (1.0 - y * y).sqrt();
    Vec3::new(r * cos, y, r * sin)
}
