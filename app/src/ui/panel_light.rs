//! The environment: which one, how it is turned and exposed.

use egui::{Slider, Ui};

use super::{Command, Editor};
use crate::document::{Edit, Environment, LightSettings};

impl Editor {
    pub(super) fn light_panel(&mut self, ui: &mut Ui) {
        let Some(document) = &self.document else { return };
        let light = document.project().light.clone();
        let name = match &light.environment {
            Environment::Sky => "Sky".to_owned(),
            Environment::Constant(_) => "Uniform".to_owned(),
            Environment::Preset(name) => name.clone(),
            Environment::Map(path) | Environment::Lights(path) => path.clone(),
        };
        egui::ComboBox::from_label("Environment")
            .selected_text(&name)
            .show_ui(ui, |ui| {
                let presets = [
                    ("Sky", Environment::Sky),
                    ("Uniform", Environment::Constant([1.0; 3])),
                ];
                for (name, environment) in presets {
                    let chosen =
                        std::mem::discriminant(&light.environment) == std::mem::discriminant(&environment);
                    if ui.selectable_label(chosen, name).clicked() && !chosen {
                        self.edit(Edit::SetLight(LightSettings {
                            environment,
                            ..light.clone()
                        }));
                    }
                }
                for command in [Command::OpenEnvironment, Command::OpenLights] {
                    if ui.button(command.label()).clicked() {
                        self.run(ui.ctx(), command);
                    }
                }
            });

        let mut changed = light.clone();
        let rotation = Slider::new(&mut changed.rotation_deg, 0.0..=360.0)
            .text("Rotation")
            .suffix("°");
        let rotation = ui.add(rotation).on_hover_text("Shift+right drag in the viewport");
        let exposure = ui.add(
            Slider::new(&mut changed.exposure_ev, -8.0..=8.0)
                .text("Exposure")
                .suffix(" EV"),
        );
        let mut count = self.wanted_lights.unwrap_or(light.light_count);
        let lights = ui.add(Slider::new(&mut count, 1..=100).text("Lights"));
        for slider in [&rotation, &exposure] {
            if slider.changed() {
                self.edit_by(slider, Edit::SetLight(changed.clone()));
            }
        }
        // A new count means a new fit: it waits until the slider is released.
        self.wanted_lights = (count != light.light_count).then_some(count);
        if self.wanted_lights.is_some() && !lights.dragged() {
            self.wanted_lights = None;
            self.edit(Edit::SetLight(LightSettings {
                light_count: count,
                ..light
            }));
        }
        if let Some(seconds) = self.lighting.as_ref().and_then(|lighting| lighting.fit_seconds) {
            ui.weak(format!("fitted in {seconds:.2} s"));
        }
    }
}
