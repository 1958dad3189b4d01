//! The list of layers, top first.

use egui::{Slider, Ui};

use super::{Command, Editor};
use crate::document::{Blend, Edit, Layer};

const BLENDS: [(Blend, &str, &str); 3] = [
    (Blend::Replace, "Replace", "Strokes act on what lies below"),
    (Blend::Add, "Add", "Paint is added to what lies below"),
    (
        Blend::Multiply,
        "Multiply",
        "Paint is a factor on what lies below",
    ),
];

impl Editor {
    pub(super) fn layers_panel(&mut self, ui: &mut Ui) {
        let Some(document) = &self.document else { return };
        let layers = document.project().layers.clone();
        for (position, layer) in layers.iter().enumerate().rev() {
            ui.horizontal(|ui| self.layer_row(ui, layer, position, layers.len()));
        }
        ui.horizontal(|ui| {
            if ui.button("Add layer").clicked() {
                self.run(ui.ctx(), Command::AddLayer);
            }
            let remove = ui.add_enabled(layers.len() > 1, egui::Button::new("Remove layer"));
            if remove
                .on_hover_text("Removes the chosen layer with its strokes; undo brings it back")
                .clicked()
            {
                self.edit(Edit::RemoveLayer(self.layer.clone()));
            }
        });
        if let Some(layer) = layers.iter().find(|layer| layer.id == self.layer) {
            self.layer_settings(ui, layer);
        }
    }

    fn layer_row(&mut self, ui: &mut Ui, layer: &Layer, position: usize, count: usize) {
        let mut visible = layer.visible;
        let name = &layer.name;
        let check = ui.checkbox(&mut visible, "").on_hover_text("Visible");
        check.widget_info(|| {
            egui::WidgetInfo::selected(egui::Role::CheckBox, true, visible, format!("Show {name}"))
        });
        if check.changed() {
            self.edit(Edit::SetLayer(Layer {
                visible,
                ..layer.clone()
            }));
        }
        if ui.selectable_label(self.layer == layer.id, name).clicked() {
            self.layer.clone_from(&layer.id);
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            for (arrow, to, possible, what) in [
                ("Down", position.saturating_sub(1), position > 0, "down"),
                ("Up", position + 1, position + 1 < count, "up"),
            ] {
                let button = ui.add_enabled(possible, egui::Button::new(arrow).small());
                button.widget_info(|| {
                    egui::WidgetInfo::labeled(egui::Role::Button, possible, format!("Move {name} {what}"))
                });
                if button.clicked() {
                    self.edit(Edit::MoveLayer(layer.id.clone(), to));
                }
            }
        });
    }

    fn layer_settings(&mut self, ui: &mut Ui, layer: &Layer) {
        let mut opacity = layer.opacity;
        let slider = ui.add(Slider::new(&mut opacity, 0.0..=1.0).text("Opacity"));
        if slider.changed() {
            self.edit_by(
                &slider,
                Edit::SetLayer(Layer {
                    opacity,
                    ..layer.clone()
                }),
            );
        }
        let mut blend = layer.blend;
        let current = BLENDS
            .iter()
            .find(|(value, ..)| *value == blend)
            .map_or("", |(_, name, _)| name);
        egui::ComboBox::from_label("Blend")
            .selected_text(current)
            .show_ui(ui, |ui| {
                for (value, name, hint) in BLENDS {
                    ui.selectable_value(&mut blend, value, name).on_hover_text(hint);
                }
            });
        if blend != layer.blend {
            self.edit(Edit::SetLayer(Layer {
                blend,
                ..layer.clone()
            }));
        }
    }
}
