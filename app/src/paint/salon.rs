//! What a colourist does to many strands at once: regrowth, gradients, balayage, foils, grey, faded tips.
//!
//! An operation covers points by where they are along their strand (millimetres) and by where the strand is rooted; what it
//! does to a covered point is what a stroke does. It is stored with its parameters and replayed, so that every one of them can
//! be changed afterwards.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    Curve,
    parameter::{self, Parameter},
    scalp::StrandFacts,
};
use crate::Problem;

/// Longest length that a parameter takes, millimetres.
const LONGEST_MM: f32 = 2000.0;

/// What lots are drawn for.
const VARY: u32 = 0;
const CHOOSE: u32 = 1;
const WEAVE: u32 = 2;

/// Which points an operation without dabs covers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// Every point.
    Fill(Fill),
    /// What has grown since the last visit: from the roots up to a length.
    Regrowth(Regrowth),
    /// Ombre: rises from one place along the strand to another.
    Gradient(Gradient),
    /// Hand-painted sub-sections of the scalp, lighter towards the tips.
    Balayage(Balayage),
    /// Slices of hair along partings.
    Foils(Foils),
    /// Single strands, drawn at random.
    Grey(Grey),
    /// The tips.
    TipFade(TipFade),
}

/// [`Shape::Fill`] has no parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fill {}

/// [`Shape::Regrowth`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Regrowth {
    /// How far it has grown.
    pub length_mm: f32,
    /// Over what length the edge fades.
    pub soften_mm: f32,
    /// How much strands differ, up or down.
    pub vary_mm: f32,
}

/// [`Shape::Gradient`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Gradient {
    /// Distance from the root where it begins.
    pub start_mm: f32,
    /// Length over which it rises to full.
    pub length_mm: f32,
    /// How much strands differ, up or down.
    pub vary_mm: f32,
    /// How it rises.
    pub curve: Curve,
}

/// [`Shape::Balayage`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Balayage {
    /// Width of a sub-section on the scalp.
    pub section_mm: f32,
    /// Share of the sub-sections that are painted.
    pub share: f32,
    /// Distance from the root where the paint begins in the middle of a sub-section.
    pub start_mm: f32,
    /// Length over which it rises to full.
    pub length_mm: f32,
    /// How much later it begins at the rim of a sub-section: the V of the brush.
    pub v_mm: f32,
    /// How much sub-sections differ, up or down.
    pub vary_mm: f32,
    /// How it rises.
    pub curve: Curve,
}

/// The direction in which foils follow one another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Parting {
    /// From ear to ear (x).
    #[default]
    SideToSide,
    /// From the crown down (y).
    TopToBottom,
    /// From the forehead to the nape (z).
    FrontToBack,
}

/// [`Shape::Foils`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Foils {
    /// Direction in which they follow one another.
    pub parting: Parting,
    /// Distance from one foil to the next.
    pub spacing_mm: f32,
    /// Thickness of the slice in a foil.
    pub slice_mm: f32,
    /// Where the first one lies.
    pub shift_mm: f32,
    /// Share of a slice's strands that is woven into the foil.
    pub weave: f32,
    /// Distance from the root where the foil begins.
    pub start_mm: f32,
    /// Over what length its edge fades.
    pub soften_mm: f32,
}

/// [`Shape::Grey`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Grey {
    /// Share of the strands.
    pub share: f32,
    /// How far they have grown out grey; 0 is all the way.
    pub grown_mm: f32,
    /// How much of it gathers in sub-sections, as at the temples: 0 evenly, 1 in patches.
    pub patches: f32,
    /// Width of such a patch.
    pub patch_mm: f32,
}

/// [`Shape::TipFade`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TipFade {
    /// Distance from the tip where it begins.
    pub length_mm: f32,
    /// How much strands differ, up or down.
    pub vary_mm: f32,
    /// How it rises towards the tip.
    pub curve: Curve,
}

