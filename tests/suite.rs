//! Laws, parity, layout, images, painting, project and command line.

mod cli;
mod frame;
mod groom;
mod groom_damage;
mod groom_generate;
mod groom_refined;
mod optics;
mod optics_probe;
mod optics_reference;
mod painting;
mod pathtraced;
mod project;
mod raster;
mod volume;
