//! What was done, so that it can be undone: one entry for a stroke, a slider drag or a click.

use balayage_render::param::Channel;

use super::project::{Dye, HairSettings, HeadReference, Layer, LightSettings};
use crate::paint::{ChannelMaps, Operation, TouchedMaps};

/// Memory that the history may take.
pub const DEFAULT_HISTORY_BYTES: usize = 256 << 20;

/// Memory that the steps themselves may take whatever the limit, without what is kept for undoing at once: the newest
/// hundreds of steps of usual work.
pub const LEAST_HISTORY_BYTES: usize = 1 << 20;

/// One thing that was done; what it holds is swapped with the document when it is undone or redone.
pub(super) enum Step {
    /// A stroke; while done, its operation is the project's last.
    Stroke {
        /// The operation while it is undone.
        operation: Option<Box<Operation>>,
        /// The maps before it, where they are still kept.
        before: Option<TouchedMaps>,
    },
    /// The other state of some operations.
    Operations(Splice),
    /// The other state of the layer list, and the operations that only that state has, by index.
    Layers {
        layers: Vec<Layer>,
        detached: Vec<(usize, Operation)>,
    },
    /// The other state of layers and operations as a whole.
    Paint {
        layers: Vec<Layer>,
        operations: Vec<Operation>,
    },
    /// The other hair settings.
    Hair(Box<HairSettings>),
    /// The other light.
    Light(Box<LightSettings>),
    /// The other head.
    Head(Option<HeadReference>),
    /// The other dye library.
    Dyes(Vec<Dye>),
}

/// Operations that stand in for `len` operations of the project from `index` on.
pub(super) struct Splice {
    pub(super) index: usize,
    pub(super) len: usize,
    pub(super) other: Vec<Operation>,
    /// The maps that go with `other`, where they are still kept.
    pub(super) maps: Option<Vec<SavedMaps>>,
}

/// All maps of one channel of the layer with this id.
pub(super) struct SavedMaps {
    pub(super) layer: String,
    pub(super) channel: Channel,
    pub(super) maps: ChannelMaps,
}

impl Step {
    /// Memory that could be given up, in bytes: undoing would take a replay.
    fn spare_bytes(&self) -> usize {
        match self {
            Self::Stroke { before, .. } => before.as_ref().map_or(0, TouchedMaps::bytes),
            Self::Operations(splice) => splice.maps.iter().flatten().map(|saved| saved.maps.bytes()).sum(),
            _ => 0,
        }
    }

    /// Memory that the step cannot do without, in bytes. Texts and unknown fields of settings are not counted: they are small beside
    /// operations.
    fn own_bytes(&self) -> usize {
        let of = |operations: &[Operation]| operations.iter().map(Operation::bytes).sum::<usize>();
        match self {
            Self::Stroke { operation, .. } => operation.as_ref().map_or(0, |operation| operation.bytes()),
            Self::Operations(splice) => of(&splice.other),
            Self::Layers { layers, detached } => {
                let detached = detached.iter().map(|(_, operation)| operation.bytes());
                size_of_val(layers.as_slice()) + detached.sum::<usize>()
            }
            Self::Paint { layers, operations } => size_of_val(layers.as_slice()) + of(operations),
            Self::Hair(_) => size_of::<HairSettings>(),
            Self::Light(light) => size_of::<LightSettings>() + size_of_val(light.hand.as_slice()),
            Self::Head(_) => 0,
            Self::Dyes(dyes) => size_of_val(dyes.as_slice()),
        }
    }

    /// Gives that memory up: undoing takes a replay from now on.
    fn forget(&mut self) {
        match self {
            Self::Stroke { before, .. } => *before = None,
            Self::Operations(splice) => splice.maps = None,
            _ => {}
        }
    }

