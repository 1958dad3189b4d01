//! What a hand does to lights on the panel: choose, drag, widen, add, and what the context menu offers.

use balayage_render::light::{SrbfLight, luminance};
use egui::{Pos2, Rect, Response, Ui};
use glam::Vec3;

use super::{
    Command, Editor,
    light_place::{USUAL_BANDWIDTH, direction_at, in_panel, widen},
};
use crate::document::{Edit, HandLight, ListedLight};

/// What the pointer holds.
#[derive(Clone, Copy)]
pub(super) enum Grab {
    /// A light, and the way from the pointer to its middle, in points.
    Light(egui::Vec2),
    /// The ring of the chosen light, and the way from the pointer to it, in points.
    Width(egui::Vec2),
}

/// Turns of the wheel farther apart than this are edits of their own, seconds.
const WHEEL_PAUSE_SECS: f64 = 0.6;

impl Editor {
    #[expect(
        clippy::too_many_arguments,
        reason = "one frame of one panel, nothing outlives it"
    )]
    pub(super) fn grab_light(
        &mut self,
        ui: &Ui,
        response: &Response,
        rect: Rect,
        lights: &[ListedLight],
        places: &[Pos2],
        under: Option<usize>,
        over_knob: Option<egui::Vec2>,
    ) {
        // A quick click may begin and end within one frame.
        let pressed = response.is_pointer_button_down_on() && ui.input(|input| input.pointer.any_pressed());
        let clicked = response.clicked() || response.secondary_clicked();
        if (pressed || clicked)
            && let Some(at) = response.interact_pointer_pos()
        {
            let is_primary = ui.input(|input| input.pointer.primary_down());
            self.light_tab.menu_at = Some(direction_at(in_panel(at, rect)));
            self.light_tab.grab = if let Some(offset) = over_knob {
                is_primary.then_some(Grab::Width(offset))
            } else {
                self.light_tab.selected = under.map(|index| lights[index].id.clone());
                under
                    .filter(|_| is_primary)
                    .map(|index| Grab::Light(places[index] - at))
            };
        }
        let moved = response.dragged() && ui.input(|input| input.pointer.delta()) != egui::Vec2::ZERO;
        if let (true, Some(grab), Some(at)) = (moved, self.light_tab.grab, response.interact_pointer_pos()) {
            self.drag_light(response, rect, grab, at);
        }
        if !ui.input(|input| input.pointer.any_down()) {
            self.light_tab.grab = None;
        }
        if response.double_clicked() && under.is_none() && over_knob.is_none() {
            self.add_light();
        }
    }

    fn drag_light(&mut self, response: &Response, rect: Rect, grab: Grab, at: Pos2) {
        let Some(selected) = self.selected_light() else {
            return;
        };
        let turn = self.light_turn();
        match grab {
            Grab::Light(offset) => {
                let direction = direction_at(in_panel(at + offset, rect));
                self.move_light(response, direction);
            }
            Grab::Width(offset) => {
                let towards = turn * selected.light.direction;
                let bandwidth = towards.angle_between(direction_at(in_panel(at + offset, rect)));
                self.edit_light(response, &selected.id, |hand| {
                    change(hand, |light| widen(light, bandwidth));
                });
            }
        }
    }

    /// Moves the chosen light to a world direction.
    pub(super) fn move_light(&mut self, response: &Response, world: Vec3) {
        let Some(selected) = self.selected_light() else {
            return;
        };
        let direction = (self.light_turn().inverse() * world).normalize();
        self.edit_light(response, &selected.id, |hand| {
            change(hand, |light| light.direction = direction);
        });
    }

    /// The wheel over a light changes its width; turns in quick succession are one edit.
    pub(super) fn wheel_width(&mut self, ui: &Ui, response: &Response, under: Option<&ListedLight>) {
        let Some(listed) = under.filter(|_| response.hovered()) else {
            return;
        };
        let (wheel, now) = ui.input_mut(|input| {
            let wheel = std::mem::take(&mut input.smooth_scroll_delta).y;
            (wheel, input.time)
        });
        if wheel == 0.0 {
            return;
        }
        let continues = now - self.light_tab.wheel_secs < WHEEL_PAUSE_SECS;
        self.light_tab.wheel_secs = now;
        self.slider = continues.then_some(response.id);
        let bandwidth = listed.light.bandwidth * (0.004 * wheel).exp();
        self.edit_light(response, &listed.id, |hand| {
            change(hand, |light| widen(light, bandwidth));
        });
    }

    pub(super) fn light_menu(&mut self, ui: &mut Ui) {
        type Switch = fn(&mut HandLight);
        let Some(selected) = self.selected_light() else {
            if ui.button("Add light here").clicked() {
                self.add_light();
                ui.close();
            }
            return;
        };
        ui.strong(&selected.name);
        let switches: [(&str, &str, Switch); 2] = [
            (
                if selected.muted { "Unmute" } else { "Mute" },
                "Takes the light out, or back in",
                |hand| hand.muted = !hand.muted,
            ),
            (
                if selected.solo { "End solo" } else { "Solo" },
                "Only lights that are solo shine",
                |hand| hand.solo = !hand.solo,
            ),
        ];
        for (name, hint, switch) in switches {
            let button = ui.button(name).on_hover_text(hint);
            if button.clicked() {
                self.edit_light(&button, &selected.id, switch);
                ui.close();
            }
        }
        if ui.button("Delete").clicked() {
            self.run(ui.ctx(), Command::DeleteLight);
            ui.close();
        }
        if ui.button("Reset").on_hover_text("As it was fitted").clicked() {
            self.reset_light();
            ui.close();
        }
    }

    /// Puts the chosen light back as it was fitted.
    pub(super) fn reset_light(&mut self) {
        let (Some(document), Some(id)) = (&self.document, &self.light_tab.selected) else {
            return;
        };
        let light = document.project().light.with_reset(id);
        if light != document.project().light {
            self.edit(Edit::SetLight(light));
        }
    }

    /// Adds a white light where the panel was last pressed: a quarter of the environment's energy, or 1 where that is dark.
    pub(super) fn add_light(&mut self) {
        let (Some(document), Some(lighting)) = (&self.document, &self.lighting) else {
            return;
        };
        let world = self.light_tab.menu_at.unwrap_or(Vec3::new(0.5, 0.7, 0.5));
        let mut light = SrbfLight {
            direction: (self.light_turn().inverse() * world).normalize(),
            bandwidth: USUAL_BANDWIDTH,
            radiance: Vec3::ONE,
        };
        let energy = luminance(lighting.lights.energy().as_vec3());
        let wanted = if energy > 0.0 { 0.25 * energy } else { 1.0 };
        light.radiance = Vec3::splat(wanted / light.solid_angle() as f32);
        let (settings, id) = document.project().light.with_added(light);
        self.light_tab.selected = Some(id);
        self.edit(Edit::SetLight(settings));
    }
}

/// Changes the light of a hand-made light that was not deleted.
pub(super) fn change(hand: &mut HandLight, change: impl FnOnce(&mut SrbfLight)) {
    if let Some(light) = &mut hand.light {
        change(light);
    }
}
