//! Long work off the UI thread: a share done, a way to stop it, a result.

use std::{
    ops::ControlFlow,
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU32, Ordering},
        mpsc::{self, Receiver, TryRecvError},
    },
    thread,
    time::{Duration, Instant},
};

use crate::Problem;

/// What the work sees of the job.
pub(super) struct JobControl {
    done: Arc<AtomicU32>,
    cancelled: Arc<AtomicBool>,
    context: egui::Context,
}

impl JobControl {
    /// Tells the share that is done, in [0, 1]; breaks once the job was cancelled.
    pub(super) fn progress(&self, share: f64) -> ControlFlow<()> {
        self.done
            .store((share.clamp(0.0, 1.0) * 1000.0) as u32, Ordering::Relaxed);
        self.context.request_repaint();
        if self.cancelled.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// Work on a thread of its own.
pub(super) struct Job<T> {
    what: String,
    started: Instant,
    done: Arc<AtomicU32>,
    cancelled: Arc<AtomicBool>,
    result: Receiver<Result<T, Problem>>,
}

impl<T: Send + 'static> Job<T> {
    /// Starts `work`; `context` is repainted when it ends.
    pub(super) fn start(
        what: impl Into<String>,
        context: &egui::Context,
        work: impl FnOnce(&JobControl) -> Result<T, Problem> + Send + 'static,
    ) -> Self {
        let (sender, result) = mpsc::channel();
        let (done, cancelled) = (Arc::new(AtomicU32::new(0)), Arc::new(AtomicBool::new(false)));
        let control = JobControl {
            done: done.clone(),
            cancelled: cancelled.clone(),
            context: context.clone(),
        };
        thread::spawn(move || {
            let outcome = work(&control);
            // Nobody listens to a job that was dropped.
            let _ = sender.send(outcome);
            control.context.request_repaint();
        });
        Self {
            what: what.into(),
            started: Instant::now(),
            done,
            cancelled,
            result,
        }
    }

    /// The result, once; none while the work goes on.
    pub(super) fn poll(&self) -> Option<Result<T, Problem>> {
        match self.result.try_recv() {
            Ok(result) => Some(result),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => {
                let reason = format!("{} stopped unexpectedly", self.what);
                Some(Err(Problem::at("", reason, "try again; if it stays, report it")))
            }
        }
    }

    /// What is done.
    pub(super) fn what(&self) -> &str {
        &self.what
    }

    /// The share that is done, in [0, 1].
    pub(super) fn share(&self) -> f32 {
        self.done.load(Ordering::Relaxed) as f32 / 1000.0
    }

    /// How long it will still take, where that can be told.
    pub(super) fn time_left(&self) -> Option<Duration> {
        let share = self.share();
        (share > 0.05).then(|| self.started.elapsed().mul_f32((1.0 - share) / share))
    }

    /// Asks the work to stop.
    pub(super) fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }
}
