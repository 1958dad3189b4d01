//! One project, one writer: a lock file beside the project says who has it open.
//!
//! The system's own file lock tells whether that program still lives; the text in the file says who it is. Where another
//! computer wrote the file, its lock may not be visible here (network folders): then only the person can tell.

use std::{
    ffi::OsString,
    fs::{self, File, OpenOptions, TryLockError},
    io::{self, Read, Seek, SeekFrom, Write},
    path::{Path, PathBuf},
    time::{Duration, SystemTime, UNIX_EPOCH},
};

use serde::{Deserialize, Serialize};

use super::{journal::seconds, recover::age_text};

/// Who has a project open.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Holder {
    /// The process.
    pub pid: u32,
    /// Its computer.
    pub host: String,
    /// Since when, seconds since 1970.
    pub since: u64,
}

impl Holder {
    fn this_process() -> Self {
        Self {
            pid: std::process::id(),
            host: host_name(),
            since: seconds(SystemTime::now()),
        }
    }

    /// True where it is this program itself.
    pub fn is_this_process(&self) -> bool {
        self.pid == std::process::id() && self.host == host_name()
    }

    /// How long it has had the project.
    pub fn age(&self) -> Duration {
        let since = UNIX_EPOCH + Duration::from_secs(self.since);
        SystemTime::now().duration_since(since).unwrap_or_default()
    }
}

impl std::fmt::Display for Holder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.pid == 0 {
            return write!(f, "another program");
        }
        let age = age_text(self.age());
        write!(f, "Balayage (process {} on {}, for {age})", self.pid, self.host)
    }
}

/// A project that is ours until this is dropped.
#[derive(Debug)]
pub struct ProjectLock {
    path: PathBuf,
    /// Holds the system's lock.
    file: File,
}

/// Why a lock was not taken.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Somebody has it, as far as can be told.
    #[error("{holder} has the project open")]
    Held {
        /// Who.
        holder: Holder,
        /// False where the holder is known to live: then the lock cannot be taken over.
        may_be_stale: bool,
    },
    /// No lock can be kept there: a read-only folder, a file system without locks.
    #[error("no lock can be kept there: {0}")]
    Impossible(io::Error),
}

impl ProjectLock {
    /// Takes the lock of `project`. The lock of a program that died on this computer is taken over, with `force` also that of a
    /// program on another computer.
    ///
    /// # Errors
    /// Somebody has it, or there can be none.
    pub fn take(project: &Path, force: bool) -> Result<Self, LockError> {
        let path = lock_path(project);
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(LockError::Impossible)?;
        let lives = match file.try_lock() {
            Ok(()) => false,
            Err(TryLockError::WouldBlock) => true,
            Err(TryLockError::Error(error)) => return Err(LockError::Impossible(error)),
        };
        let holder = holder_in(&mut file);
        let is_foreign = holder.as_ref().is_some_and(|holder| holder.host != host_name());
        if lives || (is_foreign && !force) {
            return Err(LockError::Held {
                holder: holder.unwrap_or_default(),
                may_be_stale: !lives,
            });
        }

        // Between opening and locking another program may have removed the file: a lock on a file without a name holds nothing.
        if !is_same_file(&file, &path) {
            return Err(LockError::Held {
                holder: Holder::default(),
                may_be_stale: false,
            });
        }
        let written = serde_json::to_vec(&Holder::this_process())
            .map_err(io::Error::from)
            .and_then(|text| {
                file.set_len(0)?;
                file.seek(SeekFrom::Start(0))?;
                file.write_all(&text)
            });
        written.map_err(LockError::Impossible)?;
        Ok(Self { path, file })
    }

    /// Who has `project` open, without taking the lock: none where nobody does or its program died on this computer.
    pub fn holder(project: &Path) -> Option<Holder> {
        let mut file = File::open(lock_path(project)).ok()?;
        let lives = matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock));
        let holder = holder_in(&mut file);
        if lives {
            return Some(holder.unwrap_or_default());
        }
        holder.filter(|holder| holder.host != host_name())
    }
}

impl Drop for ProjectLock {
    fn drop(&mut self) {
        // A file that stays behind is seen to be stale; one that another computer took over is not ours to remove.
        if holder_in(&mut self.file).is_some_and(|holder| holder.pid == std::process::id()) {
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// `NAME.json.lock` beside the project.
fn lock_path(project: &Path) -> PathBuf {
    let mut name = OsString::from(project);
    name.push(".lock");
    name.into()
}

fn holder_in(file: &mut File) -> Option<Holder> {
    let mut text = String::new();
    file.seek(SeekFrom::Start(0)).ok()?;
    file.take(4096).read_to_string(&mut text).ok()?;
    serde_json::from_str(&text).ok()
}

#[cfg(unix)]
fn is_same_file(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let inode = |metadata: &fs::Metadata| (metadata.dev(), metadata.ino());
    matches!((file.metadata(), fs::metadata(path)), (Ok(a), Ok(b)) if inode(&a) == inode(&b))
}

/// Elsewhere a file that is open keeps its name.
#[cfg(not(unix))]
fn is_same_file(_file: &File, _path: &Path) -> bool {
    true
}

/// The name of this computer.
fn host_name() -> String {
    let variable = if cfg!(windows) { "COMPUTERNAME" } else { "HOSTNAME" };
    let of_kernel = fs::read_to_string("/proc/sys/kernel/hostname").ok();
    let name = of_kernel.or_else(|| fs::read_to_string("/etc/hostname").ok());
    let name = name.or_else(|| std::env::var(variable).ok()).unwrap_or_default();
    name.trim().to_owned()
}
