//! The picture, made on a thread with a device of its own: the window stays alive however long a frame takes, and a lost
//! device costs a frame, not the document. The newest request wins; what has not changed is not sent.

use std::{
    panic::{self, AssertUnwindSafe},
    sync::{
        Arc, Condvar, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::{Duration, Instant},
};

use balayage_render::{
    gpu::{Camera, DebugView, FrameReport, Gpu, GpuError, RenderSettings, Renderer},
    groom::{Groom, Mesh},
    light::{EnvironmentMap, LightSet},
    param::VertexParams,
    volume::VolumeSettings,
};
use glam::Vec3;

use crate::{pace::Pace, paint::DirtyRanges, tool::PickFrame};

/// A view that is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ViewRequest {
    pub(super) camera: Camera,
    /// Pixels of the viewport.
    pub(super) size: [u32; 2],
    pub(super) settings: RenderSettings,
    /// False colours in place of the picture.
    pub(super) debug: Option<DebugView>,
    pub(super) motion: Motion,
}

/// What the hand is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Motion {
    /// Nothing: the picture shall become sharp.
    Still,
    /// Painting: the view stays, the paint shall be seen at once.
    Painting,
    /// Camera, light or a slider moves: a quick picture is worth more than a sharp one.
    Moving,
}

/// How much is put into a picture.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Effort {
    /// Fewer pixels and nodes.
    Quick,
    /// As the last picture, only what was painted is new.
    Touch,
    /// Everything that was asked for, shadows from voxels.
    Full,
    /// Shadows refined by that many exact rays per point and light; with the last of them nothing is left to do.
    Refined(u32),
}

impl Effort {
    /// What follows when nothing changes, and after how long a rest.
    fn next(self) -> Option<(Self, Duration)> {
        match self {
            Self::Quick | Self::Touch => Some((Self::Full, REST)),
            Self::Full => Some((Self::Refined(FIRST_RAYS), LONG_REST)),
            // Slices, so that a hand that comes back waits for one of them only.
            Self::Refined(rays) if rays < REFINED_RAYS => Some((Self::Refined(2 * rays), Duration::ZERO)),
            Self::Refined(_) => None,
        }
    }
}

/// Strands and head.
#[derive(Clone)]
pub(super) struct SceneInput {
    pub(super) groom: Arc<Groom>,
    pub(super) head: Option<Arc<Mesh>>,
    /// Side of the hair volume's voxels in mean distances between fibres.
    pub(super) voxel_spacings: f32,
}

/// Lights and what is seen behind the hair.
#[derive(Clone)]
pub(super) struct LightInput {
    pub(super) lights: LightSet,
    pub(super) background: Option<Arc<EnvironmentMap>>,
    pub(super) turn_rad: f32,
    /// Exposure and tint.
    pub(super) scale: Vec3,
}

/// A picture that is done.
pub(super) struct Frame {
    /// Size of the picture and its sRGB bytes, straight alpha.
    pub(super) size: [usize; 2],
    pub(super) rgba: Vec<u8>,
    pub(super) picks: Option<PickFrame>,
    pub(super) report: FrameReport,
    pub(super) milliseconds: f64,
    pub(super) is_draft: bool,
    /// What false colours mean, where they are shown.
    pub(super) legend: Option<String>,
}

/// What the thread reports.
pub(super) enum ViewerEvent {
    /// The adapter that draws.
    Adapter(String),
    Frame(Box<Frame>),
    /// The picture could not be made; the next request starts anew.
    Failed(String),
    /// The device is gone; the picture is being made on another one.
    Lost(String),
}

/// What has changed since the thread last looked.
#[derive(Default)]
struct Inbox {
    scene: Option<SceneInput>,
    params: Option<(Vec<VertexParams>, DirtyRanges)>,
    light: Option<LightInput>,
    view: Option<ViewRequest>,
    destroy: bool,
    quit: bool,
}

impl Inbox {
    fn is_empty(&self) -> bool {
        self.scene.is_none()
            && self.params.is_none()
            && self.light.is_none()
            && self.view.is_none()
            && !self.destroy
            && !self.quit
    }
}

#[derive(Default)]
struct Shared {
    inbox: Mutex<Inbox>,
    wake: Condvar,
    /// True while the inbox holds something: a refinement under way is then given up.
    has_news: Arc<AtomicBool>,
    events: Mutex<Vec<ViewerEvent>>,
}

