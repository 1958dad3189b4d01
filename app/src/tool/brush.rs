//! The brush: what it paints and how a pointer's path becomes dabs.

use balayage_render::param::Channel;
use glam::{Vec2, Vec3};

use crate::{
    document::Document,
    paint::{Extra, Falloff, Mode, Nearest, Operation, Reach, StrokeValue},
};

/// What a drag over the hair does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Paints the brush's value.
    #[default]
    Paint,
    /// Paints it along whole strands, between two arc lengths.
    Comb,
    /// Takes paint off.
    Erase,
    /// Evens out along strands and between neighbours.
    Smooth,
    /// Hides the layer where it is painted.
    Mask,
    /// Draws an outline on the scalp that the layer is limited to.
    Lasso,
    /// Takes the value of the touched hair into the brush.
    Eyedropper,
}

impl Tool {
    /// Every tool.
    pub const ALL: [Self; 7] = [
        Self::Paint,
        Self::Comb,
        Self::Erase,
        Self::Smooth,
        Self::Mask,
        Self::Lasso,
        Self::Eyedropper,
    ];

    /// The tool's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paint => "Paint",
            Self::Comb => "Comb-dye",
            Self::Erase => "Erase",
            Self::Smooth => "Smooth",
            Self::Mask => "Mask",
            Self::Lasso => "Lasso",
            Self::Eyedropper => "Eyedropper",
        }
    }

    /// What it does, in a sentence.
    pub fn hint(self) -> &'static str {
        match self {
            Self::Paint => "Drag over the hair to paint the brush's value; Ctrl erases, Shift smooths",
            Self::Comb => "Drag: paint runs along every touched strand, between the brush's two arc lengths",
            Self::Erase => "Drag to take paint off the layer; what lies below comes back",
            Self::Smooth => "Drag to even out paint along the strands and between neighbours",
            Self::Mask => "Drag to hide the layer there; Ctrl shows it again",
            Self::Lasso => "Draw round hair: the layer shows only on strands that are rooted inside",
            Self::Eyedropper => "Click on hair to take its value into the brush (C)",
        }
    }

    /// True where a drag makes a stroke.
    pub fn strokes(self) -> bool {
        !matches!(self, Self::Lasso | Self::Eyedropper)
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
pub const NATURAL_LEVELS: [NaturalLevel; 6] = {
    const fn level(name: &'static str, eumelanin: f32, pheomelanin: f32) -> NaturalLevel {
        NaturalLevel {
            name,
            eumelanin,
            pheomelanin,
        }
    }
    [
        level("Black", 8.0, 0.0),
        level("Dark brown", 2.5, 0.2),
        level("Brown", 1.3, 0.2),
        level("Light brown", 0.7, 0.2),
        level("Blond", 0.25, 0.1),
        level("Platinum", 0.04, 0.02),
    ]
};

/// The brush.
#[derive(Clone, Debug, PartialEq)]
pub struct Brush {
    /// What it paints.
    pub channel: Channel,
    /// How its value meets what is there.
    pub mode: Mode,
    /// The dye: absorption per fibre radius, linear Rec.709; used by channel dye.
    pub dye: [f32; 3],
    /// Factor on the dye, as if it was mixed stronger or thinner.
    pub dye_strength: f32,
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
    /// Distance between dabs as a share of the radius.
    pub spacing: f32,
    /// Share of the missing coverage that each dab adds.
    pub flow: f32,
    /// Smoothing: how much neighbouring strands count beside the own one.
    pub across: f32,
    /// Comb: the stretch that is painted, 0 root, 1 tip.
    pub arc_range: [f32; 2],
    /// Paints the other side of the head as well (x to -x).
    pub mirror: bool,
    /// A pen's pressure scales the strength.
    pub uses_pressure: bool,
    /// Stabiliser: length of the string that the brush hangs on behind the pointer, points of the screen; 0 is none.
    pub string: f32,
}

impl Default for Brush {
    /// A copper dye, two centimetres wide.
    fn default() -> Self {
        Self {
            channel: Channel::Dye,
            mode: Mode::Replace,
            dye: [0.144, 0.916, 1.498],
            dye_strength: 1.0,
            value: 0.5,
            radius_cm: 2.0,
            strength: 0.8,
            hardness: 0.4,
            falloff: Falloff::Smooth,
            reach: Reach::Surface,
            spacing: 0.25,
            flow: 1.0,
            across: 0.5,
            arc_range: [0.0, 1.0],
            mirror: false,
            uses_pressure: true,
            string: 0.0,
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

    /// The dye at its strength, within the channel's range.
    pub fn mixed_dye(&self) -> [f32; 3] {
        let (low, high) = Channel::Dye.range().into_inner();
        self.dye.map(|x| (x * self.dye_strength).clamp(low, high))
    }

    /// What the brush paints on its channel.
    pub fn stroke_value(&self) -> StrokeValue {
        if self.channel == Channel::Dye {
            StrokeValue::Rgb(self.mixed_dye())
        } else {
            StrokeValue::Scalar(self.value)
        }
    }

    /// The stroke that `tool` would make on `layer`, without dabs; none for tools that do not paint.
    pub fn operation(&self, tool: Tool, layer: &str, document: &Document) -> Option<Operation> {
        let (channel, mode, value) = match tool {
            Tool::Paint | Tool::Comb => (self.channel, self.mode, self.stroke_value()),
            Tool::Erase => (self.channel, Mode::Erase, StrokeValue::default()),
            Tool::Smooth => (self.channel, Mode::Smooth, StrokeValue::default()),
            Tool::Mask => (Channel::Mask, Mode::Replace, StrokeValue::default()),
            Tool::Lasso | Tool::Eyedropper => return None,
        };
        let combs = tool == Tool::Comb;
        let [from, to] = self.arc_range;
        Some(Operation {
            id: document.next_operation_id(),
            layer: layer.to_owned(),
            channel,
            mode,
            value,
            shape: None,
            hidden: false,
            radius_m: 0.01 * self.radius_cm,
            strength: self.strength,
            hardness: self.hardness,
            flow: self.flow,
            across: if mode == Mode::Smooth { self.across } else { 0.0 },
            falloff: self.falloff,
            reach: if combs { Reach::Strand } else { self.reach },
            nearest: Nearest::Place,
            arc_reach: None,
            arc_range: combs.then_some([from.min(to), from.max(to)]),
            seed: 0,
            dabs: Vec::new(),
            extra: Extra::new(),
        })
    }
}

/// A place on the other side of the head, which is symmetric about x = 0.
pub fn mirrored(place: Vec3) -> Vec3 {
    Vec3::new(-place.x, place.y, place.z)
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

    /// Where the brush is.
    pub fn place(&self) -> Vec2 {
        self.last
    }

    /// Where a pointer at `pointer` pulls the brush on a string of that length (same unit): straight on once the string is tight.
    pub fn pulled(&self, pointer: Vec2, string: f32) -> Vec2 {
        let way = pointer - self.last;
        let distance = way.length();
        if distance <= string {
            return self.last;
        }
        self.last + way * ((distance - string) / distance)
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
    fn the_stabiliser_smooths_a_trembling_hand() {
        let string = 12.0;
        let tremble = |i: usize| Vec2::new(2.0 * i as f32, if i.is_multiple_of(2) { 5.0 } else { -5.0 });
        let swing = |string: f32| {
            let mut path = StrokePath::new(Vec2::ZERO);
            let places: Vec<Vec2> = (1..200)
                .flat_map(|i| path.advance(path.pulled(tremble(i), string), 1.0))
                .collect();
            assert!(path.place().distance(tremble(199)) <= string + 1e-3);
            let later = places.iter().filter(|place| place.x > 50.0);
            later.map(|place| place.y.abs()).fold(0.0, f32::max)
        };
        assert!(swing(0.0) > 4.0 && swing(string) < 2.5, "{}", swing(string));
        let path = StrokePath::new(Vec2::ZERO);
        assert_eq!(path.pulled(Vec2::new(3.0, 4.0), 5.0), Vec2::ZERO);
        assert_eq!(path.pulled(Vec2::new(6.0, 8.0), 5.0), Vec2::new(3.0, 4.0));
    }

    #[test]
    fn a_strong_mix_stays_in_the_channels_range() {
        let brush = Brush {
            dye: [0.0, 60.0, 1.0],
            dye_strength: 4.0,
            ..Brush::default()
        };
        assert_eq!(brush.mixed_dye(), [0.0, 100.0, 4.0]);
    }
}
