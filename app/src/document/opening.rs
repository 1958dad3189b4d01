//! Opening with a person at hand: what cannot be decided without them is asked, one question after the other.
//!
//! [`open_step`] starts from the beginning each time, with the answers so far, until nothing is left to ask. Nothing outside the
//! project's own folder is looked at before the person has agreed.

use std::{
    fs,
    path::{Path, PathBuf},
};

use balayage_render::groom::ReadOptions;

use super::{
    Document, MAX_PROJECT_BYTES, Opened, UserState, files,
    journal::{self, Found, Journal},
    lock::{Holder, LockError, ProjectLock},
    open::is_project,
    project::Project,
    recover::{self, Summary},
    relink::{self, Missing, Role},
    saving::content_hash,
};
use crate::Problem;

/// What is opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// The sample inside the program, unless an earlier session left unsaved work.
    Sample,
    /// A project or a groom.
    File(PathBuf),
}

/// What the person has said so far.
#[derive(Clone, Debug, Default)]
pub struct Answers {
    /// Files outside the project's folder may be read.
    pub trusts_outside: bool,
    /// What to do about a project that somebody else has open.
    pub lock: Option<LockAnswer>,
    /// What to do about a journal.
    pub journal: Option<JournalAnswer>,
    /// Where files are that the project does not find.
    pub files: Vec<(Role, PathBuf)>,
    /// A missing head or light may stay missing.
    pub goes_without: bool,
    /// How the groom's file is read.
    pub reading: ReadOptions,
}

/// What to do about a project that somebody else has open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LockAnswer {
    /// Work on a copy, which is saved under another name.
    Copy,
    /// The other one is gone: its lock is ours.
    TakeOver,
}

/// What to do about a journal; one that is discarded is removed, and no longer found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum JournalAnswer {
    /// Its edits are taken.
    Recover(PathBuf),
    /// It stays where it is.
    Later,
}

/// What only a person can decide.
#[derive(Clone, Debug)]
pub enum Question {
    /// Whether these files outside the project's folder may be read.
    Outside(Vec<PathBuf>),
    /// The project is open elsewhere.
    Locked {
        /// Who has it.
        holder: Holder,
        /// That program may be gone.
        may_be_stale: bool,
    },
    /// Edits of an earlier session were not saved.
    Recover(Summary),
    /// Files are not where the project says, nor near it.
    Missing(Vec<Missing>),
}

/// What opening came to.
pub enum OpenStep {
    /// A document that keeps its journal and holds its lock.
    Opened(Box<Opened>),
    /// A question, after whose answer opening starts again.
    Ask(Question),
}

/// Opens `source` as far as the `answers` allow.
///
/// # Errors
/// As [`Document::open`].
pub fn open_step(source: &Source, answers: &Answers, state: &UserState) -> Result<OpenStep, Problem> {
    match source {
        Source::Sample => match left_over(None, answers, state) {
            LeftOver::Ask(summary) => Ok(OpenStep::Ask(Question::Recover(summary))),
            LeftOver::Recover(journal) => open_project(None, Some(&journal), None, answers, state),
            LeftOver::Nothing => kept(Document::sample()?, None, state),
        },
        Source::File(path) if is_project(path) => open_file(path, answers, state),
        Source::File(path) => kept(Document::open_with(path, answers.reading)?, None, state),
    }
}

/// A project's file: its lock, its journal, then what it says.
fn open_file(path: &Path, answers: &Answers, state: &UserState) -> Result<OpenStep, Problem> {
    let mut warnings = Vec::new();
    let mut is_ours = false;
    let lock = if answers.lock == Some(LockAnswer::Copy) {
        None
    } else {
        match ProjectLock::take(path, answers.lock == Some(LockAnswer::TakeOver)) {
            Ok(lock) => Some(lock),
            // The document that is open is this one: whoever replaces it passes its lock on.
            Err(LockError::Held { holder, .. }) if holder.is_this_process() => {
                is_ours = true;
                None
            }
            Err(LockError::Held { holder, may_be_stale }) => {
                return Ok(OpenStep::Ask(Question::Locked { holder, may_be_stale }));
            }
            Err(LockError::Impossible(error)) => {
                warnings.push(format!(
                    "{}: no lock can be kept beside it ({error}): others are not kept from changing it",
                    path.display()
                ));
                None
            }
        }
    };
    let journal = if answers.lock == Some(LockAnswer::Copy) || is_ours {
        None
    } else {
        match left_over(Some(path), answers, state) {
            LeftOver::Ask(summary) => return Ok(OpenStep::Ask(Question::Recover(summary))),
            LeftOver::Recover(journal) => Some(journal),
            LeftOver::Nothing => None,
        }
    };
    let mut step = open_project(Some(path), journal.as_deref(), lock, answers, state)?;
    if let OpenStep::Opened(opened) = &mut step {
        opened.warnings.append(&mut warnings);
    }
    Ok(step)
}

/// What an earlier session left behind.
enum LeftOver {
    Nothing,
    Ask(Summary),
    Recover(PathBuf),
}

