//! The record of a stroke: the JSON that the project holds and that `balayage paint` reads.

use balayage_render::param::Channel;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Shape;
use crate::problem::{Problem, within};

/// Fields that this version does not know; kept over a save.
pub type Extra = serde_json::Map<String, serde_json::Value>;

/// The version of the stroke file that this program writes.
pub const STROKE_VERSION: u32 = 2;

/// A stroke file: operations to be applied in order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StrokeFile {
    /// [`STROKE_VERSION`].
    pub version: u32,
    /// Content hash of the groom that the strokes were recorded on; null where they fit any.
    #[serde(default)]
    pub groom: Option<String>,
    /// The operations, first applied first.
    pub operations: Vec<Operation>,
    /// Unknown fields.
    #[serde(flatten)]
    pub extra: Extra,
}

/// The name of an operation: a number or a text.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum OperationId {
    /// A running number.
    Number(u64),
    /// Any text.
    Text(String),
}

impl std::fmt::Display for OperationId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(n) => write!(f, "{n}"),
            Self::Text(text) => write!(f, "{text}"),
        }
    }
}

/// One stroke: dabs of one brush on one channel of one layer; or a salon operation, which has a shape instead of dabs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Operation {
    /// Name of the operation, unique in its project.
    pub id: OperationId,
    /// Id of the layer that takes the stroke.
    #[serde(default = "default_layer")]
    pub layer: String,
    /// What is painted.
    pub channel: Channel,
    /// How the value meets what is there.
    pub mode: Mode,
    /// The brush's value in the channel's unit; modes erase and smooth ignore it.
    #[serde(default)]
    pub value: StrokeValue,
    /// Which points are covered, where dabs do not say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape: Option<Shape>,
    /// True leaves the operation in the list and out of the picture.
    #[serde(default, skip_serializing_if = "is_false")]
    pub hidden: bool,
    /// Radius of every dab, and of the neighbourhood that mode smooth evens out, metres; a shape needs it for smoothing only.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub radius_m: f32,
    /// Coverage at the centre of a dab at full pressure, in [0, 1].
    #[serde(default = "one")]
    pub strength: f32,
    /// Share of the radius that has full coverage, in [0, 1].
    #[serde(default = "half")]
    pub hardness: f32,
    /// Share of the missing coverage that each dab adds, in (0, 1]; 1 reaches the dab's coverage at once.
    #[serde(default = "one")]
    pub flow: f32,
    /// Mode smooth: how much of the mean is that of neighbouring strands instead of the own one, in [0, 1].
    #[serde(default)]
    pub across: f32,
    /// How coverage falls from there to the rim.
    #[serde(default)]
    pub falloff: Falloff,
    /// Which points round a dab it reaches.
    #[serde(default)]
    pub reach: Reach,
    /// Reach strand: how near a strand is to a dab; absent in strokes of before, which stay as they were painted.
    #[serde(default, skip_serializing_if = "Nearest::is_point")]
    pub nearest: Nearest,
    /// Reach strand: half length of the painted stretch in root-to-tip coordinate; absent, the whole strand is painted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arc_reach: Option<f32>,
    /// Reach strand: the stretch that is painted, in root-to-tip coordinate, whatever place of the strand was touched.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arc_range: Option<[f32; 2]>,
    /// Seed for shapes that draw lots; dabs draw none.
    #[serde(default)]
    pub seed: u64,
    /// The dabs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub dabs: Vec<Dab>,
    /// Unknown fields.
    #[serde(flatten)]
    pub extra: Extra,
}

/// One touch of the brush, in groom space: positions in the groom's unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Dab {
    /// Root of the strand that was touched.
    pub root: [f32; 3],
    /// Where on that strand: root-to-tip coordinate in [0, 1].
    pub arc: f32,
    /// The touched place.
    pub position: [f32; 3],
    /// Pressure of the pen in [0, 1]; multiplies the strength.
    #[serde(default = "one")]
    pub pressure: f32,
    /// Unknown fields.
    #[serde(flatten)]
    pub extra: Extra,
}

