//! The viewport: the picture, looking around, painting, the brush's ring.

use balayage_render::gpu::{Method, RenderSettings, ShadeSettings};
use egui::{Color32, Modifiers, PointerButton, Pos2, Rect, Response, Role, Sense, Stroke, Ui, WidgetInfo};
use glam::Vec2;

use super::{
    Editor, theme,
    viewer::{Motion, ViewRequest},
};
use crate::{
    document::{Edit, Layer},
    paint::{Dab, Mask, MaskKind, MaskPart, Mode, Reach},
    tool::{StrokePath, Tool, dab_at, dabs_through, mirrored},
};
use balayage_render::param::Channel;

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
                note(
                    ui,
                    rect,
                    "Open a project or a groom: File, Open, or drop a file here.",
                );
            }
            return;
        }
        self.steer(ui, rect, &response);
        self.paint_handles(ui, rect);
        self.ring(ui, rect, &response);
    }

    /// Asks for the picture of the present camera at the size of the viewport.
    fn ask_for_picture(&mut self, ui: &Ui, rect: Rect) {
        let Some(camera) = &self.camera else { return };
        let pixels = rect.size() * ui.ctx().pixels_per_point();
        let hair = self.document.as_ref().map(|document| &document.project().hair);
        self.viewer.set_view(ViewRequest {
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
            motion: match self.gesture {
                Gesture::Stroke(_) => Motion::Painting,
                Gesture::Lasso(_) => Motion::Still,
                Gesture::None | Gesture::SizeBrush if self.slider.is_none() && !self.is_playing() => {
                    Motion::Still
                }
                _ => Motion::Moving,
            },
        });
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
        let height = rect.height().max(1.0);
        if response.hovered() && wheel != 0.0 {
            self.look(|camera| camera.zoom(0.004 * wheel));
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
            response.is_pointer_button_down_on() && ui.input(|input| input.pointer.button_pressed(*button))
        });
        if let Some(button) = pressed {
            let at = response.interact_pointer_pos();
            self.gesture = self.started(button, modifiers, at, rect);
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
            Gesture::Stroke(path) => self.continue_stroke(path, response, rect),
            Gesture::Lasso(mut path) => {
                if let Some(at) = response.interact_pointer_pos() {
                    let places = path.advance(Vec2::new(at.x, at.y), LASSO_STEP);
                    self.outline.extend(places);
                    self.gesture = Gesture::Lasso(path);
                }
            }
            Gesture::MoveLight { .. } | Gesture::TurnLight | Gesture::None => {}
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
        match (button, self.view.blender_keys) {
            (PointerButton::Secondary, _) if shift => Gesture::TurnLight,
            (PointerButton::Secondary, _) if command => Gesture::SizeBrush,
            (PointerButton::Middle, true) => {
                if shift {
                    Gesture::Pan
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

    fn look(&mut self, change: impl FnOnce(&mut crate::tool::ViewCamera)) {
        if let Some(camera) = &mut self.camera {
            change(camera);
        }
    }

    /// Limits the layer to strands that are rooted inside the outline that was drawn: each of its corners counts as the root of
    /// the strand that is seen there.
    fn close_lasso(&mut self, rect: Rect) {
        let outline = std::mem::take(&mut self.outline);
        let roots: Vec<[f32; 3]> = outline
            .into_iter()
            .filter_map(|place| self.dabs(place, rect).first().map(|dab| dab.root))
            .collect();
        let layer = self.document.as_ref().and_then(|document| {
            let layers = &document.project().layers;
            layers.iter().find(|layer| layer.id == self.layer).cloned()
        });
        let Some(layer) = layer else { return };
        if roots.len() < 3 {
            self.say("Lasso: draw round hair, so that the outline meets strands");
            return;
        }
        let part = MaskPart {
            kind: MaskKind::Region {
                outline: roots,
                soften_mm: 5.0,
            },
            invert: false,
        };
        let mut parts = layer.mask.parts.clone();
        parts.push(part);
        self.edit(Edit::SetLayer(Layer {
            mask: Mask {
                parts,
                ..layer.mask.clone()
            },
            ..layer
        }));
    }

    /// Starts a stroke; Ctrl inverts it (erases), Shift smooths.
    fn begin_stroke(&mut self, at: Pos2, rect: Rect, modifiers: Modifiers) -> Gesture {
        let tool = match self.tool {
            Tool::Paint | Tool::Comb if modifiers.shift => Tool::Smooth,
            Tool::Paint | Tool::Comb if modifiers.command => Tool::Erase,
            tool => tool,
        };
        let Some(document) = &mut self.document else {
            return Gesture::None;
        };
        let Some(mut operation) = self.brush.operation(tool, &self.layer, document) else {
            return Gesture::None;
        };
        if tool == Tool::Mask && modifiers.command {
            operation.mode = Mode::Erase;
        }
        if let Err(problem) = document.begin_stroke(operation) {
            self.complain(&problem);
            return Gesture::None;
        }
        let place = Vec2::new(at.x, at.y);
        self.paint_at(&[place], rect);
        Gesture::Stroke(StrokePath::new(place))
    }

    fn continue_stroke(&mut self, mut path: StrokePath, response: &Response, rect: Rect) {
        let Some(at) = response.interact_pointer_pos() else {
            return;
        };
        let step = (self.brush.spacing * self.ring_radius(at, rect)).max(2.0);
        let places = path.advance(Vec2::new(at.x, at.y), step);
        self.gesture = Gesture::Stroke(path);
        self.paint_at(&places, rect);
    }

    pub(super) fn cancel_stroke(&mut self) {
        if let Some(document) = &mut self.document {
            let dirty = document.cancel_stroke();
            self.viewer.set_params(document.params(), &dirty);
        }
        self.gesture = Gesture::None;
        self.say("Stroke cancelled");
    }

    /// Adds the dabs that belong to places on the screen.
    fn paint_at(&mut self, places: &[Vec2], rect: Rect) {
        let dabs: Vec<Dab> = places.iter().flat_map(|place| self.dabs(*place, rect)).collect();
        let Some(document) = &mut self.document else {
            return;
        };
        match document.extend_stroke(dabs) {
            Ok(dirty) => self.viewer.set_params(document.params(), &dirty),
            Err(problem) => self.complain(&problem),
        }
    }

    /// The dabs at one place of the screen: one on the visible strand, or one for each depth.
    fn dabs(&self, place: Vec2, rect: Rect) -> Vec<Dab> {
        let picks = self.shown.as_ref().and_then(|shown| shown.picks.as_ref());
        let (Some(picks), Some(document)) = (picks, &self.document) else {
            return Vec::new();
        };
        let Some(point) = picks.place(in_picture(place, rect)) else {
            return Vec::new();
        };
        let radius = 0.01 * self.brush.radius_cm / document.groom().metres_per_unit();
        let index = document.index();
        let pressure = if self.brush.uses_pressure {
            self.pressure
        } else {
            1.0
        };
        let eye = picks.camera.position();
        let sides = [(eye, point), (mirrored(eye), mirrored(point))];
        let count = if self.brush.mirror { 2 } else { 1 };
        let of_side = |(eye, point)| {
            if self.brush.reach == Reach::Through && self.tool != Tool::Comb {
                dabs_through(index, eye, point, radius, pressure)
            } else {
                dab_at(index, point, radius, pressure).into_iter().collect()
            }
        };
        sides.into_iter().take(count).flat_map(of_side).collect()
    }

    /// Takes the value of the touched hair into the brush.
    fn pick_value(&mut self, at: Pos2, rect: Rect) {
        let Some(dab) = self.dabs(Vec2::new(at.x, at.y), rect).into_iter().next() else {
            return;
        };
        let Some(document) = &self.document else { return };
        let radius = 0.01 * self.brush.radius_cm / document.groom().metres_per_unit();
        let mut nearest = (f32::INFINITY, 0);
        document
            .index()
            .for_each_near(dab.position.into(), radius, |point, distance| {
                if distance < nearest.0 {
                    nearest = (distance, point);
                }
            });
        let point = nearest.1 as usize;
        if self.picks_seen_colour {
            let sigma_a = document.params()[point].sigma_a;
            self.brush.channel = Channel::Dye;
            self.brush.dye = sigma_a;
            self.brush.dye_strength = 1.0;
            self.say("Took the seen colour from the hair: all of its absorption, as dye for bleached hair");
            return;
        }
        let values = document.values()[point];
        match self.brush.channel {
            Channel::Dye => {
                self.brush.dye = values.dye;
                self.brush.dye_strength = 1.0;
            }
            channel => self.brush.value = values.get(channel)[0],
        }
        self.say(format!("Took {} from the hair", self.brush.channel.name()));
    }

    /// Radius of the brush on the screen, in points, at the depth of what lies under `at`.
    fn ring_radius(&self, at: Pos2, rect: Rect) -> f32 {
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
    fn ring(&self, ui: &Ui, rect: Rect, response: &Response) {
        let Some(at) = response.hover_pos().or(response.interact_pointer_pos()) else {
            return;
        };
        if self.is_over_handle(at, rect) || matches!(self.gesture, Gesture::MoveLight { .. }) {
            ui.ctx().set_cursor_icon(egui::CursorIcon::Grab);
            return;
        }
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
        let radius = self.ring_radius(at, rect);
        let color = match (self.tool, self.brush.channel) {
            (Tool::Paint | Tool::Comb, Channel::Dye) => swatch(self.dyes.seen),
            _ => Color32::from_gray(220),
        };
        painter.circle_stroke(at, radius, Stroke::new(3.0, Color32::from_black_alpha(120)));
        painter.circle_stroke(at, radius, Stroke::new(1.5, color));
        painter.circle_stroke(
            at,
            radius * self.brush.hardness,
            Stroke::new(1.0, color.gamma_multiply(0.5)),
        );
    }
}

/// A place on the screen in [0, 1]^2 of the picture.
fn in_picture(place: Vec2, rect: Rect) -> Vec2 {
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