impl Shared {
    fn inbox(&self) -> MutexGuard<'_, Inbox> {
        self.inbox.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn events(&self) -> MutexGuard<'_, Vec<ViewerEvent>> {
        self.events.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The drawing thread as the editor sees it.
pub(super) struct Viewer {
    shared: Arc<Shared>,
    thread: Option<thread::JoinHandle<()>>,
    last_view: Option<ViewRequest>,
}

impl Viewer {
    /// Starts the thread; `context` is repainted whenever it has something to tell.
    pub(super) fn start(context: &egui::Context) -> Self {
        let shared = Arc::new(Shared::default());
        let worker = Worker::new(shared.clone(), context.clone());
        let thread = thread::spawn(move || worker.run());
        Self {
            shared,
            thread: Some(thread),
            last_view: None,
        }
    }

    /// Another groom or head; parameters have to follow.
    pub(super) fn set_scene(&mut self, scene: SceneInput) {
        self.send(|inbox| {
            inbox.scene = Some(scene);
            inbox.params = None;
        });
    }

    /// Parameters of every point, of which those in `dirty` changed.
    pub(super) fn set_params(&mut self, params: &[VertexParams], dirty: &DirtyRanges) {
        if dirty.is_empty() {
            return;
        }
        self.send(|inbox| {
            let mut dirty = dirty.clone();
            if let Some((_, earlier)) = &inbox.params {
                dirty.merge(earlier);
            }
            inbox.params = Some((params.to_vec(), dirty));
        });
    }

    pub(super) fn set_light(&mut self, light: LightInput) {
        self.send(|inbox| inbox.light = Some(light));
    }

    /// Asks for a view; the same view again is no request.
    pub(super) fn set_view(&mut self, view: ViewRequest) {
        if self.last_view != Some(view) {
            self.last_view = Some(view);
            self.send(|inbox| inbox.view = Some(view));
        }
    }

    /// Destroys the device under the renderer.
    pub(super) fn destroy_device(&self) {
        self.send(|inbox| inbox.destroy = true);
    }

    /// Points whose new parameters the thread has not taken yet.
    pub(super) fn waiting_points(&self) -> usize {
        let inbox = self.shared.inbox();
        inbox.params.as_ref().map_or(0, |(_, dirty)| dirty.point_count())
    }

    /// What was reported since the last call.
    pub(super) fn events(&mut self) -> Vec<ViewerEvent> {
        let mut events = std::mem::take(&mut *self.shared.events());
        if self.thread.as_ref().is_some_and(thread::JoinHandle::is_finished) {
            self.thread = None;
            events.push(ViewerEvent::Failed(
                "the drawing thread stopped unexpectedly: save the project and start again".to_owned(),
            ));
        }
        events
    }

    fn send(&self, change: impl FnOnce(&mut Inbox)) {
        let mut inbox = self.shared.inbox();
        change(&mut inbox);
        self.shared.has_news.store(true, Ordering::Relaxed);
        drop(inbox);
        self.shared.wake.notify_one();
    }
}

impl Drop for Viewer {
    /// Waits for the frame under way: a driver must not be unloaded under a thread that uses it.
    fn drop(&mut self) {
        self.send(|inbox| inbox.quit = true);
        if self.thread.take().is_some_and(|thread| thread.join().is_err()) {
            log::error!("the drawing thread had stopped unexpectedly");
        }
    }
}

/// A full frame faster than this needs no draft before it.
const QUICK_MS: f64 = 120.0;
/// How long nothing may change before a draft is sharpened.
const REST: Duration = Duration::from_millis(150);
/// How long nothing may change before shadows are refined by exact rays, and how many per point and light: at first and at last.
const LONG_REST: Duration = Duration::from_millis(1200);
const FIRST_RAYS: u32 = 2;
const REFINED_RAYS: u32 = 16;
/// Devices that are lost one after the other before the picture is given up until something changes.
const MAX_LOSSES: u32 = 2;

/// The thread's own side: everything that was sent, so that a renderer can be rebuilt from it.
struct Worker {
    shared: Arc<Shared>,
    context: egui::Context,
    renderer: Option<Renderer>,
    /// The renderer's device.
    gpu: Option<Gpu>,
    scene: Option<SceneInput>,
    params: Vec<VertexParams>,
    light: Option<LightInput>,
    view: Option<ViewRequest>,
    /// What the last picture was drawn with, where nothing but parameters changed since.
    last: Option<(ViewRequest, [u32; 2])>,
    last_full_ms: f64,
    /// Share of the strands of the last picture.
    touched_share: f32,
    pace: Pace,
}

impl Worker {
    fn new(shared: Arc<Shared>, context: egui::Context) -> Self {
        Self {
            shared,
            context,
            renderer: None,
            gpu: None,
            scene: None,
            params: Vec::new(),
            light: None,
            view: None,
            last: None,
            last_full_ms: f64::INFINITY,
            touched_share: 1.0,
            pace: Pace::unknown(false),
        }
    }

