//! What an empty window offers, and the first-run hints.

use egui::{Align2, Rect, Ui, Vec2};

use super::{Command, Editor, actions::PendingAction};

impl Editor {
    /// In the middle of a viewport without a document: what can be opened.
    pub(super) fn welcome(&mut self, ui: &mut Ui, rect: Rect) {
        let size = Vec2::new(rect.width().min(460.0), rect.height().min(360.0));
        let place = Rect::from_center_size(rect.center(), size);
        ui.scope_builder(egui::UiBuilder::new().max_rect(place), |ui| {
            ui.heading("Balayage");
            ui.label("Open a project or a groom, or drop a file here.");
            ui.horizontal(|ui| {
                for command in [Command::Open, Command::OpenSample] {
                    if ui.button(command.label()).clicked() {
                        self.run(ui.ctx(), command);
                    }
                }
            });
            if !self.settings.values().recent.is_empty() {
                ui.separator();
                ui.strong("Recent");
                self.recent_files(ui);
            }
        });
    }

    /// A button for each file that was opened lately.
    pub(super) fn recent_files(&mut self, ui: &mut Ui) {
        let recent = self.settings.values().recent.clone();
        if recent.is_empty() {
            ui.weak("None yet");
        }
        for path in recent {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let button = ui.button(name.into_owned());
            if button.on_hover_text(path.display().to_string()).clicked() {
                ui.close();
                self.guarded(ui.ctx(), PendingAction::Open(path));
            }
        }
    }

    /// What a person has to know to begin, until they have read it.
    pub(super) fn hints(&mut self, ui: &Ui, rect: Rect) {
        if self.settings.values().hints_read {
            return;
        }
        let look = if self.navigates_as_blender() {
            "Middle button turns the view, Shift+middle moves it, the wheel zooms."
        } else {
            "Alt+drag turns the view, Alt+middle moves it, the wheel zooms."
        };
        let area = egui::Area::new(egui::Id::unique("hints"))
            .fixed_pos(rect.left_bottom() + Vec2::new(12.0, -12.0))
            .pivot(Align2::LEFT_BOTTOM);
        area.show(ui.ctx(), |ui| {
            egui::Frame::window(ui.style()).show(ui, |ui| {
                ui.set_max_width(380.0);
                ui.strong("First steps");
                ui.label("Drag over the hair to dye it; [ and ] change the brush's size.");
                ui.label(look);
                ui.label("Ctrl+Z undoes; hold B to see the hair as it was.");
                ui.label("Ctrl+Shift+P or F3 lists every command with its keys.");
                if ui.button("Got it").clicked() {
                    self.set_preference(|values| values.hints_read = true);
                }
            });
        });
    }
}
