//! Laws, parity, layout, images, painting, project and command line.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail like tests")]

mod alembic;
mod cli;
mod dirty_paths;
mod frame;
mod furnace;
mod groom;
mod groom_damage;
mod groom_generate;
mod groom_refined;
mod journal;
mod kill;
mod light;
mod light_maps;
mod material;
mod models;
mod operations;
mod optics;
mod optics_probe;
mod optics_reference;
mod painting;
mod painting_cost;
mod parity;
mod pathtraced;
mod photons;
mod project;
mod raster;
mod relink;
mod render_out;
mod salon;
mod samples;
mod saving;
mod savings;
mod scattering;
mod schema;
mod schemes;
mod seen_colour;
mod shaders;
mod timing;
mod traced;
mod usd;
mod views;
mod volume;
mod volume_work;
