//! The list of layers, top first.

use balayage_render::param::Channel;
use egui::{Role, Ui, WidgetInfo};

use super::{
    Command, Editor,
    panel_brush::channel_text,
    widgets::{Number, choice},
};
use crate::document::{Blend, Edit, Layer};

/// A layer on its way to another place, by its position from below.
struct Dragged(usize);

const BLENDS: [(Blend, &str); 3] = [
    (Blend::Replace, "Replace"),
    (Blend::Add, "Add"),
    (Blend::Multiply, "Multiply"),
];

impl Editor {
    pub(super) fn layers_panel(&mut self, ui: &mut Ui) {
        let Some(document) = &self.document else { return };
        let layers = document.project().layers.clone();
        for (position, layer) in layers.iter().enumerate().rev() {
            let row = ui.horizontal(|ui| self.layer_row(ui, layer, position, layers.len()));
            self.drop_layer(ui, &row.response, &layers, position);
        }
        ui.horizontal_wrapped(|ui| {
            for command in [Command::AddLayer, Command::DuplicateLayer, Command::MergeDown] {
                let button = ui.add_enabled(self.is_enabled(command), egui::Button::new(command.label()));
                if button.on_hover_text(command.hint()).clicked() {
                    self.run(ui.ctx(), command);
                }
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
            let count = layer.mask.parts.len();
            let title = if count > 0 {
                format!("Mask ({count})")
            } else {
                "Mask".to_owned()
            };
            egui::CollapsingHeader::new(title)
                .id_salt("mask")
                .show(ui, |ui| self.mask_panel(ui, layer));
        }
    }

    fn layer_row(&mut self, ui: &mut Ui, layer: &Layer, position: usize, count: usize) {
        let mut visible = layer.visible;
        let name = &layer.name;
        let check = ui.checkbox(&mut visible, "").on_hover_text("Visible");
        check.widget_info(|| WidgetInfo::selected(Role::CheckBox, true, visible, format!("Show {name}")));
        if check.changed() {
            self.edit(Edit::SetLayer(Layer {
                visible,
                ..layer.clone()
            }));
        }
        let button =
            egui::Button::selectable(self.layer == layer.id, name).sense(egui::Sense::click_and_drag());
        let button = ui.add(button).on_hover_text("Drag to change the order");
        button.dnd_set_drag_payload(Dragged(position));
        if button.clicked() {
            self.layer.clone_from(&layer.id);
            self.operation = None;
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            for (arrow, to, possible, what) in [
                ("Down", position.saturating_sub(1), position > 0, "down"),
                ("Up", position + 1, position + 1 < count, "up"),
            ] {
                let button = ui.add_enabled(possible, egui::Button::new(arrow).small());
                button.widget_info(|| {
                    WidgetInfo::labeled(Role::Button, possible, format!("Move {name} {what}"))
                });
                if button.clicked() {
                    self.edit(Edit::MoveLayer(layer.id.clone(), to));
                }
            }
        });
    }

    /// A layer that is dragged over the row of another one takes its place when it is let go.
    fn drop_layer(&mut self, ui: &Ui, row: &egui::Response, layers: &[Layer], position: usize) {
        if let Some(dragged) = row.dnd_hover_payload::<Dragged>() {
            let y = if dragged.0 < position {
                row.rect.top()
            } else {
                row.rect.bottom()
            };
            let stroke = egui::Stroke::new(2.0, super::theme::ACCENT);
            ui.painter().hline(row.rect.x_range(), y, stroke);
        }
        let dropped = row.dnd_release_payload::<Dragged>();
        if let Some(dragged) =
            dropped.and_then(|dragged| layers.get(dragged.0).filter(|_| dragged.0 != position))
        {
            self.edit(Edit::MoveLayer(dragged.id.clone(), position));
        }
    }

    /// A blend for each channel that the layer paints.
    fn channel_blends(&self, ui: &mut Ui, layer: &mut Layer) -> bool {
        let Some(document) = &self.document else {
            return false;
        };
        let operations = &document.project().operations;
        let painted = |channel: &Channel| {
            *channel != Channel::Mask
                && operations
                    .iter()
                    .any(|operation| operation.layer == layer.id && operation.channel == *channel)
        };
        let painted: Vec<Channel> = Channel::ALL.into_iter().filter(painted).collect();
        let mut changed = false;
        egui::CollapsingHeader::new("Blend of channels")
            .id_salt("channel blends")
            .show(ui, |ui| {
                if painted.is_empty() {
                    ui.weak("Nothing is painted on this layer yet.");
                }
                for channel in painted {
                    let mut blend = layer.channel_blends.get(&channel).copied();
                    let blends = BLENDS.map(|(blend, name)| (Some(blend), name));
                    let choices = [(None, "As the layer")].into_iter().chain(blends);
                    if choice(ui, channel_text(channel).0, &mut blend, choices) {
                        changed = true;
                        match blend {
                            Some(blend) => layer.channel_blends.insert(channel, blend),
                            None => layer.channel_blends.remove(&channel),
                        };
                    }
                }
            });
        changed
    }

    fn layer_settings(&mut self, ui: &mut Ui, layer: &Layer) {
        let mut changed = layer.clone();
        ui.horizontal(|ui| {
            let field = ui.add(egui::TextEdit::singleline(&mut changed.name).desired_width(150.0));
            field.widget_info(|| WidgetInfo::labeled(Role::TextInput, true, "Layer name"));
            ui.label("Name");
        });
        let (slider, moved) = Number::new("Opacity", 0.0..=1.0, 1.0, "How much of the layer shows")
            .show(ui, &mut changed.opacity);
        let mut blended = choice(ui, "Blend", &mut changed.blend, BLENDS);
        ui.weak(match layer.blend {
            Blend::Replace => "Paint acts on what lies below",
            Blend::Add => "Paint is added to what lies below",
            Blend::Multiply => "Paint is a factor on what lies below",
        });
        blended |= self.channel_blends(ui, &mut changed);
        if moved {
            self.edit_by(&slider, Edit::SetLayer(changed));
        } else if changed.name != layer.name {
            // Typing a name is one entry.
            self.edit_on(Edit::SetLayer(changed));
        } else if blended {
            self.edit(Edit::SetLayer(changed));
        }
    }
}
