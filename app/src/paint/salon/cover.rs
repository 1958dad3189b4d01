//! Where on a strand an operation acts, and how much.

use super::{Parting, Shape};
use crate::paint::{Curve, scalp::StrandFacts};

/// What lots are drawn for.
const VARY: u32 = 0;
const CHOOSE: u32 = 1;
const WEAVE: u32 = 2;

/// Coverage along one strand: a ramp between two places.
struct Ramp<'a> {
    /// Coverage where the ramp is full.
    share: f32,
    /// Distance from the root where it begins, millimetres.
    start: f32,
    /// Its length; zero is a step.
    length: f32,
    curve: Option<&'a Curve>,
    /// Full before the ramp instead of behind it.
    falls: bool,
}

impl Ramp<'_> {
    const FULL: Self = Self {
        share: 1.0,
        start: f32::NEG_INFINITY,
        length: 0.0,
        curve: None,
        falls: false,
    };

    fn at(&self, along_mm: f32) -> f32 {
        let from_start = along_mm - self.start;
        let x = if self.length > 0.0 {
            (from_start / self.length).clamp(0.0, 1.0)
        } else {
            f32::from(u8::from(from_start >= 0.0))
        };
        let y = self.curve.map_or(x * x * (3.0 - 2.0 * x), |curve| curve.at(x));
        self.share * if self.falls { 1.0 - y } else { y }
    }
}

impl Shape {
    /// Coverage in [0, 1] along a strand, by distance from its root in millimetres; none where the strand is left out.
    pub(in crate::paint) fn along(&self, strand: &StrandFacts, seed: u64) -> Option<impl Fn(f32) -> f32> {
        let ramp = self.ramp(strand, seed);
        (ramp.share > 0.0).then_some(move |along_mm| ramp.at(along_mm))
    }

    fn ramp(&self, strand: &StrandFacts, seed: u64) -> Ramp<'_> {
        let varied = |vary_mm: f32, lot: f32| vary_mm * (2.0 * lot - 1.0);
        let chosen = |yes: bool| f32::from(u8::from(yes));
        match self {
            Self::Fill(_) => Ramp::FULL,
            Self::Regrowth(p) => Ramp {
                start: p.length_mm + varied(p.vary_mm, strand.lot(seed, VARY)) - 0.5 * p.soften_mm,
                length: p.soften_mm,
                falls: true,
                ..Ramp::FULL
            },
            Self::Gradient(p) => Ramp {
                start: p.start_mm + varied(p.vary_mm, strand.lot(seed, VARY)),
                length: p.length_mm,
                curve: Some(&p.curve),
                ..Ramp::FULL
            },
            Self::Balayage(p) => {
                let section = strand.section(p.section_mm, seed);
                let start = p.start_mm + varied(p.vary_mm, section.lot(seed, VARY)) + p.v_mm * section.rim;
                Ramp {
                    share: chosen(section.lot(seed, CHOOSE) < p.share),
                    start,
                    length: p.length_mm,
                    curve: Some(&p.curve),
                    ..Ramp::FULL
                }
            }
            Self::Foils(p) => {
                let axis = match p.parting {
                    Parting::SideToSide => strand.root_mm.x,
                    Parting::TopToBottom => strand.root_mm.y,
                    Parting::FrontToBack => strand.root_mm.z,
                };
                let in_slice = (axis - p.shift_mm).rem_euclid(p.spacing_mm) < p.slice_mm;
                Ramp {
                    share: chosen(in_slice && strand.lot(seed, WEAVE) < p.weave),
                    start: p.start_mm - 0.5 * p.soften_mm,
                    length: p.soften_mm,
                    ..Ramp::FULL
                }
            }
            Self::Grey(p) => {
                let even = strand.lot(seed, CHOOSE);
                // Patches move the threshold up and down about the share, the mean stays.
                let patch = strand.section(p.patch_mm, seed).lot(seed, CHOOSE);
                let reach = p.patches * p.share.min(1.0 - p.share);
                Ramp {
                    share: chosen(even < p.share + reach * (2.0 * patch - 1.0)),
                    start: if p.grown_mm > 0.0 {
                        p.grown_mm
                    } else {
                        f32::INFINITY
                    },
                    falls: true,
                    ..Ramp::FULL
                }
            }
            Self::TipFade(p) => {
                let length = (p.length_mm + varied(p.vary_mm, strand.lot(seed, VARY))).max(0.0);
                Ramp {
                    start: strand.length_mm - length,
                    length,
                    curve: Some(&p.curve),
                    ..Ramp::FULL
                }
            }
        }
    }
}
