//! Balayage: paint dye onto real hair strands and see physically based hair answer at once.
//!
//! `ui -> tool -> document -> paint -> render`: each room imports only what stands to its right.

pub mod cli;
