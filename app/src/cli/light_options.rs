//! The options that choose the light, shared by everything that renders.

use std::path::PathBuf;

use balayage_render::light::PRESETS;
use clap::Args;

use crate::document::{Document, Environment, LightSettings};

/// Which light, how it is turned and exposed; what is not given stays as the project has it.
#[derive(Args)]
pub(super) struct LightOptions {
    /// Environment map (.hdr, .exr), or preset:NAME: afternoon, noon, golden-hour, dusk, overcast, three-point, uniform.
    #[arg(long, value_name = "MAP", conflicts_with = "lights", value_parser = map_or_preset)]
    env: Option<MapOrPreset>,
    /// SRBF lights that are fitted to the map [default: 40].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    light_count: Option<u32>,
    /// Light list.
    #[arg(long, value_name = "LIGHTS.json")]
    lights: Option<PathBuf>,
    /// Rotation of the environment about the vertical axis, degrees.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = finite)]
    rotate: Option<f32>,
    /// Exposure in stops.
    #[arg(long, value_name = "EV", allow_negative_numbers = true, value_parser = finite)]
    exposure: Option<f32>,
}

/// Where `--env` takes light from.
#[derive(Clone)]
enum MapOrPreset {
    Map(PathBuf),
    Preset(String),
}

/// A path, or a preset that exists.
fn map_or_preset(text: &str) -> Result<MapOrPreset, String> {
    match text.strip_prefix("preset:") {
        None => Ok(MapOrPreset::Map(PathBuf::from(text))),
        Some(name) if PRESETS.contains(&name) => Ok(MapOrPreset::Preset(name.to_owned())),
        Some(_) => Err(format!("the presets are {}", PRESETS.join(", "))),
    }
}

/// A number that is neither NaN nor infinite.
pub(super) fn finite(text: &str) -> Result<f32, String> {
    let x: f32 = text.parse().map_err(|e| format!("{e}"))?;
    if x.is_finite() {
        Ok(x)
    } else {
        Err("the number is not finite".to_owned())
    }
}

impl LightOptions {
    /// True where another light than the project's is asked for.
    pub(super) fn is_given(&self) -> bool {
        self.env.is_some() || self.lights.is_some()
    }

    /// The document's light with the options applied.
    pub(super) fn applied_to(&self, document: &Document) -> LightSettings {
        let mut light = document.project().light.clone();
        // Another light is asked for than the project's: the lights made for that one do not shine in it.
        let environment = self.env.as_ref().map(|map| match map {
            MapOrPreset::Map(path) => Environment::Map(document.reference_to(path)),
            MapOrPreset::Preset(name) => Environment::Preset(name.clone()),
        });
        let lights = self
            .lights
            .as_ref()
            .map(|lights| Environment::Lights(document.reference_to(lights)));
        if let Some(environment) = environment.or(lights) {
            light.environment = environment;
            light.hand.clear();
        }
        light.light_count = self.light_count.unwrap_or(light.light_count);
        light.rotation_deg = self.rotate.unwrap_or(light.rotation_deg);
        light.exposure_ev = self.exposure.unwrap_or(light.exposure_ev);
        light
    }
}
