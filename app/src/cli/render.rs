//! `balayage render`: pictures without a window.

use std::{
    ops::{ControlFlow, RangeInclusive},
    path::{Path, PathBuf},
};

use balayage_render::{
    gpu::{
        Camera, CameraFile, FrameReport, Gpu, Method, Model, Quality, RenderSettings, Renderer,
        ShadeSettings, Terms, ViewTransform,
    },
    image::write_png,
};
use clap::{Args, ValueEnum};
use glam::Mat4;
use serde_json::json;

use super::{
    CliError, Console,
    hair_option::HairOption,
    light_options::LightOptions,
    method_options::{MethodOptions, ModelName, MultipleName},
};
use crate::{
    Problem,
    document::{CameraPose, Document, Edit, Lighting, check_camera, files},
};

#[derive(Args)]
pub(super) struct RenderArgs {
    /// Project (.json) or groom; the built-in sample if absent.
    input: Option<PathBuf>,
    /// Picture to write: .png as seen on a display, .exr scene-linear.
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
    #[arg(long, value_enum, default_value_t = MultipleName::M3)]
    multiple: MultipleName,
    /// Exact rays per point and light that shadows come from; 0: the density of the hair. [default: 64 with --quality high, else 0]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=1024))]
    visibility_rays: Option<u32>,
    /// Shadows from 256 exact rays per point and light.
    #[arg(long, conflicts_with = "visibility_rays")]
    reference_visibility: bool,
    /// Unpainted parameters, as eumelanin=1.3; repeat for more.
    #[arg(long = "set", value_name = "CHANNEL=VALUE")]
    settings: Vec<HairOption>,
    /// Metres per unit of the groom's file.
    #[arg(long, value_name = "X")]
    metres_per_unit: Option<f32>,
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

/// What the extension of the output asks for.
#[derive(Clone, Copy, PartialEq)]
enum Format {
    Png,
    Exr,
}

impl Format {
    fn of(path: &Path) -> Result<Self, CliError> {
        let extension = path
            .extension()
            .unwrap_or_default()
            .to_string_lossy()
            .to_ascii_lowercase();
        match extension.as_str() {
            "png" => Ok(Self::Png),
            "exr" => Ok(Self::Exr),
            _ => Err(CliError::Usage(format!(
                "--output {}: the extension names no picture format; write .png or .exr",
                path.display()
            ))),
        }
    }
}

pub(super) fn run(args: &RenderArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let format = Format::of(&args.output)?;
    let mut document = match &args.input {
        Some(path) => super::open(path, args.metres_per_unit, console)?,
        None => Document::sample()?.document,
    };
    let mut hair = document.project().hair.clone();
    for option in &args.settings {
        option.apply(&mut hair).map_err(CliError::Usage)?;
    }
    document.apply(Edit::SetHair(hair))?;
    document.apply(Edit::SetLight(args.light.applied_to(&document)))?;
    let camera = camera(args.camera.as_deref(), args.size, &document)?;

    // Adapters are asked for before the fit: without one nothing is worth waiting for.
    let gpu = Gpu::headless()?;
    let lighting = load_light(&document, console)?;
    let mut renderer = scene(&gpu, &document, &lighting, args.background == BackgroundName::Env)?;
    let settings = settings(args, &document);

    // One picture, or one for every frame of the turntable.
    let mut pictures = Vec::new();
    let mut reports = Vec::new();
    let range = args.frames.clone().unwrap_or(0..=0);
    let count = u64::from(range.end() - range.start()) + 1;
    let progress = console.progress(count, "rendering");
    for (i, frame) in range.clone().enumerate() {
        let path = if args.frames.is_some() {
            numbered(&args.output, frame)
        } else {
            args.output.clone()
        };
        let turn = match args.turntable {
            Some(period) => {
                let period = if period == 0 { *range.end() } else { period };
                frame as f32 / period.max(1) as f32 * std::f32::consts::TAU
            }
            None => 0.0,
        };
        reports.push(renderer.render(&turned(camera, turn, &document), args.size, &settings)?);
        write(&renderer, &path, args.size, format)?;
        pictures.push(path);
        progress.at(i as u64 + 1);
    }
    drop(progress);

    let bad_pixels = renderer.non_finite()?;
    if bad_pixels > 0 {
        console.warn(&format!(
            "{bad_pixels} pixels are not finite; they are magenta: please report the project"
        ));
    }
    print(&pictures, &reports, &gpu, &document, &lighting, console)
}

/// The camera that the option, the project or the hair asks for, in that order.
pub(super) fn camera(
    file: Option<&Path>,
    [width, height]: [u32; 2],
    document: &Document,
) -> Result<Camera, CliError> {
    let pose = match file {
        Some(file) => {
            let text = files::read_text(file, 1 << 20)?;
            let pose: CameraPose =
                serde_json::from_str(&text).map_err(|e| Problem::json(&e).in_file(file))?;
            check_camera(&pose).map_err(|p| p.in_file(file))?;
            Some(pose)
        }
        None => document.project().camera.clone(),
    };
    match pose {
        Some(pose) => {
            let file = CameraFile {
                world_from_camera: pose.world_from_camera,
                fov_y_deg: pose.fov_y_deg,
            };
            Camera::try_from(file).map_err(CliError::Input)
        }
        None => Ok(Camera::framing(
            document.groom().bounds(),
            width as f32 / height as f32,
        )),
    }
}

/// The camera after a turn about the vertical axis through the middle of the hair.
fn turned(camera: Camera, angle_rad: f32, document: &Document) -> Camera {
    if angle_rad == 0.0 {
        return camera;
    }
    let (low, high) = document.groom().bounds();
    let middle = 0.5 * (low + high);
    let turn =
        Mat4::from_translation(middle) * Mat4::from_rotation_y(angle_rad) * Mat4::from_translation(-middle);
    Camera {
        world_from_camera: turn * camera.world_from_camera,
        ..camera
    }
}

pub(super) fn load_light(document: &Document, console: &mut Console<'_>) -> Result<Lighting, CliError> {
    let progress = console.progress(1000, "fitting lights");
    let lighting = Lighting::load(
        document.project(),
        None,
        |reference| document.resolve(reference),
        &|done| {
            progress.at((done * 1000.0) as u64);
            ControlFlow::Continue(())
        },
    )?;
    drop(progress);
    for warning in &lighting.warnings {
        console.warn(warning);
    }
    Ok(lighting)
}

/// A renderer that holds the document.
pub(super) fn scene(
    gpu: &Gpu,
    document: &Document,
    lighting: &Lighting,
    show_environment: bool,
) -> Result<Renderer, CliError> {
    let head = document.load_head()?;
    let light = &document.project().light;
    let mut renderer = Renderer::new(gpu)?;
    renderer.set_groom(&*document.groom_as_drawn()?, head.as_ref())?;
    renderer.set_params(document.params(), &[])?;
    renderer.set_lights(&lighting.exposed(light))?;
    if show_environment {
        renderer.set_background(lighting.map.as_deref())?;
        renderer.turn_background(light.rotation_deg.to_radians(), light.factor());
    }
    Ok(renderer)
}

/// Rays of `--reference-visibility`.
const REFERENCE_RAYS: u32 = 256;
/// Rays of `--quality high`.
const HIGH_RAYS: u32 = 64;

fn settings(args: &RenderArgs, document: &Document) -> RenderSettings {
    let hair = &document.project().hair;
    let method = args.method.method(hair.scheme);
    let usual_rays = if method.quality == Quality::High {
        HIGH_RAYS
    } else {
        0
    };
    RenderSettings {
        shade: ShadeSettings {
            method: Method {
                model: args.model.map_or(hair.model, Model::from),
                ..method
            },
            multiple: args.multiple.into(),
            terms: args.terms,
        },
        samples: args.samples,
        view: match args.view {
            ViewName::Neutral => ViewTransform::Neutral,
            ViewName::Agx => ViewTransform::Agx,
            ViewName::Raw => ViewTransform::Raw,
        },
        show_background: args.background == BackgroundName::Env,
        visibility_rays: if args.reference_visibility {
            REFERENCE_RAYS
        } else {
            args.visibility_rays.unwrap_or(usual_rays)
        },
        // A PNG is looked at: what is not covered is black there. An EXR keeps its alpha.
        backdrop: [0.0, 0.0, 0.0, 1.0],
        ..RenderSettings::default()
    }
}

/// `out.png` and 7 give `out-0007.png`.
fn numbered(path: &Path, frame: u32) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{frame:04}.{extension}"))
}

