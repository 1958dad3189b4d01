//! What was done, so that it can be undone: one entry for a stroke, a slider drag or a click.

use super::project::{HairSettings, HeadReference, Layer, LightSettings};
use crate::paint::{Operation, TouchedMaps};

/// Memory that strokes may keep for undoing them at once; older ones are undone by replay.
pub const DEFAULT_HISTORY_BYTES: usize = 256 << 20;

/// One thing that was done; what it holds is swapped with the document when it is undone or redone.
pub(super) enum Step {
    /// A stroke; while done, its operation is the project's last.
    Stroke {
        /// The operation while it is undone.
        operation: Option<Box<Operation>>,
        /// The maps before it, where they are still kept.
        before: Option<TouchedMaps>,
    },
    /// The other state of the layer list, and the operations that only that state has, by index.
    Layers {
        layers: Vec<Layer>,
        detached: Vec<(usize, Operation)>,
    },
    /// The other hair settings.
    Hair(Box<HairSettings>),
    /// The other light.
    Light(Box<LightSettings>),
    /// The other head.
    Head(Option<HeadReference>),
}

/// A step with its name and a number that no other entry of the document has.
pub(super) struct Entry {
    pub(super) id: u64,
    pub(super) label: String,
    pub(super) step: Step,
}

/// The entries that can be undone and redone.
pub(super) struct History {
    pub(super) undo: Vec<Entry>,
    pub(super) redo: Vec<Entry>,
    next_id: u64,
    max_bytes: usize,
}

impl History {
    pub(super) fn new() -> Self {
        Self {
            undo: Vec::new(),
            redo: Vec::new(),
            next_id: 1,
            max_bytes: DEFAULT_HISTORY_BYTES,
        }
    }

    /// Records a new step; what was undone before can no longer be redone.
    pub(super) fn push(&mut self, label: impl Into<String>, step: Step) {
        self.redo.clear();
        self.undo.push(Entry {
            id: self.next_id,
            label: label.into(),
            step,
        });
        self.next_id += 1;
        self.trim();
    }

    /// The number of the newest entry; 0 where nothing was done.
    pub(super) fn state(&self) -> u64 {
        self.undo.last().map_or(0, |entry| entry.id)
    }

    pub(super) fn set_max_bytes(&mut self, max_bytes: usize) {
        self.max_bytes = max_bytes;
        self.trim();
    }

    /// Forgets the kept maps of the oldest strokes until the limit holds.
    pub(super) fn trim(&mut self) {
        let mut left = self.max_bytes;
        for entry in self.undo.iter_mut().rev() {
            if let Step::Stroke { before, .. } = &mut entry.step {
                match before.as_ref().map_or(0, TouchedMaps::bytes) {
                    bytes if bytes <= left => left -= bytes,
                    _ => {
                        *before = None;
                        left = 0;
                    }
                }
            }
        }
    }
}
