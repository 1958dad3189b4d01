//! The camera samples of a picture.

use glam::Vec3;

use super::{Background, LastFrame, SceneBuffers};
use crate::gpu::camera::CameraUniform;
use crate::gpu::head::HeadPass;
use crate::gpu::raster::{PictureBuffers, Raster, ResolveInputs, ResolveUniform};
use crate::gpu::{Gpu, GpuError, Saving};

/// The camera samples of a picture.
pub(super) struct Samples<'a> {
    pub(super) gpu: &'a Gpu,
    pub(super) head_pass: &'a HeadPass,
    pub(super) background: &'a Background,
    pub(super) scene: &'a SceneBuffers,
    pub(super) target: &'a PictureBuffers,
    /// Factor on what the lights give.
    pub(super) gain: Vec3,
    /// Number of the frame.
    pub(super) frame: f32,
    pub(super) is_head_stale: bool,
    /// Whether pixels that show nothing that changed stay as they are.
    pub(super) keeps_pixels: bool,
}

impl Samples<'_> {
    /// Adds them up, each after `shade` has brought the vertices that it shows up to date; returns the number of fragments made.
    pub(super) fn draw(
        &self,
        raster: &mut Raster,
        now: &LastFrame,
        shade: &mut impl FnMut() -> Result<(), GpuError>,
    ) -> Result<u64, GpuError> {
        let _scope = tracing::info_span!("strand drawing").entered();
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
            solid_coverage: if settings.savings.has(Saving::Covered) {
                1.0
            } else {
                2.0
            },
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
