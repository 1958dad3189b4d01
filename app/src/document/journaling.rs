//! How the document keeps its journal.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use super::{
    Document, ProjectLock,
    history::Step,
    journal::{JOURNAL_EXTENSION, Journal, Record, Start},
    patch::Patch,
    project::Project,
};
use crate::Problem;

/// Journals of one project above this number are not made: something keeps them from being removed.
const MAX_JOURNALS: u32 = 100;

/// The document's journal.
pub(super) struct Keeper {
    /// Where journals go that cannot lie beside their project.
    state_folder: PathBuf,
    /// There is none before the first edit.
    journal: Option<Journal>,
    /// Edits were committed that no journal holds: the next journal starts from the project itself.
    is_behind: bool,
    /// What the person has not been told yet.
    problem: Option<Problem>,
    /// The last edit is in memory only.
    is_failing: bool,
}

impl Document {
    /// Writes every edit down from now on, beside the project or else in `state_folder`.
    pub fn keep_journal(&mut self, state_folder: &Path) {
        self.keeper = Some(Keeper {
            state_folder: state_folder.to_owned(),
            journal: None,
            is_behind: self.is_modified(),
            problem: None,
            is_failing: false,
        });
    }

    /// As [`Document::keep_journal`], going on with a journal that holds all that was done so far.
    pub fn resume_journal(&mut self, state_folder: &Path, journal: Journal) {
        self.keep_journal(state_folder);
        if let Some(keeper) = &mut self.keeper {
            keeper.journal = Some(journal);
            keeper.is_behind = false;
        }
    }

    /// Where the journal is, once there is one.
    pub fn journal_path(&self) -> Option<&Path> {
        self.keeper.as_ref()?.journal.as_ref().map(Journal::path)
    }

    /// Why the newest edits are in memory only; each trouble is told once.
    pub fn take_journal_problem(&mut self) -> Option<Problem> {
        self.keeper.as_mut()?.problem.take()
    }

    /// Ends the journal: what it holds is saved, or given up.
    ///
    /// # Errors
    /// Its file cannot be removed.
    pub fn discard_journal(&mut self) -> Result<(), Problem> {
        let Some(keeper) = &mut self.keeper else {
            return Ok(());
        };
        keeper.is_behind = false;
        keeper.is_failing = false;
        let Some(journal) = keeper.journal.take() else {
            return Ok(());
        };
        let path = journal.path().to_owned();
        journal
            .remove()
            .map_err(|e| Problem::io(&path, "removing the journal", &e))
    }

    /// Holds the lock of the project's file until the document goes.
    pub fn set_lock(&mut self, lock: Option<ProjectLock>) {
        self.lock = lock;
    }

    /// Gives the lock away.
    pub fn take_lock(&mut self) -> Option<ProjectLock> {
        self.lock.take()
    }

    /// Exchanges what `step` holds with the document, and writes that down as a `record`.
    pub(super) fn swap_recorded(&mut self, step: &mut Step, record: fn(Patch) -> Record) -> super::Changes {
        let inserted = match step {
            Step::Layers { detached, .. } if self.keeper.is_some() => detached.clone(),
            _ => Vec::new(),
        };
        let changes = self.swap(step);
        self.record_step(step, inserted, record);
        changes
    }

    /// Writes down what the exchange with `step` made of the project.
    pub(super) fn record_step(
        &mut self,
        step: &Step,
        inserted: Vec<(usize, crate::paint::Operation)>,
        record: fn(Patch) -> Record,
    ) {
        if self.keeper.is_some()
            && let Some(patch) = Patch::of_step(&self.project, step, inserted)
        {
            self.record(|_| record(patch));
        }
    }

    /// Writes down the newest operation, a stroke.
    pub(super) fn record_stroke(&mut self) {
        let at = self.project.operations.len().saturating_sub(1);
        self.record(|project| Record::Patch(Patch::of_operations(project, at, 1, &[])));
    }

