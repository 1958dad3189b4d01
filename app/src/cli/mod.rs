//! The `balayage` command: one file a subcommand.
//!
//! Exit codes: 0 done, 1 input refused, 2 usage, 3 no usable GPU adapter.

mod bench;
mod check;
mod console;
mod convert;
mod edit;
mod fit;
mod groom_options;
mod hair_option;
mod light_options;
pub mod method_options;
mod paint;
pub mod probe;
mod recover;
mod relink;
mod render;
mod trace;

use std::{
    ffi::OsString,
    io::{self, BufWriter, Write},
    path::PathBuf,
};

use balayage_render::{
    gpu::GpuError,
    groom::{GroomError, GroomReport},
    image::PictureError,
};
use clap::{Parser, Subcommand};

use crate::{
    Problem,
    document::{Document, relink as document_relink},
};
pub use console::Console;
use groom_options::GroomOptions;

/// Paint physically based hair.
#[derive(Parser)]
#[command(name = "balayage", version, about, args_conflicts_with_subcommands = true)]
struct Cli {
    /// Print results as JSON.
    #[arg(long, global = true)]
    json: bool,
    /// Write what took how long, for Perfetto (ui.perfetto.dev) or chrome://tracing.
    #[arg(long, global = true, value_name = "FILE.json")]
    trace: Option<PathBuf>,
    /// Without a subcommand: project or groom to open in the editor.
    #[command(flatten)]
    edit: edit::EditArgs,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Open the editor.
    Edit(edit::EditArgs),
    /// Render a picture of a project, a groom or the built-in sample.
    Render(Box<render::RenderArgs>),
    /// Apply strokes to a project or groom without a window.
    Paint(paint::PaintArgs),
    /// Check that a file can be read and say what is in it.
    Check(check::CheckArgs),
    /// Recover the edits that a crash left in a project's journal.
    Recover(recover::RecoverArgs),
    /// Find or name the files of a project that were moved.
    Relink(relink::RelinkArgs),
    /// Fit SRBF lights to an environment map.
    Fit(fit::FitArgs),
    /// Convert between groom formats.
    Convert(convert::ConvertArgs),
    /// Measure run time against error: tables, pages and plots.
    Bench(bench::BenchArgs),
    /// Evaluate the scattering model at single points: JSON lines in, JSON lines out.
    Probe(probe::Arguments),
}

/// Why a command stopped.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CliError {
    /// An input was refused.
    #[error("{0}")]
    Input(String),
    /// The command line asks for something that cannot be.
    #[error("{0}")]
    Usage(String),
    /// There is no GPU adapter.
    #[error("{0}")]
    NoGpu(String),
    /// Standard output is gone.
    #[error("writing the result: {0}; check where the output goes")]
    Output(#[from] io::Error),
}

impl From<Problem> for CliError {
    fn from(problem: Problem) -> Self {
        Self::Input(problem.to_string())
    }
}

impl From<GroomError> for CliError {
    fn from(error: GroomError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<PictureError> for CliError {
    fn from(error: PictureError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<GpuError> for CliError {
    fn from(error: GpuError) -> Self {
        match error {
            GpuError::NoAdapter(_) | GpuError::NoDevice { .. } => Self::NoGpu(error.to_string()),
            other => Self::Input(other.to_string()),
        }
    }
}

impl CliError {
    fn exit_code(&self) -> u8 {
        match self {
            Self::Input(_) | Self::Output(_) => 1,
            Self::Usage(_) => 2,
            Self::NoGpu(_) => 3,
        }
    }
}

/// Runs the command line `args` (program name first) and returns its exit code.
pub fn run<A: Into<OsString> + Clone>(
    args: impl IntoIterator<Item = A>,
    out: &mut dyn Write,
    err: &mut dyn Write,
) -> u8 {
    let cli = match Cli::try_parse_from(args) {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are answers, the rest is a complaint. A closed stream has nobody to tell.
            if error.use_stderr() {
                let _ = write!(err, "{error}");
                return 2;
            }
            let _ = write!(out, "{error}");
            return 0;
        }
    };
    let mut console = Console::new(out, err, cli.json);
    let _trace = match cli.trace.as_deref().map(trace::write).transpose() {
        Ok(trace) => trace,
        Err(error) => {
            console.complain(&error.to_string());
            return error.exit_code();
        }
    };
    let result = match &cli.command.unwrap_or(Command::Edit(cli.edit)) {
        Command::Edit(args) if !args.exists() => Err(CliError::Usage(args.neither())),
        Command::Edit(args) => edit::run(args),
        Command::Render(args) => render::run(args, &mut console),
        Command::Paint(args) => paint::run(args, &mut console),
        Command::Check(args) => check::run(args, &mut console),
        Command::Recover(args) => recover::run(args, &mut console),
        Command::Relink(args) => relink::run(args, &mut console),
        Command::Fit(args) => fit::run(args, &mut console),
        Command::Convert(args) => convert::run(args, &mut console),
        Command::Bench(args) => bench::run(args, &mut console),
        Command::Probe(args) => run_probe(args, &mut console),
    };
    match result {
        Ok(()) => 0,
        Err(error) => {
            console.complain(&error.to_string());
            error.exit_code()
        }
    }
}

/// Opens a project or groom and passes on what there is to know about it.
fn open(
    path: &std::path::Path,
    options: &GroomOptions,
    console: &mut Console<'_>,
) -> Result<Document, CliError> {
    let opened = Document::open_with(path, options.read())?;
    warn_of(&opened.report, path, console);
    for warning in &opened.warnings {
        console.warn(warning);
    }
    // The person who typed the command has asked for this project; what it reads besides is told.
    let document = &opened.document;
    if document.path().is_some() {
        for file in document_relink::outside_files(document.project(), document.folder()) {
            console.warn(&format!(
                "{}: the project reads {}, which lies outside its folder",
                path.display(),
                file.display()
            ));
        }
    }
    Ok(opened.document)
}

/// Warns of what a groom's reader repaired or left out.
fn warn_of(report: &GroomReport, path: &std::path::Path, console: &mut Console<'_>) {
    let path = path.display();
    if report.repairs() > 0 {
        return console.warn(&format!("{path}: {report}"));
    }
    for note in &report.notes {
        console.warn(&format!("{path}: {note}"));
    }
}

/// Answers the cases of standard input; lines that were refused are counted and make the command fail.
fn run_probe(args: &probe::Arguments, console: &mut Console<'_>) -> Result<(), CliError> {
    let mut out = BufWriter::new(console.stream());
    let report = probe::run(args, io::stdin().lock(), &mut out).map_err(|error| match error {
        probe::ProbeError::Stream(error) => CliError::Output(error),
        probe::ProbeError::Gpu(error) => error.into(),
    })?;
    drop(out);
    if report.refused > 0 {
        let text = format!(
            "{} of {} lines were refused; each names its reason",
            report.refused, report.lines
        );
        return Err(CliError::Input(text));
    }
    Ok(())
}
