//! Where a layer shows: by place along the strand, by strand, by region of the scalp, by paint.

use glam::Vec3;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    Affine, DirtyRanges, StrandIndex,
    parameter::{self, Parameter},
    scalp::{Outline, StrandFacts},
};
use crate::problem::{Problem, within};

/// A layer's mask: the product of its parts and of what is painted on the layer's mask channel.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Mask {
    /// The parts; a list without a painted part has an open one.
    pub parts: Vec<MaskPart>,
    /// Shows where the product hides, and the other way round.
    pub invert: bool,
}

/// One condition of a mask.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MaskPart {
    /// The condition.
    #[serde(flatten)]
    pub kind: MaskKind,
    /// Shows where the condition does not hold.
    #[serde(default)]
    pub invert: bool,
}

/// What a part of a mask lets through.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MaskKind {
    /// A range of the root-to-tip coordinate.
    Arc {
        /// Begin, 0 at the root.
        from: f32,
        /// End, 1 at the tip.
        to: f32,
        /// Over what share of the strand each edge fades.
        soften: f32,
    },
    /// A range of distances from the root.
    Length {
        /// Begin, millimetres.
        from_mm: f32,
        /// End, millimetres.
        to_mm: f32,
        /// Over what length each edge fades, millimetres.
        soften_mm: f32,
    },
    /// Strands drawn at random.
    Strands {
        /// Their share.
        share: f32,
        /// Another seed draws others.
        #[serde(default)]
        seed: u64,
    },
    /// Strands rooted inside an outline on the scalp.
    Region {
        /// Corners of the outline, in the groom's unit.
        outline: Vec<[f32; 3]>,
        /// Over what distance the edge fades, millimetres.
        soften_mm: f32,
    },
    /// Strands rooted near one of some places.
    Roots {
        /// The places, in the groom's unit.
        places: Vec<[f32; 3]>,
        /// How near, millimetres.
        radius_mm: f32,
        /// Over what distance the edge fades, millimetres.
        soften_mm: f32,
    },
    /// What is painted on the layer's mask channel.
    Painted {
        /// Over what length along the strand it is evened out, millimetres.
        soften_mm: f32,
    },
}

/// Parts and places above these numbers are refused.
const MAX_PARTS: usize = 16;
const MAX_PLACES: usize = 1024;
/// Purpose of the lots of random strands.
const STRANDS: u32 = 10;

impl MaskKind {
    /// What a person calls it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Arc { .. } => "Along the strand",
            Self::Length { .. } => "Distance from root",
            Self::Strands { .. } => "Random strands",
            Self::Region { .. } => "Scalp region",
            Self::Roots { .. } => "Chosen roots",
            Self::Painted { .. } => "Painted",
        }
    }

    /// Its numbers.
    pub fn parameters(&mut self) -> Vec<Parameter<'_>> {
        let edge = |value| {
            Parameter::length(
                "soften_mm",
                "Soft edge",
                500.0,
                "Larger: no visible border",
                value,
            )
        };
        match self {
            Self::Arc { from, to, soften } => vec![
                Parameter::share("from", "From", "Where the layer begins: 0 root, 1 tip", from),
                Parameter::share("to", "To", "Where the layer ends: 0 root, 1 tip", to),
                Parameter::share("soften", "Soft edge", "Larger: no visible border", soften),
            ],
            Self::Length {
                from_mm,
                to_mm,
                soften_mm,
            } => vec![
                Parameter::length(
                    "from_mm",
                    "From",
                    5000.0,
                    "Where the layer begins, from the root",
                    from_mm,
                ),
                Parameter::length(
                    "to_mm",
                    "To",
                    5000.0,
                    "Where the layer ends, from the root",
                    to_mm,
                ),
                edge(soften_mm),
            ],
            Self::Strands { share, .. } => {
                vec![Parameter::share(
                    "share",
                    "Strands",
                    "Larger: more strands show the layer",
                    share,
                )]
            }
            Self::Region { soften_mm, .. } => vec![edge(soften_mm)],
            Self::Roots {
                radius_mm, soften_mm, ..
            } => vec![
                Parameter::length(
                    "radius_mm",
                    "Radius",
                    500.0,
                    "Larger: more hair around each place",
                    radius_mm,
                ),
                edge(soften_mm),
            ],
            Self::Painted { soften_mm } => vec![edge(soften_mm)],
        }
    }

    /// Checks every number.
    fn check(&self, place: &str) -> Result<(), Problem> {
        parameter::check(place, self.clone().parameters())?;
        let (field, places, fewest) = match self {
            Self::Region { outline, .. } => ("outline", outline, 3),
            Self::Roots { places, .. } => ("places", places, 1),
            _ => return Ok(()),
        };
        let place = format!("{place}.{field}");
        if !(fewest..=MAX_PLACES).contains(&places.len()) {
            let reason = format!("{} places", places.len());
            return Err(Problem::at(
                place,
                reason,
                format!("give {fewest} to {MAX_PLACES}"),
            ));
        }
        places
            .iter()
            .flatten()
            .try_for_each(|x| within(&place, *x, -1e6..=1e6))
    }
}

