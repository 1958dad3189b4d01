//! The document: a groom, a project and what they amount to. Only the document changes itself, through [`Edit`]s.
//!
//! The painted values are a pure function of groom and project. Painting keeps them up to date point by point; the result
//! is bit for bit that of a replay.

mod backups;
mod builtin;
mod check;
mod compose;
mod edit;
pub mod files;
mod hand_light;
mod history;
pub mod journal;
mod journaling;
pub mod json;
mod layering;
mod lighting;
mod lock;
pub mod material;
mod open;
mod opening;
mod operations;
mod patch;
mod project;
pub mod recover;
pub mod relink;
mod saving;
mod schema;
mod sequence;
mod stroking;
mod user_state;

use std::{path::PathBuf, sync::Arc, time::Instant};

use balayage_render::{
    groom::{Groom, PaintedValues},
    param::{Channel, LobeRatios, PointValues, VertexParams},
};
use rayon::prelude::*;

pub use backups::{backup_path, backups_of};
pub use builtin::builtin_environments;
pub use check::check_camera;
pub(crate) use check::check_hair;
pub use edit::{Changes, Edit};
pub use hand_light::{HandLight, LightId, ListedLight, MAX_HAND_LIGHTS};
pub use history::{DEFAULT_HISTORY_BYTES, LEAST_HISTORY_BYTES};
pub use lighting::{FitReport, Lighting, map_warnings};
pub use lock::{Holder, LockError, ProjectLock};
pub use open::{MAX_PROJECT_BYTES, Opened};
pub use opening::{Answers, JournalAnswer, LockAnswer, OpenStep, Question, Source, open_step};
pub use patch::Patch;
pub use project::{
    Blend, CameraPose, Dye, Environment, GroomReference, HairSettings, HeadReference, Layer, LightSettings,
    MAX_LAYERS, Open, PROJECT_VERSION, Project, Sequence,
};
pub use saving::{SaveOptions, Saved};
pub use schema::{project_schema, stroke_schema};
pub use sequence::{MAX_MAPS, maps_of};
pub use user_state::{MAX_BACKUPS, UserState};

use crate::{
    Problem,
    paint::{DirtyRanges, LayerMaps, LiveStroke, Operation, OperationId, PaintWork, StrandIndex},
};
use compose::LayerState;
use history::History;
use journaling::Keeper;
use operations::Prefix;

/// An open project with its painted values and its history.
pub struct Document {
    index: Arc<StrandIndex>,
    project: Project,
    /// Where the project is saved; none for one that never was.
    path: Option<PathBuf>,
    /// Content hash of the file there when it was read or written last.
    disk_hash: Option<String>,
    /// Keeps others from writing that file.
    lock: Option<ProjectLock>,
    /// Writes down every edit, where the document was asked to.
    keeper: Option<Keeper>,
    /// The folder that the project's paths count from.
    folder: PathBuf,
    /// What each layer amounts to, in the order of the project's layers.
    layers: Vec<LayerState>,
    /// Values and lobe ratios that the groom's file brings, in place of the project's base.
    brought: Option<(Vec<PointValues>, Vec<LobeRatios>)>,
    values: Vec<PointValues>,
    params: Vec<VertexParams>,
    history: History,
    saved_state: u64,
    /// The document differs from the file since it was opened: recovered or linked to other files.
    is_restored: bool,
    /// The stroke under way and the index of its layer.
    live: Option<(usize, LiveStroke)>,
    /// What comes before the operation that is being adjusted.
    prefix: Option<Prefix>,
    work: PaintWork,
}

/// Points that one thread composites alone.
const ALONE: usize = 4096;

impl Document {
    /// The document of `project` on `groom`; the project's paths count from `folder`.
    ///
    /// # Errors
    /// The project's first field that is out of range.
    pub fn new(groom: Arc<Groom>, mut project: Project, folder: PathBuf) -> Result<Self, Problem> {
        project.add_missing_layers();
        check::check_project(&project)?;
        let mut document = Self {
            index: Arc::new(StrandIndex::new(groom)),
            project,
            path: None,
            disk_hash: None,
            lock: None,
            keeper: None,
            folder,
            layers: Vec::new(),
            brought: None,
            values: Vec::new(),
            params: Vec::new(),
            history: History::new(),
            saved_state: 0,
            is_restored: false,
            live: None,
            prefix: None,
            work: PaintWork::default(),
        };
        document.rebuild_layers();
        let count = document.groom().point_count();
        document.values = vec![document.project.hair.base.known; count];
        document.params = document.unpainted_params();
        document.recompose(&DirtyRanges::all(count));
        Ok(document)
    }

