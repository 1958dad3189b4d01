//! `balayage recover`: the edits that a crash left in a journal.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::{CliError, Console};
use crate::{
    Problem,
    document::{
        Document, LockError, ProjectLock, SaveOptions, UserState,
        journal::{self, Contents, Found, JOURNAL_EXTENSION},
        recover::{self, Summary},
    },
};

#[derive(Args)]
pub(super) struct RecoverArgs {
    /// Project, or a journal itself. Without it, journals of projects that were never saved are listed.
    project: Option<PathBuf>,
    /// Project to write instead of the one that is recovered; the journal stays.
    #[arg(short, long, value_name = "OUT.json")]
    output: Option<PathBuf>,
    /// Apply what fits although the project is not the one that the journal counts from.
    #[arg(long)]
    anyway: bool,
    /// Remove the journal without recovering it.
    #[arg(long, conflicts_with_all = ["output", "anyway"])]
    discard: bool,
}

pub(super) fn run(args: &RecoverArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let state = UserState::of_user();
    let Some(project) = &args.project else {
        return list(&state, console);
    };
    let (contents, project) = find(project, &state)?;
    if args.discard {
        recover::discard(&contents.path)?;
        let value = json!({"discarded": contents.path});
        return Ok(console.result(value, &format!("{}: discarded", contents.path.display()))?);
    }
    let recovered = recover::recover(&contents, project.as_deref(), args.anyway)?;
    let Some(output) = args.output.as_deref().or(project.as_deref()) else {
        let reason = "the journal belongs to a project that was never saved";
        return Err(CliError::Usage(format!("{reason}; name a file with -o")));
    };
    if let Some(backup) = &recovered.from_backup {
        console.warn(&format!(
            "the edits were made on {}, which the project's file no longer holds",
            backup.display()
        ));
    }

    // A project that is open elsewhere would be overwritten by its editor, or the other way round.
    let is_own = project.as_deref() == Some(output);
    let _lock = lock(output)?;
    let folder = project
        .as_deref()
        .and_then(Path::parent)
        .unwrap_or(&contents.start.folder);
    let (edits, strokes, skipped) = (recovered.edits, recovered.strokes, recovered.skipped);
    let opened = Document::open_project(recovered.project, folder)?;
    for warning in &opened.warnings {
        console.warn(warning);
    }
    let mut document = opened.document;
    let options = SaveOptions {
        backups: state.backups().max(1),
        ..SaveOptions::default()
    };
    let saved = document.save_with(output, options, |_| Ok(()))?;
    for warning in &saved.warnings {
        console.warn(warning);
    }
    if is_own {
        recover::discard(&contents.path)?;
    }
    let value = json!({
        "output": output, "journal": contents.path, "edits": edits, "strokes": strokes, "skipped": skipped,
        "torn_bytes": contents.torn_bytes,
    });
    let left = if is_own {
        String::new()
    } else {
        format!(
            "; {} stays until it is recovered or discarded",
            contents.path.display()
        )
    };
    let text = format!(
        "{}: {edits} edits recovered ({strokes} strokes), {skipped} did not fit, {} bytes of an unfinished one dropped{left}",
        output.display(),
        contents.torn_bytes
    );
    Ok(console.result(value, &text)?)
}

/// The newest journal of a project, or the journal that is named, with its project.
fn find(named: &Path, state: &UserState) -> Result<(Contents, Option<PathBuf>), Problem> {
    if named
        .extension()
        .is_some_and(|extension| extension == JOURNAL_EXTENSION)
    {
        let contents = match journal::read(named)? {
            Found::Journal(contents) => *contents,
            Found::InUse => {
                let remedy = "close the editor that writes it";
                return Err(Problem::at("", "the journal is in use", remedy).in_file(named));
            }
            Found::Empty => {
                let remedy = "remove it: no edit was committed";
                return Err(Problem::at("", "the journal holds no edit", remedy).in_file(named));
            }
        };
        let project = contents.start.path.clone();
        return Ok((contents, project));
    }
    let newest = recover::journals_of(Some(named), state.folder())
        .into_iter()
        .next();
    let contents = newest.ok_or_else(|| {
        let remedy = "open the project as it is";
        Problem::at("", "there is no journal: nothing is left to recover", remedy).in_file(named)
    })?;
    Ok((contents, Some(named.to_owned())))
}

fn list(state: &UserState, console: &mut Console<'_>) -> Result<(), CliError> {
    let journals = recover::journals_of(None, state.folder());
    let summaries: Vec<Summary> = journals
        .iter()
        .filter_map(|c| recover::summary(c, None))
        .collect();
    let lines: Vec<String> = summaries
        .iter()
        .map(|summary| format!("{}: {summary}", summary.journal.display()))
        .collect();
    let value = json!({"journals": summaries.iter().map(to_json).collect::<Vec<_>>()});
    let text = if lines.is_empty() {
        "no unsaved project is left to recover".to_owned()
    } else {
        lines.join("\n")
    };
    Ok(console.result(value, &text)?)
}

/// A journal in the results of commands.
pub(super) fn to_json(summary: &Summary) -> serde_json::Value {
    let (edits, strokes) = summary.content.clone().unwrap_or_default();
    json!({
        "journal": summary.journal, "edits": edits, "strokes": strokes, "age_seconds": summary.age.as_secs(),
        "torn_bytes": summary.torn_bytes, "problem": summary.content.as_ref().err().map(ToString::to_string),
    })
}

/// The lock of a project that is to be written; none where there can be none.
///
/// # Errors
/// Somebody else has it open.
pub(super) fn lock(project: &Path) -> Result<Option<ProjectLock>, Problem> {
    match ProjectLock::take(project, false) {
        Ok(lock) => Ok(Some(lock)),
        Err(LockError::Impossible(_)) => Ok(None),
        Err(error) => {
            let remedy = "close it there, or write to another file";
            Err(Problem::at("", error.to_string(), remedy).in_file(project))
        }
    }
}
