//! `balayage render`: pictures without a window.

mod cancel;
mod drawn;
mod names;
mod record;
mod scene;
mod wedge;

use std::{fs, ops::RangeInclusive, path::PathBuf};

use balayage_render::{
    gpu::{Camera, DebugView, FrameReport, Gpu, RenderSettings, Savings, Terms},
    image::Metadata,
    volume::VolumeSettings,
};
use clap::{Args, ValueEnum};
use serde_json::json;

use super::{
    CliError, Console,
    groom_options::GroomOptions,
    hair_option::HairOption,
    light_options::LightOptions,
    method_options::{MethodOptions, ModelName, MultipleName, TransmittanceName},
};
use crate::{
    Problem,
    document::{Document, Edit, files},
};
use drawn::Drawn;
use names::Format;
use record::Record;
pub(super) use scene::{camera, load_light, scene};
use wedge::Wedge;

#[derive(Args)]
pub(super) struct RenderArgs {
    /// Project (.json) or groom; the built-in sample if absent.
    input: Option<PathBuf>,
    /// Picture to write: .png as seen on a display, .exr scene-linear; a frame's number stands for ####, the file of a wedge for {NAME}.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    light: LightOptions,
    /// Width and height of the picture, pixels.
    #[arg(long, value_name = "WxH", default_value = "1024x1024", value_parser = size)]
    size: [u32; 2],
    /// Camera samples a pixel.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=4096))]
    samples: u32,
    /// Camera; otherwise the project's, otherwise one that frames the hair.
    #[arg(long, value_name = "FILE.json")]
    camera: Option<PathBuf>,
    /// View transform of a PNG.
    #[arg(long, value_enum, default_value_t = ViewName::Neutral)]
    view: ViewName,
    /// What is seen behind the hair.
    #[arg(long, value_enum, default_value_t = BackgroundName::Black)]
    background: BackgroundName,
    /// Frames to render, as 1-120; their number goes into the file's name.
    #[arg(long, value_name = "A-B", value_parser = frames, requires = "turntable")]
    frames: Option<RangeInclusive<u32>>,
    /// Turns the camera round the hair; a full turn takes that many frames [default: the last of --frames].
    #[arg(long, value_name = "FRAMES", num_args = 0..=1, default_missing_value = "0", requires = "frames")]
    turntable: Option<u32>,
    /// Renders everything once for every file: strokes that are added, or fields that replace the project's; repeat for more.
    #[arg(long = "wedge", value_name = "NAME=A.json,B.json")]
    wedges: Vec<Wedge>,
    /// Keeps the pictures that are there, complete, and made of the same project, files, settings and version.
    #[arg(long)]
    resume: bool,
    /// What a fibre does to light (the project's model if not given).
    #[arg(long, value_enum)]
    model: Option<ModelName>,
    #[command(flatten)]
    method: MethodOptions,
    /// Which light is seen: single (R, TT and TRT with shadows), multiple (D, L and U: light that has crossed or left other fibres), all,
    /// or some of R,TT,TRT,D,L,U.
    #[arg(long, value_name = "TERMS", default_value = "all")]
    terms: Terms,
    /// How light that has crossed other fibres is added.
    #[arg(long, value_enum, default_value_t = MultipleName::Traced)]
    multiple: MultipleName,
    /// Where shadows come from before exact rays refine them.
    #[arg(long, value_enum, default_value_t)]
    transmittance: TransmittanceName,
    /// Side of the hair volume's voxels in mean distances between fibres, 0.5 to 16; where they would be too many for memory they grow.
    #[arg(long, value_name = "X", default_value_t = VolumeSettings::default().voxel_spacings, value_parser = voxel_spacings)]
    voxel_spacings: f32,
    /// Exact rays per point and light that shadows come from; 0: the density of the hair. [default: 64 with --quality high, else 0]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=1024))]
    visibility_rays: Option<u32>,
    /// Shadows from 256 exact rays per point and light.
    #[arg(long, conflicts_with = "visibility_rays")]
    reference_visibility: bool,
    /// False colours instead of the picture (PNG): transmittance, fibres, a-f, density, overdraw or non-finite; the legend is printed.
    #[arg(long, value_name = "NAME")]
    debug_view: Option<DebugView>,
    /// Work that need not be done: all, none, or some of unseen, untouched, gain, few-lights, hidden, circular, absorbed, straight, levels,
    /// turning, covered. The highest quality makes only those that change nothing.
    #[arg(long, value_name = "NAMES", default_value = "all")]
    savings: Savings,
    /// Unpainted parameters, as eumelanin=1.3; repeat for more.
    #[arg(long = "set", value_name = "CHANNEL=VALUE")]
    settings: Vec<HairOption>,
    #[command(flatten)]
    groom: GroomOptions,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum BackgroundName {
    /// Nothing: black (an .exr keeps its coverage as alpha).
    Black,
    /// The environment.
    Env,
}

#[derive(Clone, Copy, ValueEnum)]
enum ViewName {
    /// Khronos PBR Neutral.
    Neutral,
    /// AgX, base look.
    Agx,
    /// Clipped.
    Raw,
}

/// Side of a voxel in fibre spacings.
fn voxel_spacings(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|spacings| (0.5..=16.0).contains(spacings))
        .ok_or_else(|| "write a number from 0.5 (fine) to 16 (coarse)".to_owned())
}

