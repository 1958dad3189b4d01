//! The brush: what it paints and how a pointer's path becomes dabs.

use balayage_render::param::Channel;
use glam::Vec2;

use crate::{
    document::Document,
    paint::{Extra, Falloff, Mode, Operation, OperationId, Reach, StrokeValue},
};

/// What a drag over the hair does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Paints the brush's value.
    #[default]
    Paint,
    /// Takes paint off.
    Erase,
    /// Evens out along strands.
    Smooth,
    /// Takes the value of the touched hair into the brush.
    Eyedropper,
}

impl Tool {
    /// Every tool.
    pub const ALL: [Self; 4] = [Self::Paint, Self::Erase, Self::Smooth, Self::Eyedropper];

    /// The tool's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paint => "Paint",
            Self::Erase => "Erase",
            Self::Smooth => "Smooth",
            Self::Eyedropper => "Eyedropper",
        }
    }

    /// What it does, in a sentence.
    pub fn hint(self) -> &'static str {
        match self {
            Self::Paint => "Drag over the hair to paint the brush's value",
            Self::Erase => "Drag to take paint off the layer; what lies below comes back",
            Self::Smooth => "Drag to even out paint along the strands",
            Self::Eyedropper => "Click on hair to take its value into the brush",
        }
    }
}

/// Dye as a person thinks of it: the colour of white light that has crossed one fibre, linear Rec.709.
///
/// Light that crosses a fibre through its axis travels two radii, so the colour is exp(-2 sigma_a).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrushColor(pub [f32; 3]);

/// The darkest component that has a finite absorption in range.
const DARKEST: f32 = 1e-4;

impl BrushColor {
    /// Absorption per fibre radius.
    pub fn sigma_a(self) -> [f32; 3] {
        self.0.map(|c| -0.5 * c.clamp(DARKEST, 1.0).ln())
    }

    /// The colour of an absorption.
    pub fn of_sigma_a(sigma_a: [f32; 3]) -> Self {
        Self(sigma_a.map(|s| (-2.0 * s).exp()))
    }
}

/// A natural hair colour by its melanins (concentrations of d'Eon 2011's pigments).
pub struct NaturalLevel {
    /// What a hairdresser calls it.
    pub name: &'static str,
    /// Eumelanin concentration.
    pub eumelanin: f32,
    /// Pheomelanin concentration.
    pub pheomelanin: f32,
}

/// Natural levels from dark to light.
pub const NATURAL_LEVELS: [NaturalLevel; 6] = [
    NaturalLevel {
        name: "Black",
        eumelanin: 8.0,
        pheomelanin: 0.0,
    },
    NaturalLevel {
        name: "Dark brown",
        eumelanin: 2.5,
        pheomelanin: 0.2,
    },
    NaturalLevel {
        name: "Brown",
        eumelanin: 1.3,
        pheomelanin: 0.2,
    },
    NaturalLevel {
        name: "Light brown",
        eumelanin: 0.7,
        pheomelanin: 0.2,
    },
    NaturalLevel {
        name: "Blond",
        eumelanin: 0.25,
        pheomelanin: 0.1,
    },
    NaturalLevel {
        name: "Platinum",
        eumelanin: 0.04,
        pheomelanin: 0.02,
    },
];

/// The brush.
#[derive(Clone, Debug, PartialEq)]
pub struct Brush {
    /// What it paints.
    pub channel: Channel,
    /// How its value meets what is there.
    pub mode: Mode,
    /// The dye's colour; used by channel dye.
    pub color: BrushColor,
    /// The value; used by all other channels.
    pub value: f32,
    /// Radius in centimetres.
    pub radius_cm: f32,
    /// Coverage at the centre, in [0, 1].
    pub strength: f32,
    /// Share of the radius with full coverage, in [0, 1].
    pub hardness: f32,
    /// How coverage falls towards the rim.
    pub falloff: Falloff,
    /// Which strands it reaches.
    pub reach: Reach,
}