impl Default for Regrowth {
    /// Two months.
    fn default() -> Self {
        Self {
            length_mm: 25.0,
            soften_mm: 6.0,
            vary_mm: 4.0,
        }
    }
}

impl Default for Gradient {
    fn default() -> Self {
        Self {
            start_mm: 60.0,
            length_mm: 140.0,
            vary_mm: 10.0,
            curve: Curve::default(),
        }
    }
}

impl Default for Balayage {
    fn default() -> Self {
        Self {
            section_mm: 22.0,
            share: 0.45,
            start_mm: 50.0,
            length_mm: 110.0,
            v_mm: 40.0,
            vary_mm: 20.0,
            curve: Curve::default(),
        }
    }
}

impl Default for Foils {
    fn default() -> Self {
        Self {
            parting: Parting::SideToSide,
            spacing_mm: 18.0,
            slice_mm: 5.0,
            shift_mm: 0.0,
            weave: 0.7,
            start_mm: 8.0,
            soften_mm: 6.0,
        }
    }
}

impl Default for Grey {
    fn default() -> Self {
        Self {
            share: 0.2,
            grown_mm: 0.0,
            patches: 0.0,
            patch_mm: 30.0,
        }
    }
}

impl Default for TipFade {
    fn default() -> Self {
        Self {
            length_mm: 60.0,
            vary_mm: 10.0,
            curve: Curve::default(),
        }
    }
}

/// Coverage along one strand: a ramp between two places.
struct Ramp<'a> {
    /// Coverage where the ramp is full.
    share: f32,
    /// Distance from the root where it begins, millimetres.
    start: f32,
    /// Its length; zero is a step.
    length: f32,
    curve: Option<&'a Curve>,
    /// Full before the ramp instead of behind it.
    falls: bool,
}

impl Ramp<'_> {
    const FULL: Self = Self {
        share: 1.0,
        start: f32::NEG_INFINITY,
        length: 0.0,
        curve: None,
        falls: false,
    };

    fn at(&self, along_mm: f32) -> f32 {
        let from_start = along_mm - self.start;
        let x = if self.length > 0.0 {
            (from_start / self.length).clamp(0.0, 1.0)
        } else {
            f32::from(u8::from(from_start >= 0.0))
        };
        let y = self.curve.map_or(x * x * (3.0 - 2.0 * x), |curve| curve.at(x));
        self.share * if self.falls { 1.0 - y } else { y }
    }
}

impl Shape {
    /// One of each with its usual parameters.
    pub fn all() -> [Self; 7] {
        [
            Self::Regrowth(Regrowth::default()),
            Self::Gradient(Gradient::default()),
            Self::Balayage(Balayage::default()),
            Self::Foils(Foils::default()),
            Self::Grey(Grey::default()),
            Self::TipFade(TipFade::default()),
            Self::Fill(Fill {}),
        ]
    }

