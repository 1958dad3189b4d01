//! The editor's state and one frame of it: news from threads, keys, panels.

use std::{path::PathBuf, sync::Arc};

use balayage_render::{
    gpu::{FrameReport, Terms, ViewTransform},
    groom::{Mesh, ReadOptions},
};
use egui::{Context, Panel, TextureHandle, Ui};

use super::{
    actions::{DialogAnswer, PendingAction},
    command::Command,
    job::Job,
    lighting::{FitKey, Fitted},
    panel_dye::DyeState,
    panel_light::LightTab,
    questions::Asking,
    theme,
    viewer::{Frame, SceneInput, Viewer, ViewerEvent},
    viewport::Gesture,
};
use crate::{
    Problem,
    document::{Answers, Changes, Document, Edit, Lighting, Opened, Question, Source, UserState},
    tool::{Brush, PickFrame, Tool, ViewCamera},
};

/// A file that was opened, with what has to be read beside it.
pub(super) struct Loaded {
    pub(super) opened: Opened,
    pub(super) head: Option<Arc<Mesh>>,
}

/// What opening came to: a document, or a question to the person.
pub(super) enum Opening {
    Loaded(Box<Loaded>),
    Ask(Question),
}

/// A line for the person.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Message {
    pub(super) text: String,
    pub(super) is_error: bool,
}

/// The picture that is shown and what it cost.
pub(super) struct Shown {
    pub(super) texture: TextureHandle,
    pub(super) picks: Option<PickFrame>,
    pub(super) report: FrameReport,
    pub(super) milliseconds: f64,
    pub(super) is_draft: bool,
}

/// How the picture is shown; no part of the project.
pub(super) struct ViewOptions {
    pub(super) transform: ViewTransform,
    pub(super) exposure_ev: f32,
    pub(super) terms: Terms,
    pub(super) show_background: bool,
    pub(super) blender_keys: bool,
}

/// The tabs of the dock below the layers.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Tab {
    Brush,
    Hair,
    Operations,
    Light,
    History,
}

/// The editor.
pub struct Editor {
    pub(super) document: Option<Document>,
    pub(super) lighting: Option<Lighting>,
    /// What `lighting` was or is being made for.
    pub(super) fitted_for: Option<FitKey>,
    pub(super) context: Context,
    pub(super) viewer: Viewer,
    pub(super) camera: Option<ViewCamera>,
    /// Width to height of the viewport.
    pub(super) aspect: f32,
    pub(super) shown: Option<Shown>,
    pub(super) adapter: Option<String>,
    pub(super) tool: Tool,
    pub(super) brush: Brush,
    pub(super) dyes: DyeState,
    /// The eyedropper takes the seen colour instead of the stored value.
    pub(super) picks_seen_colour: bool,
    /// A pen's pressure; 1 for anything without.
    pub(super) pressure: f32,
    /// What the lasso has drawn so far, in points of the screen.
    pub(super) outline: Vec<glam::Vec2>,
    pub(super) layer: String,
    /// The operation that is being adjusted, by its place in the project's list.
    pub(super) operation: Option<usize>,
    /// The unpainted hair is shown.
    shows_before: bool,
    pub(super) tab: Tab,
    pub(super) view: ViewOptions,
    pub(super) gesture: Gesture,
    /// The widget whose drag the newest history entry belongs to.
    pub(super) slider: Option<egui::Id>,
    pub(super) light_tab: LightTab,
    pub(super) opening: Option<Job<Opening>>,
    /// What is being opened, and what the person has said about it so far.
    pub(super) request: (Source, Answers),
    /// What only the person can decide.
    pub(super) asking: Option<Asking>,
    /// What is remembered from session to session.
    pub(super) state: UserState,
    pub(super) fitting: Option<Job<Fitted>>,
    pub(super) dialog: Option<Job<Option<DialogAnswer>>>,
    /// What waits for the person's answer to "unsaved changes".
    pub(super) guard: Option<PendingAction>,
    /// What follows once the project is saved.
    pub(super) after_save: Option<PendingAction>,
    pub(super) may_close: bool,
    pub(super) messages: Vec<Message>,
    pub(super) frames_shown: u64,
    title: String,
}

impl Editor {
    /// An editor that opens `open`, or the built-in sample.
    pub fn new(context: &Context, open: Option<PathBuf>) -> Self {
        Self::with_state(context, open, ReadOptions::default(), UserState::of_user())
    }

