//! The editor's state and one frame of it: news from threads, keys, panels.

use std::{path::PathBuf, sync::Arc};

use balayage_render::{
    gpu::{DebugView, FrameReport, Terms, ViewTransform},
    groom::{Mesh, ReadOptions},
    volume::VolumeSettings,
};
use egui::{Context, Panel, TextureHandle, Ui};

use super::{
    actions::{DialogAnswer, PendingAction},
    compare::Compare,
    job::Job,
    keymap::Keymap,
    lighting::{FitKey, Fitted},
    palette::Palette,
    panel_dye::DyeState,
    panel_light::LightTab,
    questions::Asking,
    settings::Settings,
    theme,
    viewer::{Frame, SceneInput, Viewer, ViewerEvent},
    viewport::Gesture,
};
use crate::{
    Problem,
    document::{Answers, CameraPose, Document, Lighting, Opened, Question, Source, UserState},
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
    /// What false colours mean, where they are shown.
    pub(super) legend: Option<String>,
}

/// How the picture is shown; no part of the project.
pub(super) struct ViewOptions {
    pub(super) transform: ViewTransform,
    pub(super) exposure_ev: f32,
    pub(super) terms: Terms,
    /// False colours in place of the picture.
    pub(super) debug: Option<DebugView>,
    pub(super) show_background: bool,
    /// Side of the hair volume's voxels in mean distances between fibres.
    pub(super) voxel_spacings: f32,
}

/// The tabs of the dock below the layers.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Tab {
    Brush,
    Hair,
    Operations,
    Light,
    History,
    Statistics,
}

/// The editor.
pub struct Editor {
    pub(super) document: Option<Document>,
    pub(super) lighting: Option<Lighting>,
    /// What `lighting` was or is being made for.
    pub(super) fitted_for: Option<FitKey>,
    pub(super) context: Context,
    pub(super) viewer: Viewer,
    /// What the viewer draws.
    pub(super) scene: Option<SceneInput>,
    pub(super) compare: Compare,
    pub(super) settings: Settings,
    pub(super) keymap: Keymap,
    pub(super) palette: Option<Palette>,
    /// The turntable runs.
    pub(super) turns: bool,
    pub(super) hides_panels: bool,
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
    /// It was asked for by name, without a key that is held.
    pub(super) keeps_before: bool,
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
            scene: None,
            compare: Compare::default(),
            settings: Settings::of_session(),
            keymap: Keymap::new(Default::default(), &Default::default()).0,
            palette: None,
            turns: false,
            hides_panels: false,
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
            keeps_before: false,
            tab: Tab::Brush,
            view: ViewOptions {
                transform: ViewTransform::Neutral,
                exposure_ev: 0.0,
                terms: Terms::ALL,
                debug: None,
                show_background: false,
                voxel_spacings: VolumeSettings::default().voxel_spacings,
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

    /// Points that were painted and that no picture has taken yet.
    pub fn points_to_draw(&self) -> usize {
        self.viewer.waiting_points()
    }

    /// The view as a project keeps it.
    pub fn camera_pose(&self) -> Option<CameraPose> {
        self.camera.map(|camera| camera.pose())
    }

    /// The newest message to the person.
    pub fn last_message(&self) -> Option<&str> {
        self.messages.last().map(|message| message.text.as_str())
    }

    /// Whether the newest picture is a draft; none before the first.
    pub fn is_draft(&self) -> Option<bool> {
        self.shown.as_ref().map(|shown| shown.is_draft)
    }

    /// The unpainted hair is shown.
    pub fn shows_before(&self) -> bool {
        self.shows_before
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
            legend: frame.legend,
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

    /// Shows the unpainted hair while its key is held, or until it is asked for again.
    fn show_before(&mut self, context: &Context) {
        let held = !context.text_edit_focused()
            && context.input(|input| self.keymap.is_down(super::Command::Before, input));
        let shows = held || self.keeps_before;
        let Some(document) = &self.document else { return };
        if shows != self.shows_before {
            self.shows_before = shows;
            let all = crate::paint::DirtyRanges::all(document.groom().point_count());
            if shows {
                self.viewer.set_params(&document.unpainted_params(), &all);
            } else {
                self.viewer.set_params(document.params(), &all);
            }
        }
    }
}

impl eframe::App for Editor {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        self.take_results(&context);
        self.take_pictures(&context);
        self.guard_close(&context);
        self.drive_turntable(&context);
        if self.guard.is_none()
            && self.palette.is_none()
            && self.asking.is_none()
            && !context.text_edit_focused()
        {
            while let Some(command) = context.input_mut(|input| self.keymap.pressed(input)) {
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
        if !self.hides_panels {
            Panel::left("tools")
                .resizable(false)
                .default_size(104.0)
                .show(ui, |ui| self.tool_bar(ui));
            Panel::right("dock")
                .default_size(348.0)
                .show(ui, |ui| self.right_dock(ui));
        }
        egui::CentralPanel::no_frame().show(ui, |ui| self.viewport(ui));
        self.palette_window(&context);
        self.guard_dialog(&context);
        self.question_dialog(&context);
        self.set_title(&context);
    }

    /// What was not saved was given up when the window closed; a journal is for those who had no choice.
    fn on_exit(&mut self) {
        self.give_up_document();
    }
}
