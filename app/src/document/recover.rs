//! Recovery: what a journal makes of the project that it counts from.

use std::{
    fs, io,
    path::{Path, PathBuf},
    time::{Duration, SystemTime},
};

use super::{
    MAX_PROJECT_BYTES, backups, check, files,
    journal::{self, Contents, Found, JOURNAL_EXTENSION, Record},
    project::Project,
    saving::content_hash,
};
use crate::Problem;

/// A project as it was when its writer died.
#[derive(Clone, Debug, PartialEq)]
pub struct Recovered {
    /// The project.
    pub project: Project,
    /// Edits of the journal that are in it; an undo is one, too.
    pub edits: usize,
    /// Strokes and other operations among them.
    pub strokes: usize,
    /// Edits that did not fit; none unless asked for.
    pub skipped: usize,
    /// The backup that stands in for the project's file, which is no longer what the journal counts from.
    pub from_backup: Option<PathBuf>,
    /// Content hash of the project file that the journal counts from.
    pub base: Option<String>,
    /// False where the file holds all of it already.
    pub is_needed: bool,
}

/// A journal as a person hears of it.
#[derive(Clone, Debug)]
pub struct Summary {
    /// The journal.
    pub journal: PathBuf,
    /// The project that it belongs to; none for one that was never saved.
    pub project: Option<PathBuf>,
    /// How long ago the last edit was made.
    pub age: Duration,
    /// Edits, and strokes among them; or why they cannot be recovered.
    pub content: Result<(usize, usize), Problem>,
    /// Bytes of an edit that was under way.
    pub torn_bytes: u64,
}

impl std::fmt::Display for Summary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let age = age_text(self.age);
        match &self.content {
            Ok((edits, strokes)) => {
                let (edits, strokes) = (counted(*edits, "edit"), counted(*strokes, "stroke"));
                write!(f, "{edits} ({strokes}) not yet saved, the last change {age} ago")?;
            }
            Err(problem) => write!(
                f,
                "edits of {age} ago that cannot be recovered as they are: {problem}"
            )?,
        }
        if self.torn_bytes > 0 {
            write!(
                f,
                "; an edit that was under way is lost ({} bytes)",
                self.torn_bytes
            )?;
        }
        Ok(())
    }
}

/// A duration as a person says it.
pub fn age_text(age: Duration) -> String {
    let seconds = age.as_secs();
    match seconds {
        0..=119 => format!("{seconds} s"),
        120..=7199 => format!("{} min", seconds / 60),
        7200..=172_799 => format!("{} h", seconds / 3600),
        _ => format!("{} days", seconds / 86_400),
    }
}

/// The journals of `project`, or of projects that were never saved where it is none, newest first: beside it and in the state
/// folder. Journals that are being written, and empty ones, are left out.
pub fn journals_of(project: Option<&Path>, state_folder: &Path) -> Vec<Contents> {
    let own = project.map(|path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned()));
    let mut found = Vec::new();
    if let Some(own) = &own {
        let name = own.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let folder = own.parent().unwrap_or(Path::new(""));
        for path in journals_in(folder) {
            let file = path.file_name().unwrap_or_default().to_string_lossy();
            if file.strip_prefix(&name).is_some_and(|rest| rest.starts_with('.'))
                && let Some(contents) = sound(&path)
            {
                found.push(contents);
            }
        }
    }
    let elsewhere = journals_in(state_folder)
        .into_iter()
        .filter_map(|path| sound(&path));
    found.extend(elsewhere.filter(|contents| contents.start.path == own));
    found.sort_by_key(|contents| std::cmp::Reverse(contents.modified));
    found
}

fn journals_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries
        .map(|entry| entry.path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == JOURNAL_EXTENSION)
        })
        .collect()
}

/// A journal with something in it that nobody writes; one that cannot be read is logged.
fn sound(path: &Path) -> Option<Contents> {
    match journal::read(path) {
        Ok(Found::Journal(contents)) => Some(*contents),
        Ok(Found::InUse | Found::Empty) => None,
        Err(problem) => {
            log::warn!("{problem}");
            None
        }
    }
}

/// What is to be told about a journal of `project`; none where the project's file holds all of it.
pub fn summary(contents: &Contents, project: Option<&Path>) -> Option<Summary> {
    let recovered = recover(contents, project, false);
    if recovered.as_ref().is_ok_and(|recovered| !recovered.is_needed) {
        return None;
    }
    Some(Summary {
        journal: contents.path.clone(),
        project: project.map(Path::to_owned),
        age: SystemTime::now()
            .duration_since(contents.modified)
            .unwrap_or_default(),
        content: recovered.map(|recovered| (recovered.edits, recovered.strokes)),
        torn_bytes: contents.torn_bytes,
    })
}

/// "1 edit", "2 edits".
pub(super) fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// A project to start from.
struct Base {
    project: Project,
    /// Records before this one are in it.
    from: usize,
    hash: Option<String>,
    backup: Option<PathBuf>,
}

