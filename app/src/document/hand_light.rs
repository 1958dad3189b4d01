//! Lights made or changed by hand: they stay as they are whatever is fitted anew.
//!
//! They live in the space of the environment, before its rotation, exposure and tint. A light that was taken from the fit keeps
//! what it stands for: as much energy as that goes out of the fitted lights that lie there. Straight after the edit this
//! removes exactly the one light; after another fit (a new count, the next map of a sequence) it removes the same energy from
//! those that took its place, so that nothing shines twice. Lights are a pure function of settings and fit.

use std::f64::consts::PI;

use balayage_render::light::{LightSet, SrbfLight};
use glam::{DVec3, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::project::{Environment, LightSettings};
use crate::paint::Extra;

/// Hand-made lights above this number are refused: each costs as much as a fitted one.
pub const MAX_HAND_LIGHTS: usize = 256;

/// How much two lights must overlap for one to stand in the place of the other: cosine of the angle between them as functions
/// on the sphere; two narrow lights of one bandwidth reach it 1.67 bandwidths apart.
const SAME_PLACE: f64 = 0.25;

/// A light that a person made or changed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HandLight {
    /// What a person calls it; no two hand-made lights have the same name.
    pub name: String,
    /// The light; null for one that was deleted, which only takes away what it replaces.
    pub light: Option<SrbfLight>,
    /// The light of the environment that it stands for; null for one that was added.
    #[serde(default)]
    pub replaces: Option<SrbfLight>,
    /// True takes it out of the picture.
    #[serde(default)]
    pub muted: bool,
    /// True for any light takes out those that have it not.
    #[serde(default)]
    pub solo: bool,
    /// Unknown fields.
    #[serde(flatten)]
    pub extra: Extra,
}

/// Names one of the lights of an environment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LightId {
    /// A fitted light, by its index in the fit.
    Fitted(usize),
    /// A hand-made light, by its name.
    Hand(String),
}

/// A light as a person sees it in a list.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedLight {
    /// Which one.
    pub id: LightId,
    /// What a person calls it.
    pub name: String,
    /// The light, in the space of the environment.
    pub light: SrbfLight,
    /// Taken out by hand.
    pub muted: bool,
    /// Alone by hand.
    pub solo: bool,
    /// It is in the picture.
    pub shines: bool,
}

impl LightSettings {
    /// The lights of the picture before rotation, exposure and tint: those of the fit that no hand touched, and the hand's.
    pub fn edited(&self, fitted: &LightSet) -> LightSet {
        let is_solo = self.has_solo();
        let lights = self
            .listed(fitted)
            .into_iter()
            .filter(|listed| listed.shines)
            .map(|listed| listed.light)
            .collect();
        LightSet {
            lights,
            constant: if is_solo { Vec3::ZERO } else { fitted.constant },
        }
    }

    /// Every light that is there, hand-made ones first.
    pub fn listed(&self, fitted: &LightSet) -> Vec<ListedLight> {
        let is_solo = self.has_solo();
        let by_hand = self.hand.iter().filter_map(|hand| {
            Some(ListedLight {
                id: LightId::Hand(hand.name.clone()),
                name: hand.name.clone(),
                light: hand.light?,
                muted: hand.muted,
                solo: hand.solo,
                shines: !hand.muted && (hand.solo || !is_solo),
            })
        });
        let mut left = fitted.lights.clone();
        for replaced in self.hand.iter().filter_map(|hand| hand.replaces.as_ref()) {
            take_out(&mut left, replaced);
        }
        let untouched = left.into_iter().enumerate().map(|(index, light)| ListedLight {
            id: LightId::Fitted(index),
            name: format!("Light {}", index + 1),
            light,
            muted: false,
            solo: false,
            shines: !is_solo,
        });
        by_hand
            .chain(untouched.filter(|listed| listed.light.radiance != Vec3::ZERO))
            .collect()
    }

    /// The settings after `change` of one light, and what that light is called then: a fitted light becomes the hand's.
    ///
    /// None where there is no such light.
    pub fn with_light(
        &self,
        fitted: &LightSet,
        id: &LightId,
        change: impl FnOnce(&mut HandLight),
    ) -> Option<(Self, LightId)> {
        let mut settings = self.clone();
        let hand = match id {
            LightId::Hand(name) => settings.hand.iter_mut().find(|hand| hand.name == *name)?,
            LightId::Fitted(_) => {
                let listed = self.listed(fitted).into_iter().find(|listed| listed.id == *id)?;
                let name = settings.unused_name("Edited");
                settings.hand.push(HandLight {
                    name,
                    light: Some(listed.light),
                    replaces: Some(listed.light),
                    muted: false,
                    solo: false,
                    extra: Extra::new(),
                });
                settings.hand.last_mut()?
            }
        };
        change(hand);
        let id = LightId::Hand(hand.name.clone());
        Some((settings, id))
    }