/// A condition made ready: what depends on no strand is done once.
enum Ready<'a> {
    /// A share by root-to-tip coordinate.
    Arc([f32; 3]),
    /// A share by millimetres from the root.
    Length([f32; 3]),
    Strands(f32, u64),
    Region(Option<Outline>, f32),
    Roots(&'a [[f32; 3]], f32, f32),
    Painted(f32),
}

/// Rises from 0 to 1 over `width` around zero; a step for width 0.
fn edge(x: f32, width: f32) -> f32 {
    if width <= 0.0 {
        return f32::from(u8::from(x >= 0.0));
    }
    let t = (x / width + 0.5).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// 1 between two places, falling over `soften` around each; a range that ends at its whole's end has no edge there.
fn between(x: f32, [from, to, soften]: [f32; 3]) -> f32 {
    let rise = if from <= 0.0 { 1.0 } else { edge(x - from, soften) };
    rise * edge(to - x, soften)
}

impl Mask {
    /// True where the mask lets everything through as long as nothing is painted.
    pub fn is_open(&self) -> bool {
        *self == Self::default()
    }

    /// Checks every number.
    ///
    /// # Errors
    /// Names the field below `place` and its range.
    pub fn check(&self, place: &str) -> Result<(), Problem> {
        if self.parts.len() > MAX_PARTS {
            let reason = format!("{} parts", self.parts.len());
            let remedy = format!("use at most {MAX_PARTS}");
            return Err(Problem::at(format!("{place}.parts"), reason, remedy));
        }
        self.parts
            .iter()
            .enumerate()
            .try_for_each(|(i, part)| part.kind.check(&format!("{place}.parts[{i}]")))
    }

    /// The share of the layer that shows at every point, in [0, 1]; `painted` are the maps of the layer's mask channel.
    /// None where all of it shows everywhere.
    pub fn weights(&self, index: &StrandIndex, painted: Option<&[Affine]>) -> Option<Vec<f32>> {
        if self.is_open() && painted.is_none() {
            return None;
        }
        let mut weights = vec![1.0; index.groom().point_count()];
        let whole = DirtyRanges::all(weights.len());
        self.update(index, painted, &whole, &mut weights);
        Some(weights)
    }

    /// Brings the weights of all strands that `dirty` touches up to date; returns their points.
    pub fn update(
        &self,
        index: &StrandIndex,
        painted: Option<&[Affine]>,
        dirty: &DirtyRanges,
        weights: &mut [f32],
    ) -> DirtyRanges {
        let mut parts: Vec<(Ready<'_>, bool)> = self
            .parts
            .iter()
            .map(|part| (part.kind.ready(index), part.invert))
            .collect();
        if !self
            .parts
            .iter()
            .any(|part| matches!(part.kind, MaskKind::Painted { .. }))
        {
            parts.push((Ready::Painted(0.0), false));
        }

        // Strands are worked on as a whole: softening looks along them.
        let mut strands: Vec<u32> = dirty.points().map(|point| index.strand_of(point)).collect();
        strands.dedup();
        let groom = index.groom();
        let new: Vec<Vec<f32>> = strands
            .par_iter()
            .with_min_len(64)
            .map(|strand| self.strand_weights(index, painted, &parts, *strand as usize))
            .collect();
        for (strand, new) in strands.iter().zip(&new) {
            weights[groom.strand(*strand as usize)].copy_from_slice(new);
        }
        let points = strands
            .iter()
            .flat_map(|strand| groom.strand(*strand as usize))
            .map(|point| point as u32);
        DirtyRanges::of_points(points.collect())
    }

    fn strand_weights(
        &self,
        index: &StrandIndex,
        painted: Option<&[Affine]>,
        parts: &[(Ready<'_>, bool)],
        strand: usize,
    ) -> Vec<f32> {
        let facts = index.facts(strand);
        let points = index.groom().strand(strand);
        let mut weights = vec![1.0; points.len()];
        for (part, invert) in parts {
            let whole = part.of_strand(&facts);
            for (weight, point) in weights.iter_mut().zip(points.clone()) {
                let share = whole.unwrap_or_else(|| part.of_point(index, painted, point as u32));
                *weight *= if *invert { 1.0 - share } else { share };
            }
        }
        if self.invert {
            weights.iter_mut().for_each(|weight| *weight = 1.0 - *weight);
        }
        weights
    }
}

impl MaskKind {
    fn ready(&self, index: &StrandIndex) -> Ready<'_> {
        let unit_mm = 1000.0 * index.groom().metres_per_unit();
        match self {
            Self::Arc { from, to, soften } => Ready::Arc([*from, *to, *soften]),
            Self::Length {
                from_mm,
                to_mm,
                soften_mm,
            } => Ready::Length([*from_mm, *to_mm, *soften_mm]),
            Self::Strands { share, seed } => Ready::Strands(*share, *seed),
            Self::Region { outline, soften_mm } => {
                let places: Vec<Vec3> = outline.iter().map(|p| unit_mm * Vec3::from(*p)).collect();
                Ready::Region(Outline::new(&places), *soften_mm)
            }
            Self::Roots {
                places,
                radius_mm,
                soften_mm,
            } => Ready::Roots(places, *radius_mm / unit_mm, *soften_mm / unit_mm),
            Self::Painted { soften_mm } => Ready::Painted(*soften_mm / unit_mm),
        }
    }
}

impl Ready<'_> {
    /// The share of a whole strand; none where it differs along it.
    fn of_strand(&self, strand: &StrandFacts) -> Option<f32> {
        match self {
            Self::Strands(share, seed) => Some(f32::from(u8::from(strand.lot(*seed, STRANDS) < *share))),
            Self::Region(outline, soften) => {
                let depth = outline.as_ref().map(|outline| outline.depth(strand.root_mm));
                Some(depth.map_or(0.0, |depth| edge(depth, *soften)))
            }
            Self::Roots(places, radius, soften) => {
                let nearest = places
                    .iter()
                    .map(|place| Vec3::from(*place).distance_squared(strand.root))
                    .fold(f32::INFINITY, f32::min);
                Some(edge(radius - nearest.sqrt(), *soften))
            }
            Self::Arc(_) | Self::Length(_) | Self::Painted(_) => None,
        }
    }

    /// The share at one point.
    fn of_point(&self, index: &StrandIndex, painted: Option<&[Affine]>, point: u32) -> f32 {
        match self {
            Self::Arc(range) => between(index.arc(point), *range),
            Self::Length(range) => between(index.along_mm(point), *range),
            Self::Painted(soften) => painted.map_or(1.0, |maps| {
                let stretch = if *soften > 0.0 {
                    index.stretch(point, 0.5 * *soften)
                } else {
                    point as usize..point as usize + 1
                };
                let sum: f32 = maps[stretch.clone()]
                    .iter()
                    .map(|map| map.of(1.0).clamp(0.0, 1.0))
                    .sum();
                sum / stretch.len() as f32
            }),
            Self::Strands(..) | Self::Region(..) | Self::Roots(..) => 1.0,
        }
    }
}
