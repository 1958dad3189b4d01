//! Unpainted parameters of the hair.

use balayage_render::gpu::{Model, Scheme};
use balayage_render::param::{Channel, LobeRatios, PigmentSet, PointValues};
use egui::Ui;

use super::{
    Editor,
    panel_brush::{channel_text, slider_range},
    widgets::{Number, choice},
};
use crate::{
    document::{Edit, HairSettings, Layer},
    tool::NATURAL_LEVELS,
};

impl Editor {
    pub(super) fn hair_panel(&mut self, ui: &mut Ui) {
        let Some(document) = &self.document else { return };
        let hair = document.project().hair.clone();
        let file_diameter = document.groom().diameters().first().copied().unwrap_or(0.0);
        let unit_mm = 1000.0 * document.groom().metres_per_unit();
        ui.weak("Where nothing is painted. Double-click resets.");
        self.natural_colours(ui, &hair);
        self.melanin_sliders(ui, &hair);
        for channel in Channel::ALL
            .into_iter()
            .filter(|channel| *channel != Channel::Dye)
        {
            self.base_slider(ui, &hair, channel);
        }
        self.ratio_sliders(ui, &hair);
        self.diameter_slider(ui, &hair, file_diameter, unit_mm);

        let mut pigments = hair.pigments;
        choice(
            ui,
            "Pigments",
            &mut pigments,
            [
                (PigmentSet::Deon2011, "d'Eon 2011"),
                (PigmentSet::Cycles, "Cycles"),
            ],
        );
        let mut model = hair.model;
        choice(
            ui,
            "Model",
            &mut model,
            [
                (Model::Marschner, "Marschner"),
                (Model::Deon, "d'Eon (keeps all energy)"),
                (Model::KajiyaKay, "Kajiya-Kay (simple)"),
            ],
        );
        self.scheme_choice(ui, &hair);
        if (pigments, model) != (hair.pigments, hair.model) {
            self.edit(Edit::SetHair(HairSettings {
                pigments,
                model,
                ..hair
            }));
        }
    }

    fn scheme_choice(&mut self, ui: &mut Ui, hair: &HairSettings) {
        let name = |scheme| match scheme {
            Scheme::Nodes => "Nodes",
            Scheme::Xu2011 { .. } => "Xu 2011",
            Scheme::Directional { .. } => "Directions (slow)",
        };
        let mut scheme = hair.scheme;
        egui::ComboBox::from_label("Light integrals")
            .selected_text(name(scheme))
            .show_ui(ui, |ui| {
                // The kind is chosen here; another number than the usual one comes from the project file.
                for kind in [
                    Scheme::Nodes,
                    Scheme::Xu2011 { segments: 4 },
                    Scheme::Directional { directions: 64 },
                ] {
                    let chosen = std::mem::discriminant(&kind) == std::mem::discriminant(&scheme);
                    if ui.selectable_label(chosen, name(kind)).clicked() && !chosen {
                        scheme = kind;
                    }
                }
            })
            .response
            .on_hover_text("How the light that each strand scatters is added up: Nodes is fast and accurate, the others are there to compare with");
        if scheme != hair.scheme {
            self.edit(Edit::SetHair(HairSettings {
                scheme,
                ..hair.clone()
            }));
        }
    }

    fn natural_colours(&mut self, ui: &mut Ui, hair: &HairSettings) {
        ui.horizontal_wrapped(|ui| {
            for level in NATURAL_LEVELS {
                if ui.small_button(level.name).clicked() {
                    let mut hair = hair.clone();
                    hair.base.known.eumelanin = level.eumelanin;
                    hair.base.known.pheomelanin = level.pheomelanin;
                    self.edit(Edit::SetHair(hair));
                }
            }
        });
    }

    fn base_slider(&mut self, ui: &mut Ui, hair: &HairSettings, channel: Channel) {
        let (name, unit, hint) = channel_text(channel);
        let mut value = hair.base.known.get(channel)[0];
        let usual = PointValues::default().get(channel)[0];
        let (low, high) = slider_range(channel);
        let (slider, changed) = Number::new(name, low..=high, usual, hint)
            .unit(unit)
            .show(ui, &mut value);
        if changed {
            let mut hair = hair.clone();
            hair.base.known.set(channel, [value, 0.0, 0.0]);
            self.edit_by(&slider, Edit::SetHair(hair));
        }
    }