fn left_over(project: Option<&Path>, answers: &Answers, state: &UserState) -> LeftOver {
    match &answers.journal {
        Some(JournalAnswer::Recover(journal)) => return LeftOver::Recover(journal.clone()),
        Some(JournalAnswer::Later) => return LeftOver::Nothing,
        None => {}
    }
    for contents in recover::journals_of(project, state.folder()) {
        let project = project.or(contents.start.path.as_deref());
        match recover::summary(&contents, project) {
            Some(summary) => return LeftOver::Ask(summary),
            // The project holds all of it: the writer died between saving and removing the journal.
            None => {
                if let Err(problem) = recover::discard(&contents.path) {
                    log::warn!("{problem}");
                }
            }
        }
    }
    LeftOver::Nothing
}

/// A project from its file, or from the journal of its last session.
fn open_project(
    path: Option<&Path>,
    journal: Option<&Path>,
    lock: Option<ProjectLock>,
    answers: &Answers,
    state: &UserState,
) -> Result<OpenStep, Problem> {
    let mut folder = path.and_then(Path::parent).unwrap_or(Path::new("")).to_owned();
    let mut resumed = None;
    let (mut project, hash) = match (journal, path) {
        (Some(journal), _) => {
            let Found::Journal(contents) = journal::read(journal)? else {
                let remedy = "open the project without it";
                return Err(Problem::at("", "the journal is in use or empty", remedy).in_file(journal));
            };
            let recovered = recover::recover(&contents, path, false)?;
            if path.is_none() {
                folder.clone_from(&contents.start.folder);
            }
            resumed = Some((contents, recovered.edits, recovered.from_backup));
            (recovered.project, recovered.base)
        }
        (None, Some(path)) => {
            let text = files::read_text(path, MAX_PROJECT_BYTES)?;
            let mut project = Project::parse(&text).map_err(|p| p.in_file(path))?;
            project.groom.read_with(answers.reading);
            (project, Some(content_hash(text.as_bytes())))
        }
        (None, None) => return kept(Document::sample()?, None, state),
    };

    // Files of other folders are read only where the person has agreed, once per folder.
    let outside = relink::outside_files(&project, &folder);
    let unknown: Vec<PathBuf> = outside.into_iter().filter(|file| !state.trusts(file)).collect();
    if !unknown.is_empty() && !answers.trusts_outside {
        return Ok(OpenStep::Ask(Question::Outside(unknown)));
    }
    let mut warnings = Vec::new();
    for (role, file) in &answers.files {
        warnings.extend(relink::set_file(&mut project, &folder, *role, file)?);
    }
    let (moved, missing) = relink::find_moved(&mut project, &folder, state.recent_folders());
    let blocks = |missing: &Missing| missing.role == Role::Groom || !answers.goes_without;
    if missing.iter().any(blocks) {
        return Ok(OpenStep::Ask(Question::Missing(missing)));
    }
    warnings.extend(moved.iter().map(ToString::to_string));

    let mut opened = match path {
        Some(path) => Document::open_saved(project, path, &folder, hash)?,
        None => Document::open_project(project, &folder)?,
    };
    opened.document.is_restored |= resumed.is_some() || !moved.is_empty() || !answers.files.is_empty();
    opened.document.set_lock(lock);
    let copied = path.filter(|_| answers.lock == Some(LockAnswer::Copy));
    if let Some(path) = copied {
        opened.document.detach();
        warnings.push(format!(
            "A copy of {}: save it under another name",
            path.display()
        ));
    }
    let mut journal = None;
    if let Some((contents, edits, from_backup)) = resumed {
        let edits = recover::counted(edits, "edit");
        warnings.push(format!(
            "Recovered {edits}: save the project to keep what was done"
        ));
        if let Some(backup) = from_backup {
            warnings.push(format!(
                "They were made on {}, which the project's file no longer holds: save under another name, or over the file",
                backup.display()
            ));
        }
        let resumed = Journal::resume(&contents.path, contents.sound_len);
        journal = Some(resumed.map_err(|e| Problem::io(&contents.path, "going on with the journal", &e))?);
    }
    opened.warnings.append(&mut warnings);
    kept(opened, journal, state)
}

/// The document with a journal: the one it goes on with, or a new one.
fn kept(mut opened: Opened, journal: Option<Journal>, state: &UserState) -> Result<OpenStep, Problem> {
    match journal {
        Some(journal) => opened.document.resume_journal(state.folder(), journal),
        None => opened.document.keep_journal(state.folder()),
    }
    Ok(OpenStep::Opened(Box::new(opened)))
}

impl Document {
    /// Every file that the project is made of, and those of them that lie outside its folder.
    pub fn used_files(&self) -> (Vec<PathBuf>, Vec<PathBuf>) {
        let absolute = |path: PathBuf| std::path::absolute(&path).unwrap_or(path);
        let mut used: Vec<PathBuf> = self.path.iter().cloned().map(absolute).collect();
        if self.project.groom.path.starts_with("builtin:") {
            return (used, Vec::new());
        }
        used.push(absolute(self.resolve(&self.project.groom.path)));
        used.extend(self.light_files().into_iter().map(absolute));
        used.retain(|file| fs::exists(file).unwrap_or(false));
        (used, relink::outside_files(&self.project, &self.folder))
    }
}
