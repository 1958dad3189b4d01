//! The short hair that a groom leaves out: it darkens the skin between the roots.

use rayon::prelude::*;

use super::{Groom, Mesh};

/// How far around a root the skin counts as grown over, in depths of the head's bounds (nose to back).
const REACH: f32 = 0.06;

/// Share of all roots that, within reach, grow over about two thirds of the skin; a scalp that bears all has a hundred times its area.
const FULL_SHARE: f32 = 0.8e-3;

/// Roots that are looked at; of more, evenly spaced ones stand for all.
const MAX_ROOTS: usize = 4096;

/// Share of the skin that is grown over at every vertex of `head`, 0 to 1; the groom is in the head's unit.
///
/// Samples have a few thousand strands where a head has a hundred thousand, and their scalp would shine through bald.
pub fn undergrowth(head: &Mesh, groom: &Groom) -> Vec<f32> {
    let (low, high) = head.bounds();
    let reach = REACH * (high.z - low.z);
    let step = groom.strand_count().div_ceil(MAX_ROOTS);
    let roots: Vec<_> = (0..groom.strand_count())
        .step_by(step)
        .map(|strand| groom.positions()[groom.strand(strand).start])
        .collect();
    let full = (FULL_SHARE * roots.len() as f32).max(1.0);
    head.positions()
        .par_iter()
        .map(|p| {
            let near = roots
                .iter()
                .filter(|root| root.distance_squared(*p) < reach * reach)
                .count();
            1.0 - (-(near as f32) / full).exp()
        })
        .collect()
}