    /// What a colourist calls it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Fill(_) => "Fill",
            Self::Regrowth(_) => "Regrowth",
            Self::Gradient(_) => "Ombre",
            Self::Balayage(_) => "Balayage",
            Self::Foils(_) => "Foils",
            Self::Grey(_) => "Grey",
            Self::TipFade(_) => "Tip fade",
        }
    }

    /// What it looks like, in a sentence.
    pub fn hint(&self) -> &'static str {
        match self {
            Self::Fill(_) => "All of the hair, root to tip",
            Self::Regrowth(_) => "Roots that have grown out, with a soft line of demarcation",
            Self::Gradient(_) => "The lengths melt into the colour from a height on downwards",
            Self::Balayage(_) => "Hand-painted sub-sections: roots stay, lengths lighten in soft Vs",
            Self::Foils(_) => "Fine slices from the roots: bright, regular streaks",
            Self::Grey(_) => "Single strands among the others, as hair greys",
            Self::TipFade(_) => "Only the last centimetres, as sun and sea bleach them",
        }
    }

    /// True where the seed makes a difference.
    pub fn draws_lots(&self) -> bool {
        !matches!(self, Self::Fill(_))
    }

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

    /// Its curve, where it has one.
    pub fn curve_mut(&mut self) -> Option<&mut Curve> {
        match self {
            Self::Gradient(p) => Some(&mut p.curve),
            Self::Balayage(p) => Some(&mut p.curve),
            Self::TipFade(p) => Some(&mut p.curve),
            _ => None,
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// Names the field and its range.
    pub fn check(&self) -> Result<(), Problem> {
        let mut copy = self.clone();
        parameter::check("shape", copy.parameters())?;
        copy.curve_mut()
            .map_or(Ok(()), |curve| curve.check("shape.curve"))
    }

    /// Coverage in [0, 1] along a strand, by distance from its root in millimetres; none where the strand is left out.
    pub(super) fn along(&self, strand: &StrandFacts, seed: u64) -> Option<impl Fn(f32) -> f32> {
        let ramp = self.ramp(strand, seed);
        (ramp.share > 0.0).then_some(move |along_mm| ramp.at(along_mm))
    }

    fn ramp(&self, strand: &StrandFacts, seed: u64) -> Ramp<'_> {
        let varied = |vary_mm: f32, lot: f32| vary_mm * (2.0 * lot - 1.0);
        let chosen = |yes: bool| f32::from(u8::from(yes));
        match self {
            Self::Fill(_) => Ramp::FULL,
            Self::Regrowth(p) => Ramp {
                start: p.length_mm + varied(p.vary_mm, strand.lot(seed, VARY)) - 0.5 * p.soften_mm,
                length: p.soften_mm,
                falls: true,
                ..Ramp::FULL
            },
            Self::Gradient(p) => Ramp {
                start: p.start_mm + varied(p.vary_mm, strand.lot(seed, VARY)),
                length: p.length_mm,
                curve: Some(&p.curve),
                ..Ramp::FULL
            },
            Self::Balayage(p) => {
                let section = strand.section(p.section_mm, seed);
                let start = p.start_mm + varied(p.vary_mm, section.lot(seed, VARY)) + p.v_mm * section.rim;
                Ramp {
                    share: chosen(section.lot(seed, CHOOSE) < p.share),
                    start,
                    length: p.length_mm,
                    curve: Some(&p.curve),
                    ..Ramp::FULL
                }
            }
            Self::Foils(p) => {
                let axis = match p.parting {
                    Parting::SideToSide => strand.root_mm.x,
                    Parting::TopToBottom => strand.root_mm.y,
                    Parting::FrontToBack => strand.root_mm.z,
                };
                let in_slice = (axis - p.shift_mm).rem_euclid(p.spacing_mm) < p.slice_mm;
                Ramp {
                    share: chosen(in_slice && strand.lot(seed, WEAVE) < p.weave),
                    start: p.start_mm - 0.5 * p.soften_mm,
                    length: p.soften_mm,
                    ..Ramp::FULL
                }
            }
            Self::Grey(p) => {
                let even = strand.lot(seed, CHOOSE);
                // Patches move the threshold up and down about the share, the mean stays.
                let patch = strand.section(p.patch_mm, seed).lot(seed, CHOOSE);
                let reach = p.patches * p.share.min(1.0 - p.share);
                Ramp {
                    share: chosen(even < p.share + reach * (2.0 * patch - 1.0)),
                    start: if p.grown_mm > 0.0 {
                        p.grown_mm
                    } else {
                        f32::INFINITY
                    },
                    falls: true,
                    ..Ramp::FULL
                }
            }
            Self::TipFade(p) => {
                let length = (p.length_mm + varied(p.vary_mm, strand.lot(seed, VARY))).max(0.0);
                Ramp {
                    start: strand.length_mm - length,
                    length,
                    curve: Some(&p.curve),
                    ..Ramp::FULL
                }
            }
        }
    }
}
