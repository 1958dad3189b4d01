//! The frame: what is stale and seen is brought up to date, in the order of the crate's front page, then drawn.

mod debug_view;
mod tiles;
mod vertices;

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use glam::Vec3;

use super::camera::{Camera, CameraUniform};
use super::head::{HeadBuffers, HeadPass, HeadShade, HeadTarget};
use super::pick_map::PickMap;
use super::raster::{PictureBuffers, Raster, ResolveInputs, ResolveUniform};
use super::report::FrameReport;
use super::scene_lights::{LightChange, SceneLights};
use super::shade::{ShadeInputs, ShadePass, ShadeSettings};
use super::stale::{Changes, Input, Product};
use super::strands::StrandBuffers;
use super::transmittance::{MeanFibre, Transmittance, VolumeReport};
use super::view::{ViewPass, ViewTransform};
pub use debug_view::{DebugView, FalseColours};

use super::{Gpu, GpuError, Quality, Saving, Savings};
use crate::groom::{DEFAULT_MAX_TURN_RAD, Groom, Mesh, RefinedGroom, undergrowth};
use crate::image::Picture;
use crate::light::{EnvironmentMap, LightSet};
use crate::param::VertexParams;
use crate::volume::{Occluder, VolumeSettings};

/// How a frame is drawn; what is drawn is the renderer's state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSettings {
    /// What light does.
    pub shade: ShadeSettings,
    /// Camera samples a pixel (>= 1); coverage is exact with one, more smooth the shading between vertices.
    pub samples: u32,
    /// Display transform.
    pub view: ViewTransform,
    /// Display exposure in stops, on the picture only.
    pub view_exposure_ev: f32,
    /// Shows the environment behind the hair.
    pub show_background: bool,
    /// Display-linear colour behind the picture, a = 0: transparent.
    pub backdrop: [f32; 4],
    /// Exact rays per point and light that visibility comes from; 0: from the density of the voxels. More rays are a refinement: what was
    /// traced for a picture stays for the next ones until strands or lights change.
    pub visibility_rays: u32,
    /// True while a hand moves something: what light loses on its way through freshly painted hair stays as it was (the paint itself is
    /// shown), so that only painted vertices are shaded again, and so do other things that [`Saving`] names. The next frame without it
    /// brings everything up to date.
    pub interactive: bool,
    /// Share of the strands that is drawn, each wider, so that the hair's area stays; 1: all of them.
    pub strand_share: f32,
    /// What need not be done.
    pub savings: Savings,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            shade: ShadeSettings::default(),
            samples: 1,
            view: ViewTransform::Neutral,
            view_exposure_ev: 0.0,
            show_background: false,
            backdrop: [0.0; 4],
            visibility_rays: 0,
            interactive: false,
            strand_share: 1.0,
            savings: Savings::ALL,
        }
    }
}

impl RenderSettings {
    /// The settings with the savings that their quality bears: the highest is there to be compared with.
    fn of_its_quality(&self) -> Self {
        let mut settings = *self;
        if settings.shade.method.quality == Quality::High {
            settings.savings = settings.savings.exact();
        }
        settings
    }
}

/// Everything on the GPU that one view of one groom needs; a cache of what the caller owns.
pub struct Renderer {
    gpu: Gpu,
    raster: Raster,
    head_pass: HeadPass,
    head_shade: HeadShade,
    shade: ShadePass,
    view: ViewPass,
    transmittance: Transmittance,
    scene: Option<SceneBuffers>,
    lights: SceneLights,
    /// Lights to be taken by the next frame.
    next_lights: Option<LightSet>,
    background: Background,
    target: Option<PictureBuffers>,
    last: Option<LastFrame>,
    /// What changed since the last frame.
    changes: Changes,
    lag: Lag,
    /// Number of the frame, from 1 on; whole and exact up to 2^24.
    frame: f32,
    /// Bytes of parameters that were sent since the last frame.
    sent_bytes: u64,
}

