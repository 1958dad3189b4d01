//! What a benchmark leaves: tables as CSV, everything as one Markdown page, plots as PNG.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::plot::Plot;
use crate::cli::CliError;

/// One value of a table.
pub enum Cell {
    /// A name.
    Text(String),
    /// A figure; CSV keeps all its digits.
    Number(f64),
    /// Pieces counted.
    Count(u64),
    /// Not measured.
    None,
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl Cell {
    /// The value as a person reads it: four significant digits.
    fn shown(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::None => "-".to_owned(),
            Self::Count(n) => n.to_string(),
            Self::Number(x) if *x != 0.0 && x.is_finite() => {
                let before = x.abs().log10().floor() as i32 + 1;
                format!("{x:.*}", (4 - before).clamp(0, 12) as usize)
            }
            Self::Number(x) => x.to_string(),
        }
    }

    fn json(&self) -> Value {
        match self {
            Self::Text(text) => json!(text),
            Self::Number(x) => json!(x),
            Self::Count(n) => json!(n),
            Self::None => Value::Null,
        }
    }

    /// The value in CSV (RFC 4180).
    fn csv(&self) -> String {
        match self {
            Self::Text(text) => format!("\"{}\"", text.replace('"', "\"\"")),
            Self::Number(x) => x.to_string(),
            Self::Count(n) => n.to_string(),
            Self::None => String::new(),
        }
    }
}

/// Rows of cells under named columns.
pub struct Table {
    name: &'static str,
    columns: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// An empty table; `name` is its file's, columns name their units.
    pub fn new<C: Into<String>>(name: &'static str, columns: impl IntoIterator<Item = C>) -> Self {
        Self {
            name,
            columns: columns.into_iter().map(Into::into).collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row, one cell a column.
    pub fn row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        let cells: Vec<Cell> = cells.into_iter().collect();
        debug_assert_eq!(cells.len(), self.columns.len());
        self.rows.push(cells);
    }

    fn csv(&self) -> String {
        let heads: Vec<String> = self
            .columns
            .iter()
            .map(|c| Cell::from(c.as_str()).csv())
            .collect();
        let mut out = heads.join(",") + "\n";
        for row in &self.rows {
            out += &(row.iter().map(Cell::csv).collect::<Vec<_>>().join(",") + "\n");
        }
        out
    }

    /// The table in Markdown, numbers to the right.
    fn markdown(&self) -> String {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let rule = (0..self.columns.len()).map(|c| {
            let numbers = self
                .rows
                .iter()
                .any(|row| matches!(row[c], Cell::Number(_) | Cell::Count(_)));
            if numbers { "--:" } else { "---" }.to_owned()
        });
        let mut out = line(self.columns.clone()) + &line(rule.collect());
        for row in &self.rows {
            out += &line(row.iter().map(|cell| cell.shown().replace('|', "\\|")).collect());
        }
        out
    }

    fn json(&self) -> Value {
        self.rows
            .iter()
            .map(|row| {
                let cells = self.columns.iter().zip(row);
                Value::Object(
                    cells
                        .map(|(column, cell)| (column.clone(), cell.json()))
                        .collect(),
                )
            })
            .collect()
    }
}

/// All that one benchmark found.
pub struct Report {
    /// Name of the benchmark and of its Markdown page.
    pub name: &'static str,
    /// Device, counts, seeds: what has to be known to read the tables.
    pub notes: Vec<String>,
    /// The tables.
    pub tables: Vec<Table>,
    /// The plots.
    pub plots: Vec<Plot>,
}

impl Report {
    /// Writes all files into `folder`, which is made, and returns their paths.
    ///
    /// # Errors
    /// [`CliError::Input`] where a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<Vec<PathBuf>, CliError> {
        let refused = |path: &Path, error: std::io::Error| {
            let path = path.display();
            CliError::Input(format!(
                "{path}: cannot write the report: {error}; check that the folder may be written"
            ))
        };
        fs::create_dir_all(folder).map_err(|e| refused(folder, e))?;
        let mut written = Vec::new();
        let mut page = self.text();
        let mut write = |name: String, text: &str| {
            let path = folder.join(name);
            fs::write(&path, text).map_err(|e| refused(&path, e))?;
            written.push(path);
            Ok::<(), CliError>(())
        };
        for table in &self.tables {
            write(format!("{}.csv", table.name), &table.csv())?;
        }
        for plot in &self.plots {
            let _ = writeln!(page, "![{}]({}.png)\n", plot.title, plot.name);
        }
        write(format!("{}.md", self.name), &page)?;
        for plot in &self.plots {
            let path = folder.join(format!("{}.png", plot.name));
            plot.write_png(&path)?;
            written.push(path);
        }
        Ok(written)
    }

    /// Notes and tables as Markdown.
    pub fn text(&self) -> String {
        let mut out = format!("# bench {}\n\n", self.name);
        for note in &self.notes {
            let _ = writeln!(out, "- {note}");
        }
        for table in &self.tables {
            let _ = write!(out, "\n## {}\n\n{}", table.name, table.markdown());
        }
        out + "\n"
    }

    /// Notes and tables as JSON.
    pub fn json(&self) -> Value {
        let tables = self.tables.iter().map(|t| (t.name.to_owned(), t.json()));
        json!({"bench": self.name, "notes": self.notes, "tables": Value::Object(tables.collect())})
    }
}
