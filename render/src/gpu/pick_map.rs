//! Which strand is seen where.

/// Which strand is seen at each pixel.
pub struct PickMap {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Depth bits and segment + 1, 0 where no strand is seen; row by row.
    pub(super) entries: Vec<[u32; 2]>,
}

/// A strand seen at a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// Depth along the camera's axis, groom units.
    pub depth: f32,
    /// Index of the refined strand's segment.
    pub segment: u32,
}

impl PickMap {
    /// The strand at pixel (x, y), row 0 on top.
    pub fn at(&self, x: u32, y: u32) -> Option<Pick> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let [depth, segment] = self.entries[(y * self.width + x) as usize];
        (segment > 0).then(|| Pick {
            depth: f32::from_bits(depth),
            segment: segment - 1,
        })
    }
}
