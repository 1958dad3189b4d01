//! What a colourist does to many strands at once: regrowth, gradients, balayage, foils, grey, faded tips.
//!
//! An operation covers points by where they are along their strand (millimetres) and by where the strand is rooted; what it
//! does to a covered point is what a stroke does. It is stored with its parameters and replayed, so that every one of them can
//! be changed afterwards.

mod cover;
mod numbers;
mod usual;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Curve, parameter};
use crate::Problem;

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
}
