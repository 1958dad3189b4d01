//! The frame: what is stale and seen is brought up to date, in the order of the crate's front page, then drawn.

mod debug_view;
mod tiles;
mod vertices;

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use glam::Vec3;
use serde::Serialize;

use super::camera::{Camera, CameraUniform};
use super::head::{HeadBuffers, HeadPass, HeadShade, HeadTarget};
use super::lights::{LightUniform, frame_lights};
use super::raster::{PictureBuffers, Raster, ResolveInputs, ResolveUniform};
use super::shade::{ShadeInputs, ShadePass, ShadeSettings};
use super::strands::StrandBuffers;
use super::transmittance::{MeanFibre, Transmittance, VolumeReport};
use super::view::{ViewPass, ViewTransform};
pub use debug_view::{DebugView, FalseColours};

use super::{Gpu, GpuError};
use crate::groom::{DEFAULT_MAX_TURN_RAD, Groom, Mesh, RefinedGroom, undergrowth};
use crate::image::Picture;
use crate::light::{EnvironmentMap, LightSet, SrbfLight};
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
    /// True while something is being painted: what light loses on its way through freshly painted hair stays as it was (the paint itself is
    /// shown), so that only painted vertices are shaded again. The next frame without it brings everything up to date.
    pub interactive: bool,
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
        }
    }
}

/// What a frame cost.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FrameReport {
    /// Passes that ran and their milliseconds, wall clock with the GPU waited for.
    pub passes: Vec<(String, f64)>,
    /// Named work counters.
    pub counters: Vec<(String, u64)>,
}

impl FrameReport {
    fn time<T>(
        &mut self,
        gpu: &Gpu,
        pass: &str,
        run: impl FnOnce(&mut Self) -> Result<T, GpuError>,
    ) -> Result<T, GpuError> {
        let start = Instant::now();
        let result = run(self)?;
        gpu.wait()?;
        self.add_time(pass, start.elapsed().as_secs_f64() * 1e3);
        Ok(result)
    }

    /// Milliseconds of all passes so far.
    fn total_ms(&self) -> f64 {
        self.passes.iter().map(|(_, ms)| ms).sum()
    }

    fn add_time(&mut self, pass: &str, ms: f64) {
        match self.passes.iter_mut().find(|(name, _)| name == pass) {
            Some((_, sum)) => *sum += ms,
            None => self.passes.push((pass.to_owned(), ms)),
        }
    }

    fn count(&mut self, counter: &str, value: u64) {
        match self.counters.iter_mut().find(|(name, _)| name == counter) {
            Some((_, sum)) => *sum += value,
            None => self.counters.push((counter.to_owned(), value)),
        }
    }

    /// The counter of that name, 0 where the work was not done.
    pub fn counter(&self, name: &str) -> u64 {
        self.counters
            .iter()
            .filter(|(n, _)| n == name)
            .map(|(_, v)| v)
            .sum()
    }
}

/// What changed since it was last used.
#[derive(Clone, Copy, Default)]
struct Stale {
    head: bool,
    shading: bool,
    picture: bool,
}

impl Stale {
    const ALL: Self = Self {
        head: true,
        shading: true,
        picture: true,
    };
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
    lights: LightBuffers,
    background: Background,
    target: Option<PictureBuffers>,
    last: Option<(Camera, [u32; 2], RenderSettings)>,
    stale: Stale,
    /// Bytes of parameters that were sent since the last frame.
    sent_bytes: u64,
}

/// What belongs to one groom.
struct SceneBuffers {
    strands: StrandBuffers,
    params: wgpu::Buffer,
    point_count: usize,
    head: Option<HeadBuffers>,
    head_target: HeadTarget,
    near: f32,
}