    fn run(mut self) {
        let mut pending = None;
        let mut losses = 0;
        loop {
            let inbox = self.next(pending.map(|(_, rest)| rest));
            if inbox.quit {
                return;
            }
            let due = pending.filter(|_| inbox.is_empty()).map(|(effort, _)| effort);
            let mut drawn = self.frame_or_reason(inbox, due);

            // Everything that the picture needs is on this side: a device that is gone is replaced and the picture made again.
            while let Err((reason, true)) = &drawn
                && losses < MAX_LOSSES
            {
                losses += 1;
                self.tell(ViewerEvent::Lost(reason.clone()));
                drawn = self.frame_or_reason(Inbox::default(), None);
            }
            pending = match drawn {
                Ok(drawn) => {
                    losses = 0;
                    drawn.and_then(Effort::next)
                }
                Err((reason, _)) => {
                    losses = 0;
                    self.tell(ViewerEvent::Failed(reason));
                    None
                }
            };
        }
    }

    /// [`Worker::frame`]; where it fails the renderer is given up, and the reason comes with whether another device may help.
    fn frame_or_reason(
        &mut self,
        inbox: Inbox,
        due: Option<Effort>,
    ) -> Result<Option<Effort>, (String, bool)> {
        // wgpu panics where the driver reports what it has no result for: out of memory, a device that went in mid-call.
        let drawn = panic::catch_unwind(AssertUnwindSafe(|| self.frame(inbox, due)));
        let failed = match drawn {
            Ok(Ok(drawn)) => return Ok(drawn),
            Ok(Err(error)) => (error.to_string(), matches!(error, GpuError::Lost(_))),
            Err(panicked) => {
                let text = panicked.downcast_ref::<String>().map(String::as_str);
                let text = text.or_else(|| panicked.downcast_ref::<&str>().copied());
                let text = text.unwrap_or("no reason given");
                (format!("the GPU driver stopped the drawing: {text}"), true)
            }
        };
        self.gpu = None;
        if let Some(renderer) = self.renderer.take() {
            // What a lost device does when its buffers are freed is the driver's business, too.
            let _ = panic::catch_unwind(AssertUnwindSafe(|| drop(renderer)));
        }
        Err(failed)
    }

    /// Waits for news; when a picture is to be sharpened, only until the hand has rested.
    fn next(&self, rest: Option<Duration>) -> Inbox {
        let inbox = self.shared.inbox();
        let inbox = if let Some(rest) = rest {
            let waited = self
                .shared
                .wake
                .wait_timeout_while(inbox, rest, |inbox| inbox.is_empty());
            waited.unwrap_or_else(PoisonError::into_inner).0
        } else {
            let waited = self.shared.wake.wait_while(inbox, |inbox| inbox.is_empty());
            waited.unwrap_or_else(PoisonError::into_inner)
        };
        let mut inbox = inbox;
        self.shared.has_news.store(false, Ordering::Relaxed);
        std::mem::take(&mut *inbox)
    }

