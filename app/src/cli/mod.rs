//! The commands.

pub mod probe;