/// The lights of the frame.
struct LightBuffers {
    set: LightSet,
    lights: Vec<SrbfLight>,
    buffer: wgpu::Buffer,
}

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
            lights: LightBuffers {
                set: LightSet::default(),
                lights: Vec::new(),
                buffer: gpu.storage("lights", 32)?,
            },
            background: Background {
                pixels: gpu.storage("background", 16)?,
                size: None,
                turn_rad: 0.0,
                scale: Vec3::ONE,
            },
            target: None,
            last: None,
            stale: Stale::ALL,
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
            point_count: groom.point_count(),
            head: head
                .map(|mesh| HeadBuffers::new(gpu, mesh, &undergrowth(mesh, groom)))
                .transpose()?,
            head_target: HeadTarget::new(gpu, [1, 1])?,
            near: 1e-3 * low.distance(high),
        });
        self.raster.forget();
        self.stale = Stale::ALL;
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
        let scene = self.scene.as_ref().filter(|scene| {
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
        for range in dirty {
            let slice = &params[range.start as usize..range.end as usize];
            let offset = u64::from(range.start) * size_of::<VertexParams>() as u64;
            self.gpu
                .queue
                .write_buffer(&scene.params, offset, bytemuck::cast_slice(slice));
            self.sent_bytes += size_of_val(slice) as u64;
        }
        scene.strands.forget_points(&self.gpu, dirty);
        self.transmittance
            .set_params(&scene.params, MeanFibre::of(params), dirty);
        self.stale.picture = true;
        Ok(())
    }

    /// Takes the lights, rotated and exposed as they shall be seen.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`].
    pub fn set_lights(&mut self, set: &LightSet) -> Result<(), GpuError> {
        if self.lights.set == *set {
            return Ok(());
        }
        let lights = frame_lights(set);
        self.transmittance.set_lights(&self.gpu, &lights)?;
        let uniforms: Vec<_> = lights.iter().map(LightUniform::from).collect();
        self.lights = LightBuffers {
            set: set.clone(),
            buffer: self.gpu.storage_of("lights", &uniforms)?,
            lights,
        };
        self.stale.head = true;
        self.stale.shading = true;
        Ok(())
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
        self.stale.picture = true;
        Ok(())
    }

    /// Turns the background about y and scales its radiance (rgb), as was done to the lights.
    pub fn turn_background(&mut self, turn_rad: f32, scale: Vec3) {
        self.stale.picture |= (self.background.turn_rad, self.background.scale) != (turn_rad, scale);
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
        let sent_bytes = std::mem::take(&mut self.sent_bytes);
        if sent_bytes > 0 {
            report.count("parameter bytes uploaded", sent_bytes);
        }
        let refused = |reason: &str| GpuError::Refused {
            what: "the picture".to_owned(),
            reason: reason.to_owned(),
        };
        if size.contains(&0) {
            return Err(refused("it has no pixels"));
        }
        let scene = self.scene.as_mut().ok_or_else(|| refused("no groom was given"))?;
        self.transmittance.set_model(&gpu, settings.shade.method.model)?;
        self.transmittance
            .set_visibility_source(&gpu, settings.shade.visibility)?;
        let last = self.last.as_ref();
        self.stale.shading |=
            last.is_none_or(|(c, _, s)| c.position() != camera.position() || s.shade != settings.shade);
        self.stale.picture |= self.stale.shading
            || self.stale.head
            || (self.transmittance.lags() && !settings.interactive)
            || last.is_none_or(|(c, z, s)| {
                c != camera
                    || *z != size
                    || (s.samples, s.show_background, s.visibility_rays)
                        != (
                            settings.samples,
                            settings.show_background,
                            settings.visibility_rays,
                        )
            });
        let view_stale = self.stale.picture || last.is_none_or(|(_, _, s)| s != settings);

        if self.stale.shading {
            scene.strands.forget_shading(&gpu);
        }
        if let (true, Some(head)) = (self.stale.head, &scene.head) {
            report.time(&gpu, "head shading", |_| {
                self.head_shade.run(
                    &gpu,
                    head,
                    &self.transmittance,
                    &self.lights.buffer,
                    self.lights.lights.len(),
                );
                Ok(())
            })?;
            report.count("head vertices shaded", u64::from(head.vertex_count));
        }
        if self.stale.picture {
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
            // What another view showed is not wanted any more.
            if last.is_none_or(|(c, z, s)| c != camera || *z != size || s.samples != settings.samples) {
                scene.strands.want_nothing(&gpu);
                self.raster.forget();
            }
            let scene: &SceneBuffers = scene;
            let (start, timed_before) = (Instant::now(), report.total_ms());
            let mut shade = || {
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
                let inputs = ShadeInputs {
                    camera_position: camera.position(),
                    params: &scene.params,
                    lights: &self.lights.buffer,
                    real_light_count: self.lights.set.lights.len() as u32,
                    constant: self.lights.set.constant,
                    transmittance: &self.transmittance,
                };
                let done = report.time(&gpu, "strand shading", |_| {
                    self.shade.run(&gpu, &settings.shade, &scene.strands, &inputs)
                })?;
                report.count("vertices shaded", done.vertices);
                report.count("single scattering evaluations", done.single);
                report.count("multiple scattering evaluations", done.multiple);
                Ok(())
            };
            let fragments = draw_samples(
                &gpu,
                &mut self.raster,
                &self.head_pass,
                &self.background,
                scene,
                target,
                camera,
                settings,
                &mut shade,
            )?;
            gpu.wait()?;
            let shading_ms = report.total_ms() - timed_before;
            report.add_time("strand drawing", start.elapsed().as_secs_f64() * 1e3 - shading_ms);
            report.count("fragments", fragments);
        }
        if view_stale {
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
        self.last = Some((*camera, size, *settings));
        self.stale = Stale::default();
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

/// Adds up the camera samples, each after `shade` has brought the vertices that it shows up to date; returns the number of fragments made.
#[expect(clippy::too_many_arguments, reason = "parts of the renderer, borrowed apart")]
fn draw_samples(
    gpu: &Gpu,
    raster: &mut Raster,
    head_pass: &HeadPass,
    background: &Background,
    scene: &SceneBuffers,
    target: &PictureBuffers,
    camera: &Camera,
    settings: &RenderSettings,
    shade: &mut impl FnMut() -> Result<(), GpuError>,
) -> Result<u64, GpuError> {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.clear_buffer(&target.picture, 0, None);
    gpu.queue.submit([encoder.finish()]);
    let shown_background = background.size.filter(|_| settings.show_background);
    let samples = settings.samples.max(1);
    let mut fragments = 0;
    for sample in 0..samples {
        let jitter = subpixel(sample);
        let uniform = CameraUniform::new(
            camera,
            target.size,
            jitter,
            scene.near,
            scene.strands.segment_count,
        );
        if let Some(head) = &scene.head {
            head_pass.draw(gpu, &uniform, head, &scene.head_target);
        }
        let resolve = ResolveUniform {
            world_from_view: camera.world_from_camera.to_cols_array_2d(),
            weight: 1.0 / samples as f32,
            has_head: u32::from(scene.head.is_some()),
            has_background: u32::from(shown_background.is_some()),
            background_turn_rad: background.turn_rad,
            background_scale: background.scale.to_array(),
            pad: 0,
            background_size: shown_background.unwrap_or([1, 1]),
            pad_end: [0; 2],
        };
        let inputs = ResolveInputs {
            strands: &scene.strands,
            head: &scene.head_target,
            background: &background.pixels,
            target,
        };
        fragments += raster.draw(gpu, &uniform, &resolve, &inputs, &mut *shade)?;
    }
    Ok(fragments)
}

/// Offset of a camera sample in pixels: the R2 sequence (Roberts 2018), the first one at the pixel's centre.
fn subpixel(sample: u32) -> [f32; 2] {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    [1.0 / PLASTIC, 1.0 / (PLASTIC * PLASTIC)]
        .map(|step| ((0.5 + f64::from(sample) * step).fract() - 0.5) as f32)
}

/// Which strand is seen at each pixel.
pub struct PickMap {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    entries: Vec<[u32; 2]>,
}

/// A strand seen at a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// Depth along the camera's axis, groom units.
    pub depth: f32,
    /// Index of the refined strand's segment.
    pub segment: u32,
}

impl PickMap {
    /// The strand at pixel (x, y), row 0 on top.
    pub fn at(&self, x: u32, y: u32) -> Option<Pick> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let [depth, segment] = self.entries[(y * self.width + x) as usize];
        (segment > 0).then(|| Pick {
            depth: f32::from_bits(depth),
            segment: segment - 1,
        })
    }
}
