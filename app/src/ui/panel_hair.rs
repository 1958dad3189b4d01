//! Unpainted parameters of the hair.

use balayage_render::gpu::Scheme;
use balayage_render::param::{Channel, LobeRatios, PigmentSet, PointValues};
use egui::{Slider, Ui};

use super::{
    Editor,
    panel_brush::{channel_text, slider_range},
};
use crate::{
    document::{Edit, HairSettings},
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
        for channel in Channel::ALL
            .into_iter()
            .filter(|channel| *channel != Channel::Dye)
        {
            self.base_slider(ui, &hair, channel);
        }
        self.ratio_sliders(ui, &hair);
        self.diameter_slider(ui, &hair, file_diameter, unit_mm);

        let mut pigments = hair.pigments;
        let name = |set| {
            if set == PigmentSet::Deon2011 {
                "d'Eon 2011"
            } else {
                "Cycles"
            }
        };
        egui::ComboBox::from_label("Pigments")
            .selected_text(name(pigments))
            .show_ui(ui, |ui| {
                for set in [PigmentSet::Deon2011, PigmentSet::Cycles] {
                    ui.selectable_value(&mut pigments, set, name(set));
                }
            });
        self.scheme_choice(ui, &hair);
        if pigments != hair.pigments {
            self.edit(Edit::SetHair(HairSettings { pigments, ..hair }));
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
        let slider = ui
            .add(Slider::new(&mut value, low..=high).text(name).suffix(unit))
            .on_hover_text(hint);
        if slider.double_clicked() {
            value = usual;
        }
        if slider.changed() || slider.double_clicked() {
            let mut hair = hair.clone();
            hair.base.known.set(channel, [value, 0.0, 0.0]);
            self.edit_by(&slider, Edit::SetHair(hair));
        }
    }

    fn ratio_sliders(&mut self, ui: &mut Ui, hair: &HairSettings) {
        type Field = fn(&mut LobeRatios) -> &mut f32;
        let fields: [(&str, Field, std::ops::RangeInclusive<f32>); 4] = [
            ("Tilt TT / R", |ratios| &mut ratios.alpha_tt, -3.0..=3.0),
            ("Tilt TRT / R", |ratios| &mut ratios.alpha_trt, -3.0..=3.0),
            ("Roughness TT / R", |ratios| &mut ratios.beta_tt, 0.1..=4.0),
            ("Roughness TRT / R", |ratios| &mut ratios.beta_trt, 0.1..=4.0),
        ];
        ui.collapsing("Lobes", |ui| {
            for (name, field, range) in fields {
                let mut hair = hair.clone();
                let value = field(&mut hair.ratios.known);
                let slider = ui.add(Slider::new(value, range).text(name));
                if slider.double_clicked() {
                    *value = *field(&mut LobeRatios::default());
                }
                if slider.changed() || slider.double_clicked() {
                    self.edit_by(&slider, Edit::SetHair(hair));
                }
            }
        });
    }

    fn diameter_slider(&mut self, ui: &mut Ui, hair: &HairSettings, file_diameter: f32, unit_mm: f32) {
        let mut millimetres = hair.diameter.unwrap_or(file_diameter) * unit_mm;
        let slider = ui
            .add(
                Slider::new(&mut millimetres, 0.02..=1.0)
                    .logarithmic(true)
                    .text("Diameter")
                    .suffix(" mm"),
            )
            .on_hover_text("Thickness of a fibre; double-click takes the file's");
        if slider.changed() || slider.double_clicked() {
            let diameter = (!slider.double_clicked()).then_some(millimetres / unit_mm);
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
