//! The journal: what was committed since the last save, one record a line, so that a crash loses no finished edit.
//!
//! A line is the length of a JSON record in bytes, the first 16 hexadecimal digits of its BLAKE3 hash, and the record. Each is handed
//! to the operating system in one write when the edit is committed: the death of the process loses nothing of it. A thread asks
//! for the disk once in [`SYNC_INTERVAL`]: a power cut may lose the edits of that long. What follows a torn record is dropped.

use std::{
    fs::{self, File, OpenOptions, TryLockError},
    io::{self, Read, Write},
    path::{Path, PathBuf},
    sync::mpsc::{SyncSender, sync_channel},
    thread,
    time::{Duration, SystemTime, UNIX_EPOCH},
};

use serde::{Deserialize, Serialize};

use super::{files, patch::Patch, project::Project};
use crate::Problem;

/// How often the journal is synced to the disk: what a power cut may lose at most, besides the time that the sync takes.
pub const SYNC_INTERVAL: Duration = Duration::from_secs(1);

/// The extension of journals.
pub const JOURNAL_EXTENSION: &str = "journal";

/// The version of the journal that this program writes.
const JOURNAL_VERSION: u32 = 2;

/// A line of the journal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Record {
    /// The first line.
    Start(Box<Start>),
    /// A committed edit, an undo or a redo.
    Patch(Patch),
    /// What became of the edit before, as moments of one drag do: both are one edit.
    Continued(Patch),
    /// From here on the journal counts from the project file with this content hash, if that save came to its end.
    Saved(String),
}

/// What a journal counts from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Start {
    /// The version of the journal.
    pub version: u32,
    /// The project file; none for a project that was never saved.
    pub path: Option<PathBuf>,
    /// The folder that the project's paths count from.
    pub folder: PathBuf,
    /// Content hash of the project file.
    pub base: Option<String>,
    /// The project itself, where no file holds it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub project: Option<Box<Project>>,
    /// When it began, seconds since 1970.
    pub started: u64,
}

impl Start {
    /// The start of a journal that begins now.
    pub fn now(
        path: Option<PathBuf>,
        folder: PathBuf,
        base: Option<String>,
        project: Option<&Project>,
    ) -> Self {
        Self {
            version: JOURNAL_VERSION,
            path,
            folder,
            base,
            project: project.cloned().map(Box::new),
            started: seconds(SystemTime::now()),
        }
    }
}

/// Seconds since 1970.
pub(super) fn seconds(time: SystemTime) -> u64 {
    time.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs()
}

/// Where the lines go: a file, or what stands for one in a test.
pub trait Storage: Send {
    /// Adds `bytes` at the end.
    ///
    /// # Errors
    /// Some or none of them may have been written.
    fn append(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Cuts everything after the first `len` bytes.
    ///
    /// # Errors
    /// The content is as before.
    fn cut(&mut self, len: u64) -> io::Result<()>;

    /// Shows others that nobody writes here any more.
    fn release(&mut self) {}

    /// What brings the content to the disk, for another thread.
    ///
    /// # Errors
    /// No second handle can be had.
    fn syncer(&self) -> io::Result<Box<dyn Fn() -> io::Result<()> + Send>>;
}

impl Storage for File {
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.write_all(bytes)
    }

    fn cut(&mut self, len: u64) -> io::Result<()> {
        self.set_len(len)
    }

    fn release(&mut self) {
        let _ = self.unlock();
    }

    fn syncer(&self) -> io::Result<Box<dyn Fn() -> io::Result<()> + Send>> {
        let file = self.try_clone()?;
        Ok(Box::new(move || file.sync_data()))
    }
}

/// A journal that is being written.
pub struct Journal {
    path: PathBuf,
    storage: Box<dyn Storage>,
    /// Length of what is sound.
    sound_len: u64,
    /// Lines that could not be written yet.
    pending: Vec<u8>,
    /// A failed write may have left a part of a line.
    is_torn: bool,
    /// Asks the syncing thread, which ends with it.
    sync: Option<SyncSender<()>>,
}

