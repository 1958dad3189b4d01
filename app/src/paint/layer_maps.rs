//! What the strokes of one layer amount to: an affine map per point and component of every painted channel.

use std::{collections::BTreeMap, time::Instant};

use balayage_render::param::Channel;
use rayon::prelude::*;

use glam::Vec3;

use super::{
    Affine, Coverage, Dab, DirtyRanges, Mode, Operation, PaintWork, StrandIndex, coverage::of_operation,
};

/// The maps of one layer; a channel that was never painted takes no memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayerMaps {
    /// `point_count * channel.components()` maps a channel, point after point.
    channels: BTreeMap<Channel, Vec<Affine>>,
}

/// All maps of one channel of a layer, or that it has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChannelMaps(Option<Vec<Affine>>);

impl ChannelMaps {
    /// A copy of what `maps` holds of `channel`.
    pub fn of(maps: &LayerMaps, channel: Channel) -> Self {
        Self(maps.channels.get(&channel).cloned())
    }

    /// Memory in bytes.
    pub fn bytes(&self) -> usize {
        self.0.as_ref().map_or(0, |maps| size_of_val(maps.as_slice()))
    }
}

/// The maps that some points had before a stroke.
#[derive(Clone, Debug, PartialEq)]
pub struct TouchedMaps {
    channel: Channel,
    points: Vec<u32>,
    maps: Vec<Affine>,
}

impl TouchedMaps {
    /// Memory in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.points.as_slice()) + size_of_val(self.maps.as_slice())
    }
}

/// A stroke while the pointer is down: its operation so far and what it covers.
pub struct LiveStroke {
    operation: Operation,
    coverage: Coverage,
    before: TouchedMaps,
    /// Index into `before.points` of every point, `u32::MAX` where it is untouched.
    slot_of: Vec<u32>,
    work: PaintWork,
}

impl LayerMaps {
    /// Replays the operations of one layer from nothing.
    pub fn replay<'a>(index: &StrandIndex, operations: impl IntoIterator<Item = &'a Operation>) -> Self {
        let mut maps = Self::default();
        maps.replay_onto(index, operations);
        maps
    }

    /// Applies operations in order. The coverages are independent and found in parallel, the maps are composed in order.
    pub fn replay_onto<'a>(
        &mut self,
        index: &StrandIndex,
        operations: impl IntoIterator<Item = &'a Operation>,
    ) {
        // Batches bound the memory of coverages that wait for their turn.
        const BATCH: usize = 64;
        let point_count = index.groom().point_count();
        let operations: Vec<&Operation> = operations.into_iter().collect();
        for batch in operations.chunks(BATCH) {
            let covered: Vec<Vec<(u32, f32)>> = batch
                .par_iter()
                .map_init(
                    || Coverage::new(point_count),
                    |scratch, operation| of_operation(index, operation, scratch),
                )
                .collect();
            for (operation, covered) in batch.iter().zip(covered) {
                self.stroke(index, operation, &covered);
            }
        }
    }

    /// The maps of one channel, `components` a point; none where it was never painted.
    pub fn channel(&self, channel: Channel) -> Option<&[Affine]> {
        self.channels.get(&channel).map(Vec::as_slice)
    }

    /// Takes the maps of one channel out and puts others in.
    pub fn exchange(&mut self, channel: Channel, other: ChannelMaps) -> ChannelMaps {
        let old = match other.0 {
            Some(maps) => self.channels.insert(channel, maps),
            None => self.channels.remove(&channel),
        };
        ChannelMaps(old)
    }

    /// The painted channels with their maps: `point_count * components` each.
    pub fn channels(&self) -> impl Iterator<Item = (Channel, &[Affine])> {
        self.channels
            .iter()
            .map(|(channel, maps)| (*channel, maps.as_slice()))
    }

    /// Starts a stroke; the dabs that `operation` already has are left to [`LayerMaps::extend`].
    pub fn begin(&self, index: &StrandIndex, operation: Operation) -> LiveStroke {
        let point_count = index.groom().point_count();
        LiveStroke {
            before: TouchedMaps {
                channel: operation.channel,
                points: Vec::new(),
                maps: Vec::new(),
            },
            operation,
            coverage: Coverage::new(point_count),
            slot_of: vec![u32::MAX; point_count],
            work: PaintWork::default(),
        }
    }

    /// Adds dabs to a stroke; returns the points whose maps changed.
    pub fn extend(&mut self, index: &StrandIndex, stroke: &mut LiveStroke, dabs: Vec<Dab>) -> DirtyRanges {
        let channel = stroke.operation.channel;
        let start = Instant::now();
        let measured = stroke.coverage.measured();
        let raised = stroke.coverage.add_dabs(index, &stroke.operation, &dabs);
        stroke.operation.dabs.extend(dabs);
        stroke.work.measured += stroke.coverage.measured() - measured;
        stroke.work.blended += raised.len() as u64;
        let found = Instant::now();
        stroke.work.query += found - start;

        // Every point is blended from its map before the stroke, which is kept when the stroke first touches it.
        let maps = self.maps_mut(index, channel);
        let width = channel.components();
        for point in &raised {
            let slot = &mut stroke.slot_of[*point as usize];
            if *slot == u32::MAX {
                *slot = stroke.before.points.len() as u32;
                stroke.before.points.push(*point);
                stroke
                    .before
                    .maps
                    .extend_from_slice(maps_of(maps, *point as usize, width));
            }
        }
        let LiveStroke {
            operation,
            coverage,
            before,
            slot_of,
            ..
        } = &*stroke;
        let blended: Vec<[Affine; 3]> = raised
            .iter()
            .map(|point| {
                blend(index, operation, *point, coverage.of(*point), |p| {
                    match slot_of[p] {
                        u32::MAX => maps_of(maps, p, width),
                        slot => maps_of(&before.maps, slot as usize, width),
                    }
                })
            })
            .collect();
        for (point, new) in raised.iter().zip(&blended) {
            maps_of_mut(maps, *point as usize, width).copy_from_slice(&new[..width]);
        }
        stroke.work.blend += found.elapsed();
        DirtyRanges::of_points(raised)
    }

    /// Puts back the maps of `touched` and returns what stood there; a second call undoes the first.
    pub fn swap(&mut self, index: &StrandIndex, touched: &mut TouchedMaps) -> DirtyRanges {
        let width = touched.channel.components();
        let maps = self.maps_mut(index, touched.channel);
        for (slot, point) in touched.points.iter().enumerate() {
            maps_of_mut(maps, *point as usize, width).swap_with_slice(maps_of_mut(
                &mut touched.maps,
                slot,
                width,
            ));
        }
        DirtyRanges::of_points(touched.points.clone())
    }

    /// Applies a whole stroke to the points it covers.
    fn stroke(&mut self, index: &StrandIndex, operation: &Operation, covered: &[(u32, f32)]) {
        let width = operation.channel.components();
        let maps = self.maps_mut(index, operation.channel);
        let blended: Vec<[Affine; 3]> = covered
            .iter()
            .map(|(point, c)| blend(index, operation, *point, *c, |p| maps_of(maps, p, width)))
            .collect();
        for ((point, _), new) in covered.iter().zip(&blended) {
            maps_of_mut(maps, *point as usize, width).copy_from_slice(&new[..width]);
        }
    }

    fn maps_mut(&mut self, index: &StrandIndex, channel: Channel) -> &mut Vec<Affine> {
        self.channels
            .entry(channel)
            .or_insert_with(|| vec![Affine::IDENTITY; index.groom().point_count() * channel.components()])
    }
}

