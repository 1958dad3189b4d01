//! The lights on a latitude-longitude panel, over the environment as it is turned now: click chooses, drag moves, the wheel
//! or the ring's handle widens, a double click adds, the context menu does the rest.

use std::f32::consts::{PI, TAU};

use balayage_render::light::{SrbfLight, luminance};
use egui::{Color32, CursorIcon, Painter, Pos2, Rect, Response, Role, Sense, Stroke, Ui, WidgetInfo};
use glam::{Quat, Vec2, Vec3};

use super::{Command, Editor, theme};
use crate::document::{Edit, HandLight, ListedLight};

/// What the pointer holds.
#[derive(Clone, Copy)]
pub(super) enum Grab {
    /// A light, and the way from the pointer to its middle, in points.
    Light(egui::Vec2),
    /// The ring of the chosen light, and the way from the pointer to it, in points.
    Width(egui::Vec2),
}

/// Bandwidths that the hand can give, radians-like.
pub(super) const BANDWIDTHS: std::ops::RangeInclusive<f32> = 0.02..=2.0;

/// Bandwidth of a light that is added, radians-like: a softbox.
pub(super) const USUAL_BANDWIDTH: f32 = 0.3;

/// Turns of the wheel farther apart than this are edits of their own, seconds.
const WHEEL_PAUSE_SECS: f64 = 0.6;

/// Place of a world direction on the panel, in [0, 1]^2: the layout of an environment map.
pub(super) fn place_of(direction: Vec3) -> Vec2 {
    let u = direction.x.atan2(-direction.z) / TAU;
    Vec2::new(u.rem_euclid(1.0), direction.y.clamp(-1.0, 1.0).acos() / PI)
}

/// World direction of a place on the panel.
pub(super) fn direction_at(place: Vec2) -> Vec3 {
    let (sin_phi, cos_phi) = (TAU * place.x).sin_cos();
    let (sin_theta, cos_theta) = (PI * place.y.clamp(0.0, 1.0)).sin_cos();
    Vec3::new(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta)
}

/// A light's colour at full brightness.
pub(super) fn hue(light: &SrbfLight) -> Color32 {
    let [r, g, b] = (light.radiance / light.radiance.max_element().max(f32::MIN_POSITIVE)).to_array();
    egui::Rgba::from_rgb(r, g, b).into()
}

/// Gives a light another bandwidth at the same energy.
pub(super) fn widen(light: &mut SrbfLight, bandwidth: f32) {
    let energy = light.energy();
    light.bandwidth = bandwidth.clamp(*BANDWIDTHS.start(), *BANDWIDTHS.end());
    light.radiance = (energy / light.solid_angle()).as_vec3();
}

impl Editor {
    pub(super) fn light_map(&mut self, ui: &mut Ui) {
        let width = ui.available_width().clamp(120.0, 480.0);
        let size = egui::vec2(width, 0.5 * width);
        let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Light map"));
        let painter = ui.painter_at(rect);
        self.paint_environment(&painter, rect);

        let turn = self.light_turn();
        let lights = self.listed_lights();
        let places: Vec<Pos2> = lights
            .iter()
            .map(|listed| on_panel(turn * listed.light.direction, rect))
            .collect();
        let selected = lights
            .iter()
            .position(|listed| Some(&listed.id) == self.light_tab.selected.as_ref());
        let ring = selected.map(|index| ring_of(turn * lights[index].light.direction, &lights[index].light));
        let knob = selected.zip(ring.as_ref()).map(|(index, ring)| {
            // The ring of a narrow light lies under its disc: the knob stays beside it.
            let (disc, at) = (places[index], on_panel(ring[0], rect));
            let beside = disc_radius(&lights[index].light) + 8.0;
            let is_wide = (at.x - disc.x).abs() >= beside;
            (
                if is_wide {
                    at
                } else {
                    disc + egui::vec2(beside, 0.0)
                },
                at,
            )
        });
        self.paint_lights(ui, &painter, rect, &lights, &places);
        if let (Some(ring), Some((knob, _))) = (&ring, knob) {
            paint_ring(&painter, rect, ring);
            let handle = Rect::from_center_size(knob, egui::Vec2::splat(7.0));
            painter.rect(
                handle,
                1.0,
                theme::ACCENT,
                Stroke::new(1.0, Color32::BLACK),
                egui::StrokeKind::Middle,
            );
            ui.interact(handle, response.id.with("width"), Sense::hover())
                .widget_info(|| WidgetInfo::labeled(Role::Slider, true, "Width handle"));
        }

        let pointed = response.hover_pos().or(response.interact_pointer_pos());
        let under = pointed.and_then(|at| nearest(at, &lights, &places, selected));
        let over_knob = pointed
            .zip(knob)
            .filter(|(at, (knob, _))| at.distance(*knob) < 6.0)
            .map(|(_, (knob, ring))| ring - knob);
        if response.hovered() && (under.is_some() || over_knob.is_some()) {
            ui.ctx().set_cursor_icon(CursorIcon::Grab);
        }
        self.grab_light(ui, &response, rect, &lights, &places, under, over_knob);
        self.wheel_width(ui, &response, under.map(|index| &lights[index]));
        response.context_menu(|ui| self.light_menu(ui));
        let hovered = under.filter(|_| response.hovered() && !response.dragged());
        response.on_hover_text_at_pointer(match hovered {
            Some(index) => format!(
                "{}: drag moves it, the wheel changes its width, right click for more",
                lights[index].name
            ),
            None => "Click chooses a light, a double click adds one".to_owned(),
        });
    }

