//! How the document changes: edits, strokes under way, undo and redo.

use super::{
    Document, check,
    hand_light::hand_label,
    history::Step,
    project::{HairSettings, HeadReference, Layer, LightSettings},
};
use crate::{
    Problem,
    paint::{Dab, DirtyRanges, LayerMaps, Mode, Operation, TouchedMaps, check_dabs},
};

/// One change of the document; each is one entry of the history.
#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    /// A whole stroke.
    Stroke(Operation),
    /// A new layer at a position from below; positions beyond the top mean the top.
    AddLayer(Layer, usize),
    /// The layer with this id goes, and its operations.
    RemoveLayer(String),
    /// The layer with this id moves to a position from below.
    MoveLayer(String, usize),
    /// The layer with this id gets another name, visibility, opacity or blend.
    SetLayer(Layer),
    /// Unpainted parameters.
    SetHair(HairSettings),
    /// Environment, its rotation and exposure.
    SetLight(LightSettings),
    /// The head.
    SetHead(Option<HeadReference>),
}

/// What an edit, an undo or a redo changed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// Points whose values changed.
    pub points: DirtyRanges,
    /// Parameters of the hair as a whole changed: lobe ratios.
    pub hair: bool,
    /// The fibre diameter changed.
    pub diameter: bool,
    /// Environment, rotation or exposure changed.
    pub light: bool,
    /// Another head.
    pub head: bool,
}

