//! What a command says: results on standard output, warnings and progress on standard error.

use std::{
    fmt::Display,
    io::{self, Write},
    time::Duration,
};

use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};

/// The two streams of a command.
pub struct Console<'a> {
    out: &'a mut dyn Write,
    err: &'a mut dyn Write,
    json: bool,
    warnings: Vec<String>,
}

impl<'a> Console<'a> {
    /// A console; `json` prints results as JSON.
    pub fn new(out: &'a mut dyn Write, err: &'a mut dyn Write, json: bool) -> Self {
        Self {
            out,
            err,
            json,
            warnings: Vec::new(),
        }
    }

    /// Prints the result of the command: `text`, or `value` with the warnings as one JSON object.
    pub(super) fn result(&mut self, mut value: Value, text: &dyn Display) -> io::Result<()> {
        if !self.json {
            return writeln!(self.out, "{text}");
        }
        value["warnings"] = json!(self.warnings);
        writeln!(self.out, "{value:#}")
    }

    /// Standard output, for results that are a stream of lines.
    pub(super) fn stream(&mut self) -> &mut dyn Write {
        &mut *self.out
    }

    /// Warns; a closed standard error has nobody to warn.
    pub(super) fn warn(&mut self, text: &str) {
        self.warnings.push(text.to_owned());
        let _ = writeln!(self.err, "warning: {text}");
    }

    /// Says why the command stopped.
    pub(super) fn complain(&mut self, text: &str) {
        let _ = writeln!(self.err, "error: {text}");
        if self.json {
            let _ = writeln!(
                self.out,
                "{:#}",
                json!({"error": text, "warnings": self.warnings})
            );
        }
    }

    /// A bar for `steps` steps; it shows itself on a terminal only and goes when it is dropped.
    pub(super) fn progress(&self, steps: u64, what: &str) -> Progress {
        let bar = if self.json {
            ProgressBar::hidden()
        } else {
            ProgressBar::new(steps)
        };
        if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {percent} % {elapsed} (left {eta})")
        {
            bar.set_style(style);
        }
        bar.set_length(steps);
        bar.set_message(what.to_owned());
        bar.enable_steady_tick(Duration::from_millis(200));
        Progress(bar)
    }
}

/// A progress bar that is cleared at the end of its scope.
pub(super) struct Progress(ProgressBar);

impl Progress {
    /// `steps` of the length are done.
    pub(super) fn at(&self, steps: u64) {
        self.0.set_position(steps);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
