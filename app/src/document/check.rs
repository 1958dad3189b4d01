//! What a project may hold: every number finite and in its range, every name unique.

use balayage_render::light::{MAX_BANDWIDTH, MAX_LIGHTS, PRESETS, SrbfLight};
use balayage_render::param::{Channel, LobeRatios};
use glam::Mat3;

use super::{
    hand_light::{HandLight, MAX_HAND_LIGHTS},
    project::{
        CameraPose, Dye, Environment, HairSettings, Layer, LightSettings, MAX_LAYERS, PROJECT_VERSION,
        Project, Sequence,
    },
    sequence::MAX_MAPS,
};
use crate::{
    paint,
    problem::{Problem, within},
};

/// Checks a whole project.
pub(super) fn check_project(project: &Project) -> Result<(), Problem> {
    if project.version == 0 || project.version > PROJECT_VERSION {
        return Err(Problem::at(
            "version",
            format!(
                "project version {} is not one of 1 to {PROJECT_VERSION}",
                project.version
            ),
            "open it with a newer Balayage",
        ));
    }
    if project.groom.path.is_empty() {
        return Err(Problem::at(
            "groom.path",
            "no groom is named",
            "name a .hair or .tfx file",
        ));
    }
    if let Some(metres) = project.groom.metres_per_unit {
        within("groom.metres_per_unit", metres, 1e-6..=1e6)?;
    }
    check_light(&project.light)?;
    if let Some(camera) = &project.camera {
        check_camera(camera).map_err(|p| Problem {
            place: format!("camera.{}", p.place),
            ..p
        })?;
    }
    check_hair(&project.hair)?;
    check_layers(&project.layers)?;
    check_dyes(&project.dyes)?;
    paint::check_operations(&project.operations)
}

/// Checks what lights the hair.
pub(super) fn check_light(light: &LightSettings) -> Result<(), Problem> {
    if !(1..=MAX_LIGHTS as u32).contains(&light.light_count) {
        let reason = format!("{} lights", light.light_count);
        let remedy = format!("ask for 1 to {MAX_LIGHTS} lights");
        return Err(Problem::at("light.light_count", reason, remedy));
    }
    if let Some(target) = light.target_error {
        within("light.target_error", target, 1e-6..=1.0)?;
    }
    within("light.rotation_deg", light.rotation_deg, -36_000.0..=36_000.0)?;
    within("light.exposure_ev", light.exposure_ev, -30.0..=30.0)?;
    light
        .tint
        .iter()
        .try_for_each(|x| within("light.tint", *x, 0.0..=1e3))?;
    check_hand(&light.hand)?;
    match &light.environment {
        Environment::Sky => Ok(()),
        Environment::Preset(name) if PRESETS.contains(&name.as_str()) => Ok(()),
        Environment::Preset(name) => Err(Problem::at(
            "light.environment.preset",
            format!("there is no preset {name:?}"),
            format!("name one of {}", PRESETS.join(", ")),
        )),
        Environment::Constant(rgb) => rgb
            .iter()
            .try_for_each(|x| within("light.environment.constant", *x, 0.0..=1e6)),
        Environment::Map(path) | Environment::Lights(path) if path.is_empty() => Err(Problem::at(
            "light.environment",
            "the path is empty",
            "name a file or choose \"sky\"",
        )),
        Environment::Map(_) | Environment::Lights(_) => Ok(()),
        Environment::Sequence(sequence) => check_sequence(sequence),
    }
}

fn check_sequence(sequence: &Sequence) -> Result<(), Problem> {
    let place = "light.environment.sequence";
    if sequence.maps.is_empty() || sequence.maps.len() > MAX_MAPS {
        let reason = format!("{} maps", sequence.maps.len());
        let remedy = format!("name 1 to {MAX_MAPS} maps");
        return Err(Problem::at(format!("{place}.maps"), reason, remedy));
    }
    if let Some(i) = sequence.maps.iter().position(String::is_empty) {
        let place = format!("{place}.maps[{i}]");
        return Err(Problem::at(place, "the path is empty", "name a file"));
    }
    within(&format!("{place}.fps"), sequence.fps, 0.01..=240.0)
}

/// Checks the lights made by hand.
fn check_hand(hand: &[HandLight]) -> Result<(), Problem> {
    if hand.len() > MAX_HAND_LIGHTS {
        let reason = format!("{} lights", hand.len());
        let remedy = format!("use at most {MAX_HAND_LIGHTS}");
        return Err(Problem::at("light.hand", reason, remedy));
    }
    for (i, light) in hand.iter().enumerate() {
        let place = |field: &str| format!("light.hand[{i}].{field}");
        if light.name.is_empty() || hand[..i].iter().any(|other| other.name == light.name) {
            let reason = format!("the name \"{}\" is empty or taken", light.name);
            return Err(Problem::at(
                place("name"),
                reason,
                "give every light a name of its own",
            ));
        }
        for (field, light) in [("light", &light.light), ("replaces", &light.replaces)] {
            if let Some(light) = light {
                check_srbf(&place(field), light)?;
            }
        }
    }
    Ok(())
}

