//! The brush: what it paints, how large, how strong.

use balayage_render::param::Channel;
use egui::Ui;

use super::{
    Editor,
    widgets::{Number, choice},
};
use crate::{
    paint::{Falloff, Mode, Reach},
    tool::{Brush, NATURAL_LEVELS, Tool},
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

/// The modes of a brush that paints.
pub(super) const MODES: [(Mode, &str); 4] = [
    (Mode::Replace, "Replace"),
    (Mode::Add, "Add"),
    (Mode::Subtract, "Subtract"),
    (Mode::Multiply, "Multiply"),
];

const FALLOFFS: [(Falloff, &str); 5] = [
    (Falloff::Smooth, "Smooth"),
    (Falloff::Linear, "Linear"),
    (Falloff::Round, "Round"),
    (Falloff::Sharp, "Sharp"),
    (Falloff::Constant, "Constant"),
];

const REACHES: [(Reach, &str, &str); 3] = [
    (Reach::Surface, "Surface", "Only near what is seen"),
    (Reach::Through, "Through", "All depths below the brush"),
    (Reach::Strand, "Strand", "Whole strands from root to tip"),
];

impl Editor {
    pub(super) fn brush_panel(&mut self, ui: &mut Ui) {
        if self.tool == Tool::Eyedropper {
            ui.checkbox(&mut self.picks_seen_colour, "Seen colour").on_hover_text(
                "Takes the whole absorption of the hair as a dye; otherwise the stored value of the channel",
            );
        }
        let before = self.brush.channel;
        choice(
            ui,
            "Channel",
            &mut self.brush.channel,
            Channel::ALL.map(|c| (c, channel_text(c).0)),
        );
        let channel = self.brush.channel;
        if channel != before && channel != Channel::Dye {
            self.brush.value = usual_value(channel);
        }
        choice(ui, "Mode", &mut self.brush.mode, MODES);
        if channel == Channel::Dye {
            self.dye_panel(ui);
        } else {
            let (name, unit, hint) = channel_text(channel);
            let (low, high) = match self.brush.mode {
                Mode::Multiply => (0.0, 4.0),
                _ => slider_range(channel),
            };
            self.brush.value = self.brush.value.clamp(low, high);
            Number::new(name, low..=high, usual_value(channel).clamp(low, high), hint)
                .unit(unit)
                .show(ui, &mut self.brush.value);
            if matches!(channel, Channel::Eumelanin | Channel::Pheomelanin) {
                self.natural_levels(ui, channel);
            }
        }
        self.tip(ui);
    }

    /// Size, strength and reach of the brush.
    fn tip(&mut self, ui: &mut Ui) {
        let usual = Brush::default();
        let (tool, brush) = (self.tool, &mut self.brush);
        Number::new(
            "Radius",
            0.05..=30.0,
            usual.radius_cm,
            "Keys [ and ], or Ctrl+right drag",
        )
        .unit(" cm")
        .logarithmic()
        .show(ui, &mut brush.radius_cm);
        let unit_range = || 0.0..=1.0;
        Number::new(
            "Strength",
            unit_range(),
            usual.strength,
            "How much one stroke does; keys { and }",
        )
        .show(ui, &mut brush.strength);
        Number::new(
            "Hardness",
            unit_range(),
            usual.hardness,
            "Share of the radius with full strength",
        )
        .show(ui, &mut brush.hardness);
        choice(ui, "Falloff", &mut brush.falloff, FALLOFFS);
        if tool == Tool::Comb {
            let [from, to] = &mut brush.arc_range;
            Number::new(
                "From",
                unit_range(),
                0.0,
                "Where on the strand the paint begins: 0 root, 1 tip",
            )
            .show(ui, from);
            Number::new(
                "To",
                unit_range(),
                1.0,
                "Where on the strand the paint ends: 0 root, 1 tip",
            )
            .show(ui, to);
        } else {
            choice(
                ui,
                "Depth",
                &mut brush.reach,
                REACHES.map(|(reach, name, _)| (reach, name)),
            );
            if let Some((.., hint)) = REACHES.iter().find(|(reach, ..)| *reach == brush.reach) {
                ui.weak(*hint);
            }
        }
        if tool == Tool::Smooth {
            Number::new(
                "Neighbours",
                unit_range(),
                usual.across,
                "0: along each strand; 1: between strands",
            )
            .show(ui, &mut brush.across);
        }
        ui.checkbox(&mut brush.mirror, "Mirror")
            .on_hover_text("Paints the other side of the head as well, left and right");
        ui.collapsing("Stroke", |ui| {
            Number::new(
                "Spacing",
                0.05..=2.0,
                usual.spacing,
                "Distance between dabs, in radii; larger: single dabs show",
            )
            .show(ui, &mut brush.spacing);
            Number::new(
                "Flow",
                0.02..=1.0,
                usual.flow,
                "Below 1 paint builds up where the brush dwells, as from a spray can",
            )
            .show(ui, &mut brush.flow);
            Number::new(
                "Stabiliser",
                0.0..=100.0,
                usual.string,
                "Larger: the brush follows on a longer string, lines get calmer",
            )
            .unit(" pt")
            .show(ui, &mut brush.string);
            ui.checkbox(&mut brush.uses_pressure, "Pen pressure")
                .on_hover_text("A pen's pressure scales the strength");
        });
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
        Channel::Bleach | Channel::Eta | Channel::Eccentricity | Channel::Mask => {
            channel.range().into_inner()
        }
    }
}

/// Where a brush starts when its channel is chosen.
fn usual_value(channel: Channel) -> f32 {
    match channel {
        Channel::Bleach => 0.8,
        other => balayage_render::param::PointValues::default().get(other)[0],
    }
}