impl Journal {
    /// A new journal at `path`, which must not exist yet; nothing is written before the first record.
    ///
    /// # Errors
    /// The file cannot be created.
    pub fn create(path: &Path) -> io::Result<Self> {
        let create = || OpenOptions::new().append(true).create_new(true).open(path);
        let file = match create() {
            // Its writer died before its first record.
            Err(error)
                if error.kind() == io::ErrorKind::AlreadyExists && matches!(read(path), Ok(Found::Empty)) =>
            {
                fs::remove_file(path)?;
                create()?
            }
            created => created?,
        };
        // Whoever finds the journal sees by the lock that its writer lives; file systems without locks do without.
        let _ = file.try_lock();
        Ok(Self::on(path, Box::new(file), 0))
    }

    /// Goes on with the journal at `path`, of which the first `sound_len` bytes are sound.
    ///
    /// # Errors
    /// The file cannot be opened or cut.
    pub fn resume(path: &Path, sound_len: u64) -> io::Result<Self> {
        let file = OpenOptions::new().append(true).open(path)?;
        let _ = file.try_lock();
        file.set_len(sound_len)?;
        Ok(Self::on(path, Box::new(file), sound_len))
    }

    /// A journal on any storage that holds `sound_len` sound bytes.
    pub fn on(path: &Path, storage: Box<dyn Storage>, sound_len: u64) -> Self {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let sync = storage.syncer().ok().map(|sync| start_syncing(sync, folder));
        Self {
            path: path.to_owned(),
            storage,
            sound_len,
            pending: Vec::new(),
            is_torn: false,
            sync,
        }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// True where nothing was recorded yet.
    pub fn is_empty(&self) -> bool {
        self.sound_len == 0 && self.pending.is_empty()
    }

    /// True where somebody else took the file away.
    pub fn is_gone(&self) -> bool {
        matches!(fs::symlink_metadata(&self.path), Err(e) if e.kind() == io::ErrorKind::NotFound)
    }

    /// Records of edits reach the operating system before this returns.
    ///
    /// # Errors
    /// The record is kept in memory and written before the next one.
    pub fn append(&mut self, records: &[Record]) -> Result<(), Problem> {
        for record in records {
            let line = line(record)
                .map_err(|e| Problem::at("", e.to_string(), "report this as a bug").in_file(&self.path))?;
            self.pending.extend_from_slice(&line);
        }
        self.write_pending().map_err(|e| {
            let problem = Problem::io(&self.path, "keeping the journal", &e);
            let remedy = format!("save the project to another disk, or {}", problem.remedy);
            Problem { remedy, ..problem }
        })
    }

    fn write_pending(&mut self) -> io::Result<()> {
        if self.is_torn {
            self.storage.cut(self.sound_len)?;
            self.is_torn = false;
        }
        if let Err(error) = self.storage.append(&self.pending) {
            self.is_torn = self.storage.cut(self.sound_len).is_err();
            return Err(error);
        }
        self.sound_len += self.pending.len() as u64;
        self.pending.clear();
        if let Some(sync) = &self.sync {
            // A full channel has a sync on its way that will include this record.
            let _ = sync.try_send(());
        }
        Ok(())
    }

    /// Ends the journal and removes its file: everything is saved, or given up.
    ///
    /// # Errors
    /// The file cannot be removed; the edits in it are found again at the next start.
    pub fn remove(self) -> io::Result<()> {
        match fs::remove_file(&self.path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }
}

impl Drop for Journal {
    /// The syncing thread may hold its handle a while longer.
    fn drop(&mut self) {
        self.storage.release();
    }
}

/// A thread that syncs once an interval where there is something to sync; at first with the folder, which has to know the file.
fn start_syncing(sync: Box<dyn Fn() -> io::Result<()> + Send>, folder: PathBuf) -> SyncSender<()> {
    let (sender, wanted) = sync_channel(1);
    thread::spawn(move || {
        let mut new_in = Some(folder);
        while wanted.recv().is_ok() {
            thread::sleep(SYNC_INTERVAL);
            let synced = sync().and_then(|()| new_in.as_deref().map_or(Ok(()), files::sync_folder));
            match synced {
                Ok(()) => new_in = None,
                Err(error) => log::warn!("the journal was not synced to the disk: {error}"),
            }
        }
    });
    sender
}

/// The line of a record.
fn line(record: &Record) -> Result<Vec<u8>, serde_json::Error> {
    let json = serde_json::to_vec(record)?;
    let mut line = format!("{} {} ", json.len(), check_sum(&json)).into_bytes();
    line.extend_from_slice(&json);
    line.push(b'\n');
    Ok(line)
}

fn check_sum(json: &[u8]) -> String {
    blake3::hash(json).to_hex()[..16].to_owned()
}

/// What a journal holds.
pub struct Contents {
    /// The journal.
    pub path: PathBuf,
    /// What it counts from.
    pub start: Start,
    /// The records after the start.
    pub records: Vec<Record>,
    /// Length of what is sound.
    pub sound_len: u64,
    /// Bytes after it: a record that was under way when the writer died.
    pub torn_bytes: u64,
    /// When it was last written.
    pub modified: SystemTime,
}

/// What is found where a journal is looked for.
pub enum Found {
    /// A journal that nobody writes.
    Journal(Box<Contents>),
    /// A journal whose writer lives.
    InUse,
    /// A file without a single sound record: nothing was committed.
    Empty,
}

/// Reads the journal at `path`.
///
/// # Errors
/// Unreadable, too large, or of a newer version.
pub fn read(path: &Path) -> Result<Found, Problem> {
    let failed = |e: io::Error| Problem::io(path, "reading the journal", &e);
    let file = File::open(path).map_err(failed)?;
    if matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)) {
        return Ok(Found::InUse);
    }
    let modified = file.metadata().and_then(|m| m.modified()).map_err(failed)?;
    let mut bytes = Vec::new();
    (&file)
        .take(files::MAX_TEXT_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(failed)?;
    if bytes.len() as u64 > files::MAX_TEXT_BYTES {
        let reason = format!("larger than {} bytes", files::MAX_TEXT_BYTES);
        return Err(Problem::at("", reason, "move it away and report it").in_file(path));
    }

    let (mut records, mut rest) = (Vec::new(), bytes.as_slice());
    while let Some((record, after)) = first_record(rest) {
        records.push(record);
        rest = after;
    }
    let mut records = records.into_iter();
    let Some(Record::Start(start)) = records.next() else {
        return Ok(Found::Empty);
    };
    if start.version > JOURNAL_VERSION {
        let reason = format!(
            "journal version {} is newer than {JOURNAL_VERSION}",
            start.version
        );
        return Err(Problem::at("", reason, "recover it with a newer Balayage").in_file(path));
    }
    Ok(Found::Journal(Box::new(Contents {
        path: path.to_owned(),
        start: *start,
        records: records.collect(),
        sound_len: (bytes.len() - rest.len()) as u64,
        torn_bytes: rest.len() as u64,
        modified,
    })))
}

/// The record that `bytes` begin with and what follows it; none where it is torn or was changed.
fn first_record(bytes: &[u8]) -> Option<(Record, &[u8])> {
    let mut parts = bytes.splitn(3, |byte| *byte == b' ');
    let (len, sum, rest) = (parts.next()?, parts.next()?, parts.next()?);
    let len: usize = str::from_utf8(len).ok()?.parse().ok()?;
    let (json, after) = rest.split_at_checked(len)?;
    let after = after.strip_prefix(b"\n")?;
    if check_sum(json).as_bytes() != sum {
        return None;
    }
    serde_json::from_slice(json).ok().map(|record| (record, after))
}
