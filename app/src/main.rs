//! The `balayage` command.

fn main() {}
