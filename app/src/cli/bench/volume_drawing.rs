//! Strands drawn in two ways: lists of fragments in compute, which pictures are made with, and hardware ribbons.

use balayage_render::gpu::bench::{DrawnBy, draw_strands, true_alpha};
use balayage_render::gpu::camera::CameraUniform;
use balayage_render::gpu::strands::StrandBuffers;
use balayage_render::gpu::{Camera, Gpu};
use balayage_render::groom::{Groom, RefinedGroom};
use balayage_render::volume::Strands;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::report::{Cell, Report, Table};
use super::volume_build::{POINTS, hair};
use crate::cli::{CliError, Console};
use crate::document::Document;

const STRANDS: [u32; 3] = [1_000, 10_000, 50_000];
/// Edges of the square pictures, pixels.
const EDGES: [u32; 2] = [512, 1024];
/// The fastest of so many draws is told, after one that warms up.
const RUNS: u32 = 3;

/// Adds the table `drawing`.
pub(super) fn measure(gpu: &Gpu, report: &mut Report, console: &mut Console<'_>) -> Result<(), CliError> {
    let head = Document::sample()?.document.load_head()?;
    let head =
        head.ok_or_else(|| CliError::Input("the built-in sample has no head: reinstall".to_owned()))?;
    report.notes.push(format!(
        "drawing: generated straight hair, {POINTS} points a strand and no refinement, without its head; fastest of {RUNS} draws from \
         nothing. Coverage is held against areas of clipped polygons (f64) over the pixels that hair covers: mean of its absolute error, and \
         what all pixels together have too much. Colour: relative RMSE of radiance against the fragments in their order, strands of random \
         grey; ribbons are blended without order"
    ));
    let mut table = Table::new(
        "drawing",
        [
            "strands",
            "picture",
            "rasterizer",
            "ms",
            "coverage, mean error",
            "coverage, bias",
            "colour, RMSE",
        ],
    );
    let progress = console.progress((STRANDS.len() * EDGES.len()) as u64, "drawing");
    for (row, strands) in STRANDS.into_iter().enumerate() {
        let groom = hair(strands, &head)?;
        // A turn that no strand exceeds: its own points.
        let buffers = StrandBuffers::new(gpu, &RefinedGroom::new(&groom, std::f32::consts::PI))?;
        buffers.set_radiance(gpu, &greys(&groom));
        for (column, edge) in EDGES.into_iter().enumerate() {
            let camera = camera(&groom, edge, buffers.segment_count);
            let truth = true_alpha(&camera, &Strands::from(&groom));
            let (fragments_s, sorted) = draw_strands(gpu, DrawnBy::Fragments, &camera, &buffers, RUNS)?;
            let (ribbons_s, blended) = draw_strands(gpu, DrawnBy::Ribbons, &camera, &buffers, RUNS)?;
            let ways = [
                ("fragments", fragments_s, &sorted, Cell::None),
                (
                    "ribbons",
                    ribbons_s,
                    &blended,
                    colour_error(&blended, &sorted).into(),
                ),
            ];
            for (name, seconds, picture, colour) in ways {
                let (error, bias) = coverage_error(picture, &truth);
                table.row([
                    Cell::Count(u64::from(strands)),
                    format!("{edge} x {edge}").into(),
                    name.into(),
                    (1e3 * seconds).into(),
                    error.into(),
                    bias.into(),
                    colour,
                ]);
            }
            progress.at((row * EDGES.len() + column) as u64 + 1);
        }
    }
    report.tables.push(table);
    Ok(())
}

/// A view that just holds the groom.
fn camera(groom: &Groom, edge: u32, segment_count: u32) -> CameraUniform {
    let (low, high) = groom.bounds();
    let camera = Camera::framing((low, high), 1.0);
    // Ribbons are weighted by their depth over the nearest one's.
    let nearest = camera.position().distance(0.5 * (low + high)) - 0.5 * low.distance(high);
    let near = nearest.max(1e-3 * low.distance(high));
    CameraUniform::new(&camera, [edge; 2], [0.0; 2], near, segment_count)
}

/// Radiance of every point: one grey a strand.
fn greys(groom: &Groom) -> Vec<[f32; 4]> {
    let mut random = Pcg64Mcg::seed_from_u64(11);
    let strands = groom.first_point().windows(2);
    let greys = strands.flat_map(|ends| vec![[random.random(); 4]; (ends[1] - ends[0]) as usize]);
    greys.collect()
}

/// Mean absolute error of coverage over the covered pixels, and what all pixels together have too much, relative.
fn coverage_error(picture: &[[f32; 4]], truth: &[f32]) -> (f64, f64) {
    let pairs = || {
        picture
            .iter()
            .zip(truth)
            .map(|(p, t)| (f64::from(p[3]), f64::from(*t)))
    };
    let covered = pairs().filter(|(_, t)| *t > 0.0);
    let (count, error) = covered.fold((0.0, 0.0), |(n, sum), (a, t)| (n + 1.0, sum + (a - t).abs()));
    let (seen, area) = pairs().fold((0.0, 0.0), |(seen, area), (a, t)| (seen + a, area + t));
    (error / count, seen / area - 1.0)
}

/// Root mean square difference of radiance, relative to that of `reference`.
fn colour_error(picture: &[[f32; 4]], reference: &[[f32; 4]]) -> f64 {
    let pairs = picture.iter().zip(reference);
    let (error, power) = pairs.fold((0.0, 0.0), |(error, power), (a, b)| {
        let (a, b) = (f64::from(a[0]), f64::from(b[0]));
        (error + (a - b).powi(2), power + b * b)
    });
    (error / power).sqrt()
}
