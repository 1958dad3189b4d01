//! Painted primvars in: which channels a prim has, their values anywhere on its curves, and what is said about the others.

use std::collections::BTreeMap;

use super::basis::Shape;
use super::layer::Prim;
use super::primvar::{Place, Primvar};
use super::write::{ALPHA_RATIOS, BETA_RATIOS, PIGMENTS, SIGMA_A, primvar};
use crate::param::{Channel, LobeRatios, PigmentSet, PointValues};

/// Different remarks that are kept; more of them say nothing new.
const MAX_REMARKS: usize = 16;

/// Remarks on prims, each said once with the first prim that it is about and the number of others.
#[derive(Default)]
pub(super) struct Remarks(BTreeMap<String, (String, usize)>);

impl Remarks {
    /// `what` holds for the prim at `path`.
    pub fn add(&mut self, path: &str, what: String) {
        let full = self.0.len() >= MAX_REMARKS;
        if !full || self.0.contains_key(&what) {
            self.0.entry(what).or_insert_with(|| (path.to_owned(), 0)).1 += 1;
        }
    }

    /// One sentence each.
    pub fn sentences(self) -> impl Iterator<Item = String> {
        self.0.into_iter().map(|(what, (path, count))| match count {
            1 => format!("{path}: {what}"),
            _ => format!("{path} and {} other prims: {what}", count - 1),
        })
    }
}

/// The painted primvars of a prim that can be used.
pub(super) struct Paint<'a> {
    channels: Vec<(Channel, Primvar<'a>)>,
    /// Absorption that stands for all that makes it, where no channel does.
    sigma_a: Option<Primvar<'a>>,
    ratios: [Option<Primvar<'a>>; 2],
    /// The pigments that the prim names.
    pub pigments: Option<PigmentSet>,
}

/// The channels that absorption is made of.
const ABSORPTION: [Channel; 4] = [
    Channel::Eumelanin,
    Channel::Pheomelanin,
    Channel::Bleach,
    Channel::Dye,
];

impl<'a> Paint<'a> {
    /// The paint of the prim at `path`; none where it has no painted primvar that can be used. What is not used is remarked.
    pub fn of(
        prim: &'a Prim,
        path: &str,
        time: Option<f64>,
        shapes: &[Shape],
        remarks: &mut Remarks,
    ) -> Option<Self> {
        let mut usable = |name: &str, components: usize, low: f64, high: f64| {
            let found = Primvar::of(prim, name, components, time, shapes).and_then(|found| {
                let numbers = found.as_ref().map_or(&[][..], Primvar::numbers);
                match numbers.iter().find(|x| !(low..=high).contains(*x)) {
                    Some(x) => Err(format!("{x} is outside {low} to {high}")),
                    None => Ok(found),
                }
            });
            found.unwrap_or_else(|reason| {
                remarks.add(path, format!("{name} is not used: {reason}"));
                None
            })
        };
        let channels: Vec<_> = Channel::ALL
            .into_iter()
            .filter_map(|channel| {
                let (low, high) = channel.range().into_inner();
                let name = primvar(channel);
                let found = usable(&name, channel.components(), low.into(), high.into());
                Some((channel, found?))
            })
            .collect();
        let ratios = [
            usable(ALPHA_RATIOS, 2, -100.0, 100.0),
            usable(BETA_RATIOS, 2, 0.01, 100.0),
        ];

        // Absorption alone is a dye on hair without melanin.
        let has = |channel: &Channel| channels.iter().any(|(present, _)| present == channel);
        let (_, most) = Channel::Dye.range().into_inner();
        let sigma_a = if ABSORPTION.iter().any(has) {
            None
        } else {
            usable(SIGMA_A, 3, 0.0, most.into())
        };
        if channels.is_empty() && sigma_a.is_none() {
            return None;
        }
        let usual = PointValues::default();
        for channel in Channel::ALL.iter().filter(|channel| !has(channel)) {
            let name = primvar(*channel);
            if sigma_a.is_some() && ABSORPTION.contains(channel) {
                continue;
            }
            let [x, y, z] = usual.get(*channel);
            let value = match channel.components() {
                3 => format!("{x}, {y}, {z}"),
                _ => x.to_string(),
            };
            remarks.add(path, format!("{name} is missing; {value} stands for it"));
        }
        for (name, _) in [ALPHA_RATIOS, BETA_RATIOS]
            .into_iter()
            .zip(&ratios)
            .filter(|(_, found)| found.is_none())
        {
            remarks.add(path, format!("{name} is missing; the usual ratios stand for it"));
        }
        if sigma_a.is_some() {
            let what =
                format!("{SIGMA_A} is taken as a dye on hair without melanin, whose channels are missing");
            remarks.add(path, what);
        }
        Some(Self {
            channels,
            sigma_a,
            ratios,
            pigments: prim.text(PIGMENTS).and_then(PigmentSet::from_name),
        })
    }

    /// The values at a place; what is missing has its usual value. Curves may overshoot their control values: ranges hold all the same.
    pub fn at(&self, place: &Place) -> (PointValues, LobeRatios) {
        let mut values = PointValues::default();
        if let Some(sigma_a) = &self.sigma_a {
            let (low, high) = Channel::Dye.range().into_inner();
            values.dye = sigma_a.at(place).map(|x: f64| (x as f32).clamp(low, high));
            (values.eumelanin, values.pheomelanin) = (0.0, 0.0);
        }
        for (channel, primvar) in &self.channels {
            let (low, high) = channel.range().into_inner();
            let value = match channel.components() {
                3 => primvar.at::<3>(place),
                _ => [primvar.at::<1>(place)[0], 0.0, 0.0],
            };
            values.set(*channel, value.map(|x| (x as f32).clamp(low, high)));
        }
        let mut ratios = LobeRatios::default();
        let [alpha, beta] = self.ratios.each_ref().map(|ratios| {
            ratios
                .as_ref()
                .map(|primvar| primvar.at::<2>(place).map(|x| x as f32))
        });
        if let Some([tt, trt]) = alpha {
            (ratios.alpha_tt, ratios.alpha_trt) = (tt.clamp(-100.0, 100.0), trt.clamp(-100.0, 100.0));
        }
        if let Some([tt, trt]) = beta {
            (ratios.beta_tt, ratios.beta_trt) = (tt.clamp(0.01, 100.0), trt.clamp(0.01, 100.0));
        }
        (values, ratios)
    }
}
