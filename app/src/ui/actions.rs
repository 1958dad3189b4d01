//! Opening and saving in the background, what is dropped on the window, the question about unsaved changes.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use egui::{Context, ViewportCommand};

use super::{Command, Editor, editor::Loaded, job::Job, viewer::SceneInput};
use crate::{
    Problem,
    document::{Document, Environment, Opened},
    tool::ViewCamera,
};

/// What an unsaved document holds up.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum PendingAction {
    /// Opening a file after asking for it.
    AskToOpen,
    /// Opening this file.
    Open(PathBuf),
    /// Opening the sample.
    OpenSample,
    /// Closing the window.
    Quit,
}

/// What a file dialog was for, and the file.
pub(super) enum DialogAnswer {
    Open(PathBuf),
    SaveAs(PathBuf),
    Environment(PathBuf),
    Lights(PathBuf),
    SaveLights(PathBuf),
    Sequence(Vec<PathBuf>),
}

impl Editor {
    /// Opens a project or groom in the background.
    pub fn open(&mut self, context: &Context, path: PathBuf) {
        let name = path.display().to_string();
        self.start_opening(context, &name, move || Document::open(&path, None));
    }

    pub(super) fn open_sample(&mut self, context: &Context) {
        self.start_opening(context, "the sample", Document::sample);
    }

    fn start_opening(
        &mut self,
        context: &Context,
        name: &str,
        open: impl FnOnce() -> Result<Opened, Problem> + Send + 'static,
    ) {
        self.opening = Some(Job::start(format!("Opening {name}"), context, move |_| {
            let opened = open()?;
            let head = opened.document.load_head()?.map(Arc::new);
            Ok(Loaded { opened, head })
        }));
    }

