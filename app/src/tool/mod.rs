//! What the pointer does: looking around, picking strands, brushing. No widget and no document lives here.

mod brush;
mod navigation;
mod pick;

pub use brush::{Brush, BrushColor, NATURAL_LEVELS, NaturalLevel, StrokePath, Tool};
pub use navigation::ViewCamera;
pub use pick::{PickFrame, dab_at, dabs_through};
