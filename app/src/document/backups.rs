//! Earlier versions of a project beside it: `NAME.json.1~` is the newest, the numbers rise with age.

use std::{
    ffi::OsString,
    fs, io,
    path::{Path, PathBuf},
};

/// The backup of that age, from 1.
pub fn backup_path(project: &Path, age: u32) -> PathBuf {
    let mut name = OsString::from(project);
    name.push(format!(".{age}~"));
    name.into()
}

/// The backups of `project` that exist, newest first.
pub fn backups_of(project: &Path) -> Vec<PathBuf> {
    let ages = 1..=super::user_state::MAX_BACKUPS;
    ages.map(|age| backup_path(project, age))
        .filter(|path| path.is_file())
        .collect()
}

/// Makes the file at `project` its newest backup and keeps the newest `count`; the file itself stays where it is.
///
/// # Errors
/// A folder that cannot be written, a full disk; no backup was overwritten by a newer one that is not there.
pub(super) fn rotate(project: &Path, count: u32) -> io::Result<()> {
    if count == 0 || !project.is_file() {
        return Ok(());
    }

    // A save that failed has made its backup already: trying again must not push older ones out.
    let newest = backup_path(project, 1);
    if newest.is_file() && fs::read(project)? == fs::read(&newest)? {
        return Ok(());
    }

    // The newest backup gets its content before any older one gives up its place.
    let newcomer = backup_path(project, 0);
    match fs::remove_file(&newcomer) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    if fs::hard_link(project, &newcomer).is_err() {
        let copied = fs::copy(project, &newcomer).and_then(|_| fs::File::open(&newcomer)?.sync_all());
        if let Err(error) = copied {
            let _ = fs::remove_file(&newcomer);
            return Err(error);
        }
    }
    for age in (0..count).rev() {
        let (from, to) = (backup_path(project, age), backup_path(project, age + 1));
        if from.is_file() {
            fs::rename(&from, &to)?;
        }
    }
    Ok(())
}
