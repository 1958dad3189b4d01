//! Results of background work, file dialogs, what is dropped on the window, the question about unsaved changes.

use std::path::PathBuf;

use egui::{Context, ViewportCommand};

use super::{Command, Editor, editor::Opening, job::Job, questions::Asking};
use crate::document::{Document, Environment, relink::Role};

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
    Link(Role, PathBuf),
    Environment(PathBuf),
    Lights(PathBuf),
    SaveLights(PathBuf),
    Sequence(Vec<PathBuf>),
}

impl Editor {
    /// Takes the results of background work.
    pub(super) fn take_results(&mut self, context: &Context) {
        if let Some(result) = self.opening.as_ref().and_then(Job::poll) {
            self.opening = None;
            match result {
                Ok(Opening::Loaded(loaded)) => self.take_document(*loaded),
                Ok(Opening::Ask(question)) => self.asking = Some(Asking::Opening(question)),
                Err(problem) => self.complain(&problem),
            }
        }
        if let Some(problem) = self.document.as_mut().and_then(Document::take_journal_problem) {
            self.complain(&problem);
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
            DialogAnswer::Link(role, path) => {
                let (source, mut answers) = self.request.clone();
                answers.files.push((role, path));
                self.asking = None;
                self.start_opening(context, source, answers);
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

    pub(super) fn proceed(&mut self, context: &Context, action: PendingAction) {
        match action {
            PendingAction::AskToOpen => {
                self.ask_for_file(
                    context,
                    "Projects and grooms",
                    &["json", "hair", "tfx", "usda", "usdc", "usd", "abc"],
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
