//! The frame: what is stale and seen is brought up to date, in the order of the crate's front page, then drawn.

mod changes;
mod debug_view;
mod samples;
mod settings;
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
use super::raster::{PictureBuffers, Raster};
use super::report::FrameReport;
use super::scattered_light::ScatteredLight;
use super::scene_lights::SceneLights;
use super::shade::{ShadeInputs, ShadePass};
use super::stale::{Changes, Input, Product};
use super::strands::{RefinedVertex, StrandBuffers};
use super::transmittance::{MeanFibre, Transmittance, VolumeReport};
use super::view::ViewPass;
pub use debug_view::{DebugView, FalseColours};
use samples::Samples;
pub use settings::RenderSettings;

use super::{Gpu, GpuError, Saving};
use crate::groom::{DEFAULT_MAX_TURN_RAD, Groom, Mesh, RefinedGroom, undergrowth};
use crate::image::Picture;
use crate::light::{EnvironmentMap, LightSet};
use crate::param::VertexParams;
use crate::volume::{Occluder, VolumeSettings};

/// Everything on the GPU that one view of one groom needs; a cache of what the caller owns.
pub struct Renderer {
    gpu: Gpu,
    raster: Raster,
    head_pass: HeadPass,
    head_shade: HeadShade,
    shade: ShadePass,
    view: ViewPass,
    transmittance: Transmittance,
    scattered: ScatteredLight,
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
    interrupt: Option<Arc<AtomicBool>>,
    /// Whether the sums along the ways from the lights are to be seen.
    shows_ways: bool,
    volume_settings: VolumeSettings,
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
            scattered: ScatteredLight::default(),
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
            interrupt: None,
            shows_ways: false,
            volume_settings: VolumeSettings::default(),
            frame: 0.0,
            sent_bytes: 0,
            gpu: gpu.clone(),
        })
    }

    /// How fine the hair volume of the next grooms is.
    pub fn set_volume(&mut self, settings: VolumeSettings) {
        self.volume_settings = settings;
    }

    /// Takes a groom and the head that it grows on; parameters have to follow. Where the refined strands exceed what the adapter binds they
    /// are refined less.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`].
    pub fn set_groom(&mut self, groom: &Groom, head: Option<&Mesh>) -> Result<VolumeReport, GpuError> {
        let gpu = &self.gpu;
        let refined = refined_within(groom, gpu.most_bound_bytes() / size_of::<RefinedVertex>() as u64);
        let occluder = head.map(|mesh| Occluder {
            positions: mesh.positions(),
            triangles: mesh.triangles(),
        });
        let report =
            self.transmittance
                .set_strands(gpu, &groom.into(), occluder.as_ref(), &self.volume_settings)?;
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
        let solid = self.transmittance.take_solid();
        self.scattered.set_strands(refined, solid, report.voxel_size);
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
        self.scattered.set_params(params, dirty);
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

    /// While the flag is true exact rays and shading are given up ([`GpuError::Interrupted`]): the hand has moved on. What was done until
    /// then is kept for the next frame.
    pub fn set_interrupt(&mut self, interrupt: Option<Arc<AtomicBool>>) {
        self.transmittance.set_interrupt(interrupt.clone());
        self.interrupt = interrupt;
    }

    /// Compiles in the background what a picture with `settings` will be shaded with; where nothing is said before, that picture waits.
    pub fn prepare(&mut self, settings: &RenderSettings) {
        let settings = settings.of_its_quality();
        let has_elliptic = self.scene.as_ref().is_some_and(|scene| scene.has_elliptic);
        self.shade
            .prepare(&self.gpu, &settings.shade, has_elliptic, settings.savings);
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
        let _scope = tracing::info_span!("frame").entered();
        if let Some(timer) = &gpu.timer {
            timer.forget();
        }
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
        let sums_ways = settings.shade.sums_ways() || self.shows_ways;
        self.transmittance.want_path_sums(sums_ways);
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
                if settings.shade.is_traced() {
                    let traced = report.time(&gpu, "scattered light", |_| {
                        self.scattered.set_lights(&self.lights.lights);
                        self.scattered.update(&gpu, settings, self.interrupt.as_deref())
                    })?;
                    if let Some(rays) = traced {
                        scene.strands.multiple_work.forget_all(&gpu);
                        report.count("photon rays", rays);
                    }
                }
                // What a vertex was shaded with has changed where better rays were traced.
                if done.exact_rays > 0 {
                    self.shade
                        .demote(&gpu, &scene.strands, settings.shade.method.quality)?;
                }
                report.count("voxels painted", done.painted_voxels);
                report.count("visibility rays", done.visibility_rays);
                report.count("exact rays", done.exact_rays);
                report.count("path rays", done.path_rays);
                // New losses change what points get from ways that cross them.
                self.transmittance
                    .forget_changed(&gpu, &scene.strands.multiple_work);
                let inputs = ShadeInputs {
                    interrupt: self.interrupt.as_deref(),
                    field: self.scattered.buffers(),
                    ..scene.shade_inputs(&self.lights, &self.transmittance, &now, self.frame)
                };
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
        if let Some(timer) = &gpu.timer {
            report.shaders = timer.take(&gpu)?;
        }
        self.last = Some(now);
        self.changes = Changes::default();
        Ok(report)
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

/// The refined strands, their tangents turning by the usual angle between two vertices, or by so much more that there are no more than `most`.
fn refined_within(groom: &Groom, most: u64) -> RefinedGroom {
    let mut turn = DEFAULT_MAX_TURN_RAD;
    loop {
        let refined = RefinedGroom::new(groom, turn);
        if refined.point_count() as u64 <= most || turn >= std::f32::consts::PI {
            return refined;
        }
        turn *= 1.5;
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
            field: None,
            savings: now.settings.savings,
            frame,
            interrupt: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strands_are_refined_less_where_they_would_not_fit() {
        let strand: Vec<_> = (0..12)
            .map(|k| Vec3::new((k as f32).cos(), (k as f32).sin(), 0.1 * k as f32))
            .collect();
        let (groom, _) = Groom::from_strands(vec![strand; 4], 0.01, 1.0).expect("a sound groom");
        let usual = refined_within(&groom, u64::MAX);
        assert_eq!(usual, RefinedGroom::new(&groom, DEFAULT_MAX_TURN_RAD));
        let fewer = refined_within(&groom, usual.point_count() as u64 / 3);
        assert!(3 * fewer.point_count() <= usual.point_count());
        assert!(fewer.point_count() >= groom.point_count());
        // No groom is refused for it: its own points are the least.
        assert!(refined_within(&groom, 1).point_count() >= groom.point_count());
    }
}
