//! What light does in a frame.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::gpu::{Method, VisibilitySource};

/// How light that has crossed other fibres is added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Multiple {
    /// S + light traced from the lights from fibre to fibre ([`crate::photon`]): D has not turned back so far, U has.
    #[default]
    Traced,
    /// S + D + U, where U is what two streams say has turned round; scattered light diffuses over the inclinations.
    M3,
    /// S + 1.1 D + 0.2 L + 0.25 U.
    M2,
    /// Zinke 2008 as printed, d_f = d_b = 0.7.
    Zinke2008,
    /// Single scattering only.
    Off,
}

/// Terms of the picture, each can be seen alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Terms(pub u32);

impl Terms {
    /// Single scattering: R, TT and TRT with shadows.
    pub const SINGLE: Self = Self(1 | 2 | 4);
    /// Multiple scattering: D, L and U.
    pub const MULTIPLE: Self = Self(8 | 16 | 32);
    /// Light scattered forward on its way.
    pub const D: Self = Self(8);
    /// Light that was turned back.
    pub const U: Self = Self(32);
    /// Everything.
    pub const ALL: Self = Self(63);
    /// Names of the single terms, bit 0 first.
    pub const NAMES: [&'static str; 6] = ["R", "TT", "TRT", "D", "L", "U"];
}

impl Terms {
    /// Whether any of `terms` is among them.
    pub fn has(self, terms: Self) -> bool {
        self.0 & terms.0 != 0
    }
}

impl FromStr for Terms {
    type Err = String;

    /// `single`, `multiple`, `all`, names of terms, or several of them joined by commas: `R,TRT,D`.
    fn from_str(text: &str) -> Result<Self, String> {
        text.split(',').try_fold(Self(0), |terms, word| {
            let one = match word.trim().to_ascii_lowercase().as_str() {
                "single" => Self::SINGLE.0,
                "multiple" => Self::MULTIPLE.0,
                "all" => Self::ALL.0,
                name => Self::NAMES
                    .iter()
                    .position(|n| n.eq_ignore_ascii_case(name))
                    .map(|bit| 1 << bit)
                    .ok_or_else(|| format!("no term is called {word:?}; write single, multiple, all, or some of R,TT,TRT,D,L,U"))?,
            };
            Ok(Self(terms.0 | one))
        })
    }
}

/// What light does in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShadeSettings {
    /// Model, scheme and quality of single scattering.
    pub method: Method,
    /// Multiple scattering.
    pub multiple: Multiple,
    /// Terms that are added up.
    pub terms: Terms,
    /// Where shadows come from.
    pub visibility: VisibilitySource,
}

impl Default for ShadeSettings {
    fn default() -> Self {
        Self {
            method: Method::default(),
            multiple: Multiple::Traced,
            terms: Terms::ALL,
            visibility: VisibilitySource::Voxel,
        }
    }
}

impl ShadeSettings {
    /// Whether light that other fibres have scattered is added.
    pub fn scatters_often(&self) -> bool {
        self.multiple != Multiple::Off
            && self.method.model.scatters_often()
            && self.terms.has(Terms::MULTIPLE)
    }

    /// Whether that light is read off a light field.
    pub(in crate::gpu) fn is_traced(&self) -> bool {
        self.multiple == Multiple::Traced && self.scatters_often()
    }

    /// Whether it is made from the sums along the ways from the lights.
    pub(in crate::gpu) fn sums_ways(&self) -> bool {
        self.multiple != Multiple::Traced && self.scatters_often()
    }
}
