//! The viewport: the picture, and what the pointer does to it.

use balayage_render::gpu::{Method, RenderSettings, ShadeSettings};
use egui::{Color32, Event, Modifiers, PointerButton, Pos2, Rect, Response, Role, Sense, Ui, WidgetInfo};
use glam::Vec2;

use super::{
    Editor,
    adjust::Adjusting,
    theme,
    viewer::{Motion, ViewRequest},
};
use crate::{
    document::Edit,
    tool::{StrokePath, Tool},
};

/// What the pointer is doing in the viewport.
#[derive(Clone, Copy, Debug)]
pub(super) enum Gesture {
    None,
    Orbit,
    Pan,
    Zoom,
    /// Turning the environment.
    TurnLight,
    /// Moving the chosen light by its handle: on the near half of its ball, and the way from the pointer to it, points.
    MoveLight {
        is_near: bool,
        offset: Vec2,
    },
    /// Changing radius and hardness of the brush.
    SizeBrush,
    /// Changing one value of the brush by moving the pointer, no button held.
    Adjust(Adjusting),
    /// A stroke; its path in points of the screen.
    Stroke(StrokePath),
    /// An outline is drawn; its path in points of the screen.
    Lasso(StrokePath),
}

/// Distance between the corners of a lasso's outline, in points of the screen.
const LASSO_STEP: f32 = 8.0;

impl Editor {
    pub(super) fn viewport(&mut self, ui: &mut Ui) {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Viewport"));
        self.aspect = rect.width().max(1.0) / rect.height().max(1.0);
        self.ask_for_picture(ui, rect);
        match &self.shown {
            Some(shown) => {
                let all = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
                ui.painter().image(shown.texture.id(), rect, all, Color32::WHITE);
            }
            None => {
                ui.painter().rect_filled(rect, 0.0, Color32::from_gray(50));
                if self.document.is_some() {
                    note(ui, rect, "Preparing the first picture…");
                }
            }
        }
        if self.document.is_none() {
            if self.opening.is_none() {
                self.welcome(ui, rect);
            }
            return;
        }
        self.steer(ui, rect, &response);
        self.paint_handles(ui, rect);
        self.ring(ui, rect, &response);
        self.paint_compare(ui, rect);
        self.legend(ui, rect);
        self.hints(ui, rect);
    }

    /// Asks for the picture of the present camera at the size of the viewport.
    fn ask_for_picture(&mut self, ui: &Ui, rect: Rect) {
        let Some(camera) = &self.camera else { return };
        let pixels = rect.size() * ui.ctx().pixels_per_point();
        let hair = self.document.as_ref().map(|document| &document.project().hair);
        let view = ViewRequest {
            camera: *camera.camera(),
            size: [(pixels.x as u32).max(1), (pixels.y as u32).max(1)],
            settings: RenderSettings {
                shade: ShadeSettings {
                    method: Method {
                        model: hair.map(|hair| hair.model).unwrap_or_default(),
                        scheme: hair.map(|hair| hair.scheme).unwrap_or_default(),
                        ..Method::default()
                    },
                    terms: self.view.terms,
                    ..ShadeSettings::default()
                },
                view: self.view.transform,
                view_exposure_ev: self.view.exposure_ev,
                show_background: self.view.show_background,
                backdrop: theme::BACKDROP,
                ..RenderSettings::default()
            },
            debug: self.view.debug,
            motion: match self.gesture {
                Gesture::Stroke(_) => Motion::Painting,
                Gesture::Lasso(_) => Motion::Still,
                Gesture::None | Gesture::SizeBrush | Gesture::Adjust(_)
                    if self.slider.is_none() && !self.is_playing() && !self.turns =>
                {
                    Motion::Still
                }
                _ => Motion::Moving,
            },
        };
        self.viewer.set_view(view);
        self.drive_compare(view);
    }

