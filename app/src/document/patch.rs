//! What an edit, an undo or a redo made of the project, as data: the records of the journal.
//!
//! A patch says what the project became, not what was done: it needs neither the groom nor the history before it, so that a
//! journal replays onto the saved file alone, also where something was undone that had been done before the last save.

use serde::{Deserialize, Serialize};

use super::{
    history::Step,
    project::{Dye, HairSettings, HeadReference, Layer, LightSettings, Project},
};
use crate::paint::{Dab, Operation};

/// One change of a project.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Patch {
    /// Other operations stand in for `removed` operations from `at` on.
    Operations {
        /// Index of the first.
        at: usize,
        /// How many go.
        removed: usize,
        /// What takes their place.
        with: Vec<Operation>,
        /// True where the one new operation has the dabs of the one that goes, which are not repeated.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        keeps_dabs: bool,
    },
    /// Another list of layers; operations of layers that it lacks go.
    Layers {
        /// The layers, lowest first.
        layers: Vec<Layer>,
        /// Operations that come with it, by their index in ascending order, before any goes.
        inserted: Vec<(usize, Operation)>,
    },
    /// Other layers and operations as a whole.
    Paint {
        /// The layers, lowest first.
        layers: Vec<Layer>,
        /// All operations.
        operations: Vec<Operation>,
    },
    /// Other hair settings.
    Hair(Box<HairSettings>),
    /// Another light.
    Light(Box<LightSettings>),
    /// Another head.
    Head(Option<HeadReference>),
    /// Another dye library.
    Dyes(Vec<Dye>),
}

impl Patch {
    /// True for a stroke or another operation that was added, not changed or taken away.
    pub fn adds_operation(&self) -> bool {
        matches!(self, Self::Operations { removed: 0, with, .. } if !with.is_empty())
    }

    /// Does to `project` what the patch says; false where it does not fit, and nothing was done.
    pub fn apply(self, project: &mut Project) -> bool {
        let operations = &mut project.operations;
        match self {
            Self::Operations {
                at,
                removed,
                mut with,
                keeps_dabs,
            } => {
                let Some(end) = at.checked_add(removed).filter(|end| *end <= operations.len()) else {
                    return false;
                };
                if keeps_dabs {
                    let ([new], [old]) = (with.as_mut_slice(), &operations[at..end]) else {
                        return false;
                    };
                    new.dabs.clone_from(&old.dabs);
                }
                operations.splice(at..end, with);
            }
            Self::Layers { layers, inserted } => {
                let fits = inserted
                    .iter()
                    .enumerate()
                    .all(|(before, (index, _))| *index <= operations.len() + before);
                if !fits {
                    return false;
                }
                for (index, operation) in inserted {
                    operations.insert(index, operation);
                }
                operations.retain(|operation| layers.iter().any(|layer| layer.id == operation.layer));
                project.layers = layers;
            }
            Self::Paint { layers, operations } => {
                project.layers = layers;
                project.operations = operations;
            }
            Self::Hair(hair) => project.hair = *hair,
            Self::Light(light) => project.light = *light,
            Self::Head(head) => project.head = head,
            Self::Dyes(dyes) => project.dyes = dyes,
        }
        true
    }

    /// The patch to `operations[at..]` of `project`, of which `with` are new and the ones in `old` went.
    pub(super) fn of_operations(project: &Project, at: usize, with: usize, old: &[Operation]) -> Self {
        let mut with = project.operations[at..at + with].to_vec();
        let keeps_dabs = match (with.as_mut_slice(), old) {
            ([new], [old]) if !new.dabs.is_empty() && new.dabs == old.dabs => {
                new.dabs = Vec::<Dab>::new();
                true
            }
            _ => false,
        };
        Self::Operations {
            at,
            removed: old.len(),
            with,
            keeps_dabs,
        }
    }

    /// What the exchange with `step` made of `project`; `inserted` are the operations that a layer list brought with it.
    /// None for strokes, which have their own way.
    pub(super) fn of_step(project: &Project, step: &Step, inserted: Vec<(usize, Operation)>) -> Option<Self> {
        Some(match step {
            Step::Stroke { .. } => return None,
            Step::Operations(splice) => Self::of_operations(project, splice.index, splice.len, &splice.other),
            Step::Layers { .. } => Self::Layers {
                layers: project.layers.clone(),
                inserted,
            },
            Step::Paint { .. } => Self::Paint {
                layers: project.layers.clone(),
                operations: project.operations.clone(),
            },
            Step::Hair(_) => Self::Hair(Box::new(project.hair.clone())),
            Step::Light(_) => Self::Light(Box::new(project.light.clone())),
            Step::Head(_) => Self::Head(project.head.clone()),
            Step::Dyes(_) => Self::Dyes(project.dyes.clone()),
        })
    }
}
