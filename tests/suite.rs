//! Laws, parity, layout, images, painting, project and command line.

mod groom;
mod groom_damage;
mod groom_generate;
mod groom_refined;
mod pathtraced;
mod raster;
mod scattering;
mod shaders;
mod volume;