/// How a stroke's value meets the value before the stroke, by coverage c.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Towards the value: (1 - c) x + c v.
    Replace,
    /// x + c v.
    Add,
    /// x - c v.
    Subtract,
    /// x (1 - c + c v).
    Multiply,
    /// Towards what lies below the layer.
    Erase,
    /// Towards the mean over the strand's stretch within a radius, and over neighbouring strands.
    Smooth,
}

/// How coverage falls between the hard core and the rim of a dab.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Falloff {
    /// A cubic without corners.
    #[default]
    Smooth,
    /// A straight line.
    Linear,
    /// A circle's quarter: full for long, then steep.
    Round,
    /// A parabola: steep, then a long thin rim.
    Sharp,
    /// No fall: full coverage up to the rim.
    Constant,
}

/// Which points a dab reaches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Reach {
    /// The sphere round the dab; the editor puts dabs on visible strands only.
    #[default]
    Surface,
    /// The same sphere; the editor puts one dab per layer of strands under the pointer.
    Through,
    /// Every strand that meets the sphere, along its length.
    Strand,
}

/// What of a strand its distance to a dab counts from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Nearest {
    /// Its nearest point: strands with few points are missed.
    #[default]
    Point,
    /// The nearest place on its segments: the same strands whatever the number of points.
    Place,
}

impl Nearest {
    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks with a reference")]
    fn is_point(&self) -> bool {
        *self == Self::Point
    }
}

/// A brush's value: one number, or three for dye (one number stands for three equal ones).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum StrokeValue {
    /// One number.
    Scalar(f32),
    /// Linear Rec.709.
    Rgb([f32; 3]),
}

impl Default for StrokeValue {
    fn default() -> Self {
        Self::Scalar(0.0)
    }
}

impl StrokeValue {
    /// The value per component.
    pub fn components(self) -> [f32; 3] {
        match self {
            Self::Scalar(x) => [x; 3],
            Self::Rgb(rgb) => rgb,
        }
    }
}

fn default_layer() -> String {
    "paint".to_owned()
}

fn one() -> f32 {
    1.0
}