    /// [`Editor::new`] that reads the groom with `reading`, with another memory of earlier sessions.
    pub fn with_state(
        context: &Context,
        open: Option<PathBuf>,
        reading: ReadOptions,
        state: UserState,
    ) -> Self {
        theme::apply(context);
        let mut editor = Self {
            document: None,
            lighting: None,
            fitted_for: None,
            context: context.clone(),
            viewer: Viewer::start(context),
            camera: None,
            aspect: 1.4,
            shown: None,
            adapter: None,
            tool: Tool::default(),
            brush: Brush::default(),
            dyes: DyeState::default(),
            picks_seen_colour: false,
            pressure: 1.0,
            outline: Vec::new(),
            layer: String::new(),
            operation: None,
            shows_before: false,
            tab: Tab::Brush,
            view: ViewOptions {
                transform: ViewTransform::Neutral,
                exposure_ev: 0.0,
                terms: Terms::ALL,
                show_background: false,
                blender_keys: false,
            },
            gesture: Gesture::None,
            slider: None,
            light_tab: LightTab::default(),
            opening: None,
            request: (Source::Sample, Answers::default()),
            asking: None,
            state,
            fitting: None,
            dialog: None,
            guard: None,
            after_save: None,
            may_close: false,
            messages: Vec::new(),
            frames_shown: 0,
            title: String::new(),
        };
        match open {
            Some(path) => {
                let answers = Answers {
                    reading,
                    ..Answers::default()
                };
                editor.start_opening(context, Source::File(path), answers);
            }
            None => editor.open_sample(context),
        }
        editor
    }

    /// The open document.
    pub fn document(&self) -> Option<&Document> {
        self.document.as_ref()
    }

    /// Number of pictures shown so far.
    pub fn frames_shown(&self) -> u64 {
        self.frames_shown
    }

    /// True while a file is opened or lights are fitted.
    pub fn is_busy(&self) -> bool {
        self.opening.is_some() || self.fitting.is_some()
    }

    /// The newest message to the person.
    pub fn last_message(&self) -> Option<&str> {
        self.messages.last().map(|message| message.text.as_str())
    }

    /// Whether the newest picture is a draft; none before the first.
    pub fn is_draft(&self) -> Option<bool> {
        self.shown.as_ref().map(|shown| shown.is_draft)
    }

    /// Destroys the device that draws, as a driver or a pulled cable would.
    pub fn destroy_device(&mut self) {
        self.viewer.destroy_device();
    }

    pub(super) fn say(&mut self, text: impl Into<String>) {
        self.messages.push(Message {
            text: text.into(),
            is_error: false,
        });
    }

    pub(super) fn complain(&mut self, problem: &Problem) {
        log::error!("{problem}");
        self.messages.push(Message {
            text: problem.to_string(),
            is_error: true,
        });
    }

    /// Applies an edit and passes on what it changed.
    pub(super) fn edit(&mut self, edit: Edit) {
        let Some(document) = &mut self.document else {
            return;
        };
        let result = document.apply(edit);
        self.took(result);
    }

    /// Applies an edit of a slider; the changes of one drag are one history entry.
    pub(super) fn edit_by(&mut self, response: &egui::Response, edit: Edit) {
        let Some(document) = &mut self.document else {
            return;
        };
        let continues = self.slider == Some(response.id);
        let is_held = response
            .ctx
            .input(|input| input.pointer.any_down() || input.pointer.any_released());
        self.slider = is_held.then_some(response.id);
        let result = if continues {
            document.apply_continuing(edit)
        } else {
            document.apply(edit)
        };
        self.took(result);
    }

    /// Applies an edit that goes on from the newest one where that was of the same kind, as typing does.
    pub(super) fn edit_on(&mut self, edit: Edit) {
        let Some(document) = &mut self.document else {
            return;
        };
        let result = document.apply_continuing(edit);
        self.took(result);
    }

    fn took(&mut self, result: Result<Changes, Problem>) {
        match result {
            Ok(changes) => self.pass_on(&changes),
            Err(problem) => self.complain(&problem),
        }
    }

    /// Tells the viewer what changed.
    pub(super) fn pass_on(&mut self, changes: &Changes) {
        let Some(document) = &self.document else { return };
        self.viewer.set_params(document.params(), &changes.points);
        if changes.light {
            self.refresh_light();
        }
        if changes.head || changes.diameter {
            self.refresh_scene();
        }
        let layers = &document_layers(self.document.as_ref());
        if !layers.contains(&self.layer) {
            self.layer = layers.last().cloned().unwrap_or_default();
        }
    }

