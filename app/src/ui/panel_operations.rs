//! What was done to a layer, and salon operations to add: each entry can be adjusted, hidden and removed.

use balayage_render::param::Channel;
use egui::{Role, Ui, WidgetInfo};

use super::{
    Editor,
    panel_brush::{MODES, channel_text, slider_range},
    widgets::{self, Number, choice},
};
use crate::{
    document::Edit,
    paint::{Mode, Operation, Parting, Shape, StrokeValue},
};

const PARTINGS: [(Parting, &str); 3] = [
    (Parting::SideToSide, "Side to side"),
    (Parting::TopToBottom, "Top to bottom"),
    (Parting::FrontToBack, "Front to back"),
];

/// Height of the list, in points.
const LIST_HEIGHT: f32 = 150.0;

impl Editor {
    pub(super) fn operations_panel(&mut self, ui: &mut Ui) {
        ui.weak("Add to the chosen layer. Everything can be changed afterwards.");
        ui.horizontal_wrapped(|ui| {
            for shape in Shape::all() {
                let button = ui.button(shape.name()).on_hover_text(shape.hint());
                button
                    .widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("Add {}", shape.name())));
                if button.clicked() {
                    self.add_operation(shape);
                }
            }
        });
        ui.separator();
        let Some(document) = &self.document else { return };
        let own: Vec<(usize, String, bool)> = document
            .project()
            .operations
            .iter()
            .enumerate()
            .filter(|(_, operation)| operation.layer == self.layer)
            .map(|(i, operation)| (i, operation.title(), operation.hidden))
            .rev()
            .collect();
        if own.is_empty() {
            ui.weak("Nothing was done to this layer yet.");
            return;
        }
        let row = ui.spacing().interact_size.y;
        egui::ScrollArea::vertical()
            .id_salt("operations")
            .max_height(LIST_HEIGHT)
            .auto_shrink([false, true])
            .show_rows(ui, row, own.len(), |ui, rows| {
                for (index, title, hidden) in &own[rows] {
                    ui.horizontal(|ui| self.operation_row(ui, *index, title, *hidden));
                }
            });
        let chosen = self
            .operation
            .filter(|chosen| own.iter().any(|(i, ..)| i == chosen));
        if let Some(index) = chosen {
            ui.separator();
            self.operation_settings(ui, index);
        } else {
            ui.weak("Click an entry to change it.");
        }
    }

    fn operation_row(&mut self, ui: &mut Ui, index: usize, title: &str, hidden: bool) {
        let name = format!("{}. {title}", index + 1);
        let mut shown = !hidden;
        let check = ui.checkbox(&mut shown, "").on_hover_text("Part of the picture");
        check.widget_info(|| WidgetInfo::selected(Role::CheckBox, true, shown, format!("Show {name}")));
        if check.changed() {
            self.change_operation(index, None, |operation| operation.hidden = !shown);
        }
        if ui
            .selectable_label(self.operation == Some(index), &name)
            .clicked()
        {
            self.operation = Some(index);
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let delete = ui.small_button("Delete");
            delete.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("Delete {name}")));
            if delete.clicked() {
                self.edit(Edit::RemoveOperation(index));
                self.operation = None;
            }
        });
    }

    /// Adds an operation: those that a colourist lightens with lighten, grey hair has lost its melanin, the others paint what
    /// the brush paints.
    fn add_operation(&mut self, shape: Shape) {
        let Some(document) = &self.document else { return };
        let number = document.next_operation_number();
        let usual = Operation::shaped(document.next_operation_id(), &self.layer, shape, number);
        let lightens = match usual.shape {
            Some(Shape::Grey(_)) => Some(0.97),
            Some(Shape::Balayage(_) | Shape::Foils(_) | Shape::TipFade(_)) => Some(0.88),
            _ => None,
        };
        let operation = match lightens {
            Some(bleach) => Operation {
                channel: Channel::Bleach,
                value: StrokeValue::Scalar(bleach),
                ..usual
            },
            None => Operation {
                channel: self.brush.channel,
                mode: self.brush.mode,
                value: self.brush.stroke_value(),
                ..usual
            },
        };
        self.append(operation);
    }

    /// Dyes where the operation at `index` lightens.
    fn tone(&mut self, index: usize) {
        let Some(document) = &self.document else { return };
        let Some(lightening) = document.project().operations.get(index) else {
            return;
        };
        let operation = Operation {
            id: document.next_operation_id(),
            channel: Channel::Dye,
            mode: Mode::Replace,
            value: StrokeValue::Rgb(self.brush.mixed_dye()),
            ..lightening.clone()
        };
        self.append(operation);
    }

    fn append(&mut self, operation: Operation) {
        let Some(document) = &self.document else { return };
        let index = document.project().operations.len();
        self.edit(Edit::Stroke(operation));
        self.operation = Some(index);
    }

    /// Changes an operation; changes of one slider drag are one entry of the history.
    fn change_operation(
        &mut self,
        index: usize,
        slider: Option<&egui::Response>,
        change: impl FnOnce(&mut Operation),
    ) {
        let Some(document) = &self.document else { return };
        let Some(operation) = document.project().operations.get(index) else {
            return;
        };
        let mut operation = operation.clone();
        change(&mut operation);
        let edit = Edit::SetOperation(index, operation);
        match slider {
            Some(slider) => self.edit_by(slider, edit),
            None => self.edit(edit),
        }
    }

    fn operation_settings(&mut self, ui: &mut Ui, index: usize) {
        let Some(document) = &self.document else { return };
        let Some(operation) = document.project().operations.get(index) else {
            return;
        };
        // Dabs stay where they are: only what surrounds them is adjusted here.
        let mut settings = Operation {
            dabs: Vec::new(),
            ..operation.clone()
        };
        let dab_count = operation.dabs.len();
        let mut slider = None;
        let mut changed = false;
        let mut note = |(response, did): (egui::Response, bool)| {
            if did {
                slider = Some(response);
            }
        };
        if dab_count > 0 {
            ui.weak(format!("A stroke of {dab_count} dabs"));
        }
        changed |= self.operation_value(ui, &mut settings, &mut note);
        note(
            Number::new("Amount", 0.0..=1.0, 1.0, "How much of it is done").show(ui, &mut settings.strength),
        );
        if let Some(shape) = &mut settings.shape {
            let usual = Shape::all()
                .into_iter()
                .find(|usual| std::mem::discriminant(usual) == std::mem::discriminant(shape));
            let usual: Vec<f32> = usual
                .map(|mut usual| usual.parameters().iter().map(|p| *p.value).collect())
                .unwrap_or_default();
            if let Shape::Foils(foils) = shape {
                changed |= choice(ui, "Parting", &mut foils.parting, PARTINGS);
            }
            for (parameter, usual) in shape.parameters().into_iter().zip(usual) {
                note(widgets::parameter(ui, parameter, usual));
            }
            if let Some(curve) = shape.curve_mut() {
                note(widgets::curve_editor(ui, curve));
            }
            if shape.draws_lots()
                && ui
                    .button("Draw again")
                    .on_hover_text("Other strands, other sections")
                    .clicked()
            {
                settings.seed = settings.seed.wrapping_add(1);
                changed = true;
            }
        } else {
            let mut radius_cm = 100.0 * settings.radius_m;
            note(
                Number::new(
                    "Dab radius",
                    0.05..=30.0,
                    radius_cm,
                    "Larger: the stroke is wider",
                )
                .unit(" cm")
                .logarithmic()
                .show(ui, &mut radius_cm),
            );
            settings.radius_m = 0.01 * radius_cm;
            note(
                Number::new(
                    "Dab hardness",
                    0.0..=1.0,
                    0.5,
                    "Share of the radius with full strength",
                )
                .show(ui, &mut settings.hardness),
            );
        }
        let can_tone = settings.shape.is_some() && settings.channel == Channel::Bleach;
        if can_tone
            && ui
                .button("Tone it")
                .on_hover_text("Adds the brush's dye on the same strands and lengths")
                .clicked()
        {
            self.tone(index);
            return;
        }
        if slider.is_some() || changed {
            self.change_operation(index, slider.as_ref(), |operation| {
                let dabs = std::mem::take(&mut operation.dabs);
                *operation = Operation { dabs, ..settings };
            });
        }
    }

    /// Channel, mode and value of an operation; true where a click changed something.
    fn operation_value(
        &self,
        ui: &mut Ui,
        settings: &mut Operation,
        note: &mut impl FnMut((egui::Response, bool)),
    ) -> bool {
        let (name, unit, hint) = channel_text(settings.channel);
        if matches!(settings.mode, Mode::Erase | Mode::Smooth) {
            ui.weak(name);
            return false;
        }
        let mut changed = false;
        if settings.channel == Channel::Dye {
            let mixed = self.brush.mixed_dye();
            ui.horizontal(|ui| {
                let seen = self
                    .dyes
                    .hair
                    .as_ref()
                    .map_or([0.5; 3], |hair| hair.seen(settings.value.components()));
                let (rect, _) = ui.allocate_exact_size(egui::Vec2::splat(18.0), egui::Sense::hover());
                ui.painter().rect_filled(rect, 3.0, super::viewport::swatch(seen));
                let take = ui
                    .button("Take the brush's dye")
                    .on_hover_text("Dyes with what the Brush tab shows");
                if take.clicked() && settings.value != StrokeValue::Rgb(mixed) {
                    settings.value = StrokeValue::Rgb(mixed);
                    changed = true;
                }
            });
        } else {
            let (low, high) = match settings.mode {
                Mode::Multiply => (0.0, 4.0),
                _ => slider_range(settings.channel),
            };
            let mut value = settings.value.components()[0];
            note(
                Number::new(name, low..=high, value, hint)
                    .unit(unit)
                    .show(ui, &mut value),
            );
            settings.value = StrokeValue::Scalar(value);
        }
        // A value of one mode may be out of another's range: it is brought into it.
        let before = settings.mode;
        if choice(ui, "Operation mode", &mut settings.mode, MODES) {
            let fits = settings.check().is_ok();
            if !fits {
                settings.mode = before;
            }
            changed |= fits;
        }
        changed
    }
}
