//! A and B: an earlier look of the hair beside the present one, with a slider between them.

use balayage_render::param::VertexParams;
use egui::{
    Color32, Pos2, Rect, Role, Sense, Stroke, TextureHandle, Ui, Vec2, WidgetInfo, accesskit::Action,
};

use super::{
    Editor,
    viewer::{LightInput, SceneInput, ViewRequest, Viewer, ViewerEvent},
};
use crate::paint::DirtyRanges;

/// Looks that are kept; each takes the parameters of every point.
const MAX_SNAPSHOTS: usize = 8;
/// Half width of what grabs the slider, points.
const GRIP: f32 = 5.0;
/// What an arrow key moves it by.
const STEP: f32 = 0.02;

/// A look of the document.
struct Snapshot {
    name: String,
    scene: SceneInput,
    params: Vec<VertexParams>,
    light: Option<LightInput>,
}

/// The comparison; no part of the project.
pub(super) struct Compare {
    is_on: bool,
    snapshots: Vec<Snapshot>,
    /// The snapshot on the left; none: the unpainted hair.
    chosen: Option<usize>,
    /// Place of the slider, 0 left, 1 right.
    split: f32,
    /// Draws the left side, on a device of its own; it rests while nothing is compared.
    viewer: Option<Viewer>,
    picture: Option<TextureHandle>,
    /// Names are not given twice.
    taken: usize,
}

impl Default for Compare {
    fn default() -> Self {
        Self {
            is_on: false,
            snapshots: Vec::new(),
            chosen: None,
            split: 0.5,
            viewer: None,
            picture: None,
            taken: 0,
        }
    }
}

impl Compare {
    pub(super) fn is_on(&self) -> bool {
        self.is_on
    }

    /// Another document: its looks go.
    pub(super) fn clear(&mut self) {
        *self = Self {
            viewer: self.viewer.take(),
            ..Self::default()
        };
    }

    fn left_name(&self) -> &str {
        self.chosen
            .and_then(|i| self.snapshots.get(i))
            .map_or("Unpainted", |snapshot| &snapshot.name)
    }
}

impl Editor {
    /// Keeps the present look.
    pub(super) fn take_snapshot(&mut self) {
        let (Some(document), Some(scene)) = (&self.document, &self.scene) else {
            return;
        };
        if self.compare.snapshots.len() == MAX_SNAPSHOTS {
            self.say(format!(
                "There are {MAX_SNAPSHOTS} snapshots: remove one in the History tab first"
            ));
            return;
        }
        let (scene, params, light) = (scene.clone(), document.params().to_vec(), self.light_input());
        let compare = &mut self.compare;
        compare.taken += 1;
        let name = format!("Snapshot {}", compare.taken);
        self.say(format!("Took {}", name.to_lowercase()));
        self.compare.snapshots.push(Snapshot {
            name,
            scene,
            params,
            light,
        });
        self.compare.chosen = Some(self.compare.snapshots.len() - 1);
        self.refresh_compare();
    }

    pub(super) fn toggle_compare(&mut self) {
        self.compare.is_on = !self.compare.is_on;
        self.refresh_compare();
        if self.compare.is_on {
            let left = self.compare.left_name().to_owned();
            self.say(format!("Left: {left}, right: now"));
        }
    }

    /// Tells the left side's viewer what to draw.
    pub(super) fn refresh_compare(&mut self) {
        let (Some(document), true) = (&self.document, self.compare.is_on) else {
            return;
        };
        let chosen = self.compare.chosen.and_then(|i| self.compare.snapshots.get(i));
        let (scene, params, light) = match chosen {
            Some(snapshot) => (
                Some(snapshot.scene.clone()),
                snapshot.params.clone(),
                snapshot.light.clone(),
            ),
            None => (
                self.scene.clone(),
                document.unpainted_params(),
                self.light_input(),
            ),
        };
        let (Some(scene), Some(light)) = (scene, light) else {
            return;
        };
        let context = &self.context;
        let viewer = self.compare.viewer.get_or_insert_with(|| Viewer::start(context));
        viewer.set_scene(scene);
        viewer.set_params(&params, &DirtyRanges::all(params.len()));
        viewer.set_light(light);
    }

    /// Asks for the left side of `view` and takes it when it is there.
    pub(super) fn drive_compare(&mut self, view: ViewRequest) {
        let compare = &mut self.compare;
        let (Some(viewer), true) = (&mut compare.viewer, compare.is_on) else {
            return;
        };
        viewer.set_view(view);
        let mut failed = None;
        for event in viewer.events() {
            match event {
                ViewerEvent::Frame(frame) => {
                    let image = egui::ColorImage::from_rgba_unmultiplied(frame.size, &frame.rgba);
                    let options = egui::TextureOptions::LINEAR;
                    match &mut compare.picture {
                        Some(texture) => texture.set(image, options),
                        None => {
                            compare.picture = Some(self.context.load_texture("before", image, options));
                        }
                    }
                }
                ViewerEvent::Failed(reason) => failed = Some(reason),
                ViewerEvent::Lost(reason) => log::warn!("comparison: {reason}; it is drawn anew"),
                ViewerEvent::Adapter(_) => {}
            }
        }
        if let Some(reason) = failed {
            self.compare.is_on = false;
            let remedy = "compare again, or close other programs that use the GPU";
            self.complain(&crate::Problem::at("comparison", reason, remedy));
        }
    }

