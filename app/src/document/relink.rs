//! Files that a project names: found again by their content when they were moved, and named anew.

use std::{
    collections::BTreeMap,
    fs::{self, File},
    path::{Path, PathBuf},
};

use balayage_render::groom;

use super::{
    builtin, files,
    project::{Environment, Project},
};
use crate::Problem;

/// Folders below a project that are searched for a moved file.
const DEPTH: u32 = 3;
/// Folder entries that are looked at for one project.
const MAX_ENTRIES: usize = 20_000;
/// Files that are read to compare their content, per moved file.
const MAX_CANDIDATES: usize = 64;

/// What a file is to the project.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The strands.
    Groom,
    /// The head.
    Head,
    /// What lights the hair: a map or a light list.
    Light,
}

impl Role {
    /// What a person calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Groom => "groom",
            Self::Head => "head",
            Self::Light => "light",
        }
    }
}

/// A file that is not where the project says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missing {
    /// What it is.
    pub role: Role,
    /// Where it should be.
    pub path: PathBuf,
}

/// A file that was found elsewhere.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Moved {
    /// What it is.
    pub role: Role,
    /// Where the project expected it.
    pub from: PathBuf,
    /// Where it is.
    pub to: PathBuf,
}

impl std::fmt::Display for Moved {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{}: the {} is not there any more; {} has the same content and is used: save the project to keep that",
            self.from.display(),
            self.role.name(),
            self.to.display()
        )
    }
}

/// The single files of a project that are not inside the program, with their references. Maps of a sequence are not among them.
fn named_files(project: &Project) -> Vec<(Role, &str)> {
    let mut named = vec![(Role::Groom, project.groom.path.as_str())];
    named.extend(project.head.iter().map(|head| (Role::Head, head.path.as_str())));
    if let Environment::Map(path) | Environment::Lights(path) = &project.light.environment {
        named.push((Role::Light, path));
    }
    named.retain(|(_, reference)| builtin::bytes(reference).is_none());
    named
}

/// Every file that a project in `folder` names outside that folder, links followed.
pub fn outside_files(project: &Project, folder: &Path) -> Vec<PathBuf> {
    let mut references: Vec<&str> = named_files(project)
        .into_iter()
        .map(|(_, reference)| reference)
        .collect();
    if let Environment::Sequence(sequence) = &project.light.environment {
        references.extend(sequence.maps.iter().map(String::as_str));
    }
    let absolute = |path: PathBuf| std::path::absolute(&path).unwrap_or(path);
    let folder = absolute(folder.to_owned());
    let mut outside: Vec<PathBuf> = references
        .into_iter()
        .map(|reference| files::resolve(reference, &folder))
        .filter(|file| {
            let is_inside = |file: &Path, folder: &Path| file.starts_with(folder);
            // A path that leads out is not looked at; one that stays inside may still be a link that leads out.
            !is_inside(file, &folder)
                || match (fs::canonicalize(file), fs::canonicalize(&folder)) {
                    (Ok(file), Ok(folder)) => !is_inside(&file, &folder),
                    _ => false,
                }
        })
        .collect();
    outside.sort();
    outside.dedup();
    outside
}

/// Content hashes of head and light as the project's `files` holds them; of files that cannot be read what was known before.
pub(super) fn file_hashes(project: &Project, folder: &Path) -> BTreeMap<String, String> {
    let others = named_files(project)
        .into_iter()
        .filter(|(role, _)| *role != Role::Groom);
    let hashes = others.filter_map(|(_, reference)| {
        let hash = hash_of(&files::resolve(reference, folder));
        let hash = hash.or_else(|| project.files.get(reference).cloned())?;
        Some((reference.to_owned(), hash))
    });
    hashes.collect()
}

fn hash_of(path: &Path) -> Option<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(File::open(path).ok()?).ok()?;
    Some(hasher.finalize().to_hex().to_string())
}

/// Names files that are not where the project says by where they are, as far as they are found by their content below `folder`
/// or in one of the `others`; returns what was found and what is still missing.
pub fn find_moved(project: &mut Project, folder: &Path, others: &[PathBuf]) -> (Vec<Moved>, Vec<Missing>) {
    let missing: Vec<(Role, String)> = named_files(project)
        .into_iter()
        .filter(|(_, reference)| !files::resolve(reference, folder).exists())
        .map(|(role, reference)| (role, reference.to_owned()))
        .collect();
    let (mut moved, mut still) = (Vec::new(), Vec::new());
    if missing.is_empty() {
        return (moved, still);
    }
    let near = files_near(folder, others);
    for (role, reference) in missing {
        let from = files::resolve(&reference, folder);
        let hash = match role {
            Role::Groom => project.groom.hash.clone(),
            Role::Head | Role::Light => project.files.get(&reference).cloned(),
        };
        let metres_per_unit = project.groom.metres_per_unit;
        let found = hash.and_then(|hash| find(&near, &from, role, &hash, metres_per_unit));
        match found {
            Some(to) => {
                rename(project, role, files::relative(&to, folder));
                moved.push(Moved { role, from, to });
            }
            None => still.push(Missing { role, path: from }),
        }
    }
    (moved, still)
}

