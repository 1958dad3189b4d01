//! The `balayage` command.
