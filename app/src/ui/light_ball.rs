//! Lights as handles in the viewport: discs on a ball around the hair, each where its light comes from.

use balayage_render::gpu::Camera;
use egui::{Color32, Pos2, Rect, Response, Role, Sense, Stroke, Ui, WidgetInfo};
use glam::{Vec2, Vec3};

use super::{
    Editor,
    light_place::{disc_radius, hue},
    theme,
    viewport::Gesture,
};
use crate::document::ListedLight;

/// Radius of the ball over the longest side of the hair's box.
const REACH: f32 = 0.6;

/// The ball and the camera that sees it.
#[derive(Clone, Copy)]
struct Ball {
    center: Vec3,
    radius: f32,
    camera: Camera,
    /// Width to height of the viewport.
    aspect: f32,
}

impl Ball {
    /// Place in [0, 1]^2 of the viewport of the handle in a direction, and whether it is on the near half; none behind the camera.
    fn place(&self, direction: Vec3) -> Option<(Vec2, bool)> {
        let view_from_world = self.camera.world_from_camera.inverse();
        let at = view_from_world.transform_point3(self.center + self.radius * direction);
        let center = view_from_world.transform_point3(self.center);
        if at.z >= 0.0 {
            return None;
        }
        let half = (0.5 * self.camera.fov_y_rad).tan() * -at.z;
        let place = Vec2::new(0.5 + 0.5 * at.x / (half * self.aspect), 0.5 - 0.5 * at.y / half);
        Some((place, at.z > center.z))
    }

    /// Direction of the handle under a place of the viewport, on the near or far half; beside the ball the nearest of its outline.
    fn direction(&self, place: Vec2, is_near: bool) -> Vec3 {
        let pose = self.camera.world_from_camera;
        let half = (0.5 * self.camera.fov_y_rad).tan();
        let in_view = Vec3::new(
            (2.0 * place.x - 1.0) * half * self.aspect,
            (1.0 - 2.0 * place.y) * half,
            -1.0,
        );
        let ray = pose.transform_vector3(in_view).normalize();
        let to_center = self.center - self.camera.position();
        let along = ray.dot(to_center);
        let inside = self.radius * self.radius - (to_center.length_squared() - along * along);
        let step = inside.max(0.0).sqrt();
        let t = if is_near && along > step {
            along - step
        } else {
            along + step
        };
        (t * ray - to_center).try_normalize().unwrap_or(Vec3::Y)
    }
}

impl Editor {
    pub(super) fn handles_checkbox(&mut self, ui: &mut Ui) {
        ui.checkbox(&mut self.light_tab.show_handles, "Light handles")
            .on_hover_text("Lights as discs around the hair; drag one to move its light");
    }

    fn ball(&self) -> Option<Ball> {
        let (document, camera) = (self.document.as_ref()?, self.camera.as_ref()?);
        let (low, high) = document.groom().bounds();
        Some(Ball {
            center: 0.5 * (low + high),
            radius: REACH * (high - low).max_element(),
            camera: *camera.camera(),
            aspect: self.aspect,
        })
    }

    /// The lights with their places on the screen, far ones first.
    fn handles(&self, rect: Rect) -> Vec<(ListedLight, Pos2, bool)> {
        let Some(ball) = self.ball().filter(|_| self.light_tab.show_handles) else {
            return Vec::new();
        };
        let turn = self.light_turn();
        let on_screen = |listed: ListedLight| {
            let (place, is_near) = ball.place(turn * listed.light.direction)?;
            let at = rect.min + egui::vec2(place.x * rect.width(), place.y * rect.height());
            rect.contains(at).then_some((listed, at, is_near))
        };
        let mut handles: Vec<_> = self.listed_lights().into_iter().filter_map(on_screen).collect();
        handles.sort_by_key(|(.., is_near)| *is_near);
        handles
    }

