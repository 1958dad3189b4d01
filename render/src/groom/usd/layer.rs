//! What both readers make of a USD file: one layer's prims and attributes, not composed.

use std::collections::BTreeMap;

/// Prims nested deeper than this are refused.
pub(in crate::groom) const MAX_DEPTH: usize = 128;

/// One layer. Parents stand before their children.
#[derive(Debug, Default)]
pub(in crate::groom) struct Layer {
    /// `metersPerUnit`, where the layer states it.
    pub metres_per_unit: Option<f64>,
    /// True where `upAxis` is Z.
    pub z_up: bool,
    /// Depth first.
    pub prims: Vec<Prim>,
    /// References, payloads, sublayers and variants: named in the report, not followed.
    pub not_followed: usize,
    /// More for the report.
    pub notes: Vec<String>,
}

/// A prim.
#[derive(Debug, Default)]
pub(in crate::groom) struct Prim {
    /// Index of the parent.
    pub parent: Option<usize>,
    /// Name in its parent.
    pub name: String,
    /// Schema; empty for none.
    pub type_name: String,
    /// False for `over`, `class` and `active = false`.
    pub visible: bool,
    /// By name.
    pub attributes: BTreeMap<String, Attribute>,
}

/// An attribute.
#[derive(Clone, Debug, Default)]
pub(in crate::groom) struct Attribute {
    /// Value without a time.
    pub default: Option<Value>,
    /// Values by time.
    pub samples: Vec<(f64, Value)>,
    /// `interpolation` of a primvar or of widths.
    pub interpolation: Option<String>,
}

/// A value, flattened: tuples and arrays are told apart by who reads them.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::groom) enum Value {
    /// Numbers; quaternions are w, x, y, z.
    Numbers(Vec<f64>),
    /// Tokens and strings.
    Texts(Vec<String>),
    /// `None`, or a type that curves do not need.
    Nothing,
}

impl Attribute {
    /// The value at `time`: the last sample at or before it, else the first; without a time the default, else the first sample.
    pub fn at(&self, time: Option<f64>) -> Option<&Value> {
        let held = |time: f64| {
            let before = self.samples.iter().filter(|(t, _)| *t <= time);
            let last = before.max_by(|a, b| a.0.total_cmp(&b.0));
            last.or_else(|| self.samples.iter().min_by(|a, b| a.0.total_cmp(&b.0)))
        };
        match time {
            Some(time) => held(time).map(|(_, value)| value).or(self.default.as_ref()),
            None => self
                .default
                .as_ref()
                .or_else(|| held(f64::NEG_INFINITY).map(|(_, value)| value)),
        }
    }
}

impl Prim {
    /// The numbers of an attribute.
    pub fn numbers(&self, name: &str, time: Option<f64>) -> Option<&[f64]> {
        match self.attributes.get(name)?.at(time)? {
            Value::Numbers(numbers) => Some(numbers),
            _ => None,
        }
    }

    /// The first text of an attribute.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.texts(name)?.first().map(String::as_str)
    }

    /// The texts of an attribute.
    pub fn texts(&self, name: &str) -> Option<&[String]> {
        match self.attributes.get(name)?.at(None)? {
            Value::Texts(texts) => Some(texts),
            _ => None,
        }
    }
}

impl Layer {
    /// Path of a prim.
    pub fn path(&self, prim: usize) -> String {
        let mut path = String::new();
        let mut at = Some(prim);
        while let Some(index) = at {
            path = format!("/{}{path}", self.prims[index].name);
            at = self.prims[index].parent;
        }
        path
    }
}

/// True for the attributes that curves and their transforms are made of; all others are skipped unread.
pub(super) fn is_needed(name: &str) -> bool {
    matches!(
        name,
        "points"
            | "curveVertexCounts"
            | "widths"
            | "type"
            | "basis"
            | "wrap"
            | "xformOpOrder"
            | "balayage:pigments"
    ) || name.starts_with("xformOp:")
        || name.starts_with("primvars:balayage:")
        || name == "primvars:widths"
}
