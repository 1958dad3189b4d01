//! Looks at what the picture is made of, in false colours with a legend.

use std::str::FromStr;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::{Input, LastFrame, RenderSettings, Renderer, Samples, SceneBuffers};
use crate::gpu::{Camera, Gpu, GpuError, Kernel, Transmittance};
use crate::image::Picture;
use crate::light::SrbfLight;
use crate::volume::lobe;

/// What false colours show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DebugView {
    /// Share of the lights' power that arrives unscattered, 0 to 1.
    Transmittance,
    /// n: the share exp(-n) of the lights' power crosses no fibre.
    Fibres,
    /// a_f at normal incidence, mean of the channels: the share that a fibre passes on.
    Forward,
    /// Projected area of the fibres in a voxel over that of its face.
    Density,
    /// Strand fragments that were sorted for a pixel.
    Overdraw,
    /// Pixels that are not finite: 1, all others 0.
    NonFinite,
}

impl DebugView {
    /// All of them with their names, as a user writes them, and as a menu shows them.
    pub const ALL: [(Self, &'static str, &'static str); 6] = [
        (Self::Transmittance, "transmittance", "Transmittance"),
        (Self::Fibres, "fibres", "Fibres crossed (n)"),
        (Self::Forward, "a-f", "Forward share (a_f)"),
        (Self::Density, "density", "Density"),
        (Self::Overdraw, "overdraw", "Overdraw"),
        (Self::NonFinite, "non-finite", "Non-finite pixels"),
    ];

    /// Values that have a natural range of 0 to 1; other legends reach to what is seen.
    fn is_share(self) -> bool {
        matches!(self, Self::Transmittance | Self::Forward | Self::NonFinite)
    }
}

impl FromStr for DebugView {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL
            .iter()
            .find(|(_, name, _)| *name == text)
            .map(|(view, ..)| *view)
            .ok_or_else(|| {
                let names = Self::ALL.map(|(_, name, _)| name).join(", ");
                format!("no view is called {text:?}; write one of {names}")
            })
    }
}

/// Values per pixel and their colours.
pub struct FalseColours {
    /// Width and height, pixels.
    pub size: [usize; 2],
    /// The value where something is seen, row after row.
    pub values: Vec<Option<f32>>,
    /// The value of the first and of the last colour of the scale.
    pub range: [f32; 2],
}

impl FalseColours {
    /// sRGB bytes with alpha, nothing where no value is.
    pub fn rgba(&self) -> Vec<u8> {
        let [low, high] = self.range;
        let shown = |value: &Option<f32>| match value {
            Some(value) => {
                let [r, g, b] = scale((value - low) / (high - low).max(1e-20));
                [r, g, b, 255]
            }
            None => [0; 4],
        };
        self.values.iter().flat_map(shown).collect()
    }

    /// The legend in words.
    pub fn legend(&self) -> String {
        let [low, high] = self.range;
        let values = || self.values.iter().flatten();
        let count = values().count();
        let mean = values().map(|&v| f64::from(v)).sum::<f64>() / count.max(1) as f64;
        format!("dark blue {low:.3} to yellow {high:.3}; mean {mean:.4} over {count} pixels")
    }
}

/// Colour of the scale at x in [0, 1]: dark blue, teal, green, yellow, lightness rising evenly.
fn scale(x: f32) -> [u8; 3] {
    const STOPS: [[f32; 3]; 5] = [
        [48.0, 18.0, 92.0],
        [52.0, 84.0, 140.0],
        [32.0, 145.0, 140.0],
        [108.0, 200.0, 88.0],
        [250.0, 232.0, 40.0],
    ];
    let place = x.clamp(0.0, 1.0) * (STOPS.len() - 1) as f32;
    let low = (place as usize).min(STOPS.len() - 2);
    std::array::from_fn(|c| {
        let [a, b] = [STOPS[low][c], STOPS[low + 1][c]];
        (a + (b - a) * (place - low as f32)).round() as u8
    })
}

/// Layout of `DebugRun` in `shaders/pass/debug_values.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct DebugRun {
    what: u32,
    point_count: u32,
    first_light: u32,
    light_count: u32,
    adds: u32,
    pad: [u32; 3],
}

