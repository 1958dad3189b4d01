//! The project file: everything that a picture depends on, as JSON.

use std::collections::BTreeMap;

use balayage_render::{
    gpu::{Model, Scheme},
    groom::ReadOptions,
    param::{Channel, LobeRatios, PigmentSet, PointValues},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::hand_light::HandLight;
use crate::{
    Problem,
    paint::{Extra, Mask, Operation},
};

/// The version of the project file that this program writes.
///
/// Version 1 had no masks, no salon operations and no dye library; it is read as version 2 without them.
pub const PROJECT_VERSION: u32 = 2;

/// Layers above this number are refused: each may take memory for every point of the groom.
pub const MAX_LAYERS: usize = 100;

/// A known structure and the fields beside it that this version does not know.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Open<T> {
    /// The known fields.
    #[serde(flatten)]
    pub known: T,
    /// The unknown ones, kept over a save.
    #[serde(flatten)]
    pub extra: Extra,
}

impl<T> From<T> for Open<T> {
    fn from(known: T) -> Self {
        Self {
            known,
            extra: Extra::new(),
        }
    }
}

/// A project. Paths are relative to the folder of the project file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Project {
    /// [`PROJECT_VERSION`].
    pub version: u32,
    /// The strands.
    pub groom: GroomReference,
    /// The head that is drawn and casts shadows; null for none.
    #[serde(default)]
    pub head: Option<HeadReference>,
    /// What lights them.
    #[serde(default)]
    pub light: LightSettings,
    /// Which map of a sequence lights them, from 0; counted round where the sequence is shorter.
    #[serde(default)]
    pub frame: u32,
    /// Where they are seen from; null frames the hair.
    #[serde(default)]
    pub camera: Option<CameraPose>,
    /// Unpainted parameters.
    #[serde(default)]
    pub hair: HairSettings,
    /// The layers, lowest first.
    #[serde(default)]
    pub layers: Vec<Layer>,
    /// Dyes to choose from.
    #[serde(default = "usual_dyes")]
    pub dyes: Vec<Dye>,
    /// Every stroke and salon operation, first applied first; the list of a stroke file.
    #[serde(default)]
    pub operations: Vec<Operation>,
    /// Content hashes of the head and of what lights the hair when the project was saved, by their paths: by them a file that was
    /// moved is found again. Maps of a sequence have none.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub files: BTreeMap<String, String>,
    /// Unknown fields.
    #[serde(flatten)]
    pub extra: Extra,
}

/// Which groom the strokes belong to.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GroomReference {
    /// Path of the groom file.
    pub path: String,
    /// Its content hash when the project was saved; null accepts any content.
    #[serde(default)]
    pub hash: Option<String>,
    /// Metres per unit of the file; null guesses from its size.
    #[serde(default)]
    pub metres_per_unit: Option<f32>,
    /// Time code at which a USD file's samples are taken; null takes the values without a time, else the first sample.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub usd_time: Option<f64>,
    /// Unknown fields.
    #[serde(flatten)]
    pub extra: Extra,
}

impl GroomReference {
    /// Reads the file with `options` from now on, as far as they say anything.
    pub(super) fn read_with(&mut self, options: ReadOptions) {
        self.metres_per_unit = options.metres_per_unit.or(self.metres_per_unit);
        self.usd_time = options.time.or(self.usd_time);
    }
}

/// A head in the groom's space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HeadReference {
    /// Path of the OBJ file, in the groom's unit.
    pub path: String,
    /// Unknown fields.
    #[serde(flatten)]
    pub extra: Extra,
}

/// Where light comes from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Environment {
    /// A gradient sky with a sun.
    #[default]
    Sky,
    /// A named environment of `balayage_render::light::PRESETS`.
    Preset(String),
    /// The same radiance from everywhere, linear Rec.709.
    Constant([f32; 3]),
    /// Path of an equirectangular map, Radiance or OpenEXR.
    Map(String),
    /// Path of a light list.
    Lights(String),
    /// Maps that follow each other.
    Sequence(Sequence),
}