    /// Sends groom, head and all parameters.
    pub(super) fn refresh_scene(&mut self) {
        let Some(document) = &self.document else { return };
        let scene = document.groom_as_drawn().and_then(|groom| {
            Ok(SceneInput {
                groom,
                head: document.load_head()?.map(Arc::new),
            })
        });
        match scene {
            Ok(scene) => self.send_scene(scene),
            Err(problem) => self.complain(&problem),
        }
    }

    pub(super) fn send_scene(&mut self, scene: SceneInput) {
        let Some(document) = &self.document else { return };
        let all = crate::paint::DirtyRanges::all(document.groom().point_count());
        self.viewer.set_scene(scene);
        self.viewer.set_params(document.params(), &all);
    }

    /// Takes what the drawing thread reports.
    fn take_pictures(&mut self, context: &Context) {
        for event in self.viewer.events() {
            match event {
                ViewerEvent::Adapter(name) => self.adapter = Some(name),
                ViewerEvent::Frame(frame) => self.show(context, *frame),
                ViewerEvent::Failed(reason) => {
                    let remedy = "the document is safe; change anything to try again";
                    self.complain(&Problem::at("picture", reason, remedy));
                }
                ViewerEvent::Lost(reason) => {
                    let text = format!("picture: {reason}; the document is safe, the picture is made anew");
                    log::warn!("{text}");
                    self.say(text);
                }
            }
        }
    }

    fn show(&mut self, context: &Context, frame: Frame) {
        let image = egui::ColorImage::from_rgba_unmultiplied(frame.size, &frame.rgba);
        let options = egui::TextureOptions::LINEAR;
        let texture = match self.shown.take() {
            Some(mut shown) => {
                shown.texture.set(image, options);
                shown.texture
            }
            None => context.load_texture("picture", image, options),
        };
        self.shown = Some(Shown {
            texture,
            picks: frame.picks,
            report: frame.report,
            milliseconds: frame.milliseconds,
            is_draft: frame.is_draft,
        });
        self.frames_shown += 1;
    }

    /// Names the window after the project.
    fn set_title(&mut self, context: &Context) {
        let title = format!("{} - Balayage", self.document_name());
        if title != self.title {
            context.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    /// The project's file name, with a star where there is something to save.
    pub(super) fn document_name(&self) -> String {
        let Some(document) = &self.document else {
            return "…".to_owned();
        };
        let name = document.path().and_then(|path| path.file_name());
        let name = name.map_or_else(|| "untitled".into(), |name| name.to_string_lossy());
        format!("{name}{}", if document.is_modified() { " *" } else { "" })
    }

    fn menu_bar(&mut self, ui: &mut Ui) {
        use Command as C;
        let menus: [(&str, &[C]); 4] = [
            ("File", &[C::Open, C::OpenSample, C::Save, C::SaveAs, C::Quit]),
            ("Edit", &[C::Undo, C::Redo]),
            (
                "Hair",
                &[
                    C::FrameHair,
                    C::AddLayer,
                    C::DuplicateLayer,
                    C::MergeDown,
                    C::Eyedropper,
                ],
            ),
            (
                "Light",
                &[
                    C::OpenEnvironment,
                    C::OpenLights,
                    C::OpenSequence,
                    C::OpenSequenceFolder,
                    C::PlaySequence,
                    C::NextMap,
                    C::PreviousMap,
                    C::SaveLights,
                    C::DeleteLight,
                ],
            ),
        ];
        egui::MenuBar::new().ui(ui, |ui| {
            for (name, commands) in menus {
                ui.menu_button(name, |ui| {
                    for command in commands {
                        self.menu_item(ui, *command);
                    }
                    if name == "File" {
                        self.backups_setting(ui);
                    }
                });
            }
            ui.menu_button("View", |ui| self.view_menu(ui));
            ui.separator();
            ui.label(self.document_name());
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                for command in [C::Redo, C::Undo] {
                    let button = ui.add_enabled(self.is_enabled(command), egui::Button::new(command.label()));
                    if button.on_hover_text(self.explain(command)).clicked() {
                        self.run(ui.ctx(), command);
                    }
                }
            });
        });
    }

    fn menu_item(&mut self, ui: &mut Ui, command: Command) {
        let keys = command
            .shortcuts()
            .first()
            .map(|keys| ui.ctx().format_shortcut(keys))
            .unwrap_or_default();
        let button = egui::Button::new(command.label()).shortcut_text(keys);
        if ui.add_enabled(self.is_enabled(command), button).clicked() {
            ui.close();
            self.run(ui.ctx(), command);
        }
    }

