//! What the pointer does: looking around, picking strands, brushing. No widget and no document lives here.

mod brush;
mod colour;
mod navigation;
mod pick;

pub use brush::{Brush, NATURAL_LEVELS, NaturalLevel, StrokePath, Tool, mirrored};
pub use colour::{DyeMatch, HairColour};
pub use navigation::ViewCamera;
pub use pick::{PickFrame, dab_at, dabs_through, place_on_strands};