    /// Draws the handles; those behind the hair are faint.
    pub(super) fn paint_handles(&self, ui: &Ui, rect: Rect) {
        let painter = ui.painter_at(rect);
        for (listed, at, is_near) in self.handles(rect) {
            let is_selected = self.light_tab.selected.as_ref() == Some(&listed.id);
            let strength = if is_near { 1.0 } else { 0.35 };
            let radius = disc_radius(&listed.light);
            let rim = if is_selected {
                theme::ACCENT
            } else {
                Color32::from_gray(235)
            };
            if listed.shines {
                painter.circle_filled(at, radius, hue(&listed.light).gamma_multiply(0.8 * strength));
            }
            let width = if is_selected { 2.5 } else { 1.0 };
            painter.circle_stroke(at, radius + 1.0, Stroke::new(1.0, Color32::from_black_alpha(140)));
            painter.circle_stroke(at, radius, Stroke::new(width, rim.gamma_multiply(strength)));
            // Only for the accessibility tree: the viewport itself takes the pointer.
            let name = format!("{} handle", listed.name);
            let area = Rect::from_center_size(at, egui::Vec2::splat(2.0 * radius));
            ui.interact(area, ui.scope_id().with(&name), Sense::hover())
                .widget_info(|| WidgetInfo::labeled(Role::RadioButton, true, &name));
        }
    }

    /// The nearest handle under the pointer, near ones before far ones.
    fn handle_at(&self, at: Pos2, rect: Rect) -> Option<(ListedLight, Pos2, bool)> {
        let handles = self.handles(rect).into_iter();
        handles
            .filter(|(listed, place, _)| place.distance(at) <= disc_radius(&listed.light) + 2.0)
            .min_by(|(_, a, near_a), (_, b, near_b)| {
                near_b.cmp(near_a).then(a.distance(at).total_cmp(&b.distance(at)))
            })
    }

    /// True where a press would take hold of a handle.
    pub(super) fn is_over_handle(&self, at: Pos2, rect: Rect) -> bool {
        self.handle_at(at, rect).is_some()
    }

    /// Takes hold of the handle under the pointer, if there is one.
    pub(super) fn grab_handle(&mut self, at: Pos2, rect: Rect) -> Option<Gesture> {
        let (listed, place, is_near) = self.handle_at(at, rect)?;
        self.light_tab.selected = Some(listed.id);
        let offset = place - at;
        Some(Gesture::MoveLight {
            is_near,
            offset: Vec2::new(offset.x, offset.y),
        })
    }

    /// Moves the chosen light with the pointer.
    pub(super) fn drag_handle(&mut self, response: &Response, rect: Rect, offset: Vec2, is_near: bool) {
        let (Some(ball), Some(at)) = (self.ball(), response.interact_pointer_pos()) else {
            return;
        };
        let place = (at + egui::vec2(offset.x, offset.y) - rect.min) / rect.size();
        let direction = ball.direction(Vec2::new(place.x, place.y), is_near);
        self.move_light(response, direction);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn handles_lie_where_the_pointer_finds_them() {
        let ball = Ball {
            center: Vec3::new(0.1, 1.0, -0.2),
            radius: 0.3,
            camera: Camera::look_at(Vec3::new(0.8, 1.6, 1.2), Vec3::new(0.1, 1.0, -0.2), 0.6),
            aspect: 1.5,
        };
        for direction in [
            Vec3::Y,
            Vec3::Z,
            -Vec3::Z,
            Vec3::new(0.6, 0.0, -0.8),
            Vec3::new(-0.6, -0.8, 0.0),
        ] {
            let (place, is_near) = ball.place(direction).unwrap();
            assert!(
                ball.direction(place, is_near).abs_diff_eq(direction, 1e-3),
                "{direction}"
            );
        }
        // Beside the ball the outline is meant, which lies across the line of sight.
        let beside = ball.direction(Vec2::new(0.99, 0.5), true);
        let sight = (ball.center - ball.camera.position()).normalize();
        assert!(beside.dot(sight).abs() < 0.5);
    }
}