    /// The groom.
    pub fn groom(&self) -> &Arc<Groom> {
        self.index.groom()
    }

    /// The groom with the project's fibre diameter.
    ///
    /// # Errors
    /// A diameter that the groom refuses.
    pub fn groom_as_drawn(&self) -> Result<Arc<Groom>, Problem> {
        let groom = self.groom();
        let Some(diameter) = self.project.hair.diameter else {
            return Ok(groom.clone());
        };
        let strands = (0..groom.strand_count()).map(|strand| &groom.positions()[groom.strand(strand)]);
        let (drawn, _) = Groom::from_strands(strands, diameter, groom.metres_per_unit())
            .map_err(|e| Problem::at("hair.diameter", e.to_string(), "give another diameter"))?;
        Ok(Arc::new(drawn))
    }

    /// The groom's points as a brush sees them.
    pub fn index(&self) -> &Arc<StrandIndex> {
        &self.index
    }

    /// The project as it would be saved, without a stroke under way.
    pub fn project(&self) -> &Project {
        &self.project
    }

    /// Where the project is saved.
    pub fn path(&self) -> Option<&std::path::Path> {
        self.path.as_deref()
    }

    /// The folder that the project's paths count from.
    pub fn folder(&self) -> &std::path::Path {
        &self.folder
    }

    /// The painted channels of every groom point.
    pub fn values(&self) -> &[PointValues] {
        &self.values
    }

    /// Takes what the groom's file brings as what the layers are painted on; the project's base and ratios no longer show.
    ///
    /// # Errors
    /// Not a value for every point.
    pub fn bring(&mut self, painted: PaintedValues) -> Result<(), Problem> {
        let count = self.groom().point_count();
        let (values, ratios) = (painted.values.len(), painted.ratios.len());
        if [values, ratios] != [count; 2] {
            let reason = format!("{values} values and {ratios} lobe ratios for {count} points");
            return Err(Problem::at(
                "painted values",
                reason,
                "give a value for every point",
            ));
        }
        self.project.hair.pigments = painted.pigments;
        self.brought = Some((painted.values, painted.ratios));
        self.recompose(&DirtyRanges::all(count));
        Ok(())
    }

    /// What the points are painted with, as a file can take it.
    pub fn painted(&self) -> PaintedValues {
        let ratios = self.params.iter().map(|params| LobeRatios {
            alpha_tt: params.alpha_ratios[0],
            alpha_trt: params.alpha_ratios[1],
            beta_tt: params.beta_ratios[0],
            beta_trt: params.beta_ratios[1],
        });
        PaintedValues {
            values: self.values.clone(),
            ratios: ratios.collect(),
            pigments: self.project.hair.pigments,
        }
    }

    /// What the shaders read of every groom point.
    pub fn params(&self) -> &[VertexParams] {
        &self.params
    }

    /// What the shaders would read if nothing was painted.
    pub fn unpainted_params(&self) -> Vec<VertexParams> {
        let hair = &self.project.hair;
        let params = hair.base.known.vertex_params(hair.pigments, &hair.ratios.known);
        vec![params; self.groom().point_count()]
    }

    /// The file that a path of the project names.
    pub fn resolve(&self, reference: &str) -> PathBuf {
        files::resolve(reference, &self.folder)
    }

    /// `file` as the project would name it.
    pub fn reference_to(&self, file: &std::path::Path) -> String {
        files::relative(file, &self.folder)
    }

    /// True where something would be lost if the document was closed now.
    pub fn is_modified(&self) -> bool {
        self.history.state() != self.saved_state || self.live.is_some() || self.is_restored
    }

    /// What undo would take back.
    pub fn undo_label(&self) -> Option<&str> {
        self.history.undo.last().map(|entry| entry.label.as_str())
    }

    /// What redo would do again.
    pub fn redo_label(&self) -> Option<&str> {
        self.history.redo.last().map(|entry| entry.label.as_str())
    }