    /// Saves the project to `path`; what waited for it goes on.
    pub fn save_to(&mut self, context: &Context, path: &Path) {
        let Some(document) = &mut self.document else {
            return;
        };
        let pose = self.camera.map(|camera| camera.pose());
        let saved = document.set_camera(pose).and_then(|()| document.save_as(path));
        match saved {
            Ok(()) => {
                self.say(format!("Saved {}", path.display()));
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

    /// Takes the results of background work.
    pub(super) fn take_results(&mut self, context: &Context) {
        if let Some(result) = self.opening.as_ref().and_then(Job::poll) {
            self.opening = None;
            match result {
                Ok(loaded) => self.take_document(loaded),
                Err(problem) => self.complain(&problem),
            }
        }
        self.take_lighting(context);
        if let Some(result) = self.dialog.as_ref().and_then(Job::poll) {
            self.dialog = None;
            match result {
                Ok(Some(answer)) => self.take_answer(context, answer),
                Ok(None) => self.after_save = None,
                Err(problem) => self.complain(&problem),
            }
        }
    }

    fn take_document(&mut self, loaded: Loaded) {
        let Loaded { opened, head } = loaded;
        let document = opened.document;
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
        if let Some(path) = path {
            self.remember(&path);
        }
        self.fitted_for = None;
        match groom {
            Ok(groom) => self.send_scene(SceneInput { groom, head }),
            Err(problem) => self.complain(&problem),
        }
        self.refresh_light();
    }

    fn take_answer(&mut self, context: &Context, answer: DialogAnswer) {
        match answer {
            DialogAnswer::Open(path) => self.open(context, path),
            DialogAnswer::SaveAs(path) => {
                let path = if path.extension().is_some() {
                    path
                } else {
                    path.with_extension("json")
                };
                self.save_to(context, &path);
            }
            DialogAnswer::Environment(path) => self.set_environment(&path, Environment::Map),
            DialogAnswer::Lights(path) => self.set_environment(&path, Environment::Lights),
            DialogAnswer::SaveLights(path) => self.save_lights(&path.with_extension("json")),
            DialogAnswer::Sequence(paths) => self.set_sequence(&paths),
        }
    }

    pub(super) fn ask_where_to_save(&mut self, context: &Context) {
        let dialog = rfd::AsyncFileDialog::new()
            .add_filter("Balayage projects", &["json"])
            .set_file_name("untitled.json")
            .save_file();
        self.dialog = Some(Job::start("Waiting for a file name", context, move |_| {
            let file = pollster::block_on(dialog);
            Ok(file.map(|file| DialogAnswer::SaveAs(file.path().to_owned())))
        }));
    }

    pub(super) fn ask_for_file(
        &mut self,
        context: &Context,
        what: &str,
        extensions: &[&str],
        answer: impl FnOnce(PathBuf) -> DialogAnswer + Send + 'static,
    ) {
        let dialog = rfd::AsyncFileDialog::new()
            .add_filter(what, extensions)
            .pick_file();
        self.dialog = Some(Job::start("Waiting for a file", context, move |_| {
            let file = pollster::block_on(dialog);
            Ok(file.map(|file| answer(file.path().to_owned())))
        }));
    }

    pub(super) fn ask_for_sequence(&mut self, context: &Context, is_folder: bool) {
        let dialog = rfd::AsyncFileDialog::new().add_filter("Environment maps", &["hdr", "exr"]);
        self.dialog = Some(Job::start("Waiting for maps", context, move |_| {
            let files = if is_folder {
                pollster::block_on(dialog.pick_folder()).map(|folder| vec![folder])
            } else {
                pollster::block_on(dialog.pick_files())
            };
            let paths = files.map(|files| files.iter().map(|file| file.path().to_owned()).collect());
            Ok(paths.map(DialogAnswer::Sequence))
        }));
    }

    pub(super) fn ask_where_to_save_lights(&mut self, context: &Context) {
        let dialog = rfd::AsyncFileDialog::new()
            .add_filter("Light lists", &["json"])
            .set_file_name("lights.json")
            .save_file();
        self.dialog = Some(Job::start("Waiting for a file name", context, move |_| {
            let file = pollster::block_on(dialog);
            Ok(file.map(|file| DialogAnswer::SaveLights(file.path().to_owned())))
        }));
    }

    /// Does `action` at once, or after the person said what shall become of unsaved changes.
    pub(super) fn guarded(&mut self, context: &Context, action: PendingAction) {
        if self.document.as_ref().is_some_and(Document::is_modified) {
            self.guard = Some(action);
        } else {
            self.proceed(context, action);
        }
    }

    fn proceed(&mut self, context: &Context, action: PendingAction) {
        match action {
            PendingAction::AskToOpen => {
                self.ask_for_file(
                    context,
                    "Projects and grooms",
                    &["json", "hair", "tfx", "usda", "usdc", "usd"],
                    DialogAnswer::Open,
                );
            }
            PendingAction::Open(path) => self.open(context, path),
            PendingAction::OpenSample => self.open_sample(context),
            PendingAction::Quit => {
                self.may_close = true;
                context.send_viewport_cmd(ViewportCommand::Close);
            }
        }
    }

    /// Holds the window back while there is something to lose.
    pub(super) fn guard_close(&mut self, context: &Context) {
        let (close, dropped) = context.input(|input| {
            (
                input.viewport().close_requested(),
                input.raw.dropped_files.clone(),
            )
        });
        if close && !self.may_close && self.document.as_ref().is_some_and(Document::is_modified) {
            context.send_viewport_cmd(ViewportCommand::CancelClose);
            self.guard = Some(PendingAction::Quit);
        }
        if !dropped.is_empty() {
            let paths: Vec<PathBuf> = dropped.iter().map(|file| file.path().to_owned()).collect();
            self.take_dropped(context, &paths);
        }
    }

    /// Files dropped on the window: a map becomes the environment, several or a folder a sequence, anything else is opened.
    fn take_dropped(&mut self, context: &Context, paths: &[PathBuf]) {
        let is_map = |path: &PathBuf| {
            let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
            extension == "hdr" || extension == "exr"
        };
        match paths {
            [path] if is_map(path) => self.set_environment(path, Environment::Map),
            [path] if path.is_dir() => self.set_sequence(paths),
            [_, _, ..] if paths.iter().all(is_map) => self.set_sequence(paths),
            [path, ..] => self.guarded(context, PendingAction::Open(path.clone())),
            [] => {}
        }
    }

    /// Asks what shall become of unsaved changes.
    pub(super) fn guard_dialog(&mut self, context: &Context) {
        let Some(action) = self.guard.clone() else { return };
        let answer = egui::Modal::new(egui::Id::unique("unsaved changes")).show(context, |ui| {
            ui.set_width(360.0);
            ui.heading("Unsaved changes");
            ui.label(format!(
                "{} has changes that are not saved.",
                self.document_name().trim_end_matches(" *")
            ));
            ui.horizontal(|ui| {
                let save = ui.button("Save").clicked();
                let discard = ui.button("Discard").clicked();
                let cancel = ui.button("Cancel").clicked();
                (save, discard, cancel)
            })
            .inner
        });
        let (save, discard, cancel) = answer.inner;
        if save {
            self.guard = None;
            self.after_save = Some(action);
            self.run(context, Command::Save);
        } else if discard {
            self.guard = None;
            self.proceed(context, action);
        } else if cancel || answer.should_close() {
            self.guard = None;
        }
    }
}