    /// Paints the left side over the picture, and the slider.
    pub(super) fn paint_compare(&mut self, ui: &Ui, rect: Rect) {
        if !self.compare.is_on {
            return;
        }
        let split = self.compare.split;
        let x = rect.left() + split * rect.width();
        if let Some(picture) = &self.compare.picture {
            let left = Rect::from_min_max(rect.min, Pos2::new(x, rect.bottom()));
            let part = Rect::from_min_max(Pos2::ZERO, Pos2::new(split, 1.0));
            ui.painter().image(picture.id(), left, part, Color32::WHITE);
        }
        let names = [
            (
                rect.left_top() + Vec2::new(10.0, 8.0),
                egui::Align2::LEFT_TOP,
                self.compare.left_name(),
            ),
            (
                rect.right_top() + Vec2::new(-10.0, 8.0),
                egui::Align2::RIGHT_TOP,
                "Now",
            ),
        ];
        for (at, align, name) in names {
            let font = egui::TextStyle::Body.resolve(ui.style());
            ui.painter().text(at, align, name, font, Color32::from_gray(200));
        }
        self.split_slider(ui, rect, x);
    }

    fn split_slider(&mut self, ui: &Ui, rect: Rect, x: f32) {
        let grip = Rect::from_min_max(
            Pos2::new(x - GRIP, rect.top()),
            Pos2::new(x + GRIP, rect.bottom()),
        );
        let slider = ui.interact(grip, egui::Id::unique("split"), Sense::click_and_drag());
        let mut split = self.compare.split;
        if let Some(at) = slider.interact_pointer_pos().filter(|_| slider.dragged()) {
            split = (at.x - rect.left()) / rect.width().max(1.0);
        }
        // Arrow keys while it has the focus, and what assistive technology asks for.
        if slider.has_focus() {
            ui.memory_mut(|memory| {
                let filter = egui::EventFilter {
                    horizontal_arrows: true,
                    ..Default::default()
                };
                memory.set_focus_lock_filter(slider.id, filter);
            });
            ui.input(|input| {
                split += STEP * input.num_presses(egui::Key::ArrowRight) as f32;
                split -= STEP * input.num_presses(egui::Key::ArrowLeft) as f32;
            });
        }
        ui.input(|input| {
            split += STEP * input.num_accesskit_action_requests(slider.id, Action::Increment) as f32;
            split -= STEP * input.num_accesskit_action_requests(slider.id, Action::Decrement) as f32;
        });
        self.compare.split = split.clamp(0.0, 1.0);
        slider.widget_info(|| WidgetInfo::slider(true, f64::from(split), "Before and after"));
        if slider.hovered() || slider.dragged() {
            ui.ctx().set_cursor_icon(egui::CursorIcon::ResizeHorizontal);
        }
        let color = if slider.has_focus() {
            super::theme::ACCENT
        } else {
            Color32::from_gray(230)
        };
        let painter = ui.painter_at(rect);
        painter.vline(
            x,
            rect.y_range(),
            Stroke::new(3.0, Color32::from_black_alpha(120)),
        );
        painter.vline(x, rect.y_range(), Stroke::new(1.5, color));
        painter.circle_filled(Pos2::new(x, rect.center().y), GRIP, color);
    }

    /// The looks that can stand on the left.
    pub(super) fn snapshot_list(&mut self, ui: &mut Ui) {
        ui.strong("Compare with");
        let mut chosen = self.compare.chosen;
        ui.radio_value(&mut chosen, None, "Unpainted");
        let mut removed = None;
        for (i, snapshot) in self.compare.snapshots.iter().enumerate() {
            ui.horizontal(|ui| {
                ui.radio_value(&mut chosen, Some(i), &snapshot.name);
                let remove = ui.small_button("Remove");
                let name = format!("Remove {}", snapshot.name);
                remove.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
                if remove.clicked() {
                    removed = Some(i);
                }
            });
        }
        if let Some(i) = removed {
            self.compare.snapshots.remove(i);
            chosen = None;
        }
        if chosen != self.compare.chosen {
            self.compare.chosen = chosen;
            self.refresh_compare();
        }
        ui.horizontal(|ui| {
            for command in [super::Command::TakeSnapshot, super::Command::Compare] {
                if ui.button(command.label()).on_hover_text(command.hint()).clicked() {
                    self.run(ui.ctx(), command);
                }
            }
        });
    }
}
