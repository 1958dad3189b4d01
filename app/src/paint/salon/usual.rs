//! What the operations start with.

use super::{Balayage, Foils, Gradient, Grey, Parting, Regrowth, TipFade};
use crate::paint::Curve;

impl Default for Regrowth {
    /// Two months.
    fn default() -> Self {
        Self {
            length_mm: 25.0,
            soften_mm: 6.0,
            vary_mm: 4.0,
        }
    }
}

impl Default for Gradient {
    fn default() -> Self {
        Self {
            start_mm: 60.0,
            length_mm: 140.0,
            vary_mm: 10.0,
            curve: Curve::default(),
        }
    }
}

impl Default for Balayage {
    fn default() -> Self {
        Self {
            section_mm: 22.0,
            share: 0.45,
            start_mm: 50.0,
            length_mm: 110.0,
            v_mm: 40.0,
            vary_mm: 20.0,
            curve: Curve::default(),
        }
    }
}

impl Default for Foils {
    fn default() -> Self {
        Self {
            parting: Parting::SideToSide,
            spacing_mm: 18.0,
            slice_mm: 5.0,
            shift_mm: 0.0,
            weave: 0.7,
            start_mm: 8.0,
            soften_mm: 6.0,
        }
    }
}

impl Default for Grey {
    fn default() -> Self {
        Self {
            share: 0.2,
            grown_mm: 0.0,
            patches: 0.0,
            patch_mm: 30.0,
        }
    }
}

impl Default for TipFade {
    fn default() -> Self {
        Self {
            length_mm: 60.0,
            vary_mm: 10.0,
            curve: Curve::default(),
        }
    }
}