    /// Takes what is new and draws, with the effort that is due or else what the news are worth; returns the effort of a picture of a view at rest.
    fn frame(&mut self, inbox: Inbox, due: Option<Effort>) -> Result<Option<Effort>, GpuError> {
        self.take(inbox)?;
        let (Some(view), Some(_), Some(_)) = (self.view, &self.scene, &self.light) else {
            return Ok(None);
        };
        if self.params.is_empty() {
            return Ok(None);
        }
        let effort = due.unwrap_or_else(|| self.effort(view));
        let start = Instant::now();
        let Some(renderer) = &mut self.renderer else {
            return Ok(None);
        };
        if effort != Effort::Full {
            renderer.prepare(&view.settings);
        }
        let mut settings = view.settings;
        let mut size = view.size;
        match (effort, self.last) {
            (Effort::Touch, Some((_, last_size))) => {
                settings = RenderSettings {
                    strand_share: self.touched_share,
                    ..self.pace.settings(settings)
                };
                size = last_size;
            }
            (Effort::Quick, _) => {
                settings = self.pace.settings(settings);
                size = self.pace.size(size);
            }
            (Effort::Refined(rays), _) => settings.visibility_rays = rays,
            _ => {}
        }
        self.touched_share = settings.strand_share;
        // Only what is drawn in a moment of rest is given up: a hand that never rests would see no picture at all.
        renderer.set_interrupt(due.is_some().then(|| self.shared.has_news.clone()));
        let report = match renderer.render(&view.camera, size, &settings) {
            Err(GpuError::Interrupted) => return Ok(None),
            drawn => drawn?,
        };
        let (rgba, legend) = match view.debug {
            None => (renderer.shown_bytes()?, None),
            Some(debug) => {
                let colours = renderer.debug_view(&view.camera, size, &settings, debug)?;
                (colours.rgba(), Some(colours.legend()))
            }
        };
        let picks = Some(PickFrame {
            camera: view.camera,
            picks: renderer.picks()?,
        });
        let milliseconds = start.elapsed().as_secs_f64() * 1e3;
        match effort {
            Effort::Full => self.last_full_ms = milliseconds,
            Effort::Quick => self.pace.learn(milliseconds),
            Effort::Touch | Effort::Refined(_) => {}
        }
        self.last = Some((view, size));
        let size = size.map(|side| side as usize);
        self.tell(ViewerEvent::Frame(Box::new(Frame {
            size,
            rgba,
            picks,
            report,
            milliseconds,
            is_draft: effort != Effort::Refined(REFINED_RAYS),
            legend,
        })));
        Ok((view.motion == Motion::Still).then_some(effort))
    }

    /// What the next picture is worth after a change. Frames that are quick anyway get everything.
    fn effort(&self, view: ViewRequest) -> Effort {
        let same_view = self.last.is_some_and(|(last, ..)| {
            (last.camera, last.size, last.settings, last.debug)
                == (view.camera, view.size, view.settings, view.debug)
        });
        match view.motion {
            Motion::Painting if same_view => Effort::Touch,
            Motion::Painting | Motion::Moving => Effort::Quick,
            Motion::Still if self.last_full_ms < QUICK_MS => Effort::Full,
            Motion::Still if same_view => Effort::Touch,
            Motion::Still => Effort::Quick,
        }
    }

    /// Brings the renderer up to date; one that is missing is built and gets everything.
    fn take(&mut self, inbox: Inbox) -> Result<(), GpuError> {
        if let Some(gpu) = self.gpu.as_ref().filter(|_| inbox.destroy) {
            gpu.device.destroy();
            self.last = None;
        }
        let fresh = self.renderer.is_none();
        let new_scene = inbox.scene.is_some();
        if inbox.scene.is_some() {
            self.scene = inbox.scene;
            self.params.clear();
        }
        let mut dirty = DirtyRanges::none();
        if let Some((params, changed)) = inbox.params {
            self.params = params;
            dirty = changed;
        }
        let new_light = inbox.light.is_some();
        let shown_map = self.light.as_ref().and_then(|light| light.background.clone());
        self.light = inbox.light.or(self.light.take());
        self.view = inbox.view.or(self.view);
        let (Some(scene), Some(light)) = (&self.scene, &self.light) else {
            return Ok(());
        };

        if fresh {
            let gpu = Gpu::headless()?;
            self.tell(ViewerEvent::Adapter(gpu.adapter_name.clone()));
            self.pace = Pace::unknown(gpu.is_software);
            self.renderer = Some(Renderer::new(&gpu)?);
            self.gpu = Some(gpu);
        }
        let Some(renderer) = &mut self.renderer else {
            return Ok(());
        };
        if fresh || new_scene || new_light {
            self.last = None;
        }
        if fresh || new_scene {
            renderer.set_volume(VolumeSettings {
                voxel_spacings: scene.voxel_spacings,
                ..VolumeSettings::default()
            });
            renderer.set_groom(&scene.groom, scene.head.as_deref())?;
        }
        if fresh || new_scene {
            dirty = DirtyRanges::all(self.params.len());
        }
        if self.params.len() == scene.groom.point_count() && !dirty.is_empty() {
            renderer.set_params(&self.params, dirty.ranges())?;
        }
        if fresh || new_light {
            renderer.set_lights(&light.lights);
            // A map is large: turning the light does not send it again.
            let is_shown = match (&shown_map, &light.background) {
                (Some(shown), Some(map)) => Arc::ptr_eq(shown, map),
                (None, None) => true,
                _ => false,
            };
            if fresh || !is_shown {
                renderer.set_background(light.background.as_deref())?;
            }
            renderer.turn_background(light.turn_rad, light.scale);
        }
        Ok(())
    }

    fn tell(&self, event: ViewerEvent) {
        self.shared.events().push(event);
        self.context.request_repaint();
    }
}