/// The file among `near` that has this content; those with the old name are tried first.
fn find(
    near: &[PathBuf],
    from: &Path,
    role: Role,
    hash: &str,
    metres_per_unit: Option<f32>,
) -> Option<PathBuf> {
    let is_kind = |path: &&PathBuf| match (path.extension(), from.extension()) {
        (Some(a), Some(b)) => a.eq_ignore_ascii_case(b),
        (a, b) => a == b,
    };
    let (named, others): (Vec<&PathBuf>, Vec<&PathBuf>) = near
        .iter()
        .filter(is_kind)
        .partition(|path| path.file_name() == from.file_name());
    let mut candidates = named.into_iter().chain(others).take(MAX_CANDIDATES);
    candidates
        .find(|path| {
            let found = match role {
                Role::Groom => groom_hash(path, metres_per_unit).ok(),
                Role::Head | Role::Light => hash_of(path),
            };
            found.as_deref() == Some(hash)
        })
        .cloned()
}

/// The content hash of a groom's file.
///
/// # Errors
/// A file that is refused.
pub fn groom_hash(path: &Path, metres_per_unit: Option<f32>) -> Result<String, Problem> {
    Ok(groom::read_groom(path, metres_per_unit)?.groom.content_hash())
}

/// Files below `folder` and in the `others`, nearest first.
fn files_near(folder: &Path, others: &[PathBuf]) -> Vec<PathBuf> {
    let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    let mut found = Vec::new();
    let mut folders = vec![(folder, DEPTH)];
    folders.extend(others.iter().map(|other| (other.clone(), 1)));
    let (mut next, mut entries) = (0, 0);
    while let Some((folder, depth)) = folders.get(next).cloned() {
        next += 1;
        let Ok(list) = fs::read_dir(&folder) else { continue };
        for entry in list.flatten() {
            entries += 1;
            if entries > MAX_ENTRIES {
                return found;
            }
            match entry.file_type() {
                Ok(kind) if kind.is_dir() && depth > 1 => folders.push((entry.path(), depth - 1)),
                Ok(kind) if !kind.is_dir() => found.push(entry.path()),
                _ => {}
            }
        }
    }
    found
}

fn rename(project: &mut Project, role: Role, reference: String) {
    match role {
        Role::Groom => project.groom.path = reference,
        Role::Head => {
            if let Some(head) = &mut project.head {
                head.path = reference;
            }
        }
        Role::Light => {
            if let Environment::Map(path) | Environment::Lights(path) = &mut project.light.environment {
                *path = reference;
            }
        }
    }
}

/// Makes `file` the project's groom, head or light; returns what a person should know about its content.
///
/// # Errors
/// A groom that is refused; a project whose light is no single file.
pub fn set_file(
    project: &mut Project,
    folder: &Path,
    role: Role,
    file: &Path,
) -> Result<Option<String>, Problem> {
    let named = named_files(project);
    let Some(before) = named.iter().find(|(known, _)| *known == role) else {
        let reason = format!("the project names no file as its {}", role.name());
        let remedy = "choose one in the editor; built-in files and sequences of maps are not linked here";
        return Err(Problem::at(role.name(), reason, remedy));
    };
    let before = before.1.to_owned();
    let (expected, found, meaning) = match role {
        Role::Groom => (
            project.groom.hash.clone(),
            groom_hash(file, project.groom.metres_per_unit)?,
            "strokes are painted at their recorded places, which may lie beside its strands",
        ),
        Role::Head | Role::Light => (
            project.files.get(&before).cloned(),
            hash_of(file)
                .ok_or_else(|| Problem::at("", "the file cannot be read", "check the path").in_file(file))?,
            "pictures will differ from those made before",
        ),
    };
    rename(project, role, files::relative(file, folder));
    let note = match expected {
        Some(expected) if expected == found => None,
        Some(_) => Some(format!(
            "{}: its content is not that of the {} that the project was saved with: {meaning}",
            file.display(),
            role.name()
        )),
        None => Some(format!(
            "{}: the project does not say what content its {} had",
            file.display(),
            role.name()
        )),
    };
    Ok(note)
}
