//! What differs from the last frame, and what it makes stale.

use glam::Vec3;

use super::{Lag, LastFrame, RenderSettings, Renderer, TURNING_RAD};
use crate::gpu::scene_lights::LightChange;
use crate::gpu::shade::ShadeInputs;
use crate::gpu::stale::{Changes, Input, Product};
use crate::gpu::{FrameReport, GpuError, Quality, Saving};

impl Renderer {
    /// Notes what differs between the last frame and this one, and forgets the shading that it makes stale.
    pub(super) fn note_changes(&mut self, now: &LastFrame) {
        let Some(last) = self.last else {
            self.changes = Changes::ALL;
            return;
        };
        let (old, new) = (&last.settings, &now.settings);
        let coarsest = |settings: &RenderSettings| {
            let mut shade = settings.shade;
            shade.method.quality = Quality::Draft;
            shade
        };
        let noted = [
            (Input::Eye, last.camera.position() != now.camera.position()),
            (
                Input::Lens,
                (last.camera, last.size, last.sample) != (now.camera, now.size, now.sample)
                    || (old.samples, old.savings) != (new.samples, new.savings),
            ),
            (
                Input::Method,
                coarsest(old) != coarsest(new) || old.savings != new.savings,
            ),
            (
                Input::Quality,
                (new.shade.method.quality as u32) > old.shade.method.quality as u32
                    || old.visibility_rays != new.visibility_rays
                    || (new.shade.is_traced() && self.scattered.is_coarse_for(new)),
            ),
            (
                Input::Parameters,
                !new.interactive
                    && (self.transmittance.lags() || (new.shade.is_traced() && self.scattered.lags())),
            ),
            (Input::Background, old.show_background != new.show_background),
            (
                Input::Display,
                (old.view, old.view_exposure_ev, old.backdrop)
                    != (new.view, new.view_exposure_ev, new.backdrop),
            ),
        ];
        for (input, _) in noted.into_iter().filter(|(_, changed)| *changed) {
            self.changes.note(input);
        }
        let Some(scene) = &self.scene else { return };
        let (single, multiple) = (&scene.strands.single_work, &scene.strands.multiple_work);
        if !new.savings.has(Saving::Untouched) {
            self.changes = Changes::ALL;
            self.transmittance.forget();
            self.scattered.forget();
        }
        if self.changes.has(Input::Method) || self.changes.has(Input::Geometry) {
            single.forget_all(&self.gpu);
            multiple.forget_all(&self.gpu);
            self.lag = Lag::default();
        }
        // What a moving hand left behind is done once it rests.
        if !new.interactive && self.lag.few_lights {
            single.forget_all(&self.gpu);
            multiple.forget_all(&self.gpu);
            self.changes.note(Input::Quality);
            self.lag = Lag::default();
        }
        if self.changes.has(Input::Eye) {
            single.forget_all(&self.gpu);
        }
        if self.changes.has(Input::Eye) || self.lag.multiple_eye.is_some() {
            let from = self.lag.multiple_eye.unwrap_or(last.camera.position());
            let turn = (from - scene.centre).angle_between(now.camera.position() - scene.centre);
            if new.interactive && new.savings.has(Saving::Turning) && turn <= TURNING_RAD {
                self.lag.multiple_eye = Some(from);
            } else {
                multiple.forget_all(&self.gpu);
                self.lag.multiple_eye = None;
                self.changes.note(Input::Quality);
            }
        }
    }

    /// Takes the lights that were given since the last frame. Where only a few changed what is new of their radiance is added; those that
    /// moved are taken away, and returned to be added where they are.
    pub(super) fn take_lights(
        &mut self,
        settings: &RenderSettings,
        report: &mut FrameReport,
    ) -> Result<Option<Vec<u32>>, GpuError> {
        let (Some(next), Some(scene)) = (self.next_lights.take(), &self.scene) else {
            return Ok(None);
        };
        // Only in the view of the last frame is it known which vertices are wanted.
        let is_same_view = !self.changes.stale().has(Product::Fragments);
        let savings = settings.savings;
        let gpu = &self.gpu;
        match self.lights.change(
            next,
            savings,
            settings.interactive && is_same_view,
            &self.transmittance,
        ) {
            LightChange::Nothing => Ok(None),
            LightChange::Gain(gain) => {
                self.lights.gain = gain;
                self.changes.note(Input::LightGain);
                Ok(None)
            }
            LightChange::Few(few) => {
                let Some(last) = &self.last else {
                    return Ok(None);
                };
                let difference = self.lights.difference(gpu, &few)?;
                let changed = [&few.moved[..], &few.recoloured].concat();
                let inputs = ShadeInputs {
                    lights: &difference,
                    ..scene.shade_inputs(&self.lights, &self.transmittance, last, self.frame)
                };
                report.time(gpu, "strand shading", |report| {
                    let done = self
                        .shade
                        .add(gpu, &settings.shade, &scene.strands, &inputs, &changed)?;
                    report.count_shading(&done);
                    Ok(())
                })?;
                self.lights.take(gpu, few.set, self.lights.gain)?;
                let moved = self.transmittance.set_lights(gpu, &self.lights.lights)?;
                self.changes.note(light_input(&moved));
                self.lag.few_lights = true;
                Ok(Some(few.moved))
            }
            LightChange::All(set) => {
                self.lights.take(gpu, set, Vec3::ONE)?;
                let moved = self.transmittance.set_lights(gpu, &self.lights.lights)?;
                self.changes.note(light_input(&moved));
                scene.strands.forget_shading(gpu);
                Ok(None)
            }
        }
    }
}

/// What changes with lights some of which are marched in another way.
fn light_input(moved: &[u32]) -> Input {
    if moved.is_empty() {
        Input::LightColours
    } else {
        Input::LightPlaces
    }
}