    /// True where both are moments of one drag.
    fn continues(&self, earlier: &Self) -> bool {
        match (earlier, self) {
            (Self::Hair(_), Self::Hair(_))
            | (Self::Light(_), Self::Light(_))
            | (Self::Head(_), Self::Head(_))
            | (Self::Dyes(_), Self::Dyes(_))
            | (Self::Layers { .. }, Self::Layers { .. }) => true,
            (Self::Operations(a), Self::Operations(b)) => {
                a.index == b.index && a.len == b.len && a.other.len() == b.other.len()
            }
            _ => false,
        }
    }
}

/// A step with its name and a number that no other entry of the document has.
pub(super) struct Entry {
    pub(super) id: u64,
    pub(super) label: String,
    pub(super) step: Step,
}

impl Entry {
    /// Memory without what could be given up, in bytes.
    fn own_bytes(&self) -> usize {
        size_of::<Self>() + self.label.len() + self.step.own_bytes()
    }
}

/// The entries that can be undone and redone.
pub(super) struct History {
    pub(super) undo: Vec<Entry>,
    pub(super) redo: Vec<Entry>,
    next_id: u64,
    /// The number of the newest step that was forgotten.
    forgotten: u64,
    max_bytes: usize,
}

impl History {
    pub(super) fn new() -> Self {
        Self {
            undo: Vec::new(),
            redo: Vec::new(),
            next_id: 1,
            forgotten: 0,
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

    /// True where `step` is another moment of the drag that the newest entry stands for.
    pub(super) fn goes_on_with(&self, label: &str, step: &Step) -> bool {
        let newest = self.undo.last();
        newest.is_some_and(|newest| newest.label == label && step.continues(&newest.step))
    }

    /// The newest entry stands for another state from now on: it already holds the one before the drag.
    pub(super) fn renew_newest(&mut self) {
        self.redo.clear();
        if let Some(newest) = self.undo.last_mut() {
            newest.id = self.next_id;
            self.next_id += 1;
        }
    }

    /// The number of the newest step that is done; 0 where nothing was.
    pub(super) fn state(&self) -> u64 {
        self.undo.last().map_or(self.forgotten, |entry| entry.id)
    }

    pub(super) fn max_bytes(&self) -> usize {
        self.max_bytes
    }

    pub(super) fn set_max_bytes(&mut self, max_bytes: usize) {
        self.max_bytes = max_bytes;
        self.trim();
    }

    /// Memory of all steps, in bytes.
    pub(super) fn bytes(&self) -> usize {
        let entries = self.undo.iter().chain(&self.redo);
        entries
            .map(|entry| entry.own_bytes() + entry.step.spare_bytes())
            .sum()
    }

    /// Brings the memory below the limit: steps that are furthest from now are forgotten altogether where they alone exceed it, then the kept
    /// maps of the furthest that are left.
    pub(super) fn trim(&mut self) {
        let own = |entries: &[Entry]| entries.iter().map(Entry::own_bytes).sum::<usize>();
        let most = self.max_bytes.max(LEAST_HISTORY_BYTES);
        let mut kept = own(&self.undo) + own(&self.redo);
        let mut forgotten = 0;
        while kept > most && forgotten < self.undo.len() {
            kept -= self.undo[forgotten].own_bytes();
            forgotten += 1;
        }
        if let Some(newest) = self.undo.drain(..forgotten).next_back() {
            self.forgotten = newest.id;
        }
        // What is undone first is redone last.
        let mut forgotten = 0;
        while kept > most && forgotten < self.redo.len() {
            kept -= self.redo[forgotten].own_bytes();
            forgotten += 1;
        }
        self.redo.drain(..forgotten);

        let mut left = self.max_bytes.saturating_sub(kept);
        let newest_first = self.redo.iter_mut().rev().chain(self.undo.iter_mut().rev());
        for entry in newest_first {
            match entry.step.spare_bytes() {
                bytes if bytes <= left => left -= bytes,
                _ => {
                    entry.step.forget();
                    left = 0;
                }
            }
        }
    }
}
