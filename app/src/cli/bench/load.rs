//! `balayage bench load`: from a file of many strands to a painted, saved picture, in seconds and in bytes.

use std::path::PathBuf;
use std::time::Instant;

use balayage_render::gpu::{Camera, Gpu, RenderSettings, Renderer};
use balayage_render::param::Channel;
use clap::Args;
use serde_json::json;

use super::generated::write_generated;
use super::plot::{Plot, Series};
use super::report::{Cell, Report, Table};
use crate::cli::groom_options::GroomOptions;
use crate::cli::light_options::LightOptions;
use crate::cli::{CliError, Console, open, render};
use crate::document::Edit;
use crate::paint::{Operation, OperationId, Shape, StrokeValue};
use crate::tool::dab_at;

#[derive(Args)]
pub(super) struct LoadArgs {
    /// Folder for tables, plots and the files that are loaded.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Strands of the grooms, 16 points each; 62500 make a million points, minutes in software.
    #[arg(long, value_name = "N,N", value_delimiter = ',', default_values_t = [1_000, 4_000, 16_000], value_parser = clap::value_parser!(u32).range(1..=500_000))]
    strands: Vec<u32>,
    #[command(flatten)]
    light: LightOptions,
    /// Width and height of the picture, pixels.
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = render::size)]
    size: [u32; 2],
}

/// Steps that are timed, in their order.
const STEPS: [&str; 6] = [
    "read",
    "refine, density, upload",
    "first picture",
    "stroke",
    "picture of the stroke",
    "save",
];

/// One groom's figures.
struct Loaded {
    points: usize,
    seconds: [f64; STEPS.len()],
    /// GPU bytes before the groom, with it, and with its lights; none where the adapter does not tell.
    bytes: Option<[u64; 3]>,
    lights: usize,
}

pub(super) fn run(args: &LoadArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let gpu = Gpu::headless()?;
    let mut table = Table::new(
        "load",
        ["strands", "points"].into_iter().chain(STEPS).chain([
            "GPU MiB",
            "bytes a point",
            "bytes a point and light",
        ]),
    );
    let mut series = STEPS.map(|name| Series {
        name: name.to_owned(),
        points: Vec::new(),
    });
    for strands in &args.strands {
        let loaded = load(args, *strands, &gpu, console)?;
        let points = loaded.points as f64;
        let mut row = vec![
            Cell::Count(u64::from(*strands)),
            Cell::Count(loaded.points as u64),
        ];
        row.extend(loaded.seconds.map(Cell::Number));
        let [all, groom, lights] = match loaded.bytes {
            None => [Cell::None, Cell::None, Cell::None],
            Some([before, with, lit]) => [
                (lit as f64 / f64::from(1 << 20)).into(),
                ((with - before) as f64 / points).into(),
                (lit.saturating_sub(with) as f64 / (points * loaded.lights as f64)).into(),
            ],
        };
        row.extend([all, groom, lights]);
        table.row(row);
        for (series, seconds) in series.iter_mut().zip(loaded.seconds) {
            series.points.push((points, seconds));
        }
    }
    let report = Report {
        name: "load",
        notes: vec![
            format!("device: {}", gpu.adapter_name),
            "seconds; generated straight hair in a .hair file, one stroke through it".to_owned(),
        ],
        tables: vec![table],
        plots: vec![Plot {
            name: "load",
            title: "From file to picture".to_owned(),
            x_label: "points",
            y_label: "seconds",
            series: series.into(),
        }],
    };
    let written = report.write(&args.output)?;
    let mut value = report.json();
    value["files"] = json!(written);
    console.result(value, &report.text())?;
    Ok(())
}

fn load(
    args: &LoadArgs,
    strand_count: u32,
    gpu: &Gpu,
    console: &mut Console<'_>,
) -> Result<Loaded, CliError> {
    let path = write_generated(&args.output, strand_count)?;

    let mut seconds = [0.0; STEPS.len()];
    let mut clock = Instant::now();
    let mut step = |place: usize| {
        seconds[place] = clock.elapsed().as_secs_f64();
        clock = Instant::now();
    };
    let mut document = open(&path, &GroomOptions::default(), console)?;
    step(0);
    document.apply(Edit::SetLight(args.light.applied_to(&document)))?;
    let lighting = render::load_light(&document, console)?;
    let before = gpu.allocated_bytes();
    step(1);
    let mut renderer = Renderer::new(gpu)?;
    renderer.set_groom(document.groom(), None)?;
    renderer.set_params(document.params(), &[])?;
    gpu.wait()?;
    step(1);
    let with = gpu.allocated_bytes();
    renderer.set_lights(&lighting.exposed(&document.project().light));
    let [width, height] = args.size;
    let camera = Camera::framing(document.groom().bounds(), width as f32 / height as f32);
    renderer.render(&camera, args.size, &RenderSettings::default())?;
    step(2);
    let lit = gpu.allocated_bytes();

    let groom = document.groom().clone();
    let mut operation = Operation::shaped(
        OperationId::Number(document.next_operation_number()),
        document.project().layers[0].id.clone(),
        Shape::all()[6].clone(),
        0,
    );
    let (low, high) = groom.bounds();
    operation.shape = None;
    operation.channel = Channel::Dye;
    operation.value = StrokeValue::Rgb([0.2, 0.9, 1.5]);
    operation.radius_m = 0.05 * low.distance(high) * groom.metres_per_unit();
    let middle = groom.positions()[groom.point_count() / 2];
    operation.dabs = dab_at(document.index(), middle, f32::INFINITY, 1.0)
        .into_iter()
        .collect();
    step(3);
    let changes = document.apply(Edit::Stroke(operation))?;
    step(3);
    renderer.set_params(document.params(), changes.points.ranges())?;
    renderer.render(&camera, args.size, &RenderSettings::default())?;
    step(4);
    document.save_as(&args.output.join(format!("load-{strand_count}.json")))?;
    step(5);
    Ok(Loaded {
        points: groom.point_count(),
        seconds,
        bytes: before.zip(with).zip(lit).map(|((a, b), c)| [a, b, c]),
        lights: lighting.lights.lights.len(),
    })
}
