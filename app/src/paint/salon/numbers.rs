//! The numbers of the operations as a person adjusts them.

use super::Shape;
use crate::paint::Parameter;

/// Longest length that a parameter takes, millimetres.
const LONGEST_MM: f32 = 2000.0;

impl Shape {
    /// Its numbers.
    pub fn parameters(&mut self) -> Vec<Parameter<'_>> {
        let length = Parameter::length;
        let vary = |value| {
            length(
                "vary_mm",
                "Variation",
                200.0,
                "Larger: strands begin at different heights, a softer and more natural line",
                value,
            )
        };
        match self {
            Self::Fill(_) => Vec::new(),
            Self::Regrowth(p) => vec![
                length(
                    "length_mm",
                    "Grown",
                    500.0,
                    "Larger: longer roots; hair grows about 12 mm a month",
                    &mut p.length_mm,
                ),
                length(
                    "soften_mm",
                    "Soft edge",
                    200.0,
                    "Larger: no line between roots and lengths",
                    &mut p.soften_mm,
                ),
                vary(&mut p.vary_mm),
            ],
            Self::Gradient(p) => vec![
                length(
                    "start_mm",
                    "Start",
                    LONGEST_MM,
                    "Larger: the roots stay natural further down",
                    &mut p.start_mm,
                ),
                length(
                    "length_mm",
                    "Transition",
                    LONGEST_MM,
                    "Larger: a slower melt into the colour",
                    &mut p.length_mm,
                ),
                vary(&mut p.vary_mm),
            ],
            Self::Balayage(p) => vec![
                Parameter {
                    field: "section_mm",
                    name: "Section",
                    unit: " mm",
                    hint: "Larger: wider, fewer pieces",
                    range: 1.0..=200.0,
                    value: &mut p.section_mm,
                },
                Parameter::share(
                    "share",
                    "Painted",
                    "Larger: more of the sections are painted",
                    &mut p.share,
                ),
                length(
                    "start_mm",
                    "Start",
                    LONGEST_MM,
                    "Larger: the paint begins further from the roots",
                    &mut p.start_mm,
                ),
                length(
                    "length_mm",
                    "Transition",
                    LONGEST_MM,
                    "Larger: a slower melt into the colour",
                    &mut p.length_mm,
                ),
                length(
                    "v_mm",
                    "V depth",
                    300.0,
                    "Larger: pointed pieces; 0: blunt ones",
                    &mut p.v_mm,
                ),
                vary(&mut p.vary_mm),
            ],
            Self::Foils(p) => vec![
                Parameter {
                    field: "spacing_mm",
                    name: "Spacing",
                    unit: " mm",
                    hint: "Smaller: more foils",
                    range: 0.5..=200.0,
                    value: &mut p.spacing_mm,
                },
                length(
                    "slice_mm",
                    "Slice",
                    200.0,
                    "Larger: thicker streaks",
                    &mut p.slice_mm,
                ),
                length(
                    "shift_mm",
                    "Shift",
                    200.0,
                    "Moves all foils across the head",
                    &mut p.shift_mm,
                ),
                Parameter::share(
                    "weave",
                    "Weave",
                    "Smaller: finer streaks, woven with the hair between",
                    &mut p.weave,
                ),
                length(
                    "start_mm",
                    "Start",
                    LONGEST_MM,
                    "Larger: the roots stay natural",
                    &mut p.start_mm,
                ),
                length(
                    "soften_mm",
                    "Soft edge",
                    200.0,
                    "Larger: no line at the foil's end",
                    &mut p.soften_mm,
                ),
            ],
            Self::Grey(p) => vec![
                Parameter::share(
                    "share",
                    "Grey strands",
                    "0.2: salt and pepper; 1: all white",
                    &mut p.share,
                ),
                length(
                    "grown_mm",
                    "Grown out",
                    LONGEST_MM,
                    "0: whole strands; else only that much from the root",
                    &mut p.grown_mm,
                ),
                Parameter::share(
                    "patches",
                    "Patches",
                    "0: even; 1: gathered in streaks, as at the temples",
                    &mut p.patches,
                ),
                Parameter {
                    field: "patch_mm",
                    name: "Patch size",
                    unit: " mm",
                    hint: "Larger: wider grey streaks",
                    range: 1.0..=200.0,
                    value: &mut p.patch_mm,
                },
            ],
            Self::TipFade(p) => vec![
                length(
                    "length_mm",
                    "From the tip",
                    LONGEST_MM,
                    "Larger: the fade begins higher up",
                    &mut p.length_mm,
                ),
                vary(&mut p.vary_mm),
            ],
        }
    }
}