    /// How the environment is turned.
    pub(super) fn light_turn(&self) -> Quat {
        let turn = self
            .document
            .as_ref()
            .map_or(0.0, |document| document.project().light.rotation_deg.to_radians());
        Quat::from_rotation_y(turn)
    }

    fn paint_environment(&self, painter: &Painter, rect: Rect) {
        painter.rect_filled(rect, 0.0, Color32::from_gray(20));
        let (Some(texture), Some(document)) = (&self.light_tab.panorama, &self.document) else {
            return;
        };
        let shift = (document.project().light.rotation_deg / 360.0).rem_euclid(1.0);
        let uv = Rect::from_min_max(Pos2::new(shift, 0.0), Pos2::new(1.0 + shift, 1.0));
        painter.image(texture.id(), rect, uv, Color32::WHITE);
    }

    /// Discs: size tells the bandwidth, fill the colour; hand-made lights have the accent's rim, dark ones no fill.
    fn paint_lights(&self, ui: &Ui, painter: &Painter, rect: Rect, lights: &[ListedLight], places: &[Pos2]) {
        let mut order: Vec<usize> = (0..lights.len()).collect();
        order.sort_by(|a, b| lights[*b].light.bandwidth.total_cmp(&lights[*a].light.bandwidth));
        for index in order {
            let (listed, at) = (&lights[index], places[index]);
            let is_selected = Some(&listed.id) == self.light_tab.selected.as_ref();
            let disc = disc_radius(&listed.light);
            let is_by_hand = matches!(listed.id, crate::document::LightId::Hand(_));
            let rim = match (is_selected, is_by_hand) {
                (true, _) => Color32::WHITE,
                (false, true) => theme::ACCENT,
                (false, false) => Color32::from_white_alpha(150),
            };
            if listed.shines {
                painter.circle_filled(at, disc, hue(&listed.light).gamma_multiply(0.85));
            }
            painter.circle_stroke(at, disc + 1.0, Stroke::new(1.0, Color32::from_black_alpha(180)));
            painter.circle_stroke(at, disc, Stroke::new(if is_selected { 2.0 } else { 1.0 }, rim));
            if listed.muted {
                let arm = 0.7 * egui::Vec2::splat(disc);
                painter.line_segment([at - arm, at + arm], Stroke::new(1.5, rim));
            }
            // Only for the accessibility tree: the panel itself takes the pointer.
            let name = format!("{} on the map", listed.name);
            let area = Rect::from_center_size(at, egui::Vec2::splat(2.0 * disc)).intersect(rect);
            ui.interact(area, ui.scope_id().with(&name), Sense::hover())
                .widget_info(|| WidgetInfo::selected(Role::RadioButton, true, is_selected, &name));
        }
    }