/// `WxH`.
pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    let side = |x: &str| x.parse::<u32>().ok().filter(|x| (1..=16_384).contains(x));
    let parts = text
        .split_once(['x', 'X'])
        .and_then(|(w, h)| Some([side(w)?, side(h)?]));
    parts.ok_or_else(|| "write WIDTHxHEIGHT with sides from 1 to 16384, as 1024x768".to_owned())
}

/// `A-B`, or `A` for one frame.
fn frames(text: &str) -> Result<RangeInclusive<u32>, String> {
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    match (first.parse::<u32>(), last.parse::<u32>()) {
        (Ok(first), Ok(last)) if first <= last && last <= 1_000_000 => Ok(first..=last),
        _ => Err("write FIRST-LAST, as 1-120".to_owned()),
    }
}

pub(super) fn run(args: &RenderArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let format = Format::of(&args.output)?;
    if args.debug_view.is_some() && format != Format::Png {
        let text = "--debug-view: false colours are for a display; write a .png";
        return Err(CliError::Usage(text.to_owned()));
    }
    let has_rays = args.reference_visibility || args.visibility_rays.is_some_and(|rays| rays > 0);
    if args.transmittance == TransmittanceName::Sh9 && has_rays {
        let text = "--transmittance sh9: exact rays do not refine it; leave --visibility-rays and --reference-visibility away";
        return Err(CliError::Usage(text.to_owned()));
    }
    let frames: Vec<Option<u32>> = match &args.frames {
        Some(range) => range.clone().map(Some).collect(),
        None => vec![None],
    };
    let choices = wedge::choices(&args.wedges);
    let pictures: Vec<Vec<PathBuf>> = choices
        .iter()
        .map(|choice| {
            let picture = |frame: &Option<u32>| names::picture(&args.output, *frame, choice);
            frames.iter().map(picture).collect()
        })
        .collect();
    names::check_distinct(pictures.iter().flatten())?;
    if let Some(folder) = args.output.parent() {
        fs::create_dir_all(folder).map_err(|e| Problem::io(folder, "creating the folder", &e))?;
    }

    let mut base = match &args.input {
        Some(path) => super::open(path, &args.groom, console)?,
        None => Document::sample()?.document,
    };
    let (project, folder) = (base.project().clone(), base.folder().to_owned());
    cancel::on_request();
    let mut gpu = None;
    let mut done = Done::default();
    for (choice, pictures) in choices.iter().zip(&pictures) {
        let mut varied;
        let document = if choice.is_empty() {
            &mut base
        } else {
            varied = Document::open_project(wedge::varied(&project, choice)?, &folder)?.document;
            &mut varied
        };
        let mut hair = document.project().hair.clone();
        for option in &args.settings {
            option.apply(&mut hair).map_err(CliError::Usage)?;
        }
        document.apply(Edit::SetHair(hair))?;
        document.apply(Edit::SetLight(args.light.applied_to(document)))?;
        let settings = scene::settings(args, document);
        let jobs = jobs(args, document, &settings, &frames, pictures)?;
        if jobs.iter().all(|job| job.is_there) {
            done.pictures
                .extend(jobs.into_iter().map(|job| Made::before(job.path)));
            continue;
        }
        // Adapters are asked for before the fit: without one nothing is worth waiting for.
        let gpu: &Gpu = match &mut gpu {
            Some(gpu) => gpu,
            none => none.insert(Gpu::headless()?),
        };
        render(args, document, gpu, &settings, jobs, &mut done, console)?;
    }
    Ok(print(&done, console)?)
}

/// A picture to be made.
struct Job {
    path: PathBuf,
    camera: Camera,
    metadata: Metadata,
    /// True where it was made before and is kept.
    is_there: bool,
}

/// The pictures of a document.
fn jobs(
    args: &RenderArgs,
    document: &Document,
    settings: &RenderSettings,
    frames: &[Option<u32>],
    pictures: &[PathBuf],
) -> Result<Vec<Job>, CliError> {
    let camera = scene::camera(args.camera.as_deref(), args.size, document)?;
    let record = Record::of(document, args, settings)?;
    let last = frames.last().copied().flatten();
    let job = |(frame, path): (&Option<u32>, &PathBuf)| {
        let turn = match (args.turntable, frame) {
            (Some(period), Some(frame)) => {
                let period = if period == 0 { last.unwrap_or(1) } else { period };
                *frame as f32 / period.max(1) as f32 * std::f32::consts::TAU
            }
            _ => 0.0,
        };
        let camera = scene::turned(camera, turn, document);
        let metadata = record.metadata(&camera, *frame);
        Job {
            is_there: args.resume && record::is_complete(path, &metadata),
            path: path.clone(),
            camera,
            metadata,
        }
    };
    Ok(frames.iter().zip(pictures).map(job).collect())
}

