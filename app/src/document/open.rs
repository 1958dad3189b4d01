//! From files to a document and back.

use std::{path::Path, sync::Arc};

use balayage_render::groom::{self, GroomError, GroomReport, LoadedGroom, Mesh, PaintedValues, ReadOptions};

use super::{
    Document, builtin, files, json,
    project::{GroomReference, Project},
};
use crate::Problem;

/// Project files above this size are refused, in bytes.
pub const MAX_PROJECT_BYTES: u64 = files::MAX_TEXT_BYTES;

/// A document and what a person should know about how it was opened.
pub struct Opened {
    /// The document.
    pub document: Document,
    /// What the groom's reader repaired.
    pub report: GroomReport,
    /// What differs from what the project expects, one sentence each.
    pub warnings: Vec<String>,
}

impl Document {
    /// Opens a project (`.json`) or a groom, which becomes an unpainted project.
    ///
    /// `metres_per_unit` overrides the project's factor.
    ///
    /// # Errors
    /// Unreadable or unsound files; names the file, the place in it and the remedy.
    pub fn open(path: &Path, metres_per_unit: Option<f32>) -> Result<Opened, Problem> {
        let options = ReadOptions {
            metres_per_unit,
            time: None,
        };
        Self::open_with(path, options)
    }

    /// [`Document::open`] with a time as well, at which a USD groom is taken; both are kept in the project.
    ///
    /// # Errors
    /// As [`Document::open`]; also a time for a groom of a format that has none.
    pub fn open_with(path: &Path, options: ReadOptions) -> Result<Opened, Problem> {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        if is_project(path) {
            let text = files::read_text(path, MAX_PROJECT_BYTES)?;
            let mut project = Project::parse(&text).map_err(|p| p.in_file(path))?;
            let groom = &mut project.groom;
            groom.metres_per_unit = options.metres_per_unit.or(groom.metres_per_unit);
            groom.usd_time = options.time.or(groom.usd_time);
            let mut opened = Self::open_project(project, &folder)
                .map_err(|p| if p.file.is_empty() { p.in_file(path) } else { p })?;
            opened.document.path = Some(path.to_owned());
            return Ok(opened);
        }
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let reference = GroomReference {
            path: name,
            metres_per_unit: options.metres_per_unit,
            usd_time: options.time,
            ..GroomReference::default()
        };
        let project = Project::new(reference);
        let (loaded, painted) = read_groom(&project.groom, &folder)?;
        Self::from_loaded(project, &folder, loaded, painted)
    }

    /// The document of a project whose paths count from `folder`.
    ///
    /// # Errors
    /// As [`Document::open`].
    pub fn open_project(project: Project, folder: &Path) -> Result<Opened, Problem> {
        let (loaded, painted) = read_groom(&project.groom, folder)?;
        Self::from_loaded(project, folder, loaded, painted)
    }

    fn from_loaded(
        mut project: Project,
        folder: &Path,
        loaded: LoadedGroom,
        painted: Option<PaintedValues>,
    ) -> Result<Opened, Problem> {
        // A groom that changed still opens: dabs are places in space. The person is told.
        let hash = loaded.groom.content_hash();
        let mut warnings = Vec::new();
        if let Some(expected) = project.groom.hash.as_ref().filter(|expected| **expected != hash) {
            warnings.push(format!(
                "{}: the groom changed since the project was saved (content hash {}, expected {}): strokes are painted at their recorded places; \
                 restore the file or save the project to accept it",
                project.groom.path,
                short(&hash),
                short(expected),
            ));
        }
        project.groom.hash = Some(hash);
        project.groom.metres_per_unit = Some(loaded.groom.metres_per_unit());
        if painted.is_some() {
            warnings.push(format!(
                "{}: the painted values of the file stand in place of the base parameters",
                project.groom.path
            ));
        }
        let mut document = Self::new(Arc::new(loaded.groom), project, folder.to_owned())?;
        if let Some(painted) = painted {
            document.bring(painted)?;
        }
        Ok(Opened {
            document,
            report: loaded.report,
            warnings,
        })
    }

    /// The sample that lives inside the program.
    ///
    /// # Errors
    /// None that a test would not have found.
    pub fn sample() -> Result<Opened, Problem> {
        let mut project = Project::parse(builtin::SAMPLE)?;
        project.map_paths(builtin::reference_to);
        Self::open_project(project, Path::new(""))
    }

    /// Reads the head of the project.
    ///
    /// # Errors
    /// A file that is refused.
    pub fn load_head(&self) -> Result<Option<Mesh>, Problem> {
        let Some(head) = &self.project.head else {
            return Ok(None);
        };
        let mesh = match builtin::bytes(&head.path) {
            Some(bytes) => Mesh::parse_obj(bytes, &head.path),
            None => Mesh::read_obj(self.resolve(&head.path)),
        };
        Ok(Some(mesh?))
    }

    /// Saves to `path`, which becomes the document's own; the paths in the project follow it.
    ///
    /// # Errors
    /// The file cannot be written; the old file and the document are as before.
    pub fn save_as(&mut self, path: &Path) -> Result<(), Problem> {
        self.commit_stroke();
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let mut project = self.project.clone();
        project.map_paths(|reference| match builtin::bytes(reference) {
            Some(_) => reference.to_owned(),
            None => files::relative(&self.resolve(reference), &folder),
        });
        let text = json::to_text(&project)
            .map_err(|e| Problem::at("", e.to_string(), "report this as a bug").in_file(path))?;
        files::write_atomic(path, text.as_bytes())?;
        self.project = project;
        self.folder = folder;
        self.path = Some(path.to_owned());
        self.saved_state = self.history.state();
        Ok(())
    }
}

/// True where `path` names a project by its extension.
fn is_project(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("json"))
}

/// The start of a hash, enough to tell two apart.
fn short(hash: &str) -> &str {
    hash.get(..12).unwrap_or(hash)
}

/// The groom, and the painted values that its file brings with it.
fn read_groom(
    reference: &GroomReference,
    folder: &Path,
) -> Result<(LoadedGroom, Option<PaintedValues>), Problem> {
    if let Some(bytes) = builtin::bytes(&reference.path) {
        let loaded = groom::parse_hair(bytes, &reference.path, reference.metres_per_unit)?;
        return Ok((loaded, None));
    }
    let path = files::resolve(&reference.path, folder);
    let options = ReadOptions {
        metres_per_unit: reference.metres_per_unit,
        time: reference.usd_time,
    };
    Ok(groom::read_painted_groom(&path, options)?)
}

impl From<GroomError> for Problem {
    fn from(error: GroomError) -> Self {
        match error {
            GroomError::Io { path, action, source } => Self::io(&path, action, &source),
            GroomError::Format {
                file,
                offset,
                reason,
                remedy,
            } => Self::at(format!("byte {offset}"), reason, remedy).in_file(Path::new(&file)),
            GroomError::Refused {
                subject,
                reason,
                remedy,
            } => Self::at("", reason, remedy).in_file(Path::new(&subject)),
            other => Self::at("", other.to_string(), "choose another file"),
        }
    }
}