    /// Writes down a record, which is made only where there is a journal to keep.
    pub(super) fn record(&mut self, record: impl FnOnce(&Project) -> Record) {
        if self.keeper.is_none() {
            return;
        }
        let records = [record(&self.project)];
        let written = self.ensure_journal().and_then(|has_all| {
            // A journal that starts from the project as it is now has the edit already.
            self.append(if has_all { &[] } else { &records })
        });
        self.note(written);
    }

    /// Writes down another record, where there is a journal.
    pub(super) fn record_raw(&mut self, record: Record) {
        if self.journal_path().is_some() {
            let written = self.append(&[record]);
            self.note(written);
        }
    }

    fn append(&mut self, records: &[Record]) -> Result<(), Problem> {
        match self.keeper.as_mut().and_then(|keeper| keeper.journal.as_mut()) {
            Some(journal) => journal.append(records),
            None => Ok(()),
        }
    }

    /// Keeps a trouble for the person; the same trouble at every edit is told once.
    fn note(&mut self, written: Result<(), Problem>) {
        let Some(keeper) = &mut self.keeper else { return };
        match written {
            Ok(()) => keeper.is_failing = false,
            Err(problem) => {
                if !keeper.is_failing {
                    keeper.problem = Some(problem);
                }
                keeper.is_failing = true;
            }
        }
    }

    /// Makes a journal where there is none; true where it starts from the project as it is now.
    fn ensure_journal(&mut self) -> Result<bool, Problem> {
        let Some(keeper) = &mut self.keeper else {
            return Ok(false);
        };
        if keeper.journal.as_ref().is_some_and(Journal::is_gone) {
            keeper.journal = None;
            keeper.is_behind = true;
        }
        if keeper.journal.is_some() {
            return Ok(false);
        }
        let has_base = self.disk_hash.is_some() && self.path.as_deref().is_some_and(Path::is_file);
        let whole = keeper.is_behind || !has_base;
        let created = create(self.path.as_deref(), &keeper.state_folder);
        let mut journal = created.inspect_err(|_| keeper.is_behind = true)?;
        let start = Start::now(
            self.path
                .as_deref()
                .map(|path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned())),
            std::path::absolute(&self.folder).unwrap_or_else(|_| self.folder.clone()),
            self.disk_hash.clone(),
            whole.then_some(&self.project),
        );
        keeper.is_behind = false;
        // A start that cannot be written waits in the journal for the record after it, which will say so.
        let _ = journal.append(&[Record::Start(Box::new(start))]);
        keeper.journal = Some(journal);
        Ok(whole)
    }
}

/// A new journal beside the project, else in the state folder.
fn create(project: Option<&Path>, state_folder: &Path) -> Result<Journal, Problem> {
    if let Some(project) = project {
        let name = project.to_string_lossy();
        if let Ok(journal) = create_first_free(|suffix| format!("{name}{suffix}").into()) {
            return Ok(journal);
        }
    }
    let name = match project {
        Some(project) => {
            let name = project.file_name().unwrap_or_default().to_string_lossy();
            let hash = blake3::hash(project.to_string_lossy().as_bytes());
            format!("{name}-{}", &hash.to_hex()[..8])
        }
        None => "untitled".to_owned(),
    };
    fs::create_dir_all(state_folder)
        .and_then(|()| create_first_free(|suffix| state_folder.join(format!("{name}{suffix}"))))
        .map_err(|e| {
            let problem = Problem::io(state_folder, "keeping a journal", &e);
            let remedy = format!("save often, or {}", problem.remedy);
            Problem { remedy, ..problem }
        })
}

/// The journal with the first number that is free: a journal that was kept for later keeps its name.
fn create_first_free(path: impl Fn(&str) -> PathBuf) -> io::Result<Journal> {
    for number in 1..=MAX_JOURNALS {
        let suffix = match number {
            1 => format!(".{JOURNAL_EXTENSION}"),
            n => format!(".{n}.{JOURNAL_EXTENSION}"),
        };
        match Journal::create(&path(&suffix)) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            other => return other,
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}
