//! The lights on a latitude-longitude panel, over the environment as it is turned now: click chooses, drag moves, the wheel
//! or the ring's handle widens, a double click adds, the context menu does the rest (see `light_grab`).

use egui::{Color32, CursorIcon, Painter, Pos2, Rect, Role, Sense, Stroke, Ui, WidgetInfo};
use glam::{Quat, Vec3};

use super::{
    Editor,
    light_place::{disc_radius, hue, nearest, on_panel, ring_of},
    theme,
};
use crate::document::ListedLight;

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
