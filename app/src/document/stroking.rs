//! Strokes under way: begun, extended, committed or cancelled; and their undo.

use super::{Document, history::Step};
use crate::{
    Problem,
    paint::{Dab, DirtyRanges, Operation, PaintWork, TouchedMaps, check_dabs},
};

impl Document {
    /// Starts a stroke without dabs; a stroke under way is committed first.
    ///
    /// # Errors
    /// A value out of range, a layer that does not exist, an operation with a shape.
    pub fn begin_stroke(&mut self, operation: Operation) -> Result<(), Problem> {
        self.commit_stroke();
        self.prefix = None;
        let layer = self.check_operation(&operation)?;
        if operation.shape.is_some() {
            return Err(Problem::at(
                "shape",
                "a stroke has dabs instead of a shape",
                "add the operation as a whole",
            ));
        }
        let dabs_later = Operation {
            dabs: Vec::new(),
            ..operation
        };
        self.work = PaintWork::default();
        self.live = Some((layer, self.layers[layer].maps.begin(&self.index, dabs_later)));
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
        let channel = live.operation().channel;
        let dirty = check_dabs(&dabs).map(|()| self.layers[layer].maps.extend(&self.index, &mut live, dabs));
        self.work += live.take_work();
        self.live = Some((layer, live));
        dirty.map(|dirty| self.repainted(layer, channel, &dirty))
    }

    /// Ends the stroke under way: it becomes the newest history entry. One without dabs leaves no trace.
    pub fn commit_stroke(&mut self) {
        let Some((_, live)) = self.live.take() else { return };
        let (operation, before) = live.finish();
        if operation.dabs.is_empty() {
            return;
        }
        let label = operation.title();
        self.project.operations.push(operation);
        self.history.push(
            label,
            Step::Stroke {
                operation: None,
                before: Some(before),
            },
        );
        self.record_stroke();
    }

    /// Drops the stroke under way; returns the points whose values changed back.
    pub fn cancel_stroke(&mut self) -> DirtyRanges {
        let Some((layer, live)) = self.live.take() else {
            return DirtyRanges::none();
        };
        let (operation, mut before) = live.finish();
        let dirty = self.layers[layer].maps.swap(&self.index, &mut before);
        self.repainted(layer, operation.channel, &dirty)
    }

    /// A whole stroke as one entry.
    pub(super) fn apply_stroke(&mut self, mut operation: Operation) -> Result<DirtyRanges, Problem> {
        let dabs = std::mem::take(&mut operation.dabs);
        self.begin_stroke(operation)?;
        match self.extend_stroke(dabs) {
            Ok(points) => {
                self.commit_stroke();
                Ok(points)
            }
            Err(problem) => {
                self.cancel_stroke();
                Err(problem)
            }
        }
    }

    /// Puts the maps back that `before` holds, or replays the channel of the layer where they are no longer kept.
    pub(super) fn undo_stroke(&mut self, undone: &Operation, before: Option<TouchedMaps>) -> DirtyRanges {
        let Ok(layer) = self.layer_index(&undone.layer) else {
            return DirtyRanges::none();
        };
        let dirty = match before {
            Some(mut before) => self.layers[layer].maps.swap(&self.index, &mut before),
            None => {
                self.replay_channel(layer, undone.channel);
                DirtyRanges::all(self.groom().point_count())
            }
        };
        self.repainted(layer, undone.channel, &dirty)
    }

    /// Paints an undone stroke again; none where its layer is gone, which undo and redo in order never meet.
    pub(super) fn redo_stroke(&mut self, mut redone: Operation) -> Option<(DirtyRanges, TouchedMaps)> {
        let layer = self.layer_index(&redone.layer).ok()?;
        let dabs = std::mem::take(&mut redone.dabs);
        let mut live = self.layers[layer].maps.begin(&self.index, redone);
        let dirty = self.layers[layer].maps.extend(&self.index, &mut live, dabs);
        let (redone, touched) = live.finish();
        let points = self.repainted(layer, redone.channel, &dirty);
        self.project.operations.push(redone);
        Some((points, touched))
    }
}
