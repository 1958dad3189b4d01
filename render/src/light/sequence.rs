//! Environments that change: every frame is fitted from the lights of the one before.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::error::Refusal;
use super::{EnvironmentMap, FitError, FitSettings, InputError, LightSet, Progress, fit_lights};

/// Frame after frame fitted from the lights before; the first from a seed.
#[derive(Clone, Debug)]
pub struct Sequence {
    count: usize,
    seed: u64,
    lights: Option<LightSet>,
}

impl Sequence {
    /// A sequence of `count` lights a frame; `from` are lights of a similar map, such as those on screen.
    pub fn new(count: usize, seed: u64, from: Option<LightSet>) -> Self {
        Self {
            count,
            seed,
            lights: from,
        }
    }

    /// Fits the next frame and keeps its lights for the one after.
    ///
    /// # Errors
    /// As [`fit_lights`]; the lights of the last good frame then stay.
    pub fn step(&mut self, map: &EnvironmentMap, progress: Progress) -> Result<&LightSet, FitError> {
        let settings = FitSettings {
            count: self.count,
            seed: self.seed,
            from: self.lights.as_ref(),
            ..FitSettings::default()
        };
        let lights = fit_lights(map, &settings, progress)?;
        Ok(self.lights.insert(lights))
    }

    /// The lights of the last good frame.
    pub fn lights(&self) -> Option<&LightSet> {
        self.lights.as_ref()
    }
}

/// The maps (.hdr, .exr) of a folder in the order of their names.
///
/// # Errors
/// [`InputError`] where the folder cannot be read or holds no map.
pub fn frames(folder: &Path) -> Result<Vec<PathBuf>, InputError> {
    let refused = |reason: String| {
        Refusal::new(
            "whole folder",
            reason,
            "name a folder of numbered .hdr or .exr maps",
        )
        .of(folder)
    };
    let entries = std::fs::read_dir(folder).map_err(|error| refused(error.to_string()))?;
    let mut files = Vec::new();
    for entry in entries {
        let path = entry.map_err(|error| refused(error.to_string()))?.path();
        let extension = path.extension().and_then(|text| text.to_str());
        if extension.is_some_and(|text| {
            ["hdr", "exr"]
                .iter()
                .any(|known| text.eq_ignore_ascii_case(known))
        }) {
            files.push(path);
        }
    }
    if files.is_empty() {
        return Err(refused("it holds no environment map".to_owned()));
    }
    files.sort();
    Ok(files)
}

/// What is there to show of a playback.
#[derive(Clone, Debug, Default)]
pub struct Playing {
    /// Index of the frame that `lights` belong to.
    pub frame: usize,
    /// How many frames were fitted so far; a change says that there are new lights.
    pub fitted: usize,
    /// Lights of the last good frame; none before the first.
    pub lights: Option<Arc<LightSet>>,
    /// The last frame that was refused; playing goes on.
    pub refused: Option<InputError>,
}

/// Maps that play in a loop on a thread of their own; frames that cannot be fitted in time are left out. Dropping it stops it.
pub struct Playback {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    playing: Mutex<Playing>,
    stopped: AtomicBool,
    wake: Condvar,
}

impl Shared {
    /// What is shown; a panic elsewhere leaves it whole, as it is only ever replaced field by field.
    fn playing(&self) -> MutexGuard<'_, Playing> {
        self.playing.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until `end` or until it is stopped.
    fn wait(&self, end: Instant) {
        let left = end.saturating_duration_since(Instant::now());
        let going = |_: &mut Playing| !self.stopped.load(Ordering::Acquire);
        let guard = self.wake.wait_timeout_while(self.playing(), left, going);
        drop(guard);
    }
}

impl Playback {
    /// Plays `frames` at `rate` frames a second (at least one frame in 1000 s, at most 1000 a second) from `sequence` on;
    /// `on_frame` is called after every frame, from the thread that fits.
    pub fn start(
        frames: Vec<PathBuf>,
        rate: f64,
        sequence: Sequence,
        on_frame: impl Fn() + Send + 'static,
    ) -> Self {
        let shared = Arc::new(Shared::default());
        let of_thread = shared.clone();
        let thread = thread::spawn(move || play(&of_thread, &frames, rate, sequence, on_frame));
        Self {
            shared,
            thread: Some(thread),
        }
    }

    /// What to show now.
    pub fn playing(&self) -> Playing {
        self.shared.playing().clone()
    }

    /// Asks the thread to stop without waiting for it: it does within some hundredths of a second.
    pub fn stop(&self) {
        // The lock makes sure that a thread about to wait sees either the flag or the call.
        let guard = self.shared.playing();
        self.shared.stopped.store(true, Ordering::Release);
        drop(guard);
        self.shared.wake.notify_all();
    }
}

impl Drop for Playback {
    fn drop(&mut self) {
        self.stop();
        if let Some(thread) = self.thread.take() {
            // A panic on the thread was told there; here there is nothing left to do.
            let _ = thread.join();
        }
    }
}

fn play(shared: &Shared, frames: &[PathBuf], rate: f64, mut sequence: Sequence, on_frame: impl Fn()) {
    if frames.is_empty() {
        return;
    }
    let rate = if rate.is_finite() {
        rate.clamp(1e-3, 1e3)
    } else {
        1.0
    };
    let go_on = |_| {
        if shared.stopped.load(Ordering::Acquire) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let start = Instant::now();
    let mut tick = 0_u64;
    while go_on(0.0).is_continue() {
        let index = (tick % frames.len() as u64) as usize;
        match EnvironmentMap::read(&frames[index]) {
            Ok((map, _)) => {
                if let Ok(lights) = sequence.step(&map, &go_on) {
                    let lights = Some(Arc::new(lights.clone()));
                    let mut playing = shared.playing();
                    playing.frame = index;
                    playing.fitted += 1;
                    playing.lights = lights;
                }
            }
            Err(error) => shared.playing().refused = Some(error),
        }
        if go_on(0.0).is_break() {
            return;
        }
        on_frame();

        // The next frame is the one that is due; what came late is skipped.
        tick = (tick + 1).max((start.elapsed().as_secs_f64() * rate) as u64);
        shared.wait(start + Duration::from_secs_f64(tick as f64 / rate));
    }
}