    /// A number that no operation of the project has as its id.
    pub fn next_operation_number(&self) -> u64 {
        let used = self
            .project
            .operations
            .iter()
            .filter_map(|operation| match operation.id {
                OperationId::Number(n) => Some(n),
                OperationId::Text(_) => None,
            });
        used.max().unwrap_or(0).saturating_add(1)
    }

    /// What painting cost since the newest stroke was begun.
    pub fn paint_work(&self) -> PaintWork {
        self.work
    }

    /// Limits the memory of the history, in bytes; the steps themselves may always take [`LEAST_HISTORY_BYTES`]. What does not fit is undone by
    /// painting everything again, or no longer.
    pub fn set_history_bytes(&mut self, max_bytes: usize) {
        self.history.set_max_bytes(max_bytes);
    }

    /// The limit of [`Document::set_history_bytes`].
    pub fn history_limit_bytes(&self) -> usize {
        self.history.max_bytes()
    }

    /// Memory of the history, in bytes.
    pub fn history_bytes(&self) -> usize {
        self.history.bytes()
    }

    /// Moves the camera; a view is no edit.
    ///
    /// # Errors
    /// A matrix that is no rigid motion, a field of view out of range.
    pub fn set_camera(&mut self, camera: Option<CameraPose>) -> Result<(), Problem> {
        camera.as_ref().map_or(Ok(()), check_camera)?;
        self.project.camera = camera;
        Ok(())
    }

    /// Shows another map of the sequence; a view is no edit.
    pub fn set_frame(&mut self, frame: u32) {
        self.project.frame = frame;
    }

    /// Index of the layer `id`.
    fn layer_index(&self, id: &str) -> Result<usize, Problem> {
        self.project
            .layers
            .iter()
            .position(|layer| layer.id == id)
            .ok_or_else(|| {
                Problem::at(
                    "layer",
                    format!("no layer has the id \"{id}\""),
                    "add the layer first",
                )
            })
    }

    /// The maps of the layer `id`, from its operations.
    fn replayed(&self, id: &str) -> LayerMaps {
        LayerMaps::replay(&self.index, self.operations_of(id))
    }

    fn operations_of<'a>(&'a self, id: &'a str) -> impl Iterator<Item = &'a Operation> + 'a {
        self.project
            .operations
            .iter()
            .filter(move |operation| operation.layer == id)
    }

    /// Follows new maps of a channel of a layer at the points in `dirty`; returns the points whose values changed.
    fn repainted(&mut self, layer: usize, channel: Channel, dirty: &DirtyRanges) -> DirtyRanges {
        if channel != Channel::Mask {
            return self.recompose(dirty);
        }
        let settings = &self.project.layers[layer];
        let masked = self.layers[layer].update_mask(&self.index, settings, dirty);
        self.recompose(&masked)
    }

    /// Brings values and parameters of the points in `dirty` up to date; returns those that changed.
    fn recompose(&mut self, dirty: &DirtyRanges) -> DirtyRanges {
        let hair = &self.project.hair;
        let (layers, maps, brought) = (&self.project.layers, &self.layers, &self.brought);
        let composed = |point: &u32| {
            let point = *point as usize;
            let (base, ratios) = match brought {
                Some((values, ratios)) => (&values[point], &ratios[point]),
                None => (&hair.base.known, &hair.ratios.known),
            };
            let (values, ratios) = compose::compose(base, ratios, layers.iter().zip(maps), point);
            (values, values.vertex_params(hair.pigments, &ratios))
        };
        let start = Instant::now();
        let points: Vec<u32> = dirty.points().collect();
        // Waking other threads takes longer than a dab.
        let new: Vec<_> = if points.len() < ALONE {
            points.iter().map(composed).collect()
        } else {
            points.par_iter().with_min_len(1024).map(composed).collect()
        };
        let mut changed = Vec::new();
        for (point, (values, params)) in points.iter().zip(new) {
            let p = *point as usize;
            if self.values[p] != values || self.params[p] != params {
                self.values[p] = values;
                self.params[p] = params;
                changed.push(*point);
            }
        }
        self.work += PaintWork {
            composed: points.len() as u64,
            changed: changed.len() as u64,
            compose: start.elapsed(),
            ..PaintWork::default()
        };
        DirtyRanges::of_points(changed)
    }
}
