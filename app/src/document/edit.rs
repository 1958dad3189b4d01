//! How the document changes: edits, undo and redo.

use super::{
    Document, check,
    hand_light::hand_label,
    history::{Splice, Step},
    journal::Record,
    patch::Patch,
    project::{Dye, HairSettings, HeadReference, Layer, LightSettings},
};
use crate::{
    Problem,
    paint::{DirtyRanges, Operation, OperationId},
};

/// One change of the document; each is one entry of the history.
#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    /// A whole stroke, or a salon operation.
    Stroke(Operation),
    /// The operation at this place of the project's list becomes another one.
    SetOperation(usize, Operation),
    /// The operation at this place goes.
    RemoveOperation(usize),
    /// A new layer at a position from below; positions beyond the top mean the top.
    AddLayer(Layer, usize),
    /// The layer with this id goes, and its operations.
    RemoveLayer(String),
    /// The layer with this id moves to a position from below.
    MoveLayer(String, usize),
    /// The layer with this id gets another name, visibility, opacity, blend, mask or lobe ratios.
    SetLayer(Layer),
    /// A copy of the layer with this id, under a new id, right above it.
    DuplicateLayer(String, String),
    /// The operations of the layer with this id go to the one below it.
    MergeDown(String),
    /// Unpainted parameters.
    SetHair(HairSettings),
    /// Environment, its rotation and exposure.
    SetLight(LightSettings),
    /// The head.
    SetHead(Option<HeadReference>),
    /// The dye library.
    SetDyes(Vec<Dye>),
}

/// What an edit, an undo or a redo changed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// Points whose values changed.
    pub points: DirtyRanges,
    /// The fibre diameter changed.
    pub diameter: bool,
    /// Environment, rotation or exposure changed.
    pub light: bool,
    /// Another head.
    pub head: bool,
}

impl From<DirtyRanges> for Changes {
    fn from(points: DirtyRanges) -> Self {
        Self {
            points,
            ..Self::default()
        }
    }
}

impl Document {
    /// Applies an edit as a history entry of its own; a stroke under way is committed first.
    ///
    /// # Errors
    /// A value out of range, a layer or operation that does not exist; the document is as before.
    pub fn apply(&mut self, edit: Edit) -> Result<Changes, Problem> {
        self.apply_after(edit, false)
    }

    /// Applies an edit as the continuation of the newest entry where that is of the same kind (a slider drag is one entry).
    ///
    /// # Errors
    /// As [`Document::apply`].
    pub fn apply_continuing(&mut self, edit: Edit) -> Result<Changes, Problem> {
        self.apply_after(edit, true)
    }

    fn apply_after(&mut self, edit: Edit, may_continue: bool) -> Result<Changes, Problem> {
        self.commit_stroke();
        if !matches!(&edit, Edit::SetOperation(index, _) if self.prefix.as_ref().is_some_and(|p| p.index == *index))
        {
            self.prefix = None;
        }
        let (label, step) = match edit {
            Edit::Stroke(operation) if operation.shape.is_none() && !operation.hidden => {
                return self.apply_stroke(operation).map(Changes::from);
            }
            Edit::Stroke(operation) => {
                self.check_operation(&operation)?;
                let label = operation.title();
                let end = self.project.operations.len();
                (label, splice(end, 0, vec![operation]))
            }
            Edit::SetOperation(index, operation) => {
                let old = self.operation_at(index)?;
                let label = format!("Change {}", old.title().to_lowercase());
                let same_place = old.layer == operation.layer && old.channel == operation.channel;
                self.check_operation(&operation)?;
                if same_place {
                    self.keep_prefix(index);
                }
                (label, splice(index, 1, vec![operation]))
            }
            Edit::RemoveOperation(index) => {
                let label = format!("Remove {}", self.operation_at(index)?.title().to_lowercase());
                (label, splice(index, 1, Vec::new()))
            }
            Edit::AddLayer(layer, position) => {
                let label = format!("Add layer {}", layer.name);
                let mut layers = self.project.layers.clone();
                layers.insert(position.min(layers.len()), layer);
                (label, layer_step(layers)?)
            }
            Edit::RemoveLayer(id) => {
                let mut layers = self.project.layers.clone();
                let removed = layers.remove(self.layer_index(&id)?);
                (format!("Remove layer {}", removed.name), layer_step(layers)?)
            }
            Edit::MoveLayer(id, position) => {
                let mut layers = self.project.layers.clone();
                let layer = layers.remove(self.layer_index(&id)?);
                let label = format!("Move layer {}", layer.name);
                layers.insert(position.min(layers.len()), layer);
                (label, layer_step(layers)?)
            }
            Edit::SetLayer(layer) => {
                let mut layers = self.project.layers.clone();
                let label = format!("Change layer {}", layer.name);
                let i = self.layer_index(&layer.id)?;
                layers[i] = layer;
                (label, layer_step(layers)?)
            }
            Edit::DuplicateLayer(id, new_id) => self.duplicate_step(&id, &new_id)?,
            Edit::MergeDown(id) => return self.merge_down(&id),
            Edit::SetHair(hair) => {
                check::check_hair(&hair)?;
                ("Change hair".to_owned(), Step::Hair(Box::new(hair)))
            }
            Edit::SetLight(light) => {
                check::check_light(&light)?;
                let label = light_label(&self.project.light, &light);
                (label.to_owned(), Step::Light(Box::new(light)))
            }
            Edit::SetHead(head) => ("Change head".to_owned(), Step::Head(head)),
            Edit::SetDyes(dyes) => {
                check::check_dyes(&dyes)?;
                ("Change dyes".to_owned(), Step::Dyes(dyes))
            }
        };
        let mut step = step;
        let continues = may_continue && self.history.goes_on_with(&label, &step);
        let record = if continues {
            Record::Continued
        } else {
            Record::Patch
        };
        let changes = self.swap_recorded(&mut step, record);
        if continues {
            self.history.renew_newest();
        } else {
            self.history.push(label, step);
        }
        Ok(changes)
    }