    /// The settings with one more light, and its name.
    pub fn with_added(&self, light: SrbfLight) -> (Self, LightId) {
        let mut settings = self.clone();
        let name = self.unused_name("Added");
        settings.hand.push(HandLight {
            name: name.clone(),
            light: Some(light),
            replaces: None,
            muted: false,
            solo: false,
            extra: Extra::new(),
        });
        (settings, LightId::Hand(name))
    }

    /// The settings without a light; one of the fit stays away after other fits, too.
    pub fn without_light(&self, fitted: &LightSet, id: &LightId) -> Option<Self> {
        let (mut settings, id) = self.with_light(fitted, id, |hand| {
            hand.light = None;
            hand.muted = false;
            hand.solo = false;
        })?;
        let is_added = |hand: &HandLight| hand.replaces.is_none() && LightId::Hand(hand.name.clone()) == id;
        settings.hand.retain(|hand| !is_added(hand));
        Some(settings)
    }

    /// The settings with a changed light as it was fitted; an added one stays.
    pub fn with_reset(&self, id: &LightId) -> Self {
        let mut settings = self.clone();
        settings
            .hand
            .retain(|hand| hand.replaces.is_none() || LightId::Hand(hand.name.clone()) != *id);
        settings
    }

    /// The settings under another environment: lights that the hand placed stay, what they replaced is not there.
    #[must_use]
    pub fn with_environment(&self, environment: Environment) -> Self {
        let mut settings = Self {
            environment,
            ..self.clone()
        };
        settings.hand.retain(|hand| hand.light.is_some() && !hand.muted);
        for hand in &mut settings.hand {
            hand.replaces = None;
        }
        settings
    }

    fn has_solo(&self) -> bool {
        self.hand.iter().any(|hand| hand.solo && hand.light.is_some())
    }

    /// The first of "prefix 1", "prefix 2", ... that is free.
    fn unused_name(&self, prefix: &str) -> String {
        let mut number = 1;
        loop {
            let name = format!("{prefix} {number}");
            if self.hand.iter().all(|hand| hand.name != name) {
                return name;
            }
            number += 1;
        }
    }
}

/// What a person did to the hand-made lights.
pub(super) fn hand_label(before: &[HandLight], after: &[HandLight]) -> &'static str {
    if after.len() < before.len() {
        return "Remove hand-made light";
    }
    let Some(changed) = after.iter().find(|hand| !before.contains(hand)) else {
        return "Change lights";
    };
    let Some(light) = changed.light else {
        return "Delete light";
    };

    // A light that has just been taken from the fit is compared with what it was there.
    let earlier = before.iter().find(|hand| hand.name == changed.name);
    let Some(was) = earlier.map_or(changed.replaces, |hand| hand.light) else {
        return "Add light";
    };
    if changed.muted != earlier.is_some_and(|hand| hand.muted) {
        "Mute light"
    } else if changed.solo != earlier.is_some_and(|hand| hand.solo) {
        "Solo light"
    } else if was.direction != light.direction {
        "Move light"
    } else if was.bandwidth != light.bandwidth {
        "Widen light"
    } else {
        "Colour light"
    }
}

/// Takes the energy of `replaced` out of the lights that lie where it lay, the most alike first; none falls below zero.
fn take_out(lights: &mut [SrbfLight], replaced: &SrbfLight) {
    let mut there: Vec<(f64, &mut SrbfLight)> = lights
        .iter_mut()
        .map(|light| (overlap(light, replaced), light))
        .filter(|(overlap, _)| *overlap >= SAME_PLACE)
        .collect();
    there.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let mut wanted = replaced.energy();
    for (_, light) in there {
        let energy = light.energy();
        let taken = wanted.min(energy);
        let kept = DVec3::ONE - taken / energy.max(DVec3::splat(f64::MIN_POSITIVE));
        light.radiance *= kept.as_vec3();
        wanted -= taken;
    }
}

/// Integral of the product of two lights of peak 1 over the root of the product of their squares' integrals: 1 for equals.
fn overlap(a: &SrbfLight, b: &SrbfLight) -> f64 {
    let apart = (a.direction - b.direction).as_dvec3().length_squared();
    let (kappa_a, kappa_b) = (concentration(a), concentration(b));
    let own = |kappa: f64| product_integral(kappa, kappa, 0.0);
    let product = product_integral(kappa_a, kappa_b, apart);
    product / (own(kappa_a) * own(kappa_b)).sqrt()
}

/// kappa of exp(kappa (w . d - 1)).
fn concentration(light: &SrbfLight) -> f64 {
    2.0 / f64::from(light.bandwidth).powi(2)
}

