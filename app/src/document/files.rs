//! Bounded reading, atomic writing, relative paths.

use std::{
    fs::{self, File},
    io::{self, Read, Write},
    path::{Component, Path, PathBuf},
};

use crate::Problem;

/// Text files above this size are refused, in bytes: a million dabs take a tenth of it.
pub const MAX_TEXT_BYTES: u64 = 1 << 30;

/// Reads a text file of at most `limit` bytes.
///
/// # Errors
/// Unreadable, too large, or no UTF-8.
pub fn read_text(path: &Path, limit: u64) -> Result<String, Problem> {
    let failed = |e: io::Error| Problem::io(path, "reading", &e);
    let file = File::open(path).map_err(failed)?;
    let metadata = file.metadata().map_err(failed)?;
    if metadata.is_dir() {
        return Err(Problem::at("", "this is a folder", "name a file").in_file(path));
    }

    // A pipe or a growing file has no size to trust: the limit holds for what is read, too.
    let mut bytes = Vec::new();
    file.take(limit + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > limit {
        let reason = format!("larger than {limit} bytes");
        return Err(Problem::at("", reason, "split it or choose the right file").in_file(path));
    }
    String::from_utf8(bytes).map_err(|e| {
        let place = format!("byte {}", e.utf8_error().valid_up_to());
        Problem::at(
            place,
            "not UTF-8 text",
            "save it as UTF-8 or choose the right file",
        )
        .in_file(path)
    })
}

/// The steps of an atomic save, in order; a test can make any of them fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SaveStep {
    /// A temporary file in the target's folder.
    Create,
    /// Its content.
    Write,
    /// The content is on the disk.
    Sync,
    /// It takes the target's name.
    Rename,
    /// The name is on the disk.
    SyncFolder,
}

/// Writes `bytes` to `path` so that at any moment, after a crash as well, the file holds either the old or the new content.
///
/// # Errors
/// Names the step that failed; before the rename the old content is untouched.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), Problem> {
    write_atomic_with(path, bytes, |_| Ok(()))
}

/// [`write_atomic`] with `before`, which is asked before each step and may refuse it.
///
/// # Errors
/// As [`write_atomic`].
pub fn write_atomic_with(
    path: &Path,
    bytes: &[u8],
    mut before: impl FnMut(SaveStep) -> io::Result<()>,
) -> Result<(), Problem> {
    // Saving through a link changes what it points to, not the link.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let folder = match target.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let mut step = |step, doing: &str, act: &mut dyn FnMut() -> io::Result<()>| {
        before(step)
            .and_then(|()| act())
            .map_err(|e| Problem::io(path, doing, &e))
    };

    let mut temporary = None;
    step(SaveStep::Create, "saving (new file in the folder)", &mut || {
        let mut builder = tempfile::Builder::new();
        builder.prefix(".balayage-").suffix(".tmp");
        if let Ok(metadata) = fs::metadata(&target) {
            builder.permissions(metadata.permissions());
        } else {
            allow_umask(&mut builder);
        }
        temporary = Some(builder.tempfile_in(folder)?);
        Ok(())
    })?;
    let mut temporary =
        temporary.ok_or_else(|| Problem::at("", "no temporary file", "save again").in_file(path))?;
    step(SaveStep::Write, "saving (writing)", &mut || {
        temporary.write_all(bytes)
    })?;
    step(SaveStep::Sync, "saving (syncing)", &mut || {
        temporary.as_file().sync_all()
    })?;
    let mut renamed = Some(temporary);
    step(
        SaveStep::Rename,
        "saving (renaming)",
        &mut || match renamed.take() {
            Some(file) => file.persist(&target).map(drop).map_err(|e| e.error),
            None => Ok(()),
        },
    )?;
    step(SaveStep::SyncFolder, "saving (syncing the folder)", &mut || {
        sync_folder(folder)
    })
}

/// New files get the permissions that the process's mask allows, as any other program's would.
#[cfg(unix)]
fn allow_umask(builder: &mut tempfile::Builder<'_, '_>) {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(fs::Permissions::from_mode(0o666));
}

#[cfg(not(unix))]
fn allow_umask(_builder: &mut tempfile::Builder<'_, '_>) {}

#[cfg(unix)]
pub(super) fn sync_folder(folder: &Path) -> io::Result<()> {
    let folder = if folder == Path::new("") {
        Path::new(".")
    } else {
        folder
    };
    File::open(folder)?.sync_all()
}

/// Elsewhere a folder cannot be opened as a file; the rename is as durable as the system makes it.
#[cfg(not(unix))]
pub(super) fn sync_folder(_folder: &Path) -> io::Result<()> {
    Ok(())
}

/// `file` seen from `folder`, with forward slashes; absolute where the two have no common root.
pub fn relative(file: &Path, folder: &Path) -> String {
    let absolute = |path: &Path| normal(&std::path::absolute(path).unwrap_or_else(|_| path.to_owned()));
    let (file, folder) = (absolute(file), absolute(folder));
    let shared = file
        .components()
        .zip(folder.components())
        .take_while(|(a, b)| a == b)
        .count();
    let rest: PathBuf = if shared == 0 {
        file
    } else {
        let ups = folder.components().skip(shared).map(|_| Component::ParentDir);
        ups.chain(file.components().skip(shared)).collect()
    };
    rest.to_string_lossy().replace('\\', "/")
}

/// The path that `reference` of a project in `folder` names.
pub fn resolve(reference: &str, folder: &Path) -> PathBuf {
    normal(&folder.join(reference))
}

/// The path without `.` and without `x/..`.
fn normal(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if matches!(out.components().next_back(), Some(Component::Normal(_))) => {
                out.pop();
            }
            other => out.push(other),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_paths_lead_back() {
        let folder = Path::new("/a/b/c");
        for (file, expected) in [
            ("/a/b/c/d.hair", "d.hair"),
            ("/a/x/y.hair", "../../x/y.hair"),
            ("/a/b/c/e/f", "e/f"),
        ] {
            assert_eq!(relative(Path::new(file), folder), expected);
            assert_eq!(resolve(expected, folder), Path::new(file));
        }
    }
}