fn check_srbf(place: &str, light: &SrbfLight) -> Result<(), Problem> {
    let length = light.direction.length();
    let is_unit = (length - 1.0).abs() <= 1e-3;
    if !is_unit {
        return Err(Problem::at(
            format!("{place}.direction"),
            format!("length {length} is not 1"),
            "give a unit vector towards the light",
        ));
    }
    within(
        &format!("{place}.bandwidth"),
        light.bandwidth,
        1e-3..=MAX_BANDWIDTH,
    )?;
    let mut radiance = light.radiance.to_array().into_iter();
    radiance.try_for_each(|x| within(&format!("{place}.radiance"), x, 0.0..=1e9))
}

/// Checks the parameters of unpainted hair.
pub(crate) fn check_hair(hair: &HairSettings) -> Result<(), Problem> {
    if let Some((channel, value)) = hair.base.known.out_of_range() {
        return within(&format!("hair.base.{}", channel.name()), value, channel.range());
    }
    check_ratios("hair.ratios", &hair.ratios.known)?;
    if let Err(reason) = hair.scheme.checked() {
        return Err(Problem::at(
            "hair.scheme",
            reason,
            "choose a number in that range",
        ));
    }
    match hair.diameter {
        Some(diameter) => within("hair.diameter", diameter, 1e-9..=1e6),
        None => Ok(()),
    }
}

/// Dyes above this number are refused.
const MAX_DYES: usize = 200;

/// Checks the dye library.
pub(super) fn check_dyes(dyes: &[Dye]) -> Result<(), Problem> {
    if dyes.len() > MAX_DYES {
        let reason = format!("{} dyes", dyes.len());
        return Err(Problem::at("dyes", reason, format!("use at most {MAX_DYES}")));
    }
    dyes.iter().enumerate().try_for_each(|(i, dye)| {
        dye.sigma_a
            .iter()
            .try_for_each(|x| within(&format!("dyes[{i}].sigma_a"), *x, Channel::Dye.range()))
    })
}

/// Checks the ratios of TT's and TRT's tilt and width to R's.
fn check_ratios(place: &str, ratios: &LobeRatios) -> Result<(), Problem> {
    within(&format!("{place}.alpha_tt"), ratios.alpha_tt, -100.0..=100.0)?;
    within(&format!("{place}.alpha_trt"), ratios.alpha_trt, -100.0..=100.0)?;
    within(&format!("{place}.beta_tt"), ratios.beta_tt, 0.01..=100.0)?;
    within(&format!("{place}.beta_trt"), ratios.beta_trt, 0.01..=100.0)
}

/// Checks the list of layers.
pub(super) fn check_layers(layers: &[Layer]) -> Result<(), Problem> {
    if layers.len() > MAX_LAYERS {
        let reason = format!("{} layers", layers.len());
        return Err(Problem::at("layers", reason, format!("use at most {MAX_LAYERS}")));
    }
    for (i, layer) in layers.iter().enumerate() {
        let place = |field: &str| format!("layers[{i}].{field}");
        if layer.id.is_empty() {
            return Err(Problem::at(
                place("id"),
                "the layer's id is empty",
                "give every layer an id",
            ));
        }
        if layers[..i].iter().any(|other| other.id == layer.id) {
            let reason = format!("a second layer has the id \"{}\"", layer.id);
            return Err(Problem::at(
                place("id"),
                reason,
                "give every layer an id of its own",
            ));
        }
        within(&place("opacity"), layer.opacity, 0.0..=1.0)?;
        layer.mask.check(&place("mask"))?;
        if let Some(ratios) = &layer.ratios {
            check_ratios(&place("ratios"), &ratios.known)?;
        }
    }
    Ok(())
}

/// Checks that a camera is a rigid motion (with one scale) and a usable field of view.
///
/// # Errors
/// Names the field.
pub fn check_camera(camera: &CameraPose) -> Result<(), Problem> {
    within("fov_y_deg", camera.fov_y_deg, 0.1..=170.0)?;
    let rows = camera.world_from_camera;
    rows.iter()
        .flatten()
        .try_for_each(|x| within("world_from_camera", *x, -1e6..=1e6))?;
    let problem = |reason: &str, remedy: &str| Err(Problem::at("world_from_camera", reason, remedy));
    if rows[3] != [0.0, 0.0, 0.0, 1.0] {
        return problem(
            "the last row is not 0, 0, 0, 1",
            "write the matrix row after row, for column vectors",
        );
    }
    let linear = Mat3::from_cols_array_2d(&std::array::from_fn(|c| std::array::from_fn(|r| rows[r][c])));
    let gram = linear.transpose() * linear;
    let rigid = gram.abs_diff_eq(Mat3::IDENTITY, 1e-3) && linear.determinant() > 0.0;
    if rigid {
        Ok(())
    } else {
        problem(
            "the upper 3x3 block is no rotation",
            "give it orthonormal columns",
        )
    }
}