impl LiveStroke {
    /// The operation with all dabs so far, and the maps that its points had before it.
    pub fn finish(self) -> (Operation, TouchedMaps) {
        (self.operation, self.before)
    }

    /// What the dabs cost since the last call.
    pub fn take_work(&mut self) -> PaintWork {
        std::mem::take(&mut self.work)
    }

    /// The operation with all dabs so far.
    pub fn operation(&self) -> &Operation {
        &self.operation
    }
}

fn maps_of(maps: &[Affine], point: usize, width: usize) -> &[Affine] {
    &maps[point * width..(point + 1) * width]
}

fn maps_of_mut(maps: &mut [Affine], point: usize, width: usize) -> &mut [Affine] {
    &mut maps[point * width..(point + 1) * width]
}

/// Reach of mode smooth across strands, in cells of the index.
const NEIGHBOURS: f32 = 1.5;

/// Mean of the maps of some points.
#[derive(Default)]
struct Mean {
    sum: [[f32; 2]; 3],
    count: usize,
}

impl Mean {
    fn add(&mut self, maps: &[Affine]) {
        for (sum, map) in self.sum.iter_mut().zip(maps) {
            sum[0] += map.scale;
            sum[1] += map.offset;
        }
        self.count += 1;
    }

    fn over<'a>(
        mut self,
        points: std::ops::Range<usize>,
        width: usize,
        maps: impl Fn(usize) -> &'a [Affine],
    ) -> Self {
        points.for_each(|point| self.add(&maps(point)[..width]));
        self
    }

    fn maps(self) -> [Affine; 3] {
        let weight = 1.0 / self.count.max(1) as f32;
        self.sum.map(|[scale, offset]| Affine {
            scale: scale * weight,
            offset: offset * weight,
        })
    }
}

/// The maps of `point` after a stroke that covers it by `coverage`; `before` gives any point's maps before the stroke.
fn blend<'a>(
    index: &StrandIndex,
    operation: &Operation,
    point: u32,
    coverage: f32,
    before: impl Fn(usize) -> &'a [Affine],
) -> [Affine; 3] {
    let width = operation.channel.components();
    let mut smoothed = [Affine::IDENTITY; 3];
    if operation.mode == Mode::Smooth {
        let radius = operation.radius_m / index.groom().metres_per_unit();
        let along = Mean::default()
            .over(index.stretch(point, radius), width, &before)
            .maps();
        smoothed = along;
        if operation.across > 0.0 {
            let mut around = Mean::default();
            let place: Vec3 = index.groom().positions()[point as usize];
            index.for_each_near(place, radius.min(NEIGHBOURS * index.spacing()), |p, _| {
                around.add(before(p as usize));
            });
            let around = around.maps();
            for c in 0..width {
                smoothed[c] = along[c].towards(around[c], operation.across);
            }
        }
    }
    let value = operation.value.components();
    let old = before(point as usize);
    let mut new = [Affine::IDENTITY; 3];
    for c in 0..width {
        new[c] = old[c].stroked(operation.mode, value[c], coverage, smoothed[c], operation.channel);
    }
    new
}