/// What the last frame was drawn with.
#[derive(Clone, Copy)]
struct LastFrame {
    camera: Camera,
    size: [u32; 2],
    settings: RenderSettings,
    /// Segments drawn and the factor on their width.
    sample: (u32, f32),
}

/// What interactive frames left behind.
#[derive(Clone, Copy, Default)]
struct Lag {
    /// Where the eye was that multiple scattering was evaluated for, if it has moved since.
    multiple_eye: Option<Vec3>,
    /// Whether single lights were taken away and added: rounding adds up.
    few_lights: bool,
}

/// What belongs to one groom.
struct SceneBuffers {
    strands: StrandBuffers,
    params: wgpu::Buffer,
    has_elliptic: bool,
    point_count: usize,
    head: Option<HeadBuffers>,
    head_target: HeadTarget,
    near: f32,
    centre: Vec3,
    /// Mean fibre diameter, groom units.
    diameter: f32,
}

/// Fibre width in pixels below which fewer, wider strands stand for all, and the least share of them.
const FINE_PX: f32 = 0.04;
const LEAST_SHARE: f32 = 1.0 / 64.0;

/// Turn of the eye round the hair, radians, that multiple scattering bears while a hand moves.
const TURNING_RAD: f32 = 2.0 * std::f32::consts::PI / 180.0;

/// The environment behind the picture.
struct Background {
    pixels: wgpu::Buffer,
    size: Option<[u32; 2]>,
    turn_rad: f32,
    scale: Vec3,
}

