//! Hair, its light and its picture; no user interface.
//!
//! The frame in order:
//! 1. [`groom`]: strands from a file or the generator become a sound [`groom::Groom`]; [`groom::RefinedGroom`] is the smooth cubic
//!    through its points, dense enough for a five-degree highlight.
//! 2. [`param`]: painted channels per groom point become [`param::VertexParams`], what the shaders read.
//! 3. [`light`]: an environment map becomes a few SRBF lights.
//! 4. [`gpu`]: upload of what changed, fragments of every strand, marks on the vertices that a pixel shows; for those, as far as they are
//!    stale, transmittance and strand shading; then the fragments become colours, and the view is toned.
//!
//! Light that fibres scatter to each other is traced on the CPU ([`photon`]) and read off its cells where strands are shaded.
//!
//! [`optics`] is the float64 reference that the shaders are held against; it imports nothing of ours. [`trace`] traces the paths of
//! light that the frame approximates.

pub mod gpu;
pub mod groom;
pub mod image;
pub mod light;
pub mod optics;
pub mod param;
pub mod photon;
pub mod trace;
pub mod volume;
