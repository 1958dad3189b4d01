//! Balayage: paint dye onto real hair strands and see physically based hair answer at once.
//!
//! `ui -> tool -> document -> paint -> render`: each room imports only what stands to its right.

pub mod cli;
pub mod document;
mod pace;
pub mod paint;
mod problem;
pub mod tool;
pub mod ui;

pub use problem::Problem;
