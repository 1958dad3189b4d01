//! The light behind the editor: fits in the background, what hand edits name, the way to the viewer. The last good lights stay
//! until the new ones are there.

use std::path::{Path, PathBuf};

use balayage_render::light::{LightSet, Picture};
use egui::Context;

use super::{
    Editor,
    job::{Job, JobControl},
    viewer::LightInput,
};
use crate::{
    Problem,
    document::{
        Edit, Environment, LightId, LightSettings, Lighting, ListedLight, Project, Sequence, files, maps_of,
    },
    paint::Extra,
};

/// What a fit depends on.
pub(super) type FitKey = (LightSettings, usize);

/// A fit and the environment's picture.
pub(super) struct Fitted {
    lighting: Lighting,
    panorama: Picture,
}

fn fit_key(project: &Project) -> FitKey {
    let index = match &project.light.environment {
        Environment::Sequence(sequence) => sequence.index(project.frame),
        _ => 0,
    };
    (project.light.clone(), index)
}

impl Editor {
    /// The lights of the picture as they are now: edited, turned, exposed and tinted.
    pub fn lights(&self) -> Option<LightSet> {
        let light = &self.document.as_ref()?.project().light;
        Some(self.lighting.as_ref()?.exposed(light))
    }

    /// How often an environment was read and, where it is a map, fitted: turning, exposing, tinting and edits by hand do not count.
    pub fn fits_started(&self) -> u64 {
        self.light_tab.fits_started
    }

    /// Every light of the environment, hand-made ones first.
    pub(super) fn listed_lights(&self) -> Vec<ListedLight> {
        match (&self.document, &self.lighting) {
            (Some(document), Some(lighting)) => document.project().light.listed(&lighting.lights),
            _ => Vec::new(),
        }
    }

    /// The light that is chosen, if it is still there.
    pub(super) fn selected_light(&self) -> Option<ListedLight> {
        let selected = self.light_tab.selected.as_ref()?;
        self.listed_lights()
            .into_iter()
            .find(|listed| listed.id == *selected)
    }

    /// Changes one light by hand; `response` is what the hand holds. The changed light is chosen.
    pub(super) fn edit_light(
        &mut self,
        response: &egui::Response,
        id: &LightId,
        change: impl FnOnce(&mut crate::document::HandLight),
    ) {
        let (Some(document), Some(lighting)) = (&self.document, &self.lighting) else {
            return;
        };
        let light = &document.project().light;
        let Some((light, id)) = light.with_light(&lighting.lights, id, change) else {
            return;
        };
        self.light_tab.selected = Some(id);
        self.edit_by(response, Edit::SetLight(light));
    }

    pub(super) fn delete_selected_light(&mut self) {
        let (Some(document), Some(lighting)) = (&self.document, &self.lighting) else {
            return;
        };
        let light = &document.project().light;
        let Some(id) = self.light_tab.selected.take() else {
            return;
        };
        if let Some(light) = light.without_light(&lighting.lights, &id) {
            self.edit(Edit::SetLight(light));
        }
    }

    pub(super) fn set_environment(&mut self, path: &Path, kind: impl FnOnce(String) -> Environment) {
        let Some(document) = &self.document else { return };
        let environment = kind(document.reference_to(path));
        let light = document.project().light.with_environment(environment);
        self.edit(Edit::SetLight(light));
    }

    /// Takes maps, or the maps of folders, as a sequence that starts with its first.
    pub fn set_sequence(&mut self, paths: &[PathBuf]) {
        let Some(document) = &mut self.document else {
            return;
        };
        let maps = match maps_of(paths) {
            Ok(maps) => maps,
            Err(problem) => return self.complain(&problem),
        };
        let environment = Environment::Sequence(Sequence {
            maps: maps.iter().map(|map| document.reference_to(map)).collect(),
            fps: 12.0,
            extra: Extra::new(),
        });
        document.set_frame(0);
        let light = document.project().light.with_environment(environment);
        self.edit(Edit::SetLight(light));
    }

    /// Writes the lights of the picture as a light list.
    pub fn save_lights(&mut self, path: &Path) {
        let Some(lights) = self.lights() else { return };
        match lights.write(path) {
            Ok(()) => self.say(format!("Saved {}", path.display())),
            Err(error) => self.complain(&Problem::from(error)),
        }
    }