    /// Starts, continues and ends gestures.
    fn steer(&mut self, ui: &Ui, rect: Rect, response: &Response) {
        let (modifiers, delta, wheel, escape) = ui.input(|input| {
            let escape = input.key_pressed(egui::Key::Escape);
            (
                input.modifiers,
                input.pointer.delta(),
                input.smooth_scroll_delta().y,
                escape,
            )
        });
        let way = ui.input(|input| pointer_way(&input.events));
        let height = rect.height().max(1.0);
        if response.hovered() && wheel != 0.0 {
            self.look(|camera| camera.zoom(0.004 * wheel));
        }
        if let Gesture::Adjust(adjusting) = self.gesture {
            return self.continue_adjusting(ui, adjusting, Vec2::new(delta.x, delta.y), escape);
        }
        if escape {
            match self.gesture {
                Gesture::Stroke(_) => self.cancel_stroke(),
                Gesture::Lasso(_) => {
                    self.outline.clear();
                    self.gesture = Gesture::None;
                }
                _ => {}
            }
        }
        let pressed = [
            PointerButton::Primary,
            PointerButton::Middle,
            PointerButton::Secondary,
        ]
        .into_iter()
        .find(|button| {
            // A quick hand may press and release within one frame, and move between.
            let [is_pressed, is_released] = ui.input(|input| {
                let pointer = &input.pointer;
                [pointer.button_pressed(*button), pointer.button_released(*button)]
            });
            let is_swift =
                is_released && response.hovered() && way.first().is_some_and(|at| rect.contains(*at));
            is_pressed && (response.is_pointer_button_down_on() || response.clicked_by(*button) || is_swift)
        });
        if let Some(button) = pressed {
            self.gesture = self.started(button, modifiers, way.first().copied(), rect);
        }
        if matches!(self.gesture, Gesture::None) {
            return;
        }

        let drag = Vec2::new(delta.x, delta.y) / height;
        match self.gesture {
            Gesture::Orbit => self.look(|camera| camera.orbit(drag)),
            Gesture::Pan => self.look(|camera| camera.pan(drag)),
            Gesture::Zoom => self.look(|camera| camera.zoom(3.0 * (drag.x - drag.y))),
            Gesture::TurnLight if delta.x != 0.0 => {
                if let Some(document) = &self.document {
                    let mut light = document.project().light.clone();
                    light.rotation_deg = (light.rotation_deg + 0.5 * delta.x).rem_euclid(360.0);
                    self.edit_by(response, Edit::SetLight(light));
                }
            }
            Gesture::SizeBrush => {
                self.brush.scale_radius((0.01 * delta.x).exp());
                self.brush.hardness = (self.brush.hardness - 0.005 * delta.y).clamp(0.0, 1.0);
            }
            Gesture::MoveLight { is_near, offset } if delta != egui::Vec2::ZERO => {
                self.drag_handle(response, rect, offset, is_near);
            }
            Gesture::Stroke(path) => self.continue_stroke(path, &way, rect),
            Gesture::Lasso(mut path) => {
                for at in way {
                    self.outline
                        .extend(path.advance(Vec2::new(at.x, at.y), LASSO_STEP));
                }
                self.gesture = Gesture::Lasso(path);
            }
            Gesture::MoveLight { .. } | Gesture::TurnLight | Gesture::Adjust(_) | Gesture::None => {}
        }
        if !ui.input(|input| input.pointer.any_down()) {
            match (self.gesture, &mut self.document) {
                (Gesture::Stroke(_), Some(document)) => document.commit_stroke(),
                (Gesture::Lasso(_), Some(_)) => self.close_lasso(rect),
                _ => {}
            }
            self.gesture = Gesture::None;
        }
    }

    /// The gesture that a button starts under the present key preset.
    fn started(
        &mut self,
        button: PointerButton,
        modifiers: Modifiers,
        at: Option<Pos2>,
        rect: Rect,
    ) -> Gesture {
        let Modifiers {
            alt, shift, command, ..
        } = modifiers;
        match (button, self.navigates_as_blender()) {
            (PointerButton::Secondary, _) if shift => Gesture::TurnLight,
            (PointerButton::Secondary, _) if command => Gesture::SizeBrush,
            (PointerButton::Middle, true) => {
                if shift {
                    Gesture::Pan
                } else if command {
                    Gesture::Zoom
                } else {
                    Gesture::Orbit
                }
            }
            (PointerButton::Primary, false) if alt => Gesture::Orbit,
            (PointerButton::Middle, false) if alt => Gesture::Pan,
            (PointerButton::Secondary, false) if alt => Gesture::Zoom,
            (PointerButton::Primary, _) => match at {
                Some(at) if self.is_over_handle(at, rect) => {
                    self.grab_handle(at, rect).unwrap_or(Gesture::None)
                }
                Some(at) if self.tool == Tool::Eyedropper => {
                    self.pick_value(at, rect);
                    Gesture::None
                }
                Some(at) if self.tool == Tool::Lasso => {
                    let place = Vec2::new(at.x, at.y);
                    self.outline = vec![place];
                    Gesture::Lasso(StrokePath::new(place))
                }
                Some(at) => self.begin_stroke(at, rect, modifiers),
                None => Gesture::None,
            },
            _ => Gesture::None,
        }
    }

    pub(super) fn look(&mut self, change: impl FnOnce(&mut crate::tool::ViewCamera)) {
        if let Some(camera) = &mut self.camera {
            change(camera);
        }
    }
}

/// Where the pointer was in this frame while a button was held, all of it: a slow frame makes no polygon of a curve. Begins where the button was pressed,
/// if it was in this frame, and ends where it was released.
fn pointer_way(events: &[Event]) -> Vec<Pos2> {
    let mut way = Vec::new();
    for event in events {
        match event {
            Event::PointerMoved(at) => way.push(*at),
            Event::PointerButton { pos, pressed, .. } => {
                if *pressed {
                    way.clear();
                }
                way.push(*pos);
                if !pressed {
                    break;
                }
            }
            _ => {}
        }
    }
    way
}

/// A place on the screen in [0, 1]^2 of the picture.
pub(super) fn in_picture(place: Vec2, rect: Rect) -> Vec2 {
    (place - Vec2::new(rect.min.x, rect.min.y)) / Vec2::new(rect.width().max(1.0), rect.height().max(1.0))
}

/// A colour of hair on the screen, linear Rec.709.
pub(super) fn swatch([r, g, b]: [f32; 3]) -> Color32 {
    egui::Rgba::from_rgb(r, g, b).into()
}

/// A line in the middle of an empty viewport.
fn note(ui: &Ui, rect: Rect, text: &str) {
    let font = egui::TextStyle::Body.resolve(ui.style());
    ui.painter().text(
        rect.center(),
        egui::Align2::CENTER_CENTER,
        text,
        font,
        Color32::from_gray(170),
    );
}
