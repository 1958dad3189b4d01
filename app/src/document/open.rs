//! From files to a document and back.

use std::{path::Path, sync::Arc};

use balayage_render::groom::{self, GroomError, GroomReport, LoadedGroom, Mesh, PaintedValues, ReadOptions};

use super::{
    Document, builtin, files,
    project::{GroomReference, Project},
    relink::{self, Role},
    saving,
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
            project.groom.read_with(options);
            let hash = saving::content_hash(text.as_bytes());
            return Self::open_saved(project, path, &folder, Some(hash));
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

    /// The document of a project that is saved at `path`, whose file has the content `hash`.
    pub(super) fn open_saved(
        project: Project,
        path: &Path,
        folder: &Path,
        hash: Option<String>,
    ) -> Result<Opened, Problem> {
        let mut opened = Self::open_project(project, folder)
            .map_err(|p| if p.file.is_empty() { p.in_file(path) } else { p })?;
        opened.document.path = Some(path.to_owned());
        opened.document.disk_hash = hash;
        Ok(opened)
    }

    /// The document of a project whose paths count from `folder`. Files that were moved inside that folder are found again.
    ///
    /// # Errors
    /// As [`Document::open`].
    pub fn open_project(mut project: Project, folder: &Path) -> Result<Opened, Problem> {
        let (moved, missing) = relink::find_moved(&mut project, folder, &[]);
        if let Some(groom) = missing.iter().find(|missing| missing.role == Role::Groom) {
            return Err(Problem::at(
                "groom",
                "the file is not there, and none beside the project has its content",
                "restore it, or say where it is: `balayage relink PROJECT --groom FILE`",
            )
            .in_file(&groom.path));
        }
        let (loaded, painted) = read_groom(&project.groom, folder)?;
        let mut opened = Self::from_loaded(project, folder, loaded, painted)?;
        opened.document.is_restored = !moved.is_empty();
        let found = moved.iter().map(ToString::to_string);
        opened.warnings.splice(0..0, found);
        Ok(opened)
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
}

/// True where `path` names a project by its extension.
pub(super) fn is_project(path: &Path) -> bool {
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
