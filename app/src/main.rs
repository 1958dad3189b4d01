//! The `balayage` command.

use std::io::{self, BufWriter};
use std::process::ExitCode;

use balayage::cli::probe;
use clap::{Parser, Subcommand};

/// Paint dye onto hair and see it lit.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Evaluate the scattering model at single points: JSON lines in, JSON lines out.
    Probe(probe::Arguments),
}

fn main() -> ExitCode {
    let Command::Probe(arguments) = Arguments::parse().command;
    match probe::run(
        &arguments,
        io::stdin().lock(),
        &mut BufWriter::new(io::stdout().lock()),
    ) {
        Ok(report) if report.refused == 0 => ExitCode::SUCCESS,
        Ok(report) => {
            eprintln!(
                "{} of {} lines were refused; each names its reason",
                report.refused, report.lines
            );
            ExitCode::from(1)
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(1)
        }
    }
}