    /// Takes back the newest entry; returns its name and what changed.
    pub fn undo(&mut self) -> Option<(String, Changes)> {
        self.commit_stroke();
        self.prefix = None;
        let mut entry = self.history.undo.pop()?;
        let changes = match &mut entry.step {
            Step::Stroke { operation, before } => {
                let undone = self.project.operations.pop()?;
                let points = self.undo_stroke(&undone, before.take());
                let at = self.project.operations.len();
                let removed = std::slice::from_ref(&undone);
                self.record(|project| Record::Patch(Patch::of_operations(project, at, 0, removed)));
                *operation = Some(Box::new(undone));
                points.into()
            }
            step => self.swap_recorded(step, Record::Patch),
        };
        let label = entry.label.clone();
        self.history.redo.push(entry);
        self.history.trim();
        Some((label, changes))
    }

    /// Does the last undone entry again; returns its name and what changed.
    pub fn redo(&mut self) -> Option<(String, Changes)> {
        self.commit_stroke();
        self.prefix = None;
        let mut entry = self.history.redo.pop()?;
        let changes = match &mut entry.step {
            Step::Stroke { operation, before } => {
                let (points, touched) = self.redo_stroke(*operation.take()?)?;
                *before = Some(touched);
                self.record_stroke();
                points.into()
            }
            step => self.swap_recorded(step, Record::Patch),
        };
        let label = entry.label.clone();
        self.history.undo.push(entry);
        self.history.trim();
        Some((label, changes))
    }

    /// The names of what was done, oldest first, and how many of them are done now; the others are undone.
    pub fn history_labels(&self) -> (Vec<&str>, usize) {
        let done = self.history.undo.iter();
        let undone = self.history.redo.iter().rev();
        let labels = done.chain(undone).map(|entry| entry.label.as_str()).collect();
        (labels, self.history.undo.len())
    }

    /// Exchanges what `step` holds with the document; strokes have their own way.
    pub(super) fn swap(&mut self, step: &mut Step) -> Changes {
        let mut changes = Changes::default();
        match step {
            Step::Stroke { .. } => {}
            Step::Operations(splice) => self.swap_operations(splice),
            Step::Layers { layers, detached } => self.swap_layers(layers, detached),
            Step::Paint { layers, operations } => {
                std::mem::swap(&mut self.project.operations, operations);
                std::mem::swap(&mut self.project.layers, layers);
                self.rebuild_layers();
            }
            Step::Hair(hair) => {
                std::mem::swap(&mut self.project.hair, hair);
                changes.diameter = self.project.hair.diameter != hair.diameter;
            }
            Step::Light(light) => {
                std::mem::swap(&mut self.project.light, light);
                changes.light = true;
                return changes;
            }
            Step::Head(head) => {
                std::mem::swap(&mut self.project.head, head);
                changes.head = true;
                return changes;
            }
            Step::Dyes(dyes) => {
                std::mem::swap(&mut self.project.dyes, dyes);
                return changes;
            }
        }
        changes.points = self.recompose(&DirtyRanges::all(self.groom().point_count()));
        changes
    }

    /// The operation at a place of the project's list.
    fn operation_at(&self, index: usize) -> Result<&Operation, Problem> {
        self.project.operations.get(index).ok_or_else(|| {
            Problem::at(
                format!("operations[{index}]"),
                "there is no such operation",
                "choose one of the list",
            )
        })
    }

    /// Checks an operation and that its layer exists.
    pub(super) fn check_operation(&self, operation: &Operation) -> Result<usize, Problem> {
        operation.check()?;
        self.layer_index(&operation.layer)
    }

    /// A free number for an operation.
    pub fn next_operation_id(&self) -> OperationId {
        OperationId::Number(self.next_operation_number())
    }
}

fn splice(index: usize, len: usize, other: Vec<Operation>) -> Step {
    Step::Operations(Splice {
        index,
        len,
        other,
        maps: None,
    })
}

/// What a person did to the light.
fn light_label(before: &LightSettings, after: &LightSettings) -> &'static str {
    if before.environment != after.environment {
        "Change environment"
    } else if before.hand != after.hand {
        hand_label(&before.hand, &after.hand)
    } else if before.rotation_deg != after.rotation_deg {
        "Turn environment"
    } else {
        "Change light"
    }
}

/// The step to another list of layers.
fn layer_step(layers: Vec<Layer>) -> Result<Step, Problem> {
    check::check_layers(&layers)?;
    Ok(Step::Layers {
        layers,
        detached: Vec::new(),
    })
}
