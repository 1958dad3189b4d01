//! LIGHTS.json: reading with validation, writing.

use std::path::Path;

use glam::Vec3;
use serde::Deserialize;
use serde_json::Value;

use super::error::Refusal;
use super::{InputError, LightSet, MAX_BANDWIDTH, SrbfLight};

/// How far the length of a direction may be from one before it is taken for a mistake; what is within is normalised.
const UNIT_TOLERANCE: f32 = 0.01;

/// The file as it stands, lights not yet looked at, so that a bad light can be named by its index.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    lights: Vec<Value>,
    #[serde(default)]
    constant: Vec3,
}

impl LightSet {
    /// Reads and validates a LIGHTS.json.
    ///
    /// # Errors
    /// [`InputError`] where the file cannot be read, is no JSON, or [`LightSet::from_json`] refuses a value.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let text = std::fs::read_to_string(path).map_err(|error| {
            Refusal::new(
                "whole file",
                error.to_string(),
                "check the path and its permissions",
            )
            .of(path)
        })?;
        Self::from_json(&text, path)
    }

    /// Parses and validates the text of a LIGHTS.json; `name` stands for the file in errors.
    ///
    /// # Errors
    /// [`InputError`] that names the light (counted from 0), the field, the reason and the remedy: directions must be unit
    /// vectors to 1 % (they are normalised), bandwidths in (0, 10], radiances finite and not negative.
    pub fn from_json(text: &str, name: &Path) -> Result<Self, InputError> {
        let raw: Raw = serde_json::from_str(text).map_err(|error| {
            let place = format!("line {}, column {}", error.line(), error.column());
            let remedy = r#"write {"lights": [{"direction": [x,y,z], "bandwidth": lambda, "radiance": [r,g,b]}], "constant": [r,g,b]}"#;
            Refusal::new(place, error.to_string(), remedy).of(name)
        })?;

        let mut lights = Vec::with_capacity(raw.lights.len());
        for (index, value) in raw.lights.into_iter().enumerate() {
            let light: SrbfLight = serde_json::from_value(value).map_err(|error| {
                let remedy = "a light has direction [x,y,z], bandwidth and radiance [r,g,b], all numbers";
                Refusal::new(format!("light {index}"), error.to_string(), remedy).of(name)
            })?;
            lights.push(light);
        }
        let set = Self {
            lights,
            constant: raw.constant,
        };
        set.validated().map_err(|refusal| refusal.of(name))
    }

    /// The set with normalised directions, or what is wrong with it.
    fn validated(mut self) -> Result<Self, Refusal> {
        radiance_checked("constant", self.constant)?;
        for (index, light) in self.lights.iter_mut().enumerate() {
            let field = |name: &str| format!("light {index}, {name}");

            // A length far from one says that something else was written than a direction.
            let length = light.direction.length();
            let is_unit = (length - 1.0).abs() <= UNIT_TOLERANCE;
            if !is_unit {
                let reason = format!("length {length} is not 1");
                return Err(Refusal::new(
                    field("direction"),
                    reason,
                    "give a unit vector towards the light",
                ));
            }
            light.direction /= length;

            if !(light.bandwidth > 0.0 && light.bandwidth <= MAX_BANDWIDTH) {
                let reason = format!("{} is not in (0, {MAX_BANDWIDTH}]", light.bandwidth);
                let remedy = "give lambda of exp(2 (w . d - 1) / lambda^2) in radians; a uniform light is \"constant\"";
                return Err(Refusal::new(field("bandwidth"), reason, remedy));
            }
            radiance_checked(&field("radiance"), light.radiance)?;
        }
        Ok(self)
    }

    /// The text of a LIGHTS.json that [`LightSet::from_json`] reads back exactly.
    pub fn to_json(&self) -> String {
        let light = |light: &SrbfLight| {
            serde_json::json!({
                "direction": light.direction.to_array(),
                "bandwidth": light.bandwidth,
                "radiance": light.radiance.to_array(),
            })
            .to_string()
        };
        let lights: Vec<String> = self.lights.iter().map(light).collect();
        let constant = serde_json::json!(self.constant.to_array());
        format!(
            "{{\"lights\": [\n  {}\n], \"constant\": {constant}}}\n",
            lights.join(",\n  ")
        )
    }

    /// Writes a LIGHTS.json.
    ///
    /// # Errors
    /// [`InputError`] where a value would not be read back (see [`LightSet::from_json`]) or the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), InputError> {
        self.clone().validated().map_err(|refusal| refusal.of(path))?;
        std::fs::write(path, self.to_json()).map_err(|error| {
            Refusal::new(
                "whole file",
                error.to_string(),
                "choose a folder that can be written",
            )
            .of(path)
        })
    }
}

/// Refuses a radiance that is not finite or below zero.
fn radiance_checked(place: &str, radiance: Vec3) -> Result<(), Refusal> {
    if radiance.is_finite() && radiance.min_element() >= 0.0 {
        return Ok(());
    }
    let reason = format!("{:?} is not finite and at least 0", radiance.to_array());
    Err(Refusal::new(
        place,
        reason,
        "give linear Rec.709 radiance, each channel finite and not negative",
    ))
}