impl Renderer {
    /// Compiles the passes.
    ///
    /// # Errors
    /// [`GpuError::Refused`] when a shader does not compile on this adapter.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            raster: Raster::new(gpu)?,
            head_pass: HeadPass::new(gpu)?,
            head_shade: HeadShade::new(gpu)?,
            shade: ShadePass::new(gpu)?,
            view: ViewPass::new(gpu)?,
            transmittance: Transmittance::new(gpu)?,
            scene: None,
            lights: SceneLights::dark(gpu)?,
            next_lights: None,
            background: Background {
                pixels: gpu.storage("background", 16)?,
                size: None,
                turn_rad: 0.0,
                scale: Vec3::ONE,
            },
            target: None,
            last: None,
            changes: Changes::ALL,
            lag: Lag::default(),
            frame: 0.0,
            sent_bytes: 0,
            gpu: gpu.clone(),
        })
    }

    /// Takes a groom and the head that it grows on; parameters have to follow.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`].
    pub fn set_groom(&mut self, groom: &Groom, head: Option<&Mesh>) -> Result<VolumeReport, GpuError> {
        let gpu = &self.gpu;
        let refined = RefinedGroom::new(groom, DEFAULT_MAX_TURN_RAD);
        let occluder = head.map(|mesh| Occluder {
            positions: mesh.positions(),
            triangles: mesh.triangles(),
        });
        let report = self.transmittance.set_strands(
            gpu,
            &groom.into(),
            occluder.as_ref(),
            &VolumeSettings::default(),
        )?;
        let (low, high) = groom.bounds();
        self.scene = Some(SceneBuffers {
            strands: StrandBuffers::new(gpu, &refined)?,
            params: gpu.storage(
                "vertex parameters",
                (size_of::<VertexParams>() * groom.point_count()) as u64,
            )?,
            has_elliptic: true,
            point_count: groom.point_count(),
            centre: 0.5 * (low + high),
            diameter: groom.diameters().iter().sum::<f32>() / groom.point_count() as f32,
            head: head
                .map(|mesh| HeadBuffers::new(gpu, mesh, &undergrowth(mesh, groom)))
                .transpose()?,
            head_target: HeadTarget::new(gpu, [1, 1])?,
            near: 1e-3 * low.distance(high),
        });
        self.raster.forget();
        self.changes.note(Input::Geometry);
        Ok(report)
    }

    /// Takes the parameters of the groom points in `dirty` (of all where it is empty) from `params`, one entry a groom point.
    ///
    /// # Errors
    /// [`GpuError::Refused`] when `params` has another length than the groom or a range lies outside.
    pub fn set_params(&mut self, params: &[VertexParams], dirty: &[Range<u32>]) -> Result<(), GpuError> {
        let whole = 0..params.len() as u32;
        let dirty = if dirty.is_empty() {
            std::slice::from_ref(&whole)
        } else {
            dirty
        };
        let scene = self.scene.as_mut().filter(|scene| {
            scene.point_count == params.len()
                && dirty
                    .iter()
                    .all(|r| r.start <= r.end && r.end as usize <= params.len())
        });
        let Some(scene) = scene else {
            return Err(GpuError::Refused {
                what: "the parameter buffer".to_owned(),
                reason: format!("{} entries do not fit the groom that was set", params.len()),
            });
        };
        let is_whole = *dirty == [whole.clone()];
        scene.has_elliptic &= !is_whole;
        for range in dirty {
            let slice = &params[range.start as usize..range.end as usize];
            let offset = u64::from(range.start) * size_of::<VertexParams>() as u64;
            self.gpu
                .queue
                .write_buffer(&scene.params, offset, bytemuck::cast_slice(slice));
            self.sent_bytes += size_of_val(slice) as u64;
            scene.has_elliptic |= slice.iter().any(|p| p.eccentricity != 1.0);
        }
        scene.strands.forget_points(&self.gpu, dirty);
        self.transmittance
            .set_params(&scene.params, MeanFibre::of(params), dirty);
        self.changes.note(Input::Parameters);
        Ok(())
    }

    /// Takes the lights, rotated and exposed as they shall be seen.
    pub fn set_lights(&mut self, set: &LightSet) {
        self.next_lights = Some(set.clone());
    }

    /// Takes the map that is shown behind the hair when the settings ask for it; `None`: nothing to show.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`].
    pub fn set_background(&mut self, map: Option<&EnvironmentMap>) -> Result<(), GpuError> {
        self.background.size = None;
        if let Some(map) = map {
            let pixels: Vec<[f32; 4]> = map.pixels.iter().map(|p| p.extend(1.0).to_array()).collect();
            self.background.pixels = self.gpu.storage_of("background", &pixels)?;
            self.background.size = Some([map.width as u32, map.height as u32]);
        }
        self.changes.note(Input::Background);
        Ok(())
    }

    /// Turns the background about y and scales its radiance (rgb), as was done to the lights.
    pub fn turn_background(&mut self, turn_rad: f32, scale: Vec3) {
        if (self.background.turn_rad, self.background.scale) != (turn_rad, scale) {
            self.changes.note(Input::Background);
        }
        self.background.turn_rad = turn_rad;
        self.background.scale = scale;
    }

    /// While the flag is true a refinement by exact rays is given up ([`GpuError::Interrupted`]): the hand has moved on.
    pub fn set_interrupt(&mut self, interrupt: Option<Arc<AtomicBool>>) {
        self.transmittance.set_interrupt(interrupt);
    }

    /// Draws what is stale; nothing where nothing has changed since the last frame.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] for pictures that the adapter cannot hold, [`GpuError::Refused`] without a groom, [`GpuError::Interrupted`],
    /// [`GpuError::Lost`].
    pub fn render(
        &mut self,
        camera: &Camera,
        size: [u32; 2],
        settings: &RenderSettings,
    ) -> Result<FrameReport, GpuError> {
        let mut report = FrameReport::default();
        let gpu = self.gpu.clone();
        let settings = &settings.of_its_quality();
        let sent_bytes = std::mem::take(&mut self.sent_bytes);
        if sent_bytes > 0 {
            report.count("parameter bytes uploaded", sent_bytes);
        }
        if size.contains(&0) {
            return Err(refused("it has no pixels"));
        }
        let scene = self.scene.as_ref().ok_or_else(|| refused("no groom was given"))?;
        let now = LastFrame {
            camera: *camera,
            size,
            settings: *settings,
            sample: scene.strands.sample(scene.share(camera, size, settings)),
        };
        self.transmittance.set_model(&gpu, settings.shade.method.model)?;
        self.transmittance
            .set_visibility_source(&gpu, settings.shade.visibility)?;
        self.note_changes(&now);
        let mut few = self.take_lights(settings, &mut report)?;
        let (changes, stale) = (self.changes, self.changes.stale());
        self.frame += 1.0;

        if let (true, Some(head)) = (
            stale.has(Product::Head),
            self.scene.as_ref().and_then(|s| s.head.as_ref()),
        ) {
            report.time(&gpu, "head shading", |_| {
                let lights = &self.lights;
                self.head_shade.run(
                    &gpu,
                    head,
                    &self.transmittance,
                    &lights.buffer,
                    lights.lights.len(),
                );
                Ok(())
            })?;
            report.count("head vertices shaded", u64::from(head.vertex_count));
        }
        if stale.has(Product::Picture) {
            let scene = self.scene.as_mut().ok_or_else(|| refused("no groom was given"))?;
            if self.target.as_ref().is_none_or(|target| target.size != size) {
                self.target = Some(PictureBuffers::new(&gpu, size)?);
                self.raster.forget();
                if scene.head.is_some() {
                    scene.head_target = HeadTarget::new(&gpu, size)?;
                }
            }
            let target = self
                .target
                .as_ref()
                .ok_or_else(|| refused("it was not allocated"))?;
            if !settings.savings.has(Saving::Unseen) {
                scene.strands.want_everything(&gpu);
            } else if stale.has(Product::Fragments) {
                // What another view showed is not wanted any more.
                scene.strands.want_nothing(&gpu);
            }
            if stale.has(Product::Fragments) {
                self.raster.forget();
            }
            let scene: &SceneBuffers = scene;
            let (start, timed_before) = (Instant::now(), report.total_ms());
            let shades = [Product::Single, Product::Multiple, Product::Fragments];
            let shades = shades.into_iter().any(|product| stale.has(product));
            let mut shade = || {
                if !shades {
                    return Ok(());
                }
                let done = report.time(&gpu, "transmittance", |_| {
                    let wanted = Some(&scene.strands.wanted_points);
                    self.transmittance
                        .update(&gpu, wanted, settings.interactive, settings.visibility_rays)
                })?;
                // What a vertex was shaded with has changed where better rays were traced.
                if done.exact_rays > 0 {
                    scene.strands.single_work.forget_all(&gpu);
                }
                report.count("voxels painted", done.painted_voxels);
                report.count("visibility rays", done.visibility_rays);
                report.count("exact rays", done.exact_rays);
                report.count("path rays", done.path_rays);
                // New losses change what every point gets from the light's way.
                if done.painted_voxels > 0 {
                    scene.strands.multiple_work.forget_all(&gpu);
                }
                let inputs = scene.shade_inputs(&self.lights, &self.transmittance, &now, self.frame);
                report.time(&gpu, "strand shading", |report| {
                    if let Some(few) = few.take() {
                        let done = self
                            .shade
                            .add(&gpu, &settings.shade, &scene.strands, &inputs, &few)?;
                        report.count_shading(&done);
                    }
                    let done = self.shade.run(&gpu, &settings.shade, &scene.strands, &inputs)?;
                    report.count_shading(&done);
                    Ok(())
                })
            };
            let samples = Samples {
                gpu: &gpu,
                head_pass: &self.head_pass,
                background: &self.background,
                scene,
                target,
                gain: self.lights.gain,
                frame: self.frame,
                is_head_stale: stale.has(Product::Head),
                // Where nothing but radiance on the strands changed, pixels without such strands stay.
                keeps_pixels: settings.savings.has(Saving::Untouched)
                    && !stale.has(Product::Head)
                    && !changes.has(Input::LightGain)
                    && !changes.has(Input::Background),
            };
            let fragments = samples.draw(&mut self.raster, &now, &mut shade)?;
            gpu.wait()?;
            let shading_ms = report.total_ms() - timed_before;
            report.add_time("strand drawing", start.elapsed().as_secs_f64() * 1e3 - shading_ms);
            report.count("fragments", fragments);
            report.count("strand segments drawn", u64::from(now.sample.0));
        }
        if stale.has(Product::View) {
            let target = self
                .target
                .as_ref()
                .ok_or_else(|| refused("it was not allocated"))?;
            report.time(&gpu, "view", |_| {
                let scale = settings.view_exposure_ev.exp2();
                self.view
                    .run(&gpu, target, settings.view, scale, settings.backdrop);
                Ok(())
            })?;
        }
        self.last = Some(now);
        self.changes = Changes::default();
        Ok(report)
    }

    /// Notes what differs between the last frame and this one, and forgets the shading that it makes stale.
    fn note_changes(&mut self, now: &LastFrame) {
        let Some(last) = self.last else {
            self.changes = Changes::ALL;
            return;
        };
        let (old, new) = (&last.settings, &now.settings);
        let coarsest = |settings: &RenderSettings| {
            let mut shade = settings.shade;
            shade.method.quality = Quality::Draft;
            shade
        };
        let noted = [
            (Input::Eye, last.camera.position() != now.camera.position()),
            (
                Input::Lens,
                (last.camera, last.size, last.sample) != (now.camera, now.size, now.sample)
                    || old.samples != new.samples,
            ),
            (
                Input::Method,
                coarsest(old) != coarsest(new) || old.savings != new.savings,
            ),
            (
                Input::Quality,
                (new.shade.method.quality as u32) > old.shade.method.quality as u32
                    || old.visibility_rays != new.visibility_rays,
            ),
            (Input::Parameters, self.transmittance.lags() && !new.interactive),
            (Input::Background, old.show_background != new.show_background),
            (
                Input::Display,
                (old.view, old.view_exposure_ev, old.backdrop)
                    != (new.view, new.view_exposure_ev, new.backdrop),
            ),
        ];
        for (input, _) in noted.into_iter().filter(|(_, changed)| *changed) {
            self.changes.note(input);
        }
        let Some(scene) = &self.scene else { return };
        let (single, multiple) = (&scene.strands.single_work, &scene.strands.multiple_work);
        if !new.savings.has(Saving::Untouched) {
            self.changes = Changes::ALL;
            self.transmittance.forget();
        }
        if self.changes.has(Input::Method) || self.changes.has(Input::Geometry) {
            single.forget_all(&self.gpu);
            multiple.forget_all(&self.gpu);
            self.lag = Lag::default();
        }
        // What a moving hand left behind is done once it rests.
        if !new.interactive && self.lag.few_lights {
            single.forget_all(&self.gpu);
            multiple.forget_all(&self.gpu);
            self.changes.note(Input::Quality);
            self.lag = Lag::default();
        }
        if self.changes.has(Input::Eye) {
            single.forget_all(&self.gpu);
        }
        if self.changes.has(Input::Eye) || self.lag.multiple_eye.is_some() {
            let from = self.lag.multiple_eye.unwrap_or(last.camera.position());
            let turn = (from - scene.centre).angle_between(now.camera.position() - scene.centre);
            if new.interactive && new.savings.has(Saving::Turning) && turn <= TURNING_RAD {
                self.lag.multiple_eye = Some(from);
            } else {
                multiple.forget_all(&self.gpu);
                self.lag.multiple_eye = None;
                self.changes.note(Input::Quality);
            }
        }
    }

    /// Takes the lights that were given since the last frame. Where only a few changed their contribution is taken away, and they are
    /// returned to be added again.
    fn take_lights(
        &mut self,
        settings: &RenderSettings,
        report: &mut FrameReport,
    ) -> Result<Option<Vec<u32>>, GpuError> {
        let (Some(next), Some(scene)) = (self.next_lights.take(), &self.scene) else {
            return Ok(None);
        };
        // Only in the view of the last frame is it known which vertices are wanted.
        let is_same_view = !self.changes.stale().has(Product::Fragments);
        let savings = settings.savings;
        let gpu = &self.gpu;
        match self.lights.change(
            next,
            savings,
            settings.interactive && is_same_view,
            &self.transmittance,
        ) {
            LightChange::Nothing => Ok(None),
            LightChange::Gain(gain) => {
                self.lights.gain = gain;
                self.changes.note(Input::LightGain);
                Ok(None)
            }
            LightChange::Few(few, set) => {
                let Some(last) = &self.last else {
                    return Ok(None);
                };
                let dark = self.lights.negative(gpu)?;
                let inputs = ShadeInputs {
                    lights: &dark,
                    ..scene.shade_inputs(&self.lights, &self.transmittance, last, self.frame)
                };
                report.time(gpu, "strand shading", |report| {
                    let done = self
                        .shade
                        .add(gpu, &settings.shade, &scene.strands, &inputs, &few)?;
                    report.count_shading(&done);
                    Ok(())
                })?;
                self.lights.take(gpu, set, self.lights.gain)?;
                let moved = self.transmittance.set_lights(gpu, &self.lights.lights)?;
                self.changes.note(light_input(&moved));
                self.lag.few_lights = true;
                Ok(Some(few))
            }
            LightChange::All(set) => {
                self.lights.take(gpu, set, Vec3::ONE)?;
                let moved = self.transmittance.set_lights(gpu, &self.lights.lights)?;
                self.changes.note(light_input(&moved));
                scene.strands.forget_shading(gpu);
                Ok(None)
            }
        }
    }

    /// The last picture, scene-linear and premultiplied.
    ///
    /// # Errors
    /// [`GpuError::Refused`] before the first frame, [`GpuError::Lost`].
    pub fn picture(&self) -> Result<Picture, GpuError> {
        let target = self.drawn()?;
        let [width, height] = target.size.map(|n| n as usize);
        Ok(Picture {
            width,
            height,
            pixels: self.gpu.read(&target.picture, width * height)?,
        })
    }

    /// The last picture as it is shown, sRGB bytes with straight alpha.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    pub fn shown_bytes(&self) -> Result<Vec<u8>, GpuError> {
        self.view.bytes(&self.gpu)
    }

    /// The texture that [`Self::shown_bytes`] reads; another one after a change of size.
    pub fn shown(&self) -> &wgpu::Texture {
        &self.view.shown
    }

    /// Pixels of the last picture that are not finite; the view shows them in magenta.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    pub fn non_finite(&self) -> Result<u32, GpuError> {
        self.view.non_finite(&self.gpu)
    }

    /// What strand is seen at every pixel of the last picture.
    ///
    /// # Errors
    /// [`GpuError::Refused`] before the first frame, [`GpuError::Lost`].
    pub fn picks(&self) -> Result<PickMap, GpuError> {
        let target = self.drawn()?;
        let [width, height] = target.size;
        Ok(PickMap {
            width,
            height,
            entries: self.gpu.read(&target.picks, width as usize * height as usize)?,
        })
    }

    fn drawn(&self) -> Result<&PictureBuffers, GpuError> {
        self.target
            .as_ref()
            .filter(|_| self.last.is_some())
            .ok_or_else(|| GpuError::Refused {
                what: "the picture".to_owned(),
                reason: "no frame was drawn yet".to_owned(),
            })
    }
}

