//! From base and layers to the values of a point: a pure function, the same for one point and for all.

use balayage_render::param::{Channel, LobeRatios, PointValues};

use super::project::{Blend, Layer};
use crate::paint::{Affine, ChannelMaps, DirtyRanges, LayerMaps, StrandIndex};

/// What a layer amounts to at every point.
#[derive(Default)]
pub(super) struct LayerState {
    /// What its operations do.
    pub(super) maps: LayerMaps,
    /// The share of it that shows, by its mask; none where all of it does.
    weights: Option<Vec<f32>>,
}

impl LayerState {
    pub(super) fn new(index: &StrandIndex, layer: &Layer, maps: LayerMaps) -> Self {
        let mut state = Self { maps, weights: None };
        state.refresh_mask(index, layer);
        state
    }

    /// Finds the mask anew.
    pub(super) fn refresh_mask(&mut self, index: &StrandIndex, layer: &Layer) {
        self.weights = layer.mask.weights(index, self.maps.channel(Channel::Mask));
    }

    /// Follows what was painted on the mask channel; returns the points whose weight may have changed.
    pub(super) fn update_mask(
        &mut self,
        index: &StrandIndex,
        layer: &Layer,
        dirty: &DirtyRanges,
    ) -> DirtyRanges {
        let painted = self.maps.channel(Channel::Mask);
        match &mut self.weights {
            Some(weights) => layer.mask.update(index, painted, dirty, weights),
            None => {
                self.weights = layer.mask.weights(index, painted);
                dirty.clone()
            }
        }
    }

    /// Puts other maps of a channel in place; the mask follows.
    pub(super) fn exchange(
        &mut self,
        index: &StrandIndex,
        layer: &Layer,
        channel: Channel,
        other: ChannelMaps,
    ) -> ChannelMaps {
        let old = self.maps.exchange(channel, other);
        if channel == Channel::Mask {
            self.refresh_mask(index, layer);
        }
        old
    }

    fn weight(&self, point: usize) -> f32 {
        self.weights.as_ref().map_or(1.0, |weights| weights[point])
    }
}

/// The values and lobe ratios of `point`: base values and ratios under `layers`, lowest first, clamped to each channel's range at the end.
pub(super) fn compose<'a>(
    base: &PointValues,
    ratios: &LobeRatios,
    layers: impl Iterator<Item = (&'a Layer, &'a LayerState)>,
    point: usize,
) -> (PointValues, LobeRatios) {
    let (mut values, mut ratios) = (*base, *ratios);
    for (layer, state) in layers.filter(|(layer, _)| layer.visible) {
        let share = layer.opacity * state.weight(point);
        for (channel, maps) in state.maps.channels() {
            let blend = layer.blend_of(channel);
            let width = channel.components();
            let mut value = values.get(channel);
            for (x, map) in value.iter_mut().zip(&maps[point * width..(point + 1) * width]) {
                *x = blended(*x, *map, blend, share);
            }
            values.set(channel, value);
        }
        if let Some(own) = &layer.ratios {
            ratios = ratios.towards(&own.known, share);
        }
    }
    for channel in Channel::ALL {
        let (low, high) = channel.range().into_inner();
        values.set(channel, values.get(channel).map(|x| x.clamp(low, high)));
    }
    (values, ratios)
}

/// One component through one layer of which `o` shows. Unpainted points pass bit for bit.
fn blended(below: f32, map: Affine, blend: Blend, o: f32) -> f32 {
    if map == Affine::IDENTITY || o == 0.0 {
        return below;
    }
    match blend {
        Blend::Replace => (1.0 - o) * below + o * map.of(below),
        Blend::Add => below + o * map.of(0.0),
        Blend::Multiply => below * (1.0 - o + o * map.of(1.0)),
    }
}
