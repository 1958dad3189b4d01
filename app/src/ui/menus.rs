//! Menu bar, tools and docks.

use balayage_render::gpu::ViewTransform;
use egui::Ui;

use super::{
    Command, Editor,
    editor::Tab,
    settings::{Look, Navigation},
};
use crate::tool::Tool;

impl Editor {
    pub(super) fn menu_bar(&mut self, ui: &mut Ui) {
        use Command as C;
        let menus: [(&str, &[C]); 4] = [
            ("File", &[C::Open, C::OpenSample, C::Save, C::SaveAs, C::Quit]),
            ("Edit", &[C::Undo, C::Redo, C::Palette]),
            (
                "Hair",
                &[
                    C::FrameHair,
                    C::AddLayer,
                    C::DuplicateLayer,
                    C::MergeDown,
                    C::Eyedropper,
                ],
            ),
            (
                "Light",
                &[
                    C::OpenEnvironment,
                    C::OpenLights,
                    C::OpenSequence,
                    C::OpenSequenceFolder,
                    C::PlaySequence,
                    C::NextMap,
                    C::PreviousMap,
                    C::SaveLights,
                    C::DeleteLight,
                ],
            ),
        ];
        egui::MenuBar::new().ui(ui, |ui| {
            for (name, commands) in menus {
                ui.menu_button(name, |ui| {
                    for command in commands {
                        self.menu_item(ui, *command);
                    }
                    if name == "File" {
                        ui.menu_button("Open recent", |ui| self.recent_files(ui));
                        self.backups_setting(ui);
                    }
                });
            }
            ui.menu_button("View", |ui| self.view_menu(ui));
            ui.separator();
            ui.label(self.document_name());
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let compare = egui::Button::selectable(self.compare.is_on(), "A|B");
                let compare = ui.add_enabled(self.is_enabled(C::Compare), compare);
                if compare.on_hover_text(C::Compare.hint()).clicked() {
                    self.run(ui.ctx(), C::Compare);
                }
                for command in [C::Redo, C::Undo] {
                    let button = ui.add_enabled(self.is_enabled(command), egui::Button::new(command.label()));
                    if button.on_hover_text(self.explain(command)).clicked() {
                        self.run(ui.ctx(), command);
                    }
                }
            });
        });
    }

    fn menu_item(&mut self, ui: &mut Ui, command: Command) {
        let keys = self.keymap.keys(command);
        let keys = keys
            .first()
            .map(|keys| ui.ctx().format_shortcut(keys))
            .unwrap_or_default();
        let button = egui::Button::new(command.label()).shortcut_text(keys);
        if ui.add_enabled(self.is_enabled(command), button).clicked() {
            ui.close();
            self.run(ui.ctx(), command);
        }
    }

    fn view_menu(&mut self, ui: &mut Ui) {
        for (transform, name) in [
            (ViewTransform::Neutral, "Khronos PBR Neutral"),
            (ViewTransform::Agx, "AgX"),
            (ViewTransform::Raw, "Raw"),
        ] {
            ui.radio_value(&mut self.view.transform, transform, name);
        }
        ui.separator();
        ui.checkbox(&mut self.view.show_background, "Show environment");
        self.handles_checkbox(ui);
        ui.separator();
        for command in [
            Command::ViewFront,
            Command::ViewBack,
            Command::ViewRight,
            Command::ViewLeft,
            Command::ViewTop,
            Command::ViewBottom,
        ] {
            self.menu_item(ui, command);
        }
        ui.separator();
        for command in [
            Command::Compare,
            Command::Before,
            Command::TakeSnapshot,
            Command::SoloNext,
            Command::AllLight,
        ] {
            self.menu_item(ui, command);
        }
        ui.menu_button("False colours", |ui| self.false_colours_menu(ui));
        ui.menu_button("Hair volume", |ui| self.hair_volume_menu(ui));
        for command in [Command::Turntable, Command::FullScreen, Command::HidePanels] {
            self.menu_item(ui, command);
        }
        ui.separator();
        let (mut look, mut navigation) = (self.settings.values().look, self.settings.values().navigation);
        for (choice, name) in [
            (Look::Dark, "Dark"),
            (Look::Light, "Light theme"),
            (Look::System, "Theme of the system"),
        ] {
            ui.radio_value(&mut look, choice, name);
        }
        ui.separator();
        for (choice, name, hint) in [
            (
                Navigation::Maya,
                "Maya, Substance navigation",
                "Alt with left, middle and right button",
            ),
            (
                Navigation::Blender,
                "Blender navigation",
                "Middle button orbits, with Shift it pans, with Ctrl it zooms; F and Shift+F set the brush",
            ),
        ] {
            ui.radio_value(&mut navigation, choice, name).on_hover_text(hint);
        }
        if (look, navigation) != (self.settings.values().look, self.settings.values().navigation) {
            self.set_preference(|values| (values.look, values.navigation) = (look, navigation));
        }
    }

    /// What a toolbar button will do, with its key.
    fn explain(&self, command: Command) -> String {
        let what = match (command, &self.document) {
            (Command::Undo, Some(document)) => document.undo_label(),
            (Command::Redo, Some(document)) => document.redo_label(),
            _ => None,
        };
        format!("{} {}", command.label(), what.unwrap_or("nothing"))
    }

    pub(super) fn tool_bar(&mut self, ui: &mut Ui) {
        for tool in Tool::ALL {
            ui.selectable_value(&mut self.tool, tool, tool.name())
                .on_hover_text(tool.hint());
        }
    }

    pub(super) fn right_dock(&mut self, ui: &mut Ui) {
        egui::ScrollArea::vertical().show(ui, |ui| {
            ui.heading("Layers");
            self.layers_panel(ui);
            ui.separator();
            ui.horizontal_wrapped(|ui| {
                let spacing = ui.spacing_mut();
                (spacing.item_spacing.x, spacing.button_padding.x) = (2.0, 5.0);
                for (tab, name) in [
                    (Tab::Brush, "Brush"),
                    (Tab::Hair, "Hair"),
                    (Tab::Light, "Light"),
                    (Tab::Operations, "Operations"),
                    (Tab::History, "History"),
                    (Tab::Statistics, "Statistics"),
                ] {
                    ui.selectable_value(&mut self.tab, tab, name);
                }
            });
            match self.tab {
                Tab::Brush => self.brush_panel(ui),
                Tab::Hair => self.hair_panel(ui),
                Tab::Light => self.light_panel(ui),
                Tab::Operations => self.operations_panel(ui),
                Tab::History => self.history_panel(ui),
                Tab::Statistics => self.statistics_panel(ui),
            }
        });
    }
}