/// What changes with lights some of which are marched in another way.
fn light_input(moved: &[u32]) -> Input {
    if moved.is_empty() {
        Input::LightColours
    } else {
        Input::LightPlaces
    }
}

fn refused(reason: &str) -> GpuError {
    GpuError::Refused {
        what: "the picture".to_owned(),
        reason: reason.to_owned(),
    }
}

impl SceneBuffers {
    /// Share of the strands to draw.
    fn share(&self, camera: &Camera, size: [u32; 2], settings: &RenderSettings) -> f32 {
        let wanted = settings.strand_share.clamp(LEAST_SHARE, 1.0);
        if !settings.savings.has(Saving::Levels) {
            return wanted;
        }
        let uniform = CameraUniform::new(camera, size, [0.0; 2], self.near, 0);
        let distance = camera.position().distance(self.centre).max(self.near);
        let width_px = self.diameter * uniform.focal_px / distance;
        wanted.min((width_px / FINE_PX).clamp(LEAST_SHARE, 1.0))
    }

    fn shade_inputs<'a>(
        &'a self,
        lights: &'a SceneLights,
        transmittance: &'a Transmittance,
        now: &LastFrame,
        frame: f32,
    ) -> ShadeInputs<'a> {
        ShadeInputs {
            camera_position: now.camera.position(),
            params: &self.params,
            has_elliptic: self.has_elliptic,
            lights: &lights.buffer,
            real_light_count: lights.real_count(),
            constant: lights.constant(),
            transmittance,
            savings: now.settings.savings,
            frame,
        }
    }
}

