//! The list of lights and the settings of the chosen one.

use balayage_render::light::SrbfLight;
use egui::{Role, Sense, Slider, Ui, WidgetInfo};
use glam::Vec3;

use super::{
    Command, Editor,
    light_grab::change,
    light_place::{BANDWIDTHS, USUAL_BANDWIDTH, direction_at, hue, place_of, widen},
};
use crate::document::{HandLight, LightId, ListedLight};

/// Energies below this show as the lowest stop.
const DARKEST: f32 = 1e-5;

/// A light in a person's words.
#[derive(Clone, Copy)]
struct Words {
    azimuth_deg: f32,
    elevation_deg: f32,
    width_deg: f32,
    /// Radiance times solid angle, the brightest channel, in stops.
    energy_ev: f32,
    colour: [f32; 3],
}

impl Words {
    /// Of a light that shines from the world direction `towards`.
    fn new(light: &SrbfLight, towards: Vec3) -> Self {
        let place = place_of(towards);
        let energy = light.energy().as_vec3();
        let brightest = energy.max_element().max(DARKEST);
        Self {
            azimuth_deg: 360.0 * (place.x - 0.5),
            elevation_deg: 90.0 - 180.0 * place.y,
            width_deg: light.bandwidth.to_degrees(),
            energy_ev: brightest.log2(),
            colour: (energy / brightest).to_array(),
        }
    }

    /// World direction.
    fn direction(&self) -> Vec3 {
        let place = glam::Vec2::new(0.5 + self.azimuth_deg / 360.0, 0.5 - self.elevation_deg / 180.0);
        direction_at(place)
    }

    /// Gives `light` the energy and colour.
    fn apply_energy(&self, light: &mut SrbfLight) {
        let energy = self.energy_ev.exp2() / light.solid_angle() as f32;
        light.radiance = energy * Vec3::from(self.colour).max(Vec3::ZERO);
    }
}

impl Editor {
    pub(super) fn light_inspector(&mut self, ui: &mut Ui) {
        let lights = self.listed_lights();
        ui.horizontal(|ui| {
            if ui
                .button("Add light")
                .on_hover_text("A soft white light")
                .clicked()
            {
                self.light_tab.menu_at = None;
                self.add_light();
            }
            let selected = self.selected_light();
            let delete = ui.add_enabled(
                selected.is_some(),
                egui::Button::new(Command::DeleteLight.label()),
            );
            if delete.on_hover_text("Key Delete; undo brings it back").clicked() {
                self.run(ui.ctx(), Command::DeleteLight);
            }
            let by_hand = matches!(selected.as_ref().map(|listed| &listed.id), Some(LightId::Hand(_)));
            let reset = ui.add_enabled(by_hand, egui::Button::new("Reset light"));
            if reset.on_hover_text("As it was fitted").clicked() {
                self.reset_light();
            }
        });
        egui::ScrollArea::vertical()
            .id_salt("lights")
            .max_height(110.0)
            .auto_shrink([false, true])
            .show(ui, |ui| {
                for listed in &lights {
                    ui.horizontal(|ui| self.light_row(ui, listed));
                }
            });
        match self.selected_light() {
            Some(selected) => self.light_settings(ui, &selected),
            None if !lights.is_empty() => {
                ui.weak("Choose a light on the map or in the list to change it.");
            }
            None => {}
        }
    }