    /// Starts whatever the new light needs: a fit in the background where the map or the count changed.
    pub(super) fn refresh_light(&mut self) {
        let Some(document) = &self.document else { return };
        let wanted = fit_key(document.project());
        let earlier = self.fitted_for.as_ref();
        if earlier.is_some_and(|(light, index)| *index == wanted.1 && light.same_fit(&wanted.0)) {
            self.send_light();
            return;
        }

        // The next map of a sequence is like the last one: its lights are the start.
        let is_next = earlier.is_some_and(|(light, _)| light.same_fit(&wanted.0));
        let lighting = self.lighting.as_ref().filter(|_| is_next);
        let from = lighting.map(|lighting| lighting.lights.clone());
        self.fitted_for = Some(wanted);
        if let Some(job) = &self.fitting {
            job.cancel();
        }
        let project = Project {
            light: document.project().light.clone(),
            frame: document.project().frame,
            ..Project::new(document.project().groom.clone())
        };
        let folder = document.folder().to_owned();
        let load = move |control: &JobControl| -> Result<Fitted, Problem> {
            let resolve = |reference: &str| files::resolve(reference, &folder);
            let lighting =
                Lighting::load(&project, from.as_ref(), resolve, &|share| control.progress(share))?;
            let panorama = lighting.panorama();
            Ok(Fitted { lighting, panorama })
        };
        let context = self.context.clone();
        self.light_tab.fits_started += 1;
        self.fitting = Some(Job::start("Fitting lights", &context, load));
    }

    /// Ends a fit at once; the lights in the picture stay.
    pub(super) fn stop_fitting(&mut self) {
        if let Some(job) = self.fitting.take() {
            job.cancel();
            self.fitted_for = None;
            self.say("Fit cancelled: the earlier lights stay until the light is changed again");
        }
    }

    /// Takes what was fitted, and what was measured of it.
    pub(super) fn take_lighting(&mut self, context: &Context) {
        if let Some(result) = self.fitting.as_ref().and_then(Job::poll) {
            self.fitting = None;
            match result {
                Ok(Fitted { lighting, panorama }) => {
                    for warning in lighting.warnings.clone() {
                        self.say(warning);
                    }
                    self.follow_selection(&lighting);
                    self.lighting = Some(lighting);
                    self.light_tab.take_panorama(context, &panorama);
                    self.send_light();
                    self.measure_fit();
                }
                Err(problem) => {
                    self.stop_sequence();
                    self.complain(&problem);
                }
            }
        }
        self.light_tab.take_report();
    }

    /// Starts to measure the fit in the background; a sequence that plays is not held up by it.
    pub(super) fn measure_fit(&mut self) {
        let Some(lighting) = self.lighting.clone() else {
            return;
        };
        let measuring = (!self.is_playing()).then(|| {
            Job::start("Measuring the fit", &self.context, move |control| {
                Ok(lighting.report(&|share| control.progress(share)))
            })
        });
        self.light_tab.measure(measuring);
    }

    /// Keeps a fitted light chosen where the new fit has one in its place.
    fn follow_selection(&mut self, new: &Lighting) {
        let Some(LightId::Fitted(_)) = self.light_tab.selected else {
            return;
        };
        let selected = self.selected_light();
        self.light_tab.selected = selected.and_then(|selected| {
            let distance = |index: &usize| {
                new.lights.lights[*index]
                    .direction
                    .distance(selected.light.direction)
            };
            (0..new.lights.lights.len())
                .min_by(|a, b| distance(a).total_cmp(&distance(b)))
                .filter(|index| distance(index) < selected.light.bandwidth)
                .map(LightId::Fitted)
        });
    }

    /// The lights as they are edited, turned and exposed now.
    pub(super) fn light_input(&self) -> Option<LightInput> {
        let light = &self.document.as_ref()?.project().light;
        let lighting = self.lighting.as_ref()?;
        Some(LightInput {
            lights: lighting.exposed(light),
            background: lighting.map.clone(),
            turn_rad: light.rotation_deg.to_radians(),
            scale: light.factor(),
        })
    }

    pub(super) fn send_light(&mut self) {
        if let Some(light) = self.light_input() {
            self.viewer.set_light(light);
            self.refresh_compare();
        }
    }
}