fn write(
    renderer: &Renderer,
    path: &Path,
    [width, height]: [u32; 2],
    format: Format,
) -> Result<(), CliError> {
    match format {
        Format::Exr => renderer.picture()?.write_exr(path)?,
        Format::Png => write_png(path, width as usize, height as usize, &renderer.shown_bytes()?)?,
    }
    Ok(())
}

/// Says what was rendered and what it cost.
fn print(
    pictures: &[PathBuf],
    reports: &[FrameReport],
    gpu: &Gpu,
    document: &Document,
    lighting: &Lighting,
    console: &mut Console<'_>,
) -> Result<(), CliError> {
    let groom = document.groom();
    let lights = lighting.lights.lights.len();
    let frames: Vec<_> = pictures
        .iter()
        .zip(reports)
        .map(|(path, report)| json!({"picture": path, "passes_ms": pairs(&report.passes), "counters": pairs(&report.counters)}))
        .collect();
    let value = json!({
        "adapter": gpu.adapter_name,
        "strands": groom.strand_count(),
        "points": groom.point_count(),
        "lights": lights,
        "fit_seconds": lighting.fit_seconds,
        "frames": frames,
    });

    let mut text = format!(
        "{} strands, {} points, {lights} lights, {}\n",
        groom.strand_count(),
        groom.point_count(),
        gpu.adapter_name
    );
    for (path, report) in pictures.iter().zip(reports) {
        for (pass, ms) in &report.passes {
            text += &format!("  {pass:<24} {ms:>10.1} ms\n");
        }
        for (counter, n) in &report.counters {
            text += &format!("  {counter:<24} {n:>10}\n");
        }
        text += &format!("{}\n", path.display());
    }
    Ok(console.result(value, &text.trim_end())?)
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