    fn light_row(&mut self, ui: &mut Ui, listed: &ListedLight) {
        type Switch = fn(&mut HandLight);
        let (swatch, _) = ui.allocate_exact_size(egui::Vec2::splat(12.0), Sense::hover());
        let colour = hue(&listed.light);
        ui.painter().circle_filled(
            swatch.center(),
            5.0,
            if listed.shines {
                colour
            } else {
                colour.gamma_multiply(0.2)
            },
        );
        let is_selected = self.light_tab.selected.as_ref() == Some(&listed.id);
        if ui.selectable_label(is_selected, &listed.name).clicked() {
            self.light_tab.selected = Some(listed.id.clone());
        }
        let switches: [(&str, &str, bool, Switch); 2] = [
            ("Solo", "S", listed.solo, |hand| hand.solo = !hand.solo),
            ("Mute", "M", listed.muted, |hand| hand.muted = !hand.muted),
        ];
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            for (name, letter, is_on, switch) in switches {
                let button = ui.selectable_label(is_on, letter).on_hover_text(name);
                let name = format!("{name} {}", listed.name);
                button.widget_info(|| WidgetInfo::selected(Role::CheckBox, true, is_on, &name));
                if button.clicked() {
                    self.edit_light(&button, &listed.id, switch);
                }
            }
            ui.weak(format!("{:.0}°", listed.light.bandwidth.to_degrees()));
        });
    }

    /// Direction, width, energy and colour; a double click puts one of them back.
    fn light_settings(&mut self, ui: &mut Ui, selected: &ListedLight) {
        type Field = fn(&mut Words) -> &mut f32;
        type Apply<'a> = &'a dyn Fn(&Words, &mut SrbfLight);
        let turn = self.light_turn();
        let words = Words::new(&selected.light, turn * selected.light.direction);
        let usual = self.usual_words(selected);
        let (narrow, wide) = (BANDWIDTHS.start().to_degrees(), BANDWIDTHS.end().to_degrees());
        let direction = |words: &Words, light: &mut SrbfLight| {
            light.direction = (turn.inverse() * words.direction()).normalize();
        };
        let width = |words: &Words, light: &mut SrbfLight| widen(light, words.width_deg.to_radians());
        let energy = |words: &Words, light: &mut SrbfLight| words.apply_energy(light);
        let fields: [(&str, &str, &str, f32, f32, Field, Apply<'_>); 4] = [
            (
                "Azimuth",
                "°",
                "Where the light stands: 0 is the middle of the map, positive to its right",
                -180.0,
                180.0,
                |words| &mut words.azimuth_deg,
                &direction,
            ),
            (
                "Elevation",
                "°",
                "Height above the horizon; 90 is straight up",
                -90.0,
                90.0,
                |words| &mut words.elevation_deg,
                &direction,
            ),
            (
                "Width",
                "°",
                "Larger: softer. The energy stays",
                narrow,
                wide,
                |words| &mut words.width_deg,
                &width,
            ),
            (
                "Intensity",
                " EV",
                "Energy of the light in stops: radiance times solid angle",
                -10.0,
                14.0,
                |words| &mut words.energy_ev,
                &energy,
            ),
        ];
        for (name, unit, hint, low, high, field, apply) in fields {
            let mut words = words;
            let slider = Slider::new(field(&mut words), low..=high)
                .text(name)
                .suffix(unit)
                .max_decimals(1)
                .clamping(egui::SliderClamping::Edits);
            let slider = ui
                .add(slider)
                .on_hover_text(format!("{hint}. Double-click resets"));
            if slider.double_clicked() {
                *field(&mut words) = *field(&mut usual.clone());
            }
            if slider.changed() || slider.double_clicked() {
                self.edit_light(&slider, &selected.id, |hand| {
                    change(hand, |light| apply(&words, light));
                });
            }
        }
        ui.horizontal(|ui| {
            let mut words = words;
            let button = ui.color_edit_button_rgb(&mut words.colour);
            let button = button.on_hover_text("Colour of the light; its brightest channel has the intensity");
            button.widget_info(|| WidgetInfo::labeled(Role::ColorWell, true, "Light colour"));
            ui.label("Colour");
            if button.changed() {
                self.edit_light(&button, &selected.id, |hand| {
                    change(hand, |light| words.apply_energy(light));
                });
            }
        });
    }

    /// What a double click puts back: the light as it was fitted, or as lights are added.
    fn usual_words(&self, selected: &ListedLight) -> Words {
        let hand = self.document.as_ref().and_then(|document| {
            let hand = &document.project().light.hand;
            hand.iter()
                .find(|hand| LightId::Hand(hand.name.clone()) == selected.id)
        });
        let turn = self.light_turn();
        match (hand, hand.and_then(|hand| hand.replaces)) {
            (Some(_), None) => Words {
                azimuth_deg: 0.0,
                elevation_deg: 45.0,
                width_deg: USUAL_BANDWIDTH.to_degrees(),
                energy_ev: 0.0,
                colour: [1.0; 3],
            },
            (_, fitted) => {
                let fitted = fitted.unwrap_or(selected.light);
                Words::new(&fitted, turn * fitted.direction)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_light_comes_back_from_its_words() {
        let light = SrbfLight {
            direction: Vec3::new(0.3, -0.5, 0.8).normalize(),
            bandwidth: 0.4,
            radiance: Vec3::new(0.2, 3.0, 1.0),
        };
        let words = Words::new(&light, light.direction);
        assert!(words.direction().abs_diff_eq(light.direction, 1e-5));
        let mut again = light;
        words.apply_energy(&mut again);
        assert!(again.radiance.abs_diff_eq(light.radiance, 1e-5));
    }
}