impl Renderer {
    /// Draws the picture and then, in its place, the values that `view` names. The picture is drawn anew by the next frame.
    ///
    /// # Errors
    /// What [`Self::render`] fails with.
    pub fn debug_view(
        &mut self,
        camera: &Camera,
        size: [u32; 2],
        settings: &RenderSettings,
        view: DebugView,
    ) -> Result<FalseColours, GpuError> {
        let settings = RenderSettings {
            samples: 1,
            show_background: false,
            ..*settings
        };
        self.shows_ways = matches!(view, DebugView::Fibres | DebugView::Forward);
        if self.shows_ways {
            self.changes.note(Input::Quality);
        }
        let drawn = self.render(camera, size, &settings);
        self.shows_ways = false;
        drawn?;
        let side = size.map(|n| n as usize);
        let values = match view {
            DebugView::NonFinite => {
                let is_bad = |p: &[f32; 4]| !p.iter().all(|x| x.is_finite());
                let pixels = self.picture()?.pixels;
                pixels
                    .iter()
                    .map(|p| Some(f32::from(u8::from(is_bad(p)))))
                    .collect()
            }
            DebugView::Overdraw => {
                let counts = self.raster.overdraw(&self.gpu, self.drawn()?)?;
                counts.into_iter().map(|n| (n > 0).then_some(n as f32)).collect()
            }
            DebugView::Transmittance | DebugView::Fibres | DebugView::Forward | DebugView::Density => {
                shown_values(&self.values_drawn(view)?)
            }
        };
        let highest = values.iter().flatten().copied().fold(0.0, f32::max);
        Ok(FalseColours {
            size: side,
            values,
            range: [0.0, if view.is_share() { 1.0 } else { highest }],
        })
    }

    /// The picture with values in the place of radiance.
    fn values_drawn(&mut self, view: DebugView) -> Result<Picture, GpuError> {
        let gpu = self.gpu.clone();
        let missing = || GpuError::Refused {
            what: "the debug view".to_owned(),
            reason: "no frame was drawn yet".to_owned(),
        };
        let scene = self.scene.as_ref().ok_or_else(missing)?;
        let target = self.target.as_ref().ok_or_else(missing)?;
        let now: LastFrame = self.last.ok_or_else(missing)?;
        // Radiance is overwritten, and the head hides hair without adding to it.
        self.changes.note(Input::LightColours);
        if let Some(head) = &scene.head {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            encoder.clear_buffer(&head.radiance, 0, None);
            gpu.queue.submit([encoder.finish()]);
        }
        write_values(&gpu, scene, &self.transmittance, &self.lights.lights, view)?;
        let samples = Samples {
            gpu: &gpu,
            head_pass: &self.head_pass,
            background: &self.background,
            scene,
            target,
            gain: Vec3::ONE,
            frame: self.frame,
            is_head_stale: true,
            keeps_pixels: false,
        };
        samples.draw(&mut self.raster, &now, &mut || Ok(()))?;
        self.picture()
    }
}

/// Value over weight of every pixel that hair covers: the picture holds both, premultiplied by coverage.
fn shown_values(picture: &Picture) -> Vec<Option<f32>> {
    let value = |p: &[f32; 4]| (p[2] > 1e-3).then(|| p[0] / p[2]);
    picture.pixels.iter().map(value).collect()
}

/// Writes (value, value, 1) as every vertex' radiance.
fn write_values(
    gpu: &Gpu,
    scene: &SceneBuffers,
    transmittance: &Transmittance,
    lights: &[SrbfLight],
    view: DebugView,
) -> Result<(), GpuError> {
    let kernel = Kernel::new(gpu, "pass/debug_values.wgsl", &[])?;
    let Some([grid, bricks, density]) = transmittance.volume_buffers() else {
        return Ok(());
    };
    let power =
        |light: &SrbfLight| f64::from(light.radiance.element_sum()) * lobe::solid_angle(light.bandwidth);
    let total = lights.iter().map(power).sum::<f64>().max(f64::MIN_POSITIVE);
    let weights: Vec<f32> = lights.iter().map(|light| (power(light) / total) as f32).collect();
    let weights = gpu.storage_of("weights of lights", &weights)?;
    for (index, batch) in transmittance.batches().iter().enumerate() {
        let run = DebugRun {
            what: match view {
                DebugView::Transmittance => 0,
                DebugView::Fibres => 1,
                DebugView::Forward => 2,
                DebugView::Density | DebugView::Overdraw | DebugView::NonFinite => 3,
            },
            point_count: scene.strands.point_count,
            first_light: batch.lights.start,
            light_count: batch.lights.len() as u32,
            adds: u32::from(index > 0),
            pad: [0; 3],
        };
        let bindings = [
            (0, grid),
            (1, bricks),
            (2, density),
            (3, &gpu.uniform_of("debug view", &run)),
            (4, &scene.strands.vertices),
            (5, &scene.params),
            (6, transmittance.averages_table()),
            (7, &weights),
            (8, &batch.visibility),
            (9, &batch.path),
            (10, &scene.strands.radiance),
        ];
        kernel.run(gpu, &kernel.bind(gpu, &bindings), scene.strands.vertex_count);
    }
    Ok(())
}
