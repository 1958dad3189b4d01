//! What a command says: results on standard output, warnings and progress on standard error.

use std::{
    fmt::Display,
    io::{self, IsTerminal, Write},
    sync::Mutex,
    time::{Duration, Instant},
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

    /// A bar for `steps` steps, which goes when it is dropped; where standard error is no terminal, a line now and then.
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
        let lines = (!self.json && !io::stderr().is_terminal()).then(|| Mutex::new(Instant::now()));
        Progress { bar, lines }
    }
}

/// How often a line tells of progress where there is no bar.
const LINE_PERIOD: Duration = Duration::from_secs(10);

/// A progress bar that is cleared at the end of its scope.
pub(super) struct Progress {
    bar: ProgressBar,
    /// When the last line was written, where lines stand for the bar.
    lines: Option<Mutex<Instant>>,
}

impl Progress {
    /// `steps` of the length are done.
    pub(super) fn at(&self, steps: u64) {
        self.bar.set_position(steps);
        let Some(last) = &self.lines else { return };
        // One thread writes; the others need not wait for it.
        let Ok(mut last) = last.try_lock() else { return };
        if last.elapsed() >= LINE_PERIOD {
            *last = Instant::now();
            let (what, all) = (self.bar.message(), self.bar.length().unwrap_or(steps));
            let _ = writeln!(io::stderr(), "{what}: {steps} of {all}");
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