    /// Melanin as a person sees it: how much, and how red.
    fn melanin_sliders(&mut self, ui: &mut Ui, hair: &HairSettings) {
        let base = &hair.base.known;
        let mut melanin = base.eumelanin + base.pheomelanin;
        let mut redness = if melanin > 0.0 {
            base.pheomelanin / melanin
        } else {
            0.0
        };
        let (dark, darker) = Number::new(
            "Melanin",
            0.0..=10.0,
            1.5,
            "Larger: darker, from platinum to black",
        )
        .show(ui, &mut melanin);
        let (red, redder) =
            Number::new("Redness", 0.0..=1.0, 0.13, "Larger: warmer, towards ginger").show(ui, &mut redness);
        if darker || redder {
            let mut hair = hair.clone();
            hair.base.known.eumelanin = melanin * (1.0 - redness);
            hair.base.known.pheomelanin = melanin * redness;
            self.edit_by(if darker { &dark } else { &red }, Edit::SetHair(hair));
        }
    }

    /// Ratios of the lobes: the chosen layer's own where it has some, else the hair's.
    fn ratio_sliders(&mut self, ui: &mut Ui, hair: &HairSettings) {
        type Field = fn(&mut LobeRatios) -> &mut f32;
        let fields: [(&str, Field, std::ops::RangeInclusive<f32>, &str); 4] = [
            (
                "Tilt TT / R",
                |r| &mut r.alpha_tt,
                -3.0..=3.0,
                "Where light that passes through comes out",
            ),
            (
                "Tilt TRT / R",
                |r| &mut r.alpha_trt,
                -3.0..=3.0,
                "Distance of the coloured highlight from the white one",
            ),
            (
                "Roughness TT / R",
                |r| &mut r.beta_tt,
                0.1..=4.0,
                "Larger: a wider glow against the light",
            ),
            (
                "Roughness TRT / R",
                |r| &mut r.beta_trt,
                0.1..=4.0,
                "Larger: a wider, softer coloured highlight",
            ),
        ];
        let layer = self.document.as_ref().and_then(|document| {
            let layers = &document.project().layers;
            layers.iter().find(|layer| layer.id == self.layer).cloned()
        });
        let Some(layer) = layer else { return };
        ui.collapsing("Lobes", |ui| {
            let mut own = layer.ratios.is_some();
            let hint = "The layer shapes the highlights where it shows; otherwise these are the whole hair's";
            let label = format!("Own lobes of layer {}", layer.name);
            let check = ui.checkbox(&mut own, label).on_hover_text(hint);
            check.widget_info(|| {
                egui::WidgetInfo::selected(egui::Role::CheckBox, true, own, "Own lobes of the layer")
            });
            if check.changed() {
                self.edit(Edit::SetLayer(Layer {
                    ratios: own.then(|| hair.ratios.clone()),
                    ..layer.clone()
                }));
                return;
            }
            for (name, field, range, hint) in fields {
                let mut ratios = layer.ratios.clone().unwrap_or_else(|| hair.ratios.clone());
                let usual = *field(&mut LobeRatios::default());
                let number = Number::new(name, range, usual, hint);
                let (slider, changed) = number.show(ui, field(&mut ratios.known));
                if !changed {
                    continue;
                }
                let edit = if own {
                    Edit::SetLayer(Layer {
                        ratios: Some(ratios),
                        ..layer.clone()
                    })
                } else {
                    Edit::SetHair(HairSettings {
                        ratios,
                        ..hair.clone()
                    })
                };
                self.edit_by(&slider, edit);
            }
        });
    }

    fn diameter_slider(&mut self, ui: &mut Ui, hair: &HairSettings, file_diameter: f32, unit_mm: f32) {
        let mut millimetres = hair.diameter.unwrap_or(file_diameter) * unit_mm;
        let usual = file_diameter * unit_mm;
        let (slider, changed) = Number::new(
            "Diameter",
            0.02..=1.0,
            usual,
            "Thickness of a fibre; larger: coarser, less see-through",
        )
        .unit(" mm")
        .logarithmic()
        .show(ui, &mut millimetres);
        if changed {
            let diameter = (millimetres != usual).then_some(millimetres / unit_mm);
            self.edit_by(
                &slider,
                Edit::SetHair(HairSettings {
                    diameter,
                    ..hair.clone()
                }),
            );
        }
    }
}
