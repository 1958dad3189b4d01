//! The `balayage` command.

use std::{io, process::ExitCode};

fn main() -> ExitCode {
    env_logger::init();
    ExitCode::from(balayage::cli::run(
        std::env::args_os(),
        &mut io::stdout(),
        &mut io::stderr(),
    ))
}
