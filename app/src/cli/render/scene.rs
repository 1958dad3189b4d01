//! What is rendered and how: camera, light, renderer and settings from options and document.

use std::{ops::ControlFlow, path::Path};

use balayage_render::gpu::{
    Camera, CameraFile, Gpu, Method, Model, Quality, RenderSettings, Renderer, ShadeSettings, ViewTransform,
};
use balayage_render::volume::VolumeSettings;
use glam::Mat4;

use super::{BackgroundName, CliError, Console, RenderArgs, TransmittanceName, ViewName};
use crate::{
    Problem,
    document::{CameraPose, Document, Lighting, check_camera, files},
};

/// The camera that the option, the project or the hair asks for, in that order.
pub(in crate::cli) fn camera(
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
pub(super) fn turned(camera: Camera, angle_rad: f32, document: &Document) -> Camera {
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

/// The light of a document, fitted where it is a map.
pub(in crate::cli) fn load_light(
    document: &Document,
    console: &mut Console<'_>,
) -> Result<Lighting, CliError> {
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
pub(in crate::cli) fn scene(
    gpu: &Gpu,
    document: &Document,
    lighting: &Lighting,
    show_environment: bool,
    volume: VolumeSettings,
) -> Result<Renderer, CliError> {
    let head = document.load_head()?;
    let light = &document.project().light;
    let mut renderer = Renderer::new(gpu)?;
    renderer.set_volume(volume);
    renderer.set_groom(&*document.groom_as_drawn()?, head.as_ref())?;
    renderer.set_params(document.params(), &[])?;
    renderer.set_lights(&lighting.exposed(light));
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

/// How pictures are drawn.
pub(super) fn settings(args: &RenderArgs, document: &Document) -> RenderSettings {
    let hair = &document.project().hair;
    let method = args.method.method(hair.scheme);
    let usual_rays = if method.quality == Quality::High && args.transmittance == TransmittanceName::Voxel {
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
            visibility: args.transmittance.into(),
        },
        samples: args.samples,
        savings: args.savings,
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
