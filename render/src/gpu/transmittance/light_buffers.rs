//! The lights that are marched to, and which of them new ones move.

use super::{ExactLights, Transmittance};
use crate::gpu::{Gpu, GpuError};
use crate::light::SrbfLight;
use crate::volume::lobe::{LobeDirection, LobeLight, lobe_tables};

/// The lights on the GPU.
pub(super) struct LightBuffers {
    pub(super) frames: Vec<LobeLight>,
    pub(super) lights: wgpu::Buffer,
    pub(super) directions: wgpu::Buffer,
    pub(super) exact: Option<ExactLights>,
}

impl Transmittance {
    /// Takes the lights and returns those that are marched in another way than before; the records of the others stay.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] where their table exceeds what the adapter binds.
    pub fn set_lights(&mut self, gpu: &Gpu, lights: &[SrbfLight]) -> Result<Vec<u32>, GpuError> {
        let (frames, directions) = lobe_tables(lights);
        let count = frames.len() as u32;
        let moved = self.moved_among(&frames);
        if !moved.is_empty() || self.lights.is_none() {
            self.lights = Some(LightBuffers {
                lights: gpu.storage_of("lobe lights", &frames)?,
                directions: gpu.storage_of::<LobeDirection>("lobe directions", &directions)?,
                frames,
                exact: None,
            });
            self.srbf = lights.to_vec();
        }
        // Going through the lists once for a few lights is worth it where most records stay.
        if 4 * moved.len() as u32 > count {
            self.stale.lights = true;
        } else {
            self.moved.extend(&moved);
        }
        Ok(moved)
    }

    /// What [`Self::set_lights`] would return.
    pub fn moved_by(&self, lights: &[SrbfLight]) -> Vec<u32> {
        self.moved_among(&lobe_tables(lights).0)
    }

    fn moved_among(&self, frames: &[LobeLight]) -> Vec<u32> {
        match &self.lights {
            Some(old) if old.frames.len() == frames.len() => {
                let pairs = (0..).zip(old.frames.iter().zip(frames));
                let moved = pairs.filter(|(_, (old, new))| !old.is_marched_as(new));
                moved.map(|(light, _)| light).collect()
            }
            _ => (0..frames.len() as u32).collect(),
        }
    }
}
