//! What painting costs: work counted, time taken.

use std::{ops::AddAssign, time::Duration};

/// The cost of some dabs, from the brush to the parameters of the shaders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PaintWork {
    /// Points whose distance to a dab was found.
    pub measured: u64,
    /// Points whose maps were blended, once for each batch of dabs that covered them more.
    pub blended: u64,
    /// Points whose layers were composited.
    pub composed: u64,
    /// Points whose parameters changed.
    pub changed: u64,
    /// Time for finding what the dabs cover.
    pub query: Duration,
    /// Time for blending the layer's maps.
    pub blend: Duration,
    /// Time for compositing the layers.
    pub compose: Duration,
}

impl AddAssign for PaintWork {
    fn add_assign(&mut self, more: Self) {
        self.measured += more.measured;
        self.blended += more.blended;
        self.composed += more.composed;
        self.changed += more.changed;
        self.query += more.query;
        self.blend += more.blend;
        self.compose += more.compose;
    }
}
