//! What commands do: undo, layers, file dialogs, the question about unsaved changes.

use std::path::PathBuf;

use egui::{Context, ViewportCommand};

use super::{Command, Editor, editor::Opening, job::Job, questions::Asking};
use crate::{
    document::{Document, Edit, Environment, Layer, relink::Role},
    tool::{Tool, ViewCamera},
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
    Link(Role, PathBuf),
    Environment(PathBuf),
    Lights(PathBuf),
    SaveLights(PathBuf),
    Sequence(Vec<PathBuf>),
}

impl Editor {
    /// Whether `command` makes sense now.
    pub(super) fn is_enabled(&self, command: Command) -> bool {
        let document = self.document.as_ref();
        match command {
            Command::Undo => document.is_some_and(|document| document.undo_label().is_some()),
            Command::Redo => document.is_some_and(|document| document.redo_label().is_some()),
            Command::Open | Command::OpenSample => self.opening.is_none(),
            Command::Quit => true,
            Command::DeleteLight => self.selected_light().is_some(),
            Command::SaveLights => self.lighting.is_some(),
            Command::PlaySequence | Command::NextMap | Command::PreviousMap => self.sequence().is_some(),
            Command::MergeDown => document.is_some_and(|document| {
                document
                    .project()
                    .layers
                    .first()
                    .is_some_and(|layer| layer.id != self.layer)
            }),
            _ => document.is_some(),
        }
    }

    /// Does `command`, where it makes sense.
    pub fn run(&mut self, context: &Context, command: Command) {
        if !self.is_enabled(command) {
            return;
        }
        match command {
            Command::Open => self.guarded(context, PendingAction::AskToOpen),
            Command::OpenSample => self.guarded(context, PendingAction::OpenSample),
            Command::Quit => self.guarded(context, PendingAction::Quit),
            Command::Save => match self.document.as_ref().and_then(|document| document.path()) {
                Some(path) => {
                    let path = path.to_owned();
                    self.save_to(context, &path);
                }
                None => self.ask_where_to_save(context),
            },
            Command::SaveAs => self.ask_where_to_save(context),
            Command::Undo | Command::Redo => self.step_history(command == Command::Undo),
            Command::FrameHair => {
                self.camera = self
                    .document
                    .as_ref()
                    .map(|document| ViewCamera::framing(document.groom().bounds(), self.aspect));
            }
            Command::BrushSmaller => self.brush.scale_radius(1.0 / 1.15),
            Command::BrushLarger => self.brush.scale_radius(1.15),
            Command::BrushWeaker => self.brush.add_strength(-0.05),
            Command::BrushStronger => self.brush.add_strength(0.05),
            Command::AddLayer => self.add_layer(),
            Command::DuplicateLayer => self.duplicate_layer(),
            Command::MergeDown => self.merge_down(),
            Command::Eyedropper => self.tool = Tool::Eyedropper,
            Command::OpenEnvironment => {
                self.ask_for_file(
                    context,
                    "Environment maps",
                    &["hdr", "exr"],
                    DialogAnswer::Environment,
                );
            }
            Command::OpenLights => self.ask_for_file(context, "Light lists", &["json"], DialogAnswer::Lights),
            Command::OpenSequence => self.ask_for_sequence(context, false),
            Command::OpenSequenceFolder => self.ask_for_sequence(context, true),
            Command::PlaySequence => self.play_or_pause(),
            Command::NextMap => self.step_sequence(1),
            Command::PreviousMap => self.step_sequence(-1),
            Command::SaveLights => self.ask_where_to_save_lights(context),
            Command::DeleteLight => self.delete_selected_light(),
        }
    }

    fn step_history(&mut self, back: bool) {
        let Some(document) = &mut self.document else {
            return;
        };
        let stepped = if back { document.undo() } else { document.redo() };
        if let Some((label, changes)) = stepped {
            self.say(format!("{}: {label}", if back { "Undone" } else { "Done again" }));
            self.pass_on(&changes);
        }
    }

    /// A number that no layer has in its id.
    fn free_layer_number(&self) -> usize {
        let layers = self
            .document
            .as_ref()
            .map_or(&[][..], |document| &document.project().layers);
        (1..)
            .find(|n| layers.iter().all(|layer| layer.id != format!("layer-{n}")))
            .unwrap_or(1)
    }

    fn duplicate_layer(&mut self) {
        let id = format!("layer-{}", self.free_layer_number());
        self.edit(Edit::DuplicateLayer(self.layer.clone(), id.clone()));
        self.layer = id;
    }

    fn merge_down(&mut self) {
        let Some(document) = &self.document else { return };
        let layers = &document.project().layers;
        let position = layers.iter().position(|layer| layer.id == self.layer);
        let below = position
            .and_then(|position| position.checked_sub(1))
            .map(|below| layers[below].id.clone());
        let merged = std::mem::replace(&mut self.layer, below.unwrap_or_default());
        self.edit(Edit::MergeDown(merged.clone()));
        // Where merging was refused the layer is still there.
        let layers = self
            .document
            .as_ref()
            .map_or(&[][..], |document| &document.project().layers);
        if layers.iter().any(|layer| layer.id == merged) {
            self.layer = merged;
        }
    }

    fn add_layer(&mut self) {
        let Some(document) = &self.document else { return };
        let layers = &document.project().layers;
        let number = self.free_layer_number();
        let id = format!("layer-{number}");
        let edit = Edit::AddLayer(Layer::new(&id, format!("Layer {number}")), layers.len());
        self.edit(edit);
        self.layer = id;
    }

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

    fn ask_for_sequence(&mut self, context: &Context, is_folder: bool) {
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

    fn ask_where_to_save_lights(&mut self, context: &Context) {
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
