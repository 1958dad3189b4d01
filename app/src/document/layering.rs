//! The list of layers: exchanged as a whole, duplicated, merged.

use super::{
    Changes, Document, check,
    compose::LayerState,
    history::Step,
    journal::Record,
    project::{Blend, Layer},
};
use balayage_render::param::Channel;

use crate::{
    Problem,
    paint::{Operation, OperationId},
};

/// Largest difference that merging may make, as a share of a channel's range.
const MERGE_TOLERANCE: f32 = 1e-4;

impl Document {
    /// Finds every layer anew from its operations.
    pub(super) fn rebuild_layers(&mut self) {
        self.layers = self
            .project
            .layers
            .iter()
            .map(|layer| LayerState::new(&self.index, layer, self.replayed(&layer.id)))
            .collect();
    }

    /// Exchanges the layer list; operations follow their layers out of the project and back.
    pub(super) fn swap_layers(&mut self, layers: &mut Vec<Layer>, detached: &mut Vec<(usize, Operation)>) {
        for (index, operation) in detached.drain(..) {
            self.project.operations.insert(index, operation);
        }
        let old_states: Vec<LayerState> = std::mem::take(&mut self.layers);
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

        // A layer that was there before keeps its maps, and its weights unless it has another mask.
        let mut old: Vec<(&Layer, LayerState)> = layers.iter().zip(old_states).collect();
        self.layers = self
            .project
            .layers
            .iter()
            .map(|layer| {
                let Some(i) = old.iter().position(|(other, _)| other.id == layer.id) else {
                    return LayerState::new(&self.index, layer, self.replayed(&layer.id));
                };
                let (before, mut state) = old.swap_remove(i);
                if before.mask != layer.mask {
                    state.refresh_mask(&self.index, layer);
                }
                state
            })
            .collect();
    }

    /// The step to a list with a copy of layer `id` and of its operations.
    pub(super) fn duplicate_step(&self, id: &str, new_id: &str) -> Result<(String, Step), Problem> {
        let position = self.layer_index(id)?;
        let original = &self.project.layers[position];
        let mut layers = self.project.layers.clone();
        let copy = Layer {
            id: new_id.to_owned(),
            name: format!("{} copy", original.name),
            ..original.clone()
        };
        layers.insert(position + 1, copy);
        check::check_layers(&layers)?;
        let (end, number) = (self.project.operations.len(), self.next_operation_number());
        let detached = self.operations_of(id).enumerate().map(|(i, operation)| {
            let copy = Operation {
                id: OperationId::Number(number.saturating_add(i as u64)),
                layer: new_id.to_owned(),
                ..operation.clone()
            };
            (end + i, copy)
        });
        let step = Step::Layers {
            detached: detached.collect(),
            layers,
        };
        Ok((format!("Duplicate layer {}", original.name), step))
    }

    /// Gives the operations of layer `id` to the layer below it, where that leaves the picture as it is.
    pub(super) fn merge_down(&mut self, id: &str) -> Result<Changes, Problem> {
        let position = self.layer_index(id)?;
        let refused = |reason: String, remedy: &str| Err(Problem::at("layer", reason, remedy));
        let Some(below) = position.checked_sub(1).map(|i| &self.project.layers[i]) else {
            return refused("there is no layer below".to_owned(), "merge a layer above it");
        };
        let upper = &self.project.layers[position];
        for layer in [upper, below] {
            let masked =
                !layer.mask.is_open() || self.operations_of(&layer.id).any(|o| o.channel == Channel::Mask);
            let blends = layer.channel_blends.values().chain([&layer.blend]);
            let blended = blends.into_iter().any(|blend| *blend != Blend::Replace);
            if blended || masked || !layer.visible || layer.ratios.is_some() {
                let reason = format!(
                    "layer {} is hidden, masked, blended or has lobe ratios of its own",
                    layer.name
                );
                return refused(
                    reason,
                    "merge layers that are visible, unmasked and of blend replace",
                );
            }
        }
        if below.opacity != 1.0 {
            return refused(
                format!("layer {} has an opacity below 1", below.name),
                "set it to 1 first",
            );
        }

        // The upper layer's operations follow all others; its opacity becomes theirs.
        let (target, opacity) = (below.id.clone(), upper.opacity);
        let label = format!("Merge layer {} down", upper.name);
        let (own, mut operations): (Vec<Operation>, Vec<Operation>) = self
            .project
            .operations
            .iter()
            .cloned()
            .partition(|operation| operation.layer == id);
        operations.extend(own.into_iter().map(|operation| Operation {
            layer: target.clone(),
            strength: operation.strength * opacity,
            ..operation
        }));
        let mut layers = self.project.layers.clone();
        layers.remove(position);
        let before = self.values.clone();
        let mut step = Step::Paint { layers, operations };
        let changes = self.swap(&mut step);
        let same = before.iter().zip(&self.values).all(|(a, b)| {
            Channel::ALL.into_iter().all(|channel| {
                let (low, high) = channel.range().into_inner();
                let (a, b) = (a.get(channel), b.get(channel));
                (0..3).all(|c| (a[c] - b[c]).abs() <= MERGE_TOLERANCE * (high - low))
            })
        });
        if same {
            self.record_step(&step, Vec::new(), Record::Patch);
            self.history.push(label, step);
            return Ok(changes);
        }
        self.swap(&mut step);
        refused(
            "as one layer the two would look different".to_owned(),
            "keep them apart, or set the opacity to 1 first",
        )
    }
}