/// The project at `path`, or the one that the journal holds, with the journal's edits.
///
/// `anyway` applies them to whatever the file holds now, leaving out those that do not fit.
///
/// # Errors
/// Neither the file nor one of its backups is what the journal counts from; the result is no sound project.
pub fn recover(contents: &Contents, path: Option<&Path>, anyway: bool) -> Result<Recovered, Problem> {
    let saved = path.and_then(|path| read(path).ok());
    let base = match find_base(contents, path, saved.as_ref())? {
        Some(base) => base,
        None => match saved.clone().filter(|_| anyway) {
            Some((hash, project)) => Base {
                project,
                from: 0,
                hash: Some(hash),
                backup: None,
            },
            None => return Err(no_base(contents, path)),
        },
    };

    let mut project = base.project;
    let mut recovered = Recovered {
        project: project.clone(),
        edits: 0,
        strokes: 0,
        skipped: 0,
        from_backup: base.backup,
        base: base.hash,
        is_needed: true,
    };
    for record in &contents.records[base.from..] {
        let (patch, continues) = match record {
            Record::Patch(patch) => (patch, false),
            Record::Continued(patch) => (patch, recovered.edits > 0),
            _ => continue,
        };
        let adds = patch.adds_operation();
        if patch.clone().apply(&mut project) {
            recovered.edits += usize::from(!continues);
            recovered.strokes += usize::from(adds);
        } else if anyway {
            recovered.skipped += 1;
        } else {
            let reason = format!("edit {} does not fit the project", recovered.edits + 1);
            return Err(Problem::at("", reason, "report this as a bug").in_file(&contents.path));
        }
    }
    check::check_project(&project).map_err(|problem| problem.in_file(&contents.path))?;
    recovered.is_needed = saved.is_none_or(|(_, saved)| saved != project);
    recovered.project = project;
    Ok(recovered)
}

/// A project file: its content hash and what it says.
fn read(path: &Path) -> Result<(String, Project), Problem> {
    let text = files::read_text(path, MAX_PROJECT_BYTES)?;
    let project = Project::parse(&text).map_err(|problem| problem.in_file(path))?;
    Ok((content_hash(text.as_bytes()), project))
}

/// What the journal counts from: the newest of its saves that the file or a backup still holds, else the project in it.
fn find_base(
    contents: &Contents,
    path: Option<&Path>,
    saved: Option<&(String, Project)>,
) -> Result<Option<Base>, Problem> {
    let first = contents.start.base.iter().map(|hash| (0, hash));
    let saves = contents.records.iter().enumerate();
    let saves = saves.filter_map(|(i, record)| match record {
        Record::Saved(hash) => Some((i + 1, hash)),
        _ => None,
    });
    let mut marks: Vec<(usize, &String)> = first.chain(saves).collect();
    marks.reverse();
    // A journal that holds its project has edits before its first record that the file of its start lacks.
    if contents.start.project.is_some() {
        marks.retain(|(from, _)| *from > 0);
    }
    let mark_of = |hash: &String| {
        marks
            .iter()
            .find(|(_, known)| *known == hash)
            .map(|(from, _)| *from)
    };

    if let Some((hash, project)) = saved
        && let Some(from) = mark_of(hash)
    {
        return Ok(Some(Base {
            project: project.clone(),
            from,
            hash: Some(hash.clone()),
            backup: None,
        }));
    }
    if let Some(project) = &contents.start.project {
        return Ok(Some(Base {
            project: (**project).clone(),
            from: 0,
            hash: contents.start.base.clone(),
            backup: None,
        }));
    }
    for backup in path.map(backups::backups_of).unwrap_or_default() {
        let bytes = fs::read(&backup).map_err(|e| Problem::io(&backup, "reading", &e))?;
        let hash = content_hash(&bytes);
        if let Some(from) = mark_of(&hash) {
            let (_, project) = read(&backup)?;
            return Ok(Some(Base {
                project,
                from,
                hash: Some(hash),
                backup: Some(backup),
            }));
        }
    }
    Ok(None)
}

fn no_base(contents: &Contents, path: Option<&Path>) -> Problem {
    let reason = match path {
        Some(path) if path.exists() => format!(
            "{} was changed by another program since the journal began",
            path.display()
        ),
        Some(path) => format!("{} is gone", path.display()),
        None => "the project that the journal counts from is not known".to_owned(),
    };
    let remedy = "restore that file, or apply what fits with `balayage recover --anyway`";
    Problem::at("", reason, remedy).in_file(&contents.path)
}

/// Removes a journal that nobody wants.
///
/// # Errors
/// The file cannot be removed.
pub fn discard(journal: &Path) -> Result<(), Problem> {
    match fs::remove_file(journal) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            Err(Problem::io(journal, "removing the journal", &error))
        }
        _ => Ok(()),
    }
}
