//! Laws, parity, layout, images, painting, project and command line.

mod volume;