/// Equirectangular maps that follow each other, round and round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Sequence {
    /// Paths of the maps, Radiance or OpenEXR.
    pub maps: Vec<String>,
    /// Maps a second.
    #[serde(default = "usual_fps")]
    pub fps: f32,
    /// Unknown fields.
    #[serde(flatten)]
    pub extra: Extra,
}

impl Sequence {
    /// Index of the map that a frame shows.
    pub fn index(&self, frame: u32) -> usize {
        frame as usize % self.maps.len().max(1)
    }
}

fn usual_fps() -> f32 {
    12.0
}

/// The environment and how it is used.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct LightSettings {
    /// Where light comes from.
    pub environment: Environment,
    /// SRBF lights that are fitted to a map; with a `target_error` the most of them.
    pub light_count: u32,
    /// Hair error that as few lights as possible are fitted for, a fraction; none for `light_count` lights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target_error: Option<f32>,
    /// Rotation about the vertical axis, degrees; positive turns the map's centre towards its right edge.
    pub rotation_deg: f32,
    /// Exposure in stops: radiance times 2 to this power.
    pub exposure_ev: f32,
    /// Factor on the radiance, linear Rec.709.
    pub tint: [f32; 3],
    /// Lights that a person made or changed, before rotation, exposure and tint.
    pub hand: Vec<HandLight>,
    /// Unknown fields.
    #[serde(flatten)]
    pub extra: Extra,
}

impl Default for LightSettings {
    fn default() -> Self {
        Self {
            environment: Environment::Sky,
            light_count: 40,
            target_error: None,
            rotation_deg: 0.0,
            exposure_ev: 0.0,
            tint: [1.0; 3],
            hand: Vec::new(),
            extra: Extra::new(),
        }
    }
}

/// A camera: the JSON of `--camera`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CameraPose {
    /// Rows of the matrix that takes camera space (looking along -z, y up) to the groom's space.
    pub world_from_camera: [[f32; 4]; 4],
    /// Vertical field of view, degrees.
    pub fov_y_deg: f32,
    /// Unknown fields.
    #[serde(flatten)]
    pub extra: Extra,
}

/// The parameters of unpainted hair.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct HairSettings {
    /// Value of every channel where nothing is painted.
    pub base: Open<PointValues>,
    /// Which absorption a unit of melanin has.
    pub pigments: PigmentSet,
    /// Tilt and width of TT and TRT relative to R.
    pub ratios: Open<LobeRatios>,
    /// Fibre diameter in the groom's unit; null keeps the file's.
    pub diameter: Option<f32>,
    /// Which scattering function the fibres have; not written where it is the usual one.
    #[serde(skip_serializing_if = "is_usual")]
    pub model: Model,
    /// How scattering is integrated over a light; not written where it is the usual one.
    #[serde(skip_serializing_if = "is_usual")]
    pub scheme: Scheme,
    /// Unknown fields.
    #[serde(flatten)]
    pub extra: Extra,
}

/// A layer of paint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Layer {
    /// What operations call it; never changes.
    pub id: String,
    /// What a person calls it.
    pub name: String,
    /// False takes it out of the picture.
    #[serde(default = "yes")]
    pub visible: bool,
    /// How much of it shows, in [0, 1].
    #[serde(default = "one")]
    pub opacity: f32,
    /// How its paint meets what lies below.
    #[serde(default)]
    pub blend: Blend,
    /// Blends of single channels, where they differ from the layer's.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub channel_blends: BTreeMap<Channel, Blend>,
    /// Where it shows.
    #[serde(default, skip_serializing_if = "Mask::is_open")]
    pub mask: Mask,
    /// Tilt and width of TT and TRT relative to R where the layer shows; null keeps what lies below.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ratios: Option<Open<LobeRatios>>,
    /// Unknown fields.
    #[serde(flatten)]
    pub extra: Extra,
}

/// A dye of the project's library.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Dye {
    /// What a person calls it.
    pub name: String,
    /// Absorption per fibre radius, linear Rec.709.
    pub sigma_a: [f32; 3],
    /// Unknown fields.
    #[serde(flatten)]
    pub extra: Extra,
}

