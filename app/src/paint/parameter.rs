//! Numbers of operations and masks as a person adjusts them: one table for the sliders and for the check of files.

use std::ops::RangeInclusive;

use crate::problem::{Problem, within};

/// One adjustable number.
pub struct Parameter<'a> {
    /// Its field in JSON.
    pub field: &'static str,
    /// What a person calls it.
    pub name: &'static str,
    /// Its unit, with the space before it; empty for shares.
    pub unit: &'static str,
    /// What more of it looks like.
    pub hint: &'static str,
    /// What it may be.
    pub range: RangeInclusive<f32>,
    /// The number.
    pub value: &'a mut f32,
}

impl<'a> Parameter<'a> {
    /// A length from 0 to `longest`, millimetres.
    pub(super) fn length(
        field: &'static str,
        name: &'static str,
        longest: f32,
        hint: &'static str,
        value: &'a mut f32,
    ) -> Self {
        Self {
            field,
            name,
            unit: " mm",
            hint,
            range: 0.0..=longest,
            value,
        }
    }

    /// A share from 0 to 1.
    pub(super) fn share(
        field: &'static str,
        name: &'static str,
        hint: &'static str,
        value: &'a mut f32,
    ) -> Self {
        Self {
            field,
            name,
            unit: "",
            hint,
            range: 0.0..=1.0,
            value,
        }
    }
}

/// Checks every number of a table; the problem's place is `prefix.field`.
pub(super) fn check(prefix: &str, parameters: Vec<Parameter<'_>>) -> Result<(), Problem> {
    parameters
        .into_iter()
        .try_for_each(|p| within(&format!("{prefix}.{}", p.field), *p.value, p.range))
}
