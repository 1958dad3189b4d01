//! The dye of the brush: picked by the colour that hair is seen in, taken from a library of swatches, mixed stronger or thinner.

use egui::{Button, Role, Ui, WidgetInfo};

use super::{Editor, viewport::swatch, widgets::Number};
use crate::{
    document::{Dye, Edit},
    paint::Extra,
    tool::HairColour,
};

/// What the dye panel remembers between frames.
pub(super) struct DyeState {
    /// What the hair of the document looks like at any absorption.
    pub(super) hair: Option<HairColour>,
    /// The dye that `seen` belongs to.
    seen_for: Option<[f32; 3]>,
    /// The colour that the brush's dye gives bleached hair, linear Rec.709.
    pub(super) seen: [f32; 3],
    /// The dye is mixed for bleached hair instead of the hair as it grows.
    on_bleached: bool,
    /// What was said about the colour that was picked last.
    verdict: &'static str,
    /// Name for a new swatch.
    name: String,
    /// The colours of the library's dyes: absorption and what it is seen in.
    swatches: Vec<([f32; 3], [f32; 3])>,
}

impl Default for DyeState {
    fn default() -> Self {
        Self {
            hair: None,
            seen_for: None,
            seen: [0.5; 3],
            on_bleached: true,
            verdict: "",
            name: String::new(),
            swatches: Vec::new(),
        }
    }
}

impl DyeState {
    /// Finds the colours of the library's dyes where they are not known yet.
    fn follow(&mut self, library: &[Dye]) {
        let known = self.swatches.iter().map(|(sigma_a, _)| sigma_a);
        if !known.eq(library.iter().map(|dye| &dye.sigma_a)) {
            let seen = |sigma_a| self.hair.as_ref().map_or([0.5; 3], |hair| hair.seen(sigma_a));
            self.swatches = library
                .iter()
                .map(|dye| (dye.sigma_a, seen(dye.sigma_a)))
                .collect();
        }
    }
}

impl Editor {
    /// Keeps the seen colours in step with the hair and the brush.
    pub(super) fn refresh_colours(&mut self) {
        let Some(document) = &self.document else { return };
        let settings = &document.project().hair;
        let (values, ratios) = (&settings.base.known, &settings.ratios.known);
        let current = self.dyes.hair.as_ref();
        if !current.is_some_and(|hair| hair.is_for(values, ratios, settings.pigments)) {
            // Parameters that the model refuses keep the colours of those before.
            if let Ok(hair) = HairColour::new(values, ratios, settings.pigments) {
                self.dyes.hair = Some(hair);
                self.dyes.seen_for = None;
                self.dyes.swatches.clear();
            }
        }
        let dye = self.brush.mixed_dye();
        if let (Some(hair), true) = (&self.dyes.hair, self.dyes.seen_for != Some(dye)) {
            self.dyes.seen = hair.seen(dye);
            self.dyes.seen_for = Some(dye);
        }
    }

    pub(super) fn dye_panel(&mut self, ui: &mut Ui) {
        let mut rgb = self.dyes.seen;
        ui.horizontal(|ui| {
            let button = ui.color_edit_button_rgb(&mut rgb);
            button.widget_info(|| WidgetInfo::labeled(Role::ColorWell, true, "Dye colour"));
            ui.label("Dye colour").on_hover_text(
                "The colour that a mass of hair is seen in; the dye that gives it is solved for",
            );
        });
        ui.horizontal(|ui| {
            ui.radio_value(&mut self.dyes.on_bleached, true, "On bleached hair");
            ui.radio_value(&mut self.dyes.on_bleached, false, "On this hair")
                .on_hover_text("Counts with the melanin of the unpainted hair: less dye is needed");
        });
        if rgb != self.dyes.seen {
            self.pick_colour(rgb);
        }
        if !self.dyes.verdict.is_empty() {
            ui.colored_label(ui.visuals().warn_fg_color, self.dyes.verdict);
        }
        Number::new(
            "Dye strength",
            0.05..=4.0,
            1.0,
            "Larger: the same shade mixed stronger, deeper and darker",
        )
        .logarithmic()
        .show(ui, &mut self.brush.dye_strength);
        let sigma_a = self.brush.mixed_dye();
        ui.weak(format!(
            "absorbs {:.2}, {:.2}, {:.2} per fibre radius",
            sigma_a[0], sigma_a[1], sigma_a[2]
        ));
        self.dye_library(ui);
    }

    /// Mixes the dye for a colour.
    fn pick_colour(&mut self, rgb: [f32; 3]) {
        let Some(hair) = &self.dyes.hair else { return };
        let found = hair.dye_for(rgb, self.dyes.on_bleached);
        self.brush.dye = found.dye;
        self.brush.dye_strength = 1.0;
        self.dyes.verdict = if found.wants_bleach {
            "Lighter than this hair: bleach it first"
        } else if found.in_gamut {
            ""
        } else {
            "No hair has this colour: the nearest was taken"
        };
    }

    fn dye_library(&mut self, ui: &mut Ui) {
        let Some(document) = &self.document else { return };
        let library = document.project().dyes.clone();
        self.dyes.follow(&library);
        let mut chosen = None;
        ui.horizontal_wrapped(|ui| {
            for (i, (dye, (_, seen))) in library.iter().zip(&self.dyes.swatches).enumerate() {
                let is_current = self.brush.dye == dye.sigma_a;
                let stroke = if is_current { 2.0 } else { 0.0 };
                let button = Button::new("")
                    .fill(swatch(*seen))
                    .stroke(egui::Stroke::new(stroke, ui.visuals().strong_text_color()))
                    .min_size(egui::Vec2::splat(20.0));
                let button = ui.add(button).on_hover_text(&dye.name);
                button.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("Dye {}", dye.name)));
                if button.clicked() {
                    chosen = Some(i);
                }
            }
        });
        if let Some(i) = chosen {
            self.brush.dye = library[i].sigma_a;
            self.brush.dye_strength = 1.0;
            self.dyes.name.clone_from(&library[i].name);
            self.dyes.verdict = "";
        }
        ui.horizontal(|ui| {
            let name = ui.add(
                egui::TextEdit::singleline(&mut self.dyes.name)
                    .desired_width(110.0)
                    .hint_text("Name"),
            );
            name.widget_info(|| WidgetInfo::labeled(Role::TextInput, true, "Dye name"));
            let known = library.iter().position(|dye| dye.name == self.dyes.name);
            let named = !self.dyes.name.is_empty();
            let save = ui.add_enabled(named, Button::new("Save dye"));
            if save
                .on_hover_text("Keeps the brush's dye in the library, in place of one of the same name")
                .clicked()
            {
                let dye = Dye {
                    name: self.dyes.name.clone(),
                    sigma_a: self.brush.mixed_dye(),
                    extra: Extra::new(),
                };
                let mut library = library.clone();
                match known {
                    Some(i) => library[i] = dye,
                    None => library.push(dye),
                }
                self.edit(Edit::SetDyes(library));
            }
            if let Some(i) = known
                && ui.button("Remove dye").clicked()
            {
                let mut library = library.clone();
                library.remove(i);
                self.edit(Edit::SetDyes(library));
            }
        });
    }
}
