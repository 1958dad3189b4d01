//! Opening, saving and leaving documents in the editor.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use egui::Context;

use super::{
    Editor,
    editor::{Loaded, Opening},
    job::Job,
    questions::Asking,
    viewer::SceneInput,
};
use crate::{
    Problem,
    document::{Answers, LockError, OpenStep, ProjectLock, SaveOptions, Source, open_step},
    tool::ViewCamera,
};

impl Editor {
    /// Opens a project or groom in the background.
    pub fn open(&mut self, context: &Context, path: PathBuf) {
        self.start_opening(context, Source::File(path), Answers::default());
    }

    pub(super) fn open_sample(&mut self, context: &Context) {
        self.start_opening(context, Source::Sample, Answers::default());
    }

    /// Opens `source` as far as `answers` go.
    pub(super) fn start_opening(&mut self, context: &Context, source: Source, answers: Answers) {
        let name = match &source {
            Source::Sample => "the sample".to_owned(),
            Source::File(path) => path.display().to_string(),
        };
        self.request = (source.clone(), answers.clone());
        let state = self.state.clone();
        self.opening = Some(Job::start(format!("Opening {name}"), context, move |_| {
            let opened = match open_step(&source, &answers, &state)? {
                OpenStep::Ask(question) => return Ok(Opening::Ask(question)),
                OpenStep::Opened(opened) => *opened,
            };
            let head = match opened.document.load_head() {
                Err(_) if answers.goes_without => None,
                head => head?.map(Arc::new),
            };
            Ok(Opening::Loaded(Box::new(Loaded { opened, head })))
        }));
    }

    /// Saves the project to `path`; what waited for it goes on.
    pub fn save_to(&mut self, context: &Context, path: &Path) {
        self.save(context, path, false);
    }

    /// [`Editor::save_to`], over a file that another program has changed only where the person `overwrites` it.
    pub(super) fn save(&mut self, context: &Context, path: &Path, overwrites: bool) {
        let options = SaveOptions {
            // The version that somebody else wrote is never lost.
            backups: self.state.backups().max(u32::from(overwrites)),
            overwrites_changes: overwrites,
        };
        let pose = self.camera.map(|camera| camera.pose());
        let Some(document) = &mut self.document else {
            return;
        };
        if !overwrites && document.is_changed_on_disk(path) {
            self.asking = Some(Asking::Conflict(path.to_owned()));
            return;
        }
        let is_own = document.is_own(path);
        let lock = if is_own { Ok(None) } else { lock_for(path) };
        let saved = lock.and_then(|lock| {
            document.set_camera(pose)?;
            let saved = document.save_with(path, options, |_| Ok(()))?;
            if !is_own {
                document.set_lock(lock);
            }
            Ok(saved)
        });
        match saved {
            Ok(saved) => {
                for warning in saved.warnings {
                    self.say(warning);
                }
                self.say(format!("Saved {}", path.display()));
                self.remember_files();
                self.remember(path);
                if let Some(action) = self.after_save.take() {
                    self.proceed(context, action);
                }
            }
            Err(problem) => {
                self.after_save = None;
                self.complain(&problem);
            }
        }
    }

    /// Remembers where the document's files are: they are trusted, and searched when another project misses one.
    fn remember_files(&mut self) {
        let Some(document) = &self.document else { return };
        let (used, trusted) = document.used_files();
        if let Err(problem) = self.state.remember(&used, &trusted) {
            log::warn!("{problem}");
        }
    }

    /// Ends the document's journal: what is not saved is given up.
    pub(super) fn give_up_document(&mut self) {
        if let Some(document) = &mut self.document
            && let Err(problem) = document.discard_journal()
        {
            log::warn!("{problem}");
        }
    }

    /// Takes a document that was opened; the one before is given up.
    pub(super) fn take_document(&mut self, loaded: Loaded) {
        let Loaded { opened, head } = loaded;
        let mut document = opened.document;
        self.give_up_document();
        if let Some(before) = self
            .document
            .as_mut()
            .filter(|before| before.path() == document.path())
            && let Some(lock) = before.take_lock()
        {
            document.set_lock(Some(lock));
        }
        let bounds = document.groom().bounds();
        let pose = document.project().camera.as_ref();
        self.camera = pose
            .and_then(|pose| ViewCamera::from_pose(pose, bounds))
            .or_else(|| Some(ViewCamera::framing(bounds, self.aspect)));
        self.layer = document
            .project()
            .layers
            .last()
            .map(|layer| layer.id.clone())
            .unwrap_or_default();
        self.messages.clear();
        if opened.report.repairs() > 0 {
            self.say(opened.report.to_string());
        }
        for warning in opened.warnings {
            self.say(warning);
        }
        if self.messages.is_empty() {
            self.say("Drag over the hair to dye it. Alt+drag to look around.");
        }
        let (groom, path) = (document.groom_as_drawn(), document.path().map(Path::to_owned));
        self.compare.clear();
        self.document = Some(document);
        self.remember_files();
        if let Some(path) = path {
            self.remember(&path);
        }
        self.fitted_for = None;
        match groom {
            Ok(groom) => self.send_scene(SceneInput {
                groom,
                head,
                voxel_spacings: self.view.voxel_spacings,
            }),
            Err(problem) => self.complain(&problem),
        }
        self.refresh_light();
    }
}

/// The lock of a file that is to become the document's own; none where none can be kept.
fn lock_for(path: &Path) -> Result<Option<ProjectLock>, Problem> {
    match ProjectLock::take(path, false) {
        Ok(lock) => Ok(Some(lock)),
        Err(LockError::Impossible(_)) => Ok(None),
        Err(error) => {
            let remedy = "close it there, or save under another name";
            Err(Problem::at("", error.to_string(), remedy).in_file(path))
        }
    }
}
