//! The brush as the pointer shows it: its ring, the outline of a lasso.

use balayage_render::param::Channel;
use egui::{Color32, Pos2, Rect, Response, Stroke, Ui};
use glam::Vec2;

use super::{
    Editor,
    viewport::{Gesture, in_picture, swatch},
};
use crate::tool::Tool;

impl Editor {
    /// Radius of the brush on the screen, in points, at the depth of what lies under `at`.
    pub(super) fn ring_radius(&self, at: Pos2, rect: Rect) -> f32 {
        let (Some(camera), Some(document)) = (&self.camera, &self.document) else {
            return 0.0;
        };
        let radius = 0.01 * self.brush.radius_cm / document.groom().metres_per_unit();
        let picks = self.shown.as_ref().and_then(|shown| shown.picks.as_ref());
        let depth = picks
            .and_then(|picks| picks.place(in_picture(Vec2::new(at.x, at.y), rect)))
            .map_or(camera.pivot_depth(), |place| {
                let pose = camera.camera().world_from_camera;
                (camera.camera().position() - place).dot(pose.z_axis.truncate())
            });
        camera.pixels(radius, depth, rect.height())
    }

    /// The brush's ring with its hard core; its colour is the dye's.
    pub(super) fn ring(&self, ui: &Ui, rect: Rect, response: &Response) {
        let Some(at) = response.hover_pos().or(response.interact_pointer_pos()) else {
            return;
        };
        if self.is_over_handle(at, rect) || matches!(self.gesture, Gesture::MoveLight { .. }) {
            ui.ctx().set_cursor_icon(egui::CursorIcon::Grab);
            return;
        }
        let at = match self.gesture {
            Gesture::Adjust(adjusting) => adjusting.at,
            _ => at,
        };
        let painter = ui.painter_at(rect);
        if !self.tool.strokes() {
            ui.ctx().set_cursor_icon(egui::CursorIcon::Crosshair);
            let outline: Vec<Pos2> = self.outline.iter().map(|p| Pos2::new(p.x, p.y)).collect();
            painter.add(egui::Shape::closed_line(
                outline,
                Stroke::new(1.5, Color32::from_gray(230)),
            ));
            return;
        }
        // On its string the brush lags behind the pointer.
        let at = match &self.gesture {
            Gesture::Stroke(path) if self.brush.string > 0.0 => {
                let brush = Pos2::new(path.place().x, path.place().y);
                painter.line_segment([brush, at], Stroke::new(1.0, Color32::from_gray(200)));
                brush
            }
            _ => at,
        };
        let radius = self.ring_radius(at, rect);
        let color = match (self.tool, self.brush.channel) {
            (Tool::Paint | Tool::Comb, Channel::Dye) => swatch(self.dyes.seen),
            _ => Color32::from_gray(220),
        };
        painter.circle_stroke(at, radius, Stroke::new(3.0, Color32::from_black_alpha(120)));
        painter.circle_stroke(at, radius, Stroke::new(1.5, color));
        // Strength is seen while it is set only.
        if let Gesture::Adjust(_) = self.gesture {
            let text = format!(
                "{:.1} cm, strength {:.0} %",
                self.brush.radius_cm,
                100.0 * self.brush.strength
            );
            let font = egui::TextStyle::Body.resolve(ui.style());
            painter.circle_filled(at, radius, color.gamma_multiply(0.4 * self.brush.strength));
            painter.text(at, egui::Align2::CENTER_CENTER, text, font, Color32::WHITE);
        }
        painter.circle_stroke(
            at,
            radius * self.brush.hardness,
            Stroke::new(1.0, color.gamma_multiply(0.5)),
        );
    }
}
