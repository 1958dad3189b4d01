//! Operations of the list: added, adjusted, hidden, removed. What depends on them is replayed, or taken from the history.

use balayage_render::param::Channel;

use super::{
    Document,
    history::{SavedMaps, Splice},
};
use crate::paint::{ChannelMaps, LayerMaps, Operation};

/// The maps of a layer's channel before one of its operations: an operation whose sliders are dragged is replayed from here.
pub(super) struct Prefix {
    /// The operation's place in the project's list.
    pub(super) index: usize,
    layer: String,
    channel: Channel,
    maps: ChannelMaps,
}

impl Document {
    /// Keeps what comes before the operation at `index`.
    pub(super) fn keep_prefix(&mut self, index: usize) {
        if self.prefix.as_ref().is_some_and(|prefix| prefix.index == index) {
            return;
        }
        let operation = &self.project.operations[index];
        let (layer, channel) = (operation.layer.clone(), operation.channel);
        let maps = self.replayed_channel(
            ChannelMaps::default(),
            &self.project.operations[..index],
            &layer,
            channel,
        );
        self.prefix = Some(Prefix {
            index,
            layer,
            channel,
            maps,
        });
    }

    /// `start` after those of `operations` that paint `channel` of `layer`.
    fn replayed_channel(
        &self,
        start: ChannelMaps,
        operations: &[Operation],
        layer: &str,
        channel: Channel,
    ) -> ChannelMaps {
        let mut maps = LayerMaps::default();
        maps.exchange(channel, start);
        let own = operations
            .iter()
            .filter(|operation| operation.layer == layer && operation.channel == channel);
        maps.replay_onto(&self.index, own);
        maps.exchange(channel, ChannelMaps::default())
    }

    /// Replays one channel of a layer from nothing.
    pub(super) fn replay_channel(&mut self, layer: usize, channel: Channel) {
        let settings = &self.project.layers[layer];
        let maps = self.replayed_channel(
            ChannelMaps::default(),
            &self.project.operations,
            &settings.id,
            channel,
        );
        self.layers[layer].exchange(&self.index, settings, channel, maps);
    }

    /// Exchanges operations with those of `splice`, and the maps that depend on them.
    pub(super) fn swap_operations(&mut self, splice: &mut Splice) {
        let other = std::mem::take(&mut splice.other);
        let inserted = splice.index..splice.index + other.len();
        let end = splice.index + splice.len;
        splice.other = self.project.operations.splice(splice.index..end, other).collect();
        splice.len = inserted.len();

        // Maps that are still kept go with the other operations; else each channel that is concerned is found anew.
        let mut saved = splice.maps.take().unwrap_or_else(|| {
            let mut concerned: Vec<(String, Channel)> = Vec::new();
            for operation in splice
                .other
                .iter()
                .chain(&self.project.operations[inserted.clone()])
            {
                let place = (operation.layer.clone(), operation.channel);
                if !concerned.contains(&place) {
                    concerned.push(place);
                }
            }
            let found = concerned.into_iter().map(|(layer, channel)| {
                let maps = self.maps_after(&inserted, splice.other.is_empty(), &layer, channel);
                SavedMaps { layer, channel, maps }
            });
            found.collect()
        });
        for saved in &mut saved {
            let Ok(layer) = self.layer_index(&saved.layer) else {
                continue;
            };
            let maps = std::mem::take(&mut saved.maps);
            let settings = &self.project.layers[layer];
            saved.maps = self.layers[layer].exchange(&self.index, settings, saved.channel, maps);
        }
        splice.maps = Some(saved);
    }

    /// The maps of a channel now that the operations in `inserted` are in the list, from the nearest state that is known.
    fn maps_after(
        &self,
        inserted: &std::ops::Range<usize>,
        only_added: bool,
        layer: &str,
        channel: Channel,
    ) -> ChannelMaps {
        let operations = &self.project.operations;
        if only_added && inserted.end == operations.len() {
            let now = self
                .layer_index(layer)
                .map(|layer| ChannelMaps::of(&self.layers[layer].maps, channel));
            let start = now.unwrap_or_default();
            return self.replayed_channel(start, &operations[inserted.start..], layer, channel);
        }
        let known = self.prefix.as_ref().filter(|prefix| {
            prefix.index == inserted.start && prefix.layer == layer && prefix.channel == channel
        });
        match known {
            Some(prefix) => {
                self.replayed_channel(prefix.maps.clone(), &operations[prefix.index..], layer, channel)
            }
            None => self.replayed_channel(ChannelMaps::default(), operations, layer, channel),
        }
    }
}