impl Default for Brush {
    /// A copper dye, two centimetres wide.
    fn default() -> Self {
        Self {
            channel: Channel::Dye,
            mode: Mode::Replace,
            color: BrushColor([0.75, 0.16, 0.05]),
            value: 0.5,
            radius_cm: 2.0,
            strength: 0.8,
            hardness: 0.4,
            falloff: Falloff::Smooth,
            reach: Reach::Surface,
        }
    }
}

/// Limits of the brush's radius, centimetres.
const RADIUS_CM: std::ops::RangeInclusive<f32> = 0.05..=30.0;

impl Brush {
    /// Makes the brush larger or smaller within its limits.
    pub fn scale_radius(&mut self, factor: f32) {
        self.radius_cm = (self.radius_cm * factor).clamp(*RADIUS_CM.start(), *RADIUS_CM.end());
    }

    /// Changes the strength within its limits.
    pub fn add_strength(&mut self, step: f32) {
        self.strength = (self.strength + step).clamp(0.0, 1.0);
    }

    /// The stroke that `tool` would make on `layer`, without dabs; none for tools that do not paint.
    pub fn operation(&self, tool: Tool, layer: &str, document: &Document) -> Option<Operation> {
        let mode = match tool {
            Tool::Paint => self.mode,
            Tool::Erase => Mode::Erase,
            Tool::Smooth => Mode::Smooth,
            Tool::Eyedropper => return None,
        };
        let value = if self.channel == Channel::Dye {
            StrokeValue::Rgb(self.color.sigma_a())
        } else {
            StrokeValue::Scalar(self.value)
        };
        Some(Operation {
            id: OperationId::Number(document.next_operation_number()),
            layer: layer.to_owned(),
            channel: self.channel,
            mode,
            value,
            radius_m: 0.01 * self.radius_cm,
            strength: self.strength,
            hardness: self.hardness,
            falloff: self.falloff,
            reach: self.reach,
            arc_reach: None,
            arc_range: None,
            shape: None,
            hidden: false,
            flow: 1.0,
            across: 0.0,
            seed: 0,
            dabs: Vec::new(),
            extra: Extra::new(),
        })
    }
}

/// The pointer's path through a stroke: dabs at even steps, however fast the pointer moves.
#[derive(Clone, Copy, Debug)]
pub struct StrokePath {
    last: Vec2,
    /// Length since the last dab.
    carried: f32,
}

impl StrokePath {
    /// A path that starts at `at`, where the first dab belongs.
    pub fn new(at: Vec2) -> Self {
        Self {
            last: at,
            carried: 0.0,
        }
    }

    /// Goes straight on to `to`; returns where dabs belong, one every `step` (same unit, > 0).
    pub fn advance(&mut self, to: Vec2, step: f32) -> Vec<Vec2> {
        let length = self.last.distance(to);
        let mut places = Vec::new();
        let mut along = step - self.carried;
        while along <= length && length > 0.0 {
            places.push(self.last.lerp(to, along / length));
            along += step;
        }
        self.carried = length - (along - step);
        self.last = to;
        places
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dabs_do_not_depend_on_how_often_the_pointer_is_read() {
        let end = Vec2::new(100.0, 40.0);
        let whole = StrokePath::new(Vec2::ZERO).advance(end, 7.0);
        let mut path = StrokePath::new(Vec2::ZERO);
        let parts: Vec<Vec2> = (1..=23)
            .flat_map(|i| path.advance(end * (i as f32 / 23.0), 7.0))
            .collect();
        assert_eq!(whole.len(), 15);
        assert_eq!(parts.len(), whole.len());
        assert!(whole.iter().zip(&parts).all(|(a, b)| a.distance(*b) < 1e-3));
        assert!(
            path.advance(end, 7.0).is_empty(),
            "a resting pointer makes no dabs"
        );
    }

    #[test]
    fn dye_colours_come_back_from_their_absorption() {
        let color = BrushColor([0.75, 0.16, 0.05]);
        let back = BrushColor::of_sigma_a(color.sigma_a()).0;
        assert!(back.iter().zip(color.0).all(|(a, b)| (a - b).abs() < 1e-6));
        assert!(
            BrushColor([0.0; 3])
                .sigma_a()
                .iter()
                .all(|s| Channel::Dye.range().contains(s))
        );
    }
}