    fn view_menu(&mut self, ui: &mut Ui) {
        for (transform, name) in [
            (ViewTransform::Neutral, "Khronos PBR Neutral"),
            (ViewTransform::Agx, "AgX"),
            (ViewTransform::Raw, "Raw"),
        ] {
            ui.radio_value(&mut self.view.transform, transform, name);
        }
        ui.separator();
        ui.checkbox(&mut self.view.show_background, "Show environment");
        self.handles_checkbox(ui);
        ui.checkbox(&mut self.view.blender_keys, "Blender navigation")
            .on_hover_text(
                "Middle button orbits, Shift+middle pans; otherwise Alt with left, middle, right button",
            );
    }

    /// What a toolbar button will do, with its key.
    fn explain(&self, command: Command) -> String {
        let what = match (command, &self.document) {
            (Command::Undo, Some(document)) => document.undo_label(),
            (Command::Redo, Some(document)) => document.redo_label(),
            _ => None,
        };
        format!("{} {}", command.label(), what.unwrap_or("nothing"))
    }

    fn tool_bar(&mut self, ui: &mut Ui) {
        for tool in Tool::ALL {
            ui.selectable_value(&mut self.tool, tool, tool.name())
                .on_hover_text(tool.hint());
        }
    }

    fn right_dock(&mut self, ui: &mut Ui) {
        egui::ScrollArea::vertical().show(ui, |ui| {
            ui.heading("Layers");
            self.layers_panel(ui);
            ui.separator();
            ui.horizontal(|ui| {
                for (tab, name) in [
                    (Tab::Brush, "Brush"),
                    (Tab::Hair, "Hair"),
                    (Tab::Light, "Light"),
                    (Tab::Operations, "Operations"),
                    (Tab::History, "History"),
                ] {
                    ui.selectable_value(&mut self.tab, tab, name);
                }
            });
            match self.tab {
                Tab::Brush => self.brush_panel(ui),
                Tab::Hair => self.hair_panel(ui),
                Tab::Light => self.light_panel(ui),
                Tab::Operations => self.operations_panel(ui),
                Tab::History => self.history_panel(ui),
            }
        });
    }
}

impl Editor {
    /// Follows a pen's pressure; a mouse presses fully.
    fn read_pen(&mut self, context: &Context) {
        context.input(|input| {
            for event in &input.events {
                match event {
                    egui::Event::Touch {
                        force: Some(force), ..
                    } => self.pressure = force.clamp(0.0, 1.0),
                    egui::Event::MouseMoved(_) => self.pressure = 1.0,
                    _ => {}
                }
            }
        });
    }

    /// Shows the unpainted hair while B is held.
    fn show_before(&mut self, context: &Context) {
        let held =
            !context.egui_wants_keyboard_input() && context.input(|input| input.key_down(egui::Key::B));
        let Some(document) = &self.document else { return };
        if held != self.shows_before {
            self.shows_before = held;
            let all = crate::paint::DirtyRanges::all(document.groom().point_count());
            if held {
                self.viewer.set_params(&document.unpainted_params(), &all);
            } else {
                self.viewer.set_params(document.params(), &all);
            }
        }
    }
}

/// Ids of the layers, lowest first.
fn document_layers(document: Option<&Document>) -> Vec<String> {
    document.map_or_else(Vec::new, |document| {
        document
            .project()
            .layers
            .iter()
            .map(|layer| layer.id.clone())
            .collect()
    })
}

impl eframe::App for Editor {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        self.take_results(&context);
        self.take_pictures(&context);
        self.guard_close(&context);
        if self.guard.is_none() && self.asking.is_none() && !context.egui_wants_keyboard_input() {
            while let Some(command) = context.input_mut(Command::pressed) {
                self.run(&context, command);
            }
        }
        if context.input(|input| !input.pointer.any_down() && !input.pointer.any_released()) {
            self.slider = None;
        }
        self.drive_sequence(&context);
        self.read_pen(&context);
        self.show_before(&context);
        self.refresh_colours();

        Panel::top("menu").show(ui, |ui| self.menu_bar(ui));
        Panel::bottom("status").show(ui, |ui| self.status_bar(ui));
        Panel::left("tools")
            .resizable(false)
            .default_size(104.0)
            .show(ui, |ui| self.tool_bar(ui));
        Panel::right("dock")
            .default_size(324.0)
            .show(ui, |ui| self.right_dock(ui));
        egui::CentralPanel::no_frame().show(ui, |ui| self.viewport(ui));
        self.guard_dialog(&context);
        self.question_dialog(&context);
        self.set_title(&context);
    }

    /// What was not saved was given up when the window closed; a journal is for those who had no choice.
    fn on_exit(&mut self) {
        self.give_up_document();
    }
}