/// The camera samples of a picture.
struct Samples<'a> {
    gpu: &'a Gpu,
    head_pass: &'a HeadPass,
    background: &'a Background,
    scene: &'a SceneBuffers,
    target: &'a PictureBuffers,
    gain: Vec3,
    frame: f32,
    is_head_stale: bool,
    keeps_pixels: bool,
}

impl Samples<'_> {
    /// Adds them up, each after `shade` has brought the vertices that it shows up to date; returns the number of fragments made.
    fn draw(
        &self,
        raster: &mut Raster,
        now: &LastFrame,
        shade: &mut impl FnMut() -> Result<(), GpuError>,
    ) -> Result<u64, GpuError> {
        let Self {
            gpu,
            scene,
            background,
            target,
            ..
        } = self;
        let settings = &now.settings;
        let samples = settings.samples.max(1);
        let uniform = |sample: u32| CameraUniform {
            width_factor: now.sample.1,
            ..CameraUniform::new(
                &now.camera,
                target.size,
                subpixel(sample),
                scene.near,
                now.sample.0,
            )
        };
        let is_held = samples == 1 && raster.holds(&uniform(0));
        let touched_only = is_held && self.keeps_pixels;
        if !touched_only {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            encoder.clear_buffer(&target.picture, 0, None);
            gpu.queue.submit([encoder.finish()]);
        }
        let shown_background = background.size.filter(|_| settings.show_background);
        let mut fragments = 0;
        for sample in 0..samples {
            let uniform = uniform(sample);
            if let (Some(head), true) = (&scene.head, !is_held || self.is_head_stale) {
                self.head_pass.draw(gpu, &uniform, head, &scene.head_target);
            }
            let resolve = ResolveUniform {
                world_from_view: now.camera.world_from_camera.to_cols_array_2d(),
                weight: 1.0 / samples as f32,
                has_head: u32::from(scene.head.is_some()),
                has_background: u32::from(shown_background.is_some()),
                background_turn_rad: background.turn_rad,
                background_scale: background.scale.to_array(),
                frame: self.frame,
                gain: self.gain.to_array(),
                pad: 0,
                background_size: shown_background.unwrap_or([1, 1]),
                pad_end: [0; 2],
            };
            let inputs = ResolveInputs {
                strands: &scene.strands,
                head: &scene.head_target,
                background: &background.pixels,
                target,
                has_head: scene.head.is_some(),
                interpolates_straight: settings.savings.has(Saving::Straight),
                touched_only,
            };
            fragments += raster.draw(gpu, &uniform, &resolve, &inputs, &mut *shade)?;
        }
        Ok(fragments)
    }
}

/// Offset of a camera sample in pixels: the R2 sequence (Roberts 2018), the first one at the pixel's centre.
fn subpixel(sample: u32) -> [f32; 2] {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    [1.0 / PLASTIC, 1.0 / (PLASTIC * PLASTIC)]
        .map(|step| ((0.5 + f64::from(sample) * step).fract() - 0.5) as f32)
}
