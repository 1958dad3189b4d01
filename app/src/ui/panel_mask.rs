//! The mask of a layer: a list of conditions.

use egui::Ui;

use super::{Editor, widgets};
use crate::{
    document::{Edit, Layer},
    paint::{Mask, MaskKind, MaskPart},
};

/// The conditions that a click adds; a scalp region is drawn with the lasso.
fn kinds() -> [MaskKind; 4] {
    [
        MaskKind::Arc {
            from: 0.5,
            to: 1.0,
            soften: 0.2,
        },
        MaskKind::Length {
            from_mm: 50.0,
            to_mm: 5000.0,
            soften_mm: 20.0,
        },
        MaskKind::Strands { share: 0.5, seed: 1 },
        MaskKind::Painted { soften_mm: 10.0 },
    ]
}

/// What a condition's sliders go back to.
fn usual(kind: &MaskKind) -> Vec<f32> {
    let mut usual = match kind {
        MaskKind::Region { .. } => MaskKind::Region {
            outline: Vec::new(),
            soften_mm: 5.0,
        },
        MaskKind::Roots { .. } => MaskKind::Roots {
            places: Vec::new(),
            radius_mm: 20.0,
            soften_mm: 5.0,
        },
        other => kinds()
            .into_iter()
            .find(|usual| std::mem::discriminant(usual) == std::mem::discriminant(other))
            .unwrap_or_else(|| other.clone()),
    };
    usual
        .parameters()
        .iter()
        .map(|parameter| *parameter.value)
        .collect()
}

impl Editor {
    pub(super) fn mask_panel(&mut self, ui: &mut Ui, layer: &Layer) {
        let mask = layer.mask.clone();
        let with = |mask: Mask| {
            Edit::SetLayer(Layer {
                mask,
                ..layer.clone()
            })
        };
        if mask.parts.is_empty() {
            ui.weak("Shows everywhere. Add a condition, paint with the Mask tool, or draw with the Lasso.");
        }
        let mut invert = mask.invert;
        if ui
            .checkbox(&mut invert, "Invert mask")
            .on_hover_text("Shows where it was hidden, and the other way round")
            .changed()
        {
            self.edit(with(Mask {
                invert,
                ..mask.clone()
            }));
        }
        for (i, part) in mask.parts.iter().enumerate() {
            ui.push_id(i, |ui| {
                ui.horizontal(|ui| {
                    ui.strong(part.kind.name());
                    let mut invert = part.invert;
                    if ui
                        .checkbox(&mut invert, "Not")
                        .on_hover_text("Where this does not hold")
                        .changed()
                    {
                        let mut mask = mask.clone();
                        mask.parts[i].invert = invert;
                        self.edit(with(mask));
                    }
                    let remove = ui.small_button("Remove");
                    remove.widget_info(|| {
                        let name = format!("Remove mask {}", part.kind.name());
                        egui::WidgetInfo::labeled(egui::Role::Button, true, name)
                    });
                    if remove.clicked() {
                        let mut mask = mask.clone();
                        mask.parts.remove(i);
                        self.edit(with(mask));
                    }
                });
                let mut kind = part.kind.clone();
                let usual = usual(&kind);
                let mut adjusted = None;
                for (parameter, usual) in kind.parameters().into_iter().zip(usual) {
                    let (slider, changed) = widgets::parameter(ui, parameter, usual);
                    if changed {
                        adjusted = Some(slider);
                    }
                }
                if let MaskKind::Strands { seed, .. } = &mut kind
                    && ui.small_button("Other strands").clicked()
                {
                    *seed = seed.wrapping_add(1);
                    let mut mask = mask.clone();
                    mask.parts[i].kind = kind.clone();
                    self.edit(with(mask));
                }
                if let Some(slider) = adjusted {
                    let mut mask = mask.clone();
                    mask.parts[i].kind = kind;
                    self.edit_by(&slider, with(mask));
                }
            });
        }
        ui.menu_button("Add condition", |ui| {
            for kind in kinds() {
                if ui.button(kind.name()).clicked() {
                    let mut mask = mask.clone();
                    mask.parts.push(MaskPart { kind, invert: false });
                    self.edit(with(mask));
                    ui.close();
                }
            }
        });
    }
}