/// A picture that is there.
struct Made {
    path: PathBuf,
    /// What it cost; none where it was there before.
    cost: Option<FrameReport>,
    /// What its false colours mean.
    legend: Option<String>,
}

impl Made {
    fn before(path: PathBuf) -> Self {
        Self {
            path,
            cost: None,
            legend: None,
        }
    }
}

/// What was done, for the report.
#[derive(Default)]
struct Done {
    pictures: Vec<Made>,
    /// Adapter, strands, points, lights and seconds of the fit, of what was rendered last.
    scene: Option<(String, [usize; 3], Option<f64>)>,
}

/// Makes the pictures of a document that are not there.
fn render(
    args: &RenderArgs,
    document: &Document,
    gpu: &Gpu,
    settings: &RenderSettings,
    jobs: Vec<Job>,
    done: &mut Done,
    console: &mut Console<'_>,
) -> Result<(), CliError> {
    let format = Format::of(&args.output)?;
    let lighting = scene::load_light(document, console)?;
    let volume = VolumeSettings {
        voxel_spacings: args.voxel_spacings,
        ..VolumeSettings::default()
    };
    let mut renderer = scene::scene(
        gpu,
        document,
        &lighting,
        args.background == BackgroundName::Env,
        volume,
    )?;
    let progress = console.progress(jobs.len() as u64, "rendering");
    let mut bad_pixels = 0;
    for (i, job) in jobs.into_iter().enumerate() {
        let mut made = Made::before(job.path.clone());
        if !job.is_there {
            let (drawn, cost) = match args.debug_view {
                Some(view) => Drawn::false_colours(&mut renderer, &job.camera, args.size, settings, view)?,
                None => Drawn::picture(&mut renderer, &job.camera, args.size, settings, format)?,
            };
            bad_pixels += drawn.bad_pixels;
            write(&drawn, &job)?;
            made.cost = Some(cost);
            made.legend = drawn.legend;
        }
        done.pictures.push(made);
        progress.at(i as u64 + 1);
    }
    drop(progress);

    if bad_pixels > 0 {
        console.warn(&format!(
            "{bad_pixels} pixels are not finite; they are magenta: please report the project"
        ));
    }
    let groom = document.groom();
    let counts = [
        groom.strand_count(),
        groom.point_count(),
        lighting.lights.lights.len(),
    ];
    done.scene = Some((gpu.adapter_name.clone(), counts, lighting.fit_seconds));
    Ok(())
}

/// Writes a picture, all of it or nothing.
fn write(drawn: &Drawn, job: &Job) -> Result<(), CliError> {
    let bytes = drawn.bytes(&job.path, &job.metadata)?;
    let mut written = cancel::writing();
    files::write_atomic(&job.path, &bytes)?;
    *written += 1;
    Ok(())
}

/// Says what was rendered and what it cost.
fn print(done: &Done, console: &mut Console<'_>) -> std::io::Result<()> {
    let frames: Vec<_> = done
        .pictures
        .iter()
        .map(|Made { path, cost, legend }| match cost {
            Some(cost) => {
                let mut frame = json!({"picture": path, "passes_ms": pairs(&cost.passes), "counters": pairs(&cost.counters)});
                if !cost.shaders.is_empty() {
                    frame["gpu_ms"] = json!(pairs(&cost.shaders));
                }
                if let Some(legend) = legend {
                    frame["legend"] = json!(legend);
                }
                frame
            }
            None => json!({"picture": path, "kept": true}),
        })
        .collect();
    let mut value = json!({ "frames": frames });
    let mut text = String::new();
    if let Some((adapter, [strands, points, lights], fit_seconds)) = &done.scene {
        value["adapter"] = json!(adapter);
        value["strands"] = json!(strands);
        value["points"] = json!(points);
        value["lights"] = json!(lights);
        value["fit_seconds"] = json!(fit_seconds);
        text = format!("{strands} strands, {points} points, {lights} lights, {adapter}\n");
    }
    for Made { path, cost, legend } in &done.pictures {
        let report = cost.clone().unwrap_or_default();
        for (pass, ms) in &report.passes {
            text += &format!("  {pass:<24} {ms:>10.1} ms\n");
        }
        for (counter, n) in &report.counters {
            text += &format!("  {counter:<24} {n:>10}\n");
        }
        let kept = if cost.is_none() { " (kept)" } else { "" };
        text += &format!("{}{kept}\n", path.display());
        if let Some(legend) = legend {
            text += &format!("  {legend}\n");
        }
    }
    console.result(value, &text.trim_end())
}

/// Named values as a JSON object.
fn pairs<T: Clone + Into<serde_json::Value>>(
    values: &[(String, T)],
) -> serde_json::Map<String, serde_json::Value> {
    values
        .iter()
        .map(|(name, value)| (name.clone(), value.clone().into()))
        .collect()
}
