//! Generative fuzzing of every reader, on the stable toolchain.
//!
//! Small valid files are mutated as bytes, as text, as JSON trees, or built anew from damaged tables (`mutate.rs`, `usdc.rs`). An input that
//! draws an answer of a new kind, told by the words of the refusal, joins the files that are mutated further. A reader may refuse or
//! return something sound; it may not panic, return something unsound, take longer than [`SLOW`] or more memory than [`budget`].
//!
//! `./run fuzz [SECONDS] [READER]`; without it each reader has [`USUAL_SECONDS`], from one seed. A failure prints the seed, and the input
//! stands in `out/fuzz/`: `BALAYAGE_FUZZ_INPUT=FILE ./run fuzz 1 READER` reads it again. After a crash that cannot be caught it is in
//! `out/fuzz/READER.running`.

#![allow(clippy::unwrap_used, reason = "a helper that fails fails its test")]

mod corpus;
mod mutate;
mod targets;
mod usdc;

use std::collections::HashSet;
use std::fs::{self, File};
use std::io::{Seek, SeekFrom, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use balayage_tests::{random, repository};
use peak_alloc::PeakAlloc;
use rand::Rng;

use targets::{TARGETS, Target};

#[global_allocator]
static COUNTER: PeakAlloc = PeakAlloc;

/// Seconds a reader where nobody asks for more: eleven of them stay within a few seconds.
const USUAL_SECONDS: f64 = 0.5;

/// The longest that one input may take in a development build on a busy machine.
const SLOW: Duration = Duration::from_secs(10);

/// Inputs of which each drew an answer of its own kind.
const MAX_POOL: usize = 512;

/// Bytes that reading `len` bytes may allocate at the peak.
fn budget(len: usize) -> usize {
    (64 << 20) + 4 * len
}

/// What the last panic said.
static PANIC: Mutex<String> = Mutex::new(String::new());
/// Milliseconds since the start at which the input now being read was begun; 0 while none is.
static BEGUN: AtomicU64 = AtomicU64::new(0);

#[test]
fn every_reader_refuses_or_returns_something_sound() {
    let seconds = variable("BALAYAGE_FUZZ_SECONDS").map_or(USUAL_SECONDS, |text| text.parse().unwrap());
    let seed = variable("BALAYAGE_FUZZ_SEED").map_or(1, |text| text.parse().unwrap());
    let only = variable("BALAYAGE_FUZZ_READER");
    let input = variable("BALAYAGE_FUZZ_INPUT").map(|path| fs::read(path).unwrap());
    let folder = repository("out/fuzz");
    fs::create_dir_all(&folder).unwrap();
    std::panic::set_hook(Box::new(|panic| *PANIC.lock().unwrap() = panic.to_string()));
    watch();

    let chosen = |target: &&Target| only.as_ref().is_none_or(|only| only == target.name);
    let mut failures = Vec::new();
    for target in TARGETS.iter().filter(chosen) {
        let result = match &input {
            Some(input) => Run::new(target, &folder, seed).read(input),
            None => Run::new(target, &folder, seed).fuzz(Duration::from_secs_f64(seconds)),
        };
        failures.extend(result.err());
    }
    // The comparator can fail: a reader that panics, one that allocates, one that is unsound.
    if only.is_none() {
        for target in &targets::BROKEN {
            let result = Run::new(target, &folder, seed).fuzz(Duration::from_millis(200));
            assert!(result.is_err(), "{} was not noticed", target.name);
        }
    }
    let _ = std::panic::take_hook();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

fn variable(name: &str) -> Option<String> {
    std::env::var(name).ok().filter(|text| !text.is_empty())
}

/// One reader's turn.
struct Run<'a> {
    target: &'a Target,
    folder: &'a Path,
    seed: u64,
    /// Holds the input while it is read, for the case that the process does not survive it.
    running: File,
    running_path: PathBuf,
}

impl<'a> Run<'a> {
    fn new(target: &'a Target, folder: &'a Path, seed: u64) -> Self {
        let running_path = folder.join(format!("{}.running", target.name));
        Self {
            target,
            folder,
            seed,
            running: File::create(&running_path).unwrap(),
            running_path,
        }
    }

    /// Mutates and reads until the time is over or something fails.
    fn fuzz(mut self, time: Duration) -> Result<(), String> {
        let mut random = random(self.seed);
        let mut pool = (self.target.corpus)();
        let valid = pool.len();
        for (i, input) in pool.iter().enumerate() {
            if let Err(reason) = self.answer(input)? {
                return Err(format!(
                    "{}: valid file {i} is refused: {reason}",
                    self.target.name
                ));
            }
        }
        let mut kinds = HashSet::new();
        let start = Instant::now();
        let (mut read, mut refused) = (0_u64, 0_u64);
        while start.elapsed() < time {
            // Most inputs come from valid files, the others from what has been found since.
            let of = if random.random_ratio(3, 4) {
                valid
            } else {
                pool.len()
            };
            let chosen = random.random_range(0..of);
            let input = (self.target.mutate)(&mut random, &pool, chosen);
            read += 1;
            if let Err(reason) = self.answer(&input)? {
                refused += 1;
                if pool.len() < MAX_POOL && kinds.insert(kind(&reason)) {
                    pool.push(input);
                }
            }
        }
        let words = format!(
            "fuzz {:<8} {read:>9} inputs in {:.1} s, {refused} refused with {} kinds of words, seed {}\n",
            self.target.name,
            start.elapsed().as_secs_f64(),
            kinds.len(),
            self.seed
        );
        let _ = std::io::stderr().write_all(words.as_bytes());
        let _ = fs::remove_file(&self.running_path);
        Ok(())
    }

    /// Reads one input that was kept.
    fn read(mut self, input: &[u8]) -> Result<(), String> {
        let answer = self.answer(input)?;
        let words = format!("fuzz {}: {answer:?}\n", self.target.name);
        let _ = std::io::stderr().write_all(words.as_bytes());
        Ok(())
    }

    /// What the reader says to an input.
    ///
    /// # Errors
    /// What it did that no reader may; the input is kept.
    fn answer(&mut self, input: &[u8]) -> Result<Result<(), String>, String> {
        self.running.seek(SeekFrom::Start(0)).unwrap();
        self.running.write_all(input).unwrap();
        self.running.set_len(input.len() as u64).unwrap();
        COUNTER.reset_peak_usage();
        let before = COUNTER.current_usage();
        let start = Instant::now();
        BEGUN.store(now_ms(), Ordering::SeqCst);
        let answer = catch_unwind(AssertUnwindSafe(|| (self.target.read)(input)));
        BEGUN.store(0, Ordering::SeqCst);
        let (taken, peak) = (start.elapsed(), COUNTER.peak_usage().saturating_sub(before));
        match answer {
            Err(_) => Err(self.failure(input, &PANIC.lock().unwrap().clone())),
            Ok(_) if taken > SLOW => Err(self.failure(input, &format!("it took {taken:?}"))),
            Ok(_) if peak > budget(input.len()) => {
                let reason = format!("{peak} bytes were allocated for an input of {}", input.len());
                Err(self.failure(input, &reason))
            }
            Ok(answer) => Ok(answer),
        }
    }

    /// Keeps the input and tells how to read it again.
    fn failure(&self, input: &[u8], reason: &str) -> String {
        let name = self.target.name;
        let file = self
            .folder
            .join(format!("{name}-{}.bin", &blake3::hash(input).to_hex()[..12]));
        fs::write(&file, input).unwrap();
        format!(
            "{name}: {reason}\n  seed {}, input of {} bytes; again: BALAYAGE_FUZZ_INPUT={} ./run fuzz 1 {name}",
            self.seed,
            input.len(),
            file.display()
        )
    }
}

/// The words of a refusal without its numbers and without what it quotes.
fn kind(reason: &str) -> String {
    let mut quoted = false;
    let keep = |c: &char| {
        quoted ^= matches!(c, '"' | '`');
        !quoted && (c.is_ascii_alphabetic() || *c == ' ')
    };
    reason.chars().filter(keep).take(200).collect()
}

fn now_ms() -> u64 {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    1 + START.get_or_init(Instant::now).elapsed().as_millis() as u64
}

/// Ends the process when one input takes so long that it may never end; its `.running` file stays.
fn watch() {
    std::thread::spawn(|| {
        loop {
            std::thread::sleep(Duration::from_secs(1));
            let begun = BEGUN.load(Ordering::SeqCst);
            if begun > 0 && now_ms() - begun > 60_000 {
                let words = "fuzz: an input takes more than a minute; it stands in out/fuzz/*.running\n";
                let _ = std::io::stderr().write_all(words.as_bytes());
                std::process::abort();
            }
        }
    });
}