/// The library of a new project: what salons mix, and the vivid ones.
pub(super) fn usual_dyes() -> Vec<Dye> {
    let dyes: [(&str, [f32; 3]); 10] = [
        ("Honey", [0.02, 0.09, 0.35]),
        ("Copper", [0.03, 0.35, 1.1]),
        ("Auburn", [0.3, 1.2, 2.2]),
        ("Chocolate", [0.7, 1.3, 2.2]),
        ("Rose", [0.03, 0.42, 0.2]),
        ("Ruby", [0.1, 2.0, 1.4]),
        ("Violet", [0.35, 0.9, 0.1]),
        ("Blue", [1.6, 0.7, 0.08]),
        ("Teal", [1.2, 0.15, 0.25]),
        ("Silver", [0.1, 0.08, 0.05]),
    ];
    let dye = |(name, sigma_a): (&str, _)| Dye {
        name: name.to_owned(),
        sigma_a,
        extra: Extra::new(),
    };
    dyes.into_iter().map(dye).collect()
}

/// How a layer's paint meets what lies below it, in the channel's own space, by opacity o.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Blend {
    /// The strokes act on what lies below: (1 - o) x + o paint(x).
    #[default]
    Replace,
    /// What the strokes make of zero is added: x + o paint(0).
    Add,
    /// What the strokes make of one is a factor: x (1 - o + o paint(1)).
    Multiply,
}

fn is_usual<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

fn yes() -> bool {
    true
}

fn one() -> f32 {
    1.0
}

impl Layer {
    /// How the paint of a channel meets what lies below.
    pub fn blend_of(&self, channel: Channel) -> Blend {
        self.channel_blends.get(&channel).copied().unwrap_or(self.blend)
    }

    /// A visible, opaque layer that replaces what lies below.
    pub fn new(id: impl Into<String>, name: impl Into<String>) -> Self {
        Self {
            id: id.into(),
            name: name.into(),
            visible: true,
            opacity: 1.0,
            blend: Blend::Replace,
            channel_blends: BTreeMap::new(),
            mask: Mask::default(),
            ratios: None,
            extra: Extra::new(),
        }
    }
}

impl Project {
    /// A project without paint on `groom`.
    pub fn new(groom: GroomReference) -> Self {
        Self {
            version: PROJECT_VERSION,
            groom,
            head: None,
            light: LightSettings::default(),
            frame: 0,
            camera: None,
            hair: HairSettings::default(),
            layers: vec![Layer::new("paint", "Paint")],
            dyes: usual_dyes(),
            operations: Vec::new(),
            files: BTreeMap::new(),
            extra: Extra::new(),
        }
    }

    /// Reads and checks a project; a layer that operations name and the list lacks is added on top.
    ///
    /// # Errors
    /// Line and column where the text is no project, the field where a value is out of range.
    pub fn parse(text: &str) -> Result<Self, Problem> {
        let mut project: Self = serde_json::from_str(text).map_err(|e| Problem::json(&e))?;
        project.add_missing_layers();
        super::check::check_project(&project)?;
        // What version 1 lacked has been read as absent.
        project.version = PROJECT_VERSION;
        Ok(project)
    }

    /// Adds a layer for every layer id that only operations know, and one to paint on where there is none.
    pub fn add_missing_layers(&mut self) {
        for operation in &self.operations {
            if !self.layers.iter().any(|layer| layer.id == operation.layer) {
                self.layers.push(Layer::new(&operation.layer, &operation.layer));
            }
        }
        if self.layers.is_empty() {
            self.layers.push(Layer::new("paint", "Paint"));
        }
    }

    /// Applies `change` to every path of the project.
    pub fn map_paths(&mut self, mut change: impl FnMut(&str) -> String) {
        self.groom.path = change(&self.groom.path);
        let files = std::mem::take(&mut self.files).into_iter();
        self.files = files.map(|(path, hash)| (change(&path), hash)).collect();
        if let Some(head) = &mut self.head {
            head.path = change(&head.path);
        }
        match &mut self.light.environment {
            Environment::Map(path) | Environment::Lights(path) => *path = change(path),
            Environment::Sequence(sequence) => {
                for path in &mut sequence.maps {
                    *path = change(path);
                }
            }
            Environment::Sky | Environment::Preset(_) | Environment::Constant(_) => {}
        }
    }
}