    #[expect(
        clippy::too_many_arguments,
        reason = "one frame of one panel, nothing outlives it"
    )]
    fn grab_light(
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
    fn wheel_width(&mut self, ui: &Ui, response: &Response, under: Option<&ListedLight>) {
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

    fn light_menu(&mut self, ui: &mut Ui) {
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

fn on_panel(direction: Vec3, rect: Rect) -> Pos2 {
    let place = place_of(direction);
    rect.min + egui::vec2(place.x * rect.width(), place.y * rect.height())
}

fn in_panel(at: Pos2, rect: Rect) -> Vec2 {
    let place = (at - rect.min) / rect.size();
    Vec2::new(place.x, place.y)
}

/// Radius of a light's disc, points.
pub(super) fn disc_radius(light: &SrbfLight) -> f32 {
    (3.0 + 8.0 * light.bandwidth).min(12.0)
}

/// The light under the pointer: the chosen one before others, then the nearest.
fn nearest(at: Pos2, lights: &[ListedLight], places: &[Pos2], selected: Option<usize>) -> Option<usize> {
    let reached = |index: &usize| at.distance(places[*index]) <= disc_radius(&lights[*index].light) + 2.0;
    selected.filter(reached).or_else(|| {
        let distance = |index: &usize| at.distance(places[*index]);
        (0..lights.len())
            .filter(reached)
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    })
}

/// Directions at one bandwidth from a light's middle; the first lies to its right.
fn ring_of(towards: Vec3, light: &SrbfLight) -> Vec<Vec3> {
    let angle = light.bandwidth.min(0.98 * PI);
    let right = Vec3::Y.cross(towards).try_normalize().unwrap_or(Vec3::X);
    let up = towards.cross(right);
    let at = |k: usize| {
        let (sin, cos) = (TAU * k as f32 / 64.0).sin_cos();
        angle.cos() * towards + angle.sin() * (-cos * right + sin * up)
    };
    (0..=64).map(at).collect()
}

/// The ring; pieces that cross the panel's edge are left out.
fn paint_ring(painter: &Painter, rect: Rect, ring: &[Vec3]) {
    let places: Vec<Pos2> = ring.iter().map(|w| on_panel(*w, rect)).collect();
    for (a, b) in places.iter().zip(&places[1..]) {
        if (a.x - b.x).abs() < 0.5 * rect.width() {
            painter.line_segment([*a, *b], Stroke::new(2.5, Color32::from_black_alpha(110)));
            painter.line_segment([*a, *b], Stroke::new(1.0, theme::ACCENT));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_directions_lead_back() {
        for (u, v) in [(0.1, 0.3), (0.5, 0.5), (0.93, 0.8), (0.25, 0.02)] {
            let direction = direction_at(Vec2::new(u, v));
            assert!(place_of(direction).abs_diff_eq(Vec2::new(u, v), 1e-4));
        }
        // The middle of the panel is +z, its right quarter -x.
        assert!(direction_at(Vec2::new(0.5, 0.5)).abs_diff_eq(Vec3::Z, 1e-6));
        assert!(direction_at(Vec2::new(0.75, 0.5)).abs_diff_eq(-Vec3::X, 1e-6));
    }

    #[test]
    fn widening_keeps_the_energy_and_the_ring_has_the_width() {
        let mut light = SrbfLight {
            direction: Vec3::new(0.6, 0.8, 0.0),
            bandwidth: 0.1,
            radiance: Vec3::new(9.0, 5.0, 1.0),
        };
        let energy = light.energy();
        widen(&mut light, 0.7);
        assert!(light.energy().abs_diff_eq(energy, 1e-6) && light.bandwidth == 0.7);
        let ring = ring_of(light.direction, &light);
        let to_right = place_of(ring[0]).x - place_of(light.direction).x;
        assert!(to_right.rem_euclid(1.0) < 0.5, "{to_right}");
        assert!(
            ring.iter()
                .all(|w| (w.angle_between(light.direction) - 0.7).abs() < 1e-4)
        );
        widen(&mut light, 99.0);
        assert_eq!(light.bandwidth, *BANDWIDTHS.end());
    }
}
