//! From base and layers to the values of a point: a pure function, the same for one point and for all.

use balayage_render::param::{Channel, PointValues};

use super::project::{Blend, Layer};
use crate::paint::{Affine, LayerMaps};

/// The values of `point` under `layers`, lowest first, clamped to each channel's range at the end.
pub(super) fn compose<'a>(
    base: &PointValues,
    layers: impl Iterator<Item = (&'a Layer, &'a LayerMaps)>,
    point: usize,
) -> PointValues {
    let mut values = *base;
    for (layer, maps) in layers.filter(|(layer, _)| layer.visible) {
        for (channel, maps) in maps.channels() {
            let width = channel.components();
            let mut value = values.get(channel);
            for (x, map) in value.iter_mut().zip(&maps[point * width..(point + 1) * width]) {
                *x = blended(*x, *map, layer);
            }
            values.set(channel, value);
        }
    }
    for channel in Channel::ALL {
        let (low, high) = channel.range().into_inner();
        values.set(channel, values.get(channel).map(|x| x.clamp(low, high)));
    }
    values
}

/// One component through one layer. Unpainted points pass bit for bit.
fn blended(below: f32, map: Affine, layer: &Layer) -> f32 {
    if map == Affine::IDENTITY {
        return below;
    }
    let o = layer.opacity;
    match layer.blend {
        Blend::Replace => (1.0 - o) * below + o * map.of(below),
        Blend::Add => below + o * map.of(0.0),
        Blend::Multiply => below * (1.0 - o + o * map.of(1.0)),
    }
}