impl Document {
    /// Applies an edit as a history entry of its own; a stroke under way is committed first.
    ///
    /// # Errors
    /// A value out of range or a layer that does not exist; the document is as before.
    pub fn apply(&mut self, edit: Edit) -> Result<Changes, Problem> {
        self.commit_stroke();
        let (label, step) = match edit {
            Edit::Stroke(mut operation) => {
                let dabs = std::mem::take(&mut operation.dabs);
                self.begin_stroke(operation)?;
                return match self.extend_stroke(dabs) {
                    Ok(points) => {
                        self.commit_stroke();
                        Ok(Changes {
                            points,
                            ..Changes::default()
                        })
                    }
                    Err(problem) => {
                        self.cancel_stroke();
                        Err(problem)
                    }
                };
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
        };
        let mut step = step;
        let changes = self.swap(&mut step);
        self.history.push(label, step);
        Ok(changes)
    }

    /// Applies an edit as the continuation of the newest entry where that is of the same kind (a slider drag is one entry).
    ///
    /// # Errors
    /// As [`Document::apply`].
    pub fn apply_continuing(&mut self, edit: Edit) -> Result<Changes, Problem> {
        let entries = self.history.undo.len();
        let changes = self.apply(edit)?;
        let [.., earlier, newest] = self.history.undo.as_slice() else {
            return Ok(changes);
        };

        // The earlier entry already holds the state before the drag: the newest one adds nothing.
        let same = matches!(
            (&earlier.step, &newest.step),
            (Step::Hair(_), Step::Hair(_))
                | (Step::Light(_), Step::Light(_))
                | (Step::Head(_), Step::Head(_))
        ) || matches!((&earlier.step, &newest.step), (Step::Layers { .. }, Step::Layers { .. }) if earlier.label == newest.label);
        if same && self.history.undo.len() == entries + 1 {
            let newest = self.history.undo.pop();
            if let (Some(earlier), Some(newest)) = (self.history.undo.last_mut(), newest) {
                earlier.id = newest.id;
            }
        }
        Ok(changes)
    }

    /// Takes back the newest entry; returns its name and what changed.
    pub fn undo(&mut self) -> Option<(String, Changes)> {
        self.commit_stroke();
        let mut entry = self.history.undo.pop()?;
        let changes = match &mut entry.step {
            Step::Stroke { operation, before } => {
                let undone = self.project.operations.pop()?;
                let before = before.take();
                let points = self.undo_stroke(&undone, before);
                *operation = Some(Box::new(undone));
                Changes {
                    points,
                    ..Changes::default()
                }
            }
            step => self.swap(step),
        };
        let label = entry.label.clone();
        self.history.redo.push(entry);
        Some((label, changes))
    }

    /// Does the last undone entry again; returns its name and what changed.
    pub fn redo(&mut self) -> Option<(String, Changes)> {
        self.commit_stroke();
        let mut entry = self.history.redo.pop()?;
        let changes = match &mut entry.step {
            Step::Stroke { operation, before } => {
                let mut redone = *operation.take()?;
                let layer = self.layer_index(&redone.layer).ok()?;
                let dabs = std::mem::take(&mut redone.dabs);
                let mut live = self.layers[layer].begin(&self.index, redone);
                let dirty = self.layers[layer].extend(&self.index, &mut live, dabs);
                let (redone, touched) = live.finish();
                self.project.operations.push(redone);
                *before = Some(touched);
                Changes {
                    points: self.recompose(&dirty),
                    ..Changes::default()
                }
            }
            step => self.swap(step),
        };
        let label = entry.label.clone();
        self.history.undo.push(entry);
        self.history.trim();
        Some((label, changes))
    }

    /// Starts a stroke without dabs; a stroke under way is committed first.
    ///
    /// # Errors
    /// A value out of range or a layer that does not exist.
    pub fn begin_stroke(&mut self, operation: Operation) -> Result<(), Problem> {
        self.commit_stroke();
        operation.check()?;
        let layer = self.layer_index(&operation.layer)?;
        let dabs_later = Operation {
            dabs: Vec::new(),
            ..operation
        };
        self.live = Some((layer, self.layers[layer].begin(&self.index, dabs_later)));
        Ok(())
    }

    /// Adds dabs to the stroke under way; returns the points whose values changed.
    ///
    /// # Errors
    /// A dab that is out of range: none of `dabs` is painted.
    pub fn extend_stroke(&mut self, dabs: Vec<Dab>) -> Result<DirtyRanges, Problem> {
        let Some((layer, mut live)) = self.live.take() else {
            return Ok(DirtyRanges::none());
        };
        let dirty = check_dabs(&dabs).map(|()| self.layers[layer].extend(&self.index, &mut live, dabs));
        self.live = Some((layer, live));
        dirty.map(|dirty| self.recompose(&dirty))
    }

    /// Ends the stroke under way: it becomes the newest history entry. One without dabs leaves no trace.
    pub fn commit_stroke(&mut self) {
        let Some((_, live)) = self.live.take() else { return };
        let (operation, before) = live.finish();
        if operation.dabs.is_empty() {
            return;
        }
        let verb = match operation.mode {
            Mode::Erase => "Erase",
            Mode::Smooth => "Smooth",
            _ => "Paint",
        };
        let label = format!("{verb} {}", operation.channel.name());
        self.project.operations.push(operation);
        self.history.push(
            label,
            Step::Stroke {
                operation: None,
                before: Some(before),
            },
        );
    }

    /// Drops the stroke under way; returns the points whose values changed back.
    pub fn cancel_stroke(&mut self) -> DirtyRanges {
        let Some((layer, live)) = self.live.take() else {
            return DirtyRanges::none();
        };
        let (_, mut before) = live.finish();
        let dirty = self.layers[layer].swap(&self.index, &mut before);
        self.recompose(&dirty)
    }

    /// Puts the maps back that `before` holds, or replays the channel of the layer where they are no longer kept.
    fn undo_stroke(&mut self, undone: &Operation, before: Option<TouchedMaps>) -> DirtyRanges {
        let Ok(layer) = self.layer_index(&undone.layer) else {
            return DirtyRanges::none();
        };
        let dirty = match before {
            Some(mut before) => self.layers[layer].swap(&self.index, &mut before),
            None => {
                let mut maps = std::mem::take(&mut self.layers[layer]);
                maps.replay_channel(&self.index, undone.channel, self.operations_of(&undone.layer));
                self.layers[layer] = maps;
                DirtyRanges::all(self.groom().point_count())
            }
        };
        self.recompose(&dirty)
    }

    /// Exchanges what `step` holds with the document; strokes have their own way.
    fn swap(&mut self, step: &mut Step) -> Changes {
        let mut changes = Changes::default();
        match step {
            Step::Stroke { .. } => {}
            Step::Layers { layers, detached } => self.swap_layers(layers, detached),
            Step::Hair(hair) => {
                std::mem::swap(&mut self.project.hair, hair);
                changes.hair = true;
                changes.diameter = self.project.hair.diameter != hair.diameter;
            }
            Step::Light(light) => {
                std::mem::swap(&mut self.project.light, light);
                return Changes {
                    light: true,
                    ..changes
                };
            }
            Step::Head(head) => {
                std::mem::swap(&mut self.project.head, head);
                return Changes {
                    head: true,
                    ..changes
                };
            }
        }
        changes.points = self.recompose(&DirtyRanges::all(self.groom().point_count()));
        changes
    }

    /// Exchanges the layer list; operations follow their layers out of the project and back.
    fn swap_layers(&mut self, layers: &mut Vec<Layer>, detached: &mut Vec<(usize, Operation)>) {
        for (index, operation) in detached.drain(..) {
            self.project.operations.insert(index, operation);
        }
        let old_maps: Vec<LayerMaps> = std::mem::take(&mut self.layers);
        std::mem::swap(&mut self.project.layers, layers);

        // Indices count in the list with the operation still in it, so that inserting in ascending order restores it.
        let kept = |id: &str| self.project.layers.iter().any(|layer| layer.id == id);
        let all = std::mem::take(&mut self.project.operations);
        let mut left = Vec::with_capacity(all.len());
        for (index, operation) in all.into_iter().enumerate() {
            if kept(&operation.layer) {
                left.push(operation);
            } else {
                detached.push((index, operation));
            }
        }
        self.project.operations = left;

        // A layer that was there before keeps its maps.
        let mut old: Vec<(String, LayerMaps)> = layers
            .iter()
            .map(|layer| layer.id.clone())
            .zip(old_maps)
            .collect();
        let ids: Vec<String> = self.project.layers.iter().map(|layer| layer.id.clone()).collect();
        self.layers = ids
            .iter()
            .map(|id| match old.iter().position(|(other, _)| other == id) {
                Some(i) => old.swap_remove(i).1,
                None => self.replayed(id),
            })
            .collect();
    }
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
