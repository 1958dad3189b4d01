//! Light that fibres have scattered, traced from the lights on and kept in cells of the hair: what multiple scattering is read off.
//!
//! Photons come along lines of a light through the box around the hair, are scattered where they meet a fibre as [`crate::optics`] says and
//! fly to the next one, until they leave the hair or are absorbed. Where one meets a fibre that is not its first, the cell there notes power
//! and direction: a [`LightField`] is the radiance in every cell, averaged over parts of the sphere of directions. (Moon, Walter and Marschner
//! 2008, "Efficient Multiple Scattering in Hair Using Spherical Harmonics", trace photons into spherical harmonics of the cells; parts of
//! the sphere keep the cones that fibres scatter into, and light from one side.) Nothing is fitted or weighted: with photons and cells without
//! end it is exact for fibres far from each other.

mod field;
mod flight;
mod pool;

pub use field::{DIRECTIONS, FieldGrid, LightField, Packed, part_directions};
pub use flight::{Hair, Interrupted, Rules, Traced};
