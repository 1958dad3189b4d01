//! The lights of a renderer, and what a new list of them changes.

use glam::Vec3;

use super::lights::{frame_lights, light_uniforms};
use super::transmittance::Transmittance;
use super::{Gpu, GpuError, Saving, Savings};
use crate::light::{LightSet, SrbfLight};

/// Relative difference of radiance that is no change.
const SAME: f32 = 1e-5;

/// The lights that strands and head are shaded with, and the factor that they are seen with.
pub(super) struct SceneLights {
    set: LightSet,
    /// Those of the set, then those that stand for its uniform environment.
    pub(super) lights: Vec<SrbfLight>,
    /// `LightUniform` each.
    pub(super) buffer: wgpu::Buffer,
    /// Factor (rgb) on what they give.
    pub(super) gain: Vec3,
}

/// What another list of lights means.
#[derive(Debug, PartialEq)]
pub(super) enum LightChange {
    /// The same light.
    Nothing,
    /// All of it times a factor.
    Gain(Vec3),
    /// Few changed.
    Few(FewLights),
    /// The whole list.
    All(LightSet),
}

/// Lights that changed, by number.
#[derive(Debug, PartialEq)]
pub(super) struct FewLights {
    /// Lights that stand elsewhere, or are marched in another way.
    pub(super) moved: Vec<u32>,
    /// Lights of another radiance, where they were.
    pub(super) recoloured: Vec<u32>,
    /// The whole list, in units of the factor that is there.
    pub(super) set: LightSet,
}

impl SceneLights {
    pub(super) fn dark(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            set: LightSet::default(),
            lights: Vec::new(),
            buffer: gpu.storage("lights", 32)?,
            gain: Vec3::ONE,
        })
    }

    /// Number of the set's own lights.
    pub(super) fn real_count(&self) -> u32 {
        self.set.lights.len() as u32
    }

    /// Radiance of the uniform environment.
    pub(super) fn constant(&self) -> Vec3 {
        self.set.constant
    }

    /// What `next` changes; few lights count as few only while a hand moves.
    pub(super) fn change(
        &self,
        next: LightSet,
        savings: Savings,
        interactive: bool,
        marches: &Transmittance,
    ) -> LightChange {
        let are_same_places = self.set.lights.len() == next.lights.len()
            && self
                .set
                .lights
                .iter()
                .zip(&next.lights)
                .all(|(a, b)| is_same_place(a, b));
        if savings.has(Saving::Gain) && are_same_places {
            let radiances = |set: &LightSet| -> Vec<Vec3> {
                let lights = set.lights.iter().map(|light| light.radiance);
                lights.chain([set.constant]).collect()
            };
            if let Some(gain) = common_factor(&radiances(&self.set), &radiances(&next)) {
                return if gain == self.gain {
                    LightChange::Nothing
                } else {
                    LightChange::Gain(gain)
                };
            }
        }
        let same_constant = is_scaled(next.constant, self.set.constant, self.gain);
        if interactive
            && savings.has(Saving::FewLights)
            && self.gain.min_element() > SAME
            && next.lights.len() == self.set.lights.len()
            && same_constant
        {
            let mut set = self.set.clone();
            let (mut moved, mut recoloured) = (Vec::new(), Vec::new());
            for (i, (old, new)) in (0..).zip(set.lights.iter_mut().zip(&next.lights)) {
                let list = if !is_same_place(old, new) {
                    &mut moved
                } else if !is_scaled(new.radiance, old.radiance, self.gain) {
                    &mut recoloured
                } else {
                    continue;
                };
                list.push(i);
                *old = SrbfLight {
                    radiance: new.radiance / self.gain,
                    ..*new
                };
            }
            // A light whose share of the power changed may be marched in another way.
            moved.extend(marches.moved_by(&frame_lights(&set)));
            moved.sort_unstable();
            moved.dedup();
            recoloured.retain(|light| !moved.contains(light));
            if 4 * (moved.len() + recoloured.len()) <= self.lights.len() {
                return LightChange::Few(FewLights {
                    moved,
                    recoloured,
                    set,
                });
            }
        }
        LightChange::All(next)
    }

    /// Takes a list, and the factor on it.
    pub(super) fn take(&mut self, gpu: &Gpu, set: LightSet, gain: Vec3) -> Result<(), GpuError> {
        let lights = frame_lights(&set);
        *self = Self {
            set,
            buffer: gpu.storage_of("lights", &light_uniforms(&lights))?,
            lights,
            gain,
        };
        Ok(())
    }

    /// What makes the lights into those of `few`, but for what those that moved give where they are then.
    pub(super) fn difference(&self, gpu: &Gpu, few: &FewLights) -> Result<wgpu::Buffer, GpuError> {
        let mut uniforms = light_uniforms(&self.lights);
        let next = light_uniforms(&frame_lights(&few.set));
        for (number, (light, new)) in (0..).zip(uniforms.iter_mut().zip(next)) {
            if few.moved.contains(&number) {
                light.radiance = light.radiance.map(|x| -x);
            } else {
                light.radiance = std::array::from_fn(|c| new.radiance[c] - light.radiance[c]);
                // Where one of them counts the difference does.
                light.share = light.share.max(new.share);
            }
        }
        gpu.storage_of("what is new of the lights", &uniforms)
    }
}

fn is_same_place(a: &SrbfLight, b: &SrbfLight) -> bool {
    (a.direction, a.bandwidth) == (b.direction, b.bandwidth)
}

/// Whether `new` is `gain` times `old`.
fn is_scaled(new: Vec3, old: Vec3, gain: Vec3) -> bool {
    (new - gain * old).abs().cmple(SAME * new.abs()).all()
}

/// The factor (rgb) that makes `old` into `new`, one where both are dark; none where there is no such factor.
fn common_factor(old: &[Vec3], new: &[Vec3]) -> Option<Vec3> {
    let sums = [old, new].map(|list| list.iter().sum::<Vec3>().to_array());
    let factor = |c: usize| match [sums[0][c], sums[1][c]] {
        [0.0, 0.0] => Some(1.0),
        [a, b] if a > 0.0 && b >= 0.0 => Some(b / a),
        _ => None,
    };
    let gain = Vec3::new(factor(0)?, factor(1)?, factor(2)?);
    let is_common = gain.is_finite() && old.iter().zip(new).all(|(a, b)| is_scaled(*b, *a, gain));
    is_common.then_some(gain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_factor_on_all_is_a_factor() {
        let old = [
            Vec3::new(1.0, 2.0, 0.0),
            Vec3::new(0.3, 0.0, 0.0),
            Vec3::new(0.1, 7.0, 0.0),
        ];
        let tint = Vec3::new(0.5, 3.0, 1.0);
        let tinted = old.map(|x| tint * x);
        let gain = common_factor(&old, &tinted).unwrap();
        assert!((gain - tint).abs().max_element() < 1e-6, "{gain}");
        let mut other = tinted;
        other[2].y *= 1.01;
        assert_eq!(common_factor(&old, &other), None);
        // Light that comes out of the dark is no factor; light that goes out is.
        other = tinted;
        other[1].z = 1.0;
        assert_eq!(common_factor(&old, &other), None);
        assert_eq!(common_factor(&old, &[Vec3::ZERO; 3]), Some(Vec3::Z));
        assert_eq!(common_factor(&[Vec3::ZERO], &[Vec3::ONE]), None);
    }
}
