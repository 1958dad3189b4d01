//! The brush: what it paints, how large, how strong.

use balayage_render::param::Channel;
use egui::{Slider, Ui};

use super::Editor;
use crate::{
    paint::{Falloff, Mode, Reach},
    tool::{BrushColor, NATURAL_LEVELS},
};

/// A channel as a person knows it: name, unit, what more of it looks like.
pub(super) fn channel_text(channel: Channel) -> (&'static str, &'static str, &'static str) {
    match channel {
        Channel::Eumelanin => ("Melanin, brown", "", "More: darker, towards black"),
        Channel::Pheomelanin => ("Melanin, red", "", "More: redder, towards ginger"),
        Channel::Bleach => (
            "Bleach",
            "",
            "Share of melanin taken out: lighter, warmer on the way",
        ),
        Channel::Dye => ("Dye", "", "Absorption that is added to the fibre"),
        Channel::AlphaDeg => (
            "Tilt",
            "°",
            "Tilt of the scales: shifts the highlight, towards the root when negative",
        ),
        Channel::BetaDeg => ("Roughness", "°", "Larger: wider, softer highlights"),
        Channel::AzimuthalDeg => ("Roughness across", "°", "Larger: softer glints between strands"),
        Channel::Eta => ("Index", "", "Index of refraction: hair 1.55; larger is shinier"),
        Channel::Eccentricity => ("Eccentricity", "", "1: round fibre; others glint when they twist"),
        Channel::Mask => ("Layer mask", "", "0 hides the layer, 1 shows it"),
    }
}

const MODES: [(Mode, &str); 4] = [
    (Mode::Replace, "Replace"),
    (Mode::Add, "Add"),
    (Mode::Subtract, "Subtract"),
    (Mode::Multiply, "Multiply"),
];

const FALLOFFS: [(Falloff, &str); 3] = [
    (Falloff::Smooth, "Smooth"),
    (Falloff::Linear, "Linear"),
    (Falloff::Constant, "Constant"),
];

const REACHES: [(Reach, &str, &str); 3] = [
    (Reach::Surface, "Surface", "Only near what is seen"),
    (Reach::Through, "Through", "All depths below the brush"),
    (Reach::Strand, "Strand", "Whole strands from root to tip"),
];

/// A choice among named values.
fn choice<T: Copy + PartialEq>(
    ui: &mut Ui,
    label: &str,
    value: &mut T,
    names: impl Iterator<Item = (T, &'static str)>,
) {
    let names: Vec<_> = names.collect();
    let current = names
        .iter()
        .find(|(v, _)| v == value)
        .map_or("", |(_, name)| name);
    egui::ComboBox::from_label(label)
        .selected_text(current)
        .show_ui(ui, |ui| {
            for (v, name) in names {
                ui.selectable_value(value, v, name);
            }
        });
}

impl Editor {
    pub(super) fn brush_panel(&mut self, ui: &mut Ui) {
        let before = self.brush.channel;
        choice(
            ui,
            "Channel",
            &mut self.brush.channel,
            Channel::ALL.into_iter().map(|c| (c, channel_text(c).0)),
        );
        let channel = self.brush.channel;
        if channel != before && channel != Channel::Dye {
            self.brush.value = usual_value(channel);
        }
        choice(ui, "Mode", &mut self.brush.mode, MODES.into_iter());
        if channel == Channel::Dye {
            self.dye_value(ui);
        } else {
            let (name, unit, hint) = channel_text(channel);
            let (low, high) = slider_range(channel);
            ui.add(
                Slider::new(&mut self.brush.value, low..=high)
                    .text(name)
                    .suffix(unit),
            )
            .on_hover_text(hint);
            if matches!(channel, Channel::Eumelanin | Channel::Pheomelanin) {
                self.natural_levels(ui, channel);
            }
        }
        let brush = &mut self.brush;
        ui.add(
            Slider::new(&mut brush.radius_cm, 0.05..=30.0)
                .logarithmic(true)
                .text("Radius")
                .suffix(" cm"),
        )
        .on_hover_text("Keys [ and ], or Ctrl+right drag");
        ui.add(Slider::new(&mut brush.strength, 0.0..=1.0).text("Strength"))
            .on_hover_text("Keys { and }");
        ui.add(Slider::new(&mut brush.hardness, 0.0..=1.0).text("Hardness"))
            .on_hover_text("Share of the radius with full strength");
        choice(ui, "Falloff", &mut brush.falloff, FALLOFFS.into_iter());
        choice(
            ui,
            "Depth",
            &mut brush.reach,
            REACHES.into_iter().map(|(reach, name, _)| (reach, name)),
        );
        if let Some((.., hint)) = REACHES.iter().find(|(reach, ..)| *reach == brush.reach) {
            ui.weak(*hint);
        }
    }

    fn dye_value(&mut self, ui: &mut Ui) {
        let mut rgb = self.brush.color.0;
        ui.horizontal(|ui| {
            let button = ui.color_edit_button_rgb(&mut rgb);
            button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ColorWell, true, "Dye colour"));
            if button.changed() {
                self.brush.color = BrushColor(rgb);
            }
            ui.label("Dye colour")
                .on_hover_text("Colour of white light that has crossed one fibre");
        });
        let sigma_a = self.brush.color.sigma_a();
        ui.weak(format!(
            "absorbs {:.2}, {:.2}, {:.2} per fibre radius",
            sigma_a[0], sigma_a[1], sigma_a[2]
        ));
    }

    fn natural_levels(&mut self, ui: &mut Ui, channel: Channel) {
        ui.horizontal_wrapped(|ui| {
            for level in NATURAL_LEVELS {
                if ui.small_button(level.name).clicked() {
                    self.brush.value = if channel == Channel::Eumelanin {
                        level.eumelanin
                    } else {
                        level.pheomelanin
                    };
                }
            }
        });
    }
}

/// What a slider offers: the useful part of the channel's range.
pub(super) fn slider_range(channel: Channel) -> (f32, f32) {
    match channel {
        Channel::Eumelanin | Channel::Pheomelanin => (0.0, 10.0),
        Channel::Dye => (0.0, 5.0),
        Channel::AlphaDeg => (-15.0, 15.0),
        Channel::BetaDeg => (0.5, 40.0),
        Channel::AzimuthalDeg => (0.1, 60.0),
        Channel::Bleach | Channel::Eta | Channel::Eccentricity | Channel::Mask => channel.range().into_inner(),
    }
}

/// Where a brush starts when its channel is chosen.
fn usual_value(channel: Channel) -> f32 {
    match channel {
        Channel::Bleach => 0.8,
        other => balayage_render::param::PointValues::default().get(other)[0],
    }
}
