//! Laws, parity, layout, images, painting, project and command line.

mod painting;
mod project;
mod raster;