/// Integral of exp(kappa_a (w . a - 1) + kappa_b (w . b - 1)) over the sphere, `apart` = |a - b|^2: with
/// k = |kappa_a a + kappa_b b| it is 4 pi sinh(k)/k exp(-kappa_a - kappa_b), here without the cancellation in its exponent.
fn product_integral(kappa_a: f64, kappa_b: f64, apart: f64) -> f64 {
    let sum = kappa_a + kappa_b;
    let k = (sum * sum - kappa_a * kappa_b * apart).max(1e-12).sqrt();
    let exponent = -kappa_a * kappa_b * apart / (k + sum);
    2.0 * PI * exponent.exp() * -(-2.0 * k).exp_m1() / k
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(direction: Vec3, bandwidth: f32, radiance: f32) -> SrbfLight {
        SrbfLight {
            direction: direction.normalize(),
            bandwidth,
            radiance: Vec3::new(radiance, 0.5 * radiance, 0.1 * radiance),
        }
    }

    /// The closed form against a sum over the sphere.
    #[test]
    fn overlap_is_the_cosine_between_two_lights() {
        let directions: Vec<Vec3> = (0..200_000)
            .map(|k| {
                let y = 1.0 - (2.0 * k as f32 + 1.0) / 200_000.0;
                let (sin, cos) = (2.399_963_2 * k as f32 % std::f32::consts::TAU).sin_cos();
                let r = (1.0 - y * y).sqrt();
                Vec3::new(r * cos, y, r * sin)
            })
            .collect();
        let dot = |a: &SrbfLight, b: &SrbfLight| -> f64 {
            let value =
                |light: &SrbfLight, w: Vec3| f64::from(light.radiance_towards(w).x / light.radiance.x);
            directions.iter().map(|w| value(a, *w) * value(b, *w)).sum()
        };
        let lights = [
            light(Vec3::Y, 0.1, 1.0),
            light(Vec3::new(0.1, 1.0, 0.0), 0.2, 3.0),
            light(Vec3::new(1.0, 0.3, -0.4), 0.7, 2.0),
            light(-Vec3::Y, 2.0, 1.0),
        ];
        for a in &lights {
            for b in &lights {
                let expected = dot(a, b) / (dot(a, a) * dot(b, b)).sqrt();
                assert!(
                    (overlap(a, b) - expected).abs() < 2e-3,
                    "{a:?} {b:?}: {}",
                    overlap(a, b)
                );
            }
        }
        assert!(overlap(&lights[0], &light(Vec3::X, 0.1, 1.0)) < 1e-12);
    }

    #[test]
    fn only_the_light_that_is_replaced_goes_out_and_no_energy_is_lost_after_another_fit() {
        let fitted = LightSet {
            lights: vec![
                light(Vec3::Y, 0.2, 5.0),
                light(Vec3::new(0.2, 1.0, 0.0), 0.25, 2.0),
                light(Vec3::X, 0.5, 1.0),
            ],
            constant: Vec3::ONE,
        };
        let (settings, id) = LightSettings::default()
            .with_light(&fitted, &LightId::Fitted(0), |hand| hand.muted = true)
            .unwrap();
        assert_eq!(id, LightId::Hand("Edited 1".to_owned()));
        assert_eq!(settings.edited(&fitted).lights, fitted.lights[1..]);
        assert_eq!(settings.with_reset(&id).edited(&fitted), fitted);

        // In another fit two lights have its place: the same energy goes out of them, and nothing elsewhere.
        let refit = LightSet {
            lights: vec![
                light(Vec3::new(0.0, 1.0, 0.05), 0.15, 6.0),
                light(Vec3::new(0.05, 1.0, 0.0), 0.25, 3.0),
                light(Vec3::X, 0.5, 1.0),
            ],
            constant: Vec3::ONE,
        };
        let out = refit.energy() - settings.edited(&refit).energy();
        assert!(out.abs_diff_eq(fitted.lights[0].energy(), 1e-6), "{out}");
        assert_eq!(settings.edited(&refit).lights.last(), refit.lights.last());
    }

    #[test]
    fn solo_mute_delete_add_and_another_environment() {
        let fitted = LightSet {
            lights: vec![light(Vec3::Y, 0.2, 5.0), light(Vec3::X, 0.5, 1.0)],
            constant: Vec3::ONE,
        };
        let (settings, added) = LightSettings::default().with_added(light(Vec3::Z, 0.3, 2.0));
        assert_eq!(settings.edited(&fitted).lights.len(), 3);
        let (solo, _) = settings
            .with_light(&fitted, &added, |hand| hand.solo = true)
            .unwrap();
        let alone = solo.edited(&fitted);
        assert_eq!((alone.lights.len(), alone.constant), (1, Vec3::ZERO));
        let (silent, _) = solo
            .with_light(&fitted, &added, |hand| hand.muted = true)
            .unwrap();
        assert!(silent.edited(&fitted).lights.is_empty());
        assert_eq!(
            solo.without_light(&fitted, &added),
            Some(LightSettings::default())
        );

        // Deleting a fitted light is kept as what goes out; another environment has nothing to take it from.
        let deleted = settings.without_light(&fitted, &LightId::Fitted(1)).unwrap();
        assert_eq!(deleted.edited(&fitted).lights.len(), 2);
        assert_eq!(deleted.hand.len(), 2);
        let elsewhere = deleted.with_environment(Environment::Constant([1.0; 3]));
        assert_eq!(elsewhere.hand, settings.hand);
        assert_eq!(settings.with_light(&fitted, &LightId::Fitted(7), |_| ()), None);
    }
}