fn half() -> f32 {
    0.5
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks with a reference")]
fn is_false(x: &bool) -> bool {
    !x
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks with a reference")]
fn is_zero(x: &f32) -> bool {
    *x == 0.0
}

impl StrokeFile {
    /// Reads and checks a stroke file.
    ///
    /// # Errors
    /// Line and column where the text is no stroke file, the field where a value is out of range.
    pub fn parse(text: &str) -> Result<Self, Problem> {
        let file: Self = serde_json::from_str(text).map_err(|e| Problem::json(&e))?;
        if file.version == 0 || file.version > STROKE_VERSION {
            return Err(Problem::at(
                "version",
                format!(
                    "stroke version {} is not one of 1 to {STROKE_VERSION}",
                    file.version
                ),
                "open it with a newer Balayage",
            ));
        }
        check_operations(&file.operations)?;
        Ok(file)
    }
}

/// Checks every operation of a list; the problem's place is `operations[i]...`.
pub(crate) fn check_operations(operations: &[Operation]) -> Result<(), Problem> {
    operations.iter().enumerate().try_for_each(|(i, operation)| {
        operation
            .check()
            .map_err(|p| prefixed(&format!("operations[{i}]"), p))
    })
}

/// Checks every number of some dabs; the problem's place is `dabs[i]...`.
pub(crate) fn check_dabs(dabs: &[Dab]) -> Result<(), Problem> {
    dabs.iter()
        .enumerate()
        .try_for_each(|(i, dab)| dab.check().map_err(|p| prefixed(&format!("dabs[{i}]"), p)))
}

fn prefixed(prefix: &str, problem: Problem) -> Problem {
    Problem {
        place: format!("{prefix}.{}", problem.place),
        ..problem
    }
}

impl Operation {
    /// An operation that covers what `shape` says, at full strength.
    pub fn shaped(id: OperationId, layer: impl Into<String>, shape: Shape, seed: u64) -> Self {
        Self {
            id,
            layer: layer.into(),
            channel: Channel::Dye,
            mode: Mode::Replace,
            value: StrokeValue::default(),
            shape: Some(shape),
            hidden: false,
            radius_m: 0.0,
            strength: 1.0,
            hardness: half(),
            flow: 1.0,
            across: 0.0,
            falloff: Falloff::Smooth,
            reach: Reach::Surface,
            nearest: Nearest::Place,
            arc_reach: None,
            arc_range: None,
            seed,
            dabs: Vec::new(),
            extra: Extra::new(),
        }
    }

    /// Memory in bytes; unknown fields and curves are not counted.
    pub fn bytes(&self) -> usize {
        size_of::<Self>() + self.layer.len() + size_of_val(self.dabs.as_slice())
    }

    /// What a person calls it.
    pub fn title(&self) -> String {
        let what = match (&self.shape, self.mode) {
            (Some(shape), _) => shape.name(),
            (None, Mode::Erase) => "Erase",
            (None, Mode::Smooth) => "Smooth",
            (None, _) => "Paint",
        };
        format!("{what} {}", self.channel.name())
    }

    /// Checks every number of the operation.
    ///
    /// # Errors
    /// Names the field and its range.
    pub fn check(&self) -> Result<(), Problem> {
        if self.layer.is_empty() {
            return Err(Problem::at(
                "layer",
                "the layer's id is empty",
                "name the layer that takes the stroke",
            ));
        }
        // Nothing is larger than a kilometre, and a radius of zero would reach no point.
        let least = match self.shape {
            Some(_) if self.mode != Mode::Smooth => 0.0,
            _ => f32::MIN_POSITIVE,
        };
        within("radius_m", self.radius_m, least..=1000.0)?;
        within("flow", self.flow, f32::MIN_POSITIVE..=1.0)?;
        within("across", self.across, 0.0..=1.0)?;
        within("strength", self.strength, 0.0..=1.0)?;
        within("hardness", self.hardness, 0.0..=1.0)?;
        if let Some(arc_reach) = self.arc_reach {
            within("arc_reach", arc_reach, f32::MIN_POSITIVE..=1.0)?;
        }
        if let Some([from, to]) = self.arc_range {
            within("arc_range", from, 0.0..=1.0)?;
            within("arc_range", to, from.max(0.0)..=1.0)?;
        }
        self.check_value()?;
        if let Some(shape) = &self.shape {
            shape.check()?;
            if !self.dabs.is_empty() {
                return Err(Problem::at(
                    "dabs",
                    "an operation with a shape has dabs",
                    "take out one of the two",
                ));
            }
        }
        check_dabs(&self.dabs)
    }

    /// The values that make sense depend on the mode: a replacement lies in the channel's range, a summand within its width.
    fn check_value(&self) -> Result<(), Problem> {
        let (low, high) = self.channel.range().into_inner();
        let range = match self.mode {
            Mode::Replace => low..=high,
            Mode::Add | Mode::Subtract => low - high..=high - low,
            Mode::Multiply => 0.0..=1000.0,
            // The value is not used, but it is written: JSON holds no infinity.
            Mode::Erase | Mode::Smooth => {
                let mut all = self.value.components().into_iter();
                return all.try_for_each(|x| within("value", x, f32::MIN..=f32::MAX));
            }
        };
        if self.channel.components() == 1 && matches!(self.value, StrokeValue::Rgb(_)) {
            return Err(Problem::at(
                "value",
                format!("channel {} takes one number, not three", self.channel.name()),
                "give one number",
            ));
        }
        self.value.components()[..self.channel.components()]
            .iter()
            .try_for_each(|x| within("value", *x, range.clone()))
    }
}

impl Dab {
    /// Checks every number of the dab.
    fn check(&self) -> Result<(), Problem> {
        // Groom coordinates are metres to tenths of millimetres: a million units is beyond any of them.
        for (place, xyz) in [("root", self.root), ("position", self.position)] {
            xyz.iter().try_for_each(|x| within(place, *x, -1e6..=1e6))?;
        }
        within("arc", self.arc, 0.0..=1.0)?;
        within("pressure", self.pressure, 0.0..=1.0)
    }
}
