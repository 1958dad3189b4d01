//! Ctrl-C: a picture that is being written is finished, then the process ends.

use std::{
    io::Write,
    process,
    sync::{Mutex, MutexGuard, Once, PoisonError},
};

/// Exit code of a process that was interrupted, as shells have it.
const INTERRUPTED: i32 = 130;

/// Pictures that are on the disk; held while one is written.
static WRITTEN: Mutex<u64> = Mutex::new(0);

/// Ends the process on Ctrl-C or a request to terminate, never in the middle of a file.
pub(super) fn on_request() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // Where there is no such signal the process ends as it always did.
        let _ = ctrlc::set_handler(|| {
            let written = writing();
            let _ = writeln!(
                std::io::stderr(),
                "\nstopped: {} pictures were written; the same command with --resume goes on",
                *written
            );
            process::exit(INTERRUPTED);
        });
    });
}

/// While this is held the process does not end; the number is that of the pictures written.
pub(super) fn writing() -> MutexGuard<'static, u64> {
    WRITTEN.lock().unwrap_or_else(PoisonError::into_inner)
}
