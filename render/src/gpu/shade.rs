//! Strand shading: which lobes and which multiple scattering, and the pass that evaluates them per refined vertex.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::strands::StrandBuffers;
use super::tables::scattering_tables;
use super::transmittance::Transmittance;
use super::{Gpu, GpuError, Kernel};
use crate::param::LobeRatios;

/// How finely the integrals of single scattering are evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quality {
    /// Fewest nodes: while something moves.
    Draft,
    /// The default.
    #[default]
    Standard,
    /// For final pictures and for checking.
    High,
}

/// How light that has crossed other fibres is added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Multiple {
    /// S + 1.1 D + 0.2 L + 0.25 U.
    #[default]
    M2,
    /// Zinke 2008 as printed, d_f = d_b = 0.7.
    Zinke2008,
    /// Single scattering only.
    Off,
}

/// Terms of the picture, each can be seen alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Terms(pub u32);

impl Terms {
    /// Single scattering: R, TT and TRT with shadows.
    pub const SINGLE: Self = Self(1 | 2 | 4);
    /// Multiple scattering: D, L and U.
    pub const MULTIPLE: Self = Self(8 | 16 | 32);
    /// Everything.
    pub const ALL: Self = Self(63);
    /// Names of the single terms, bit 0 first.
    pub const NAMES: [&'static str; 6] = ["R", "TT", "TRT", "D", "L", "U"];
}

/// What light does in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShadeSettings {
    /// Accuracy of the integrals.
    pub quality: Quality,
    /// Multiple scattering.
    pub multiple: Multiple,
    /// Terms that are added up.
    pub terms: Terms,
}

impl Default for ShadeSettings {
    fn default() -> Self {
        Self { quality: Quality::Standard, multiple: Multiple::M2, terms: Terms::ALL }
    }
}

/// Layout of `ShadeUniform` in `shaders/pass/shade.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ShadeUniform {
    camera_position: [f32; 3],
    vertex_count: u32,
    constant: [f32; 3],
    point_count: u32,
    alpha_ratios: [f32; 2],
    beta_ratios: [f32; 2],
    terms: u32,
    first_light: u32,
    light_count: u32,
    first_record: u32,
    adds: u32,
    multiple: u32,
    padding: [u32; 2],
}

/// What shading reads besides the strands.
pub struct ShadeInputs<'a> {
    /// World position of the eye.
    pub camera_position: Vec3,
    /// `VertexParams` per groom point.
    pub params: &'a wgpu::Buffer,
    /// `Light` per light, those of the uniform environment at the end.
    pub lights: &'a wgpu::Buffer,
    /// Lights in front of those that stand for the uniform environment.
    pub real_light_count: u32,
    /// Radiance of the uniform environment.
    pub constant: Vec3,
    /// Records per (point, light).
    pub transmittance: &'a Transmittance,
    /// Tilts and widths of TT and TRT to R.
    pub ratios: LobeRatios,
}

/// The pass, compiled for the quality that was used last.
pub struct ShadePass {
    kernel: Option<(Quality, Kernel)>,
    tables: wgpu::Buffer,
}

impl ShadePass {
    /// Uploads the scattering tables; the pass is compiled at the first frame, when its quality is known.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`].
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self { kernel: None, tables: gpu.storage_of("scattering tables", &scattering_tables())? })
    }

    /// Fills the strands' radiance; returns the number of evaluated (vertex, light) pairs.
    ///
    /// # Errors
    /// [`GpuError::Refused`] when the shader does not compile.
    pub fn run(
        &mut self,
        gpu: &Gpu,
        settings: &ShadeSettings,
        strands: &StrandBuffers,
        inputs: &ShadeInputs<'_>,
    ) -> Result<u64, GpuError> {
        let kernel = match &mut self.kernel {
            Some((quality, kernel)) if *quality == settings.quality => kernel,
            stale => {
                let level = f64::from(settings.quality as u32);
                let kernel = Kernel::new(gpu, "pass/shade.wgsl", &[("quality", level)])?;
                &mut stale.insert((settings.quality, kernel)).1
            }
        };
        let (Some(frames), Some(directions)) =
            (inputs.transmittance.light_buffer(), inputs.transmittance.direction_buffer())
        else {
            return Ok(0);
        };
        let point_count = inputs.params.size() as u32 / size_of::<crate::param::VertexParams>() as u32;
        let mut evaluated = 0;
        for batch in inputs.transmittance.batches() {
            // Lights of the user and lights that stand for the uniform environment are weighed differently.
            let split = inputs.real_light_count.clamp(batch.lights.start, batch.lights.end);
            for (lights, constant) in
                [(batch.lights.start..split, Vec3::ZERO), (split..batch.lights.end, inputs.constant)]
            {
                if lights.is_empty() {
                    continue;
                }
                let uniform = ShadeUniform {
                    camera_position: inputs.camera_position.to_array(),
                    vertex_count: strands.vertex_count,
                    constant: constant.to_array(),
                    point_count,
                    alpha_ratios: [inputs.ratios.alpha_tt, inputs.ratios.alpha_trt],
                    beta_ratios: [inputs.ratios.beta_tt, inputs.ratios.beta_trt],
                    terms: settings.terms.0 & if settings.multiple == Multiple::Off { Terms::SINGLE.0 } else { Terms::ALL.0 },
                    first_light: lights.start,
                    light_count: lights.len() as u32,
                    first_record: (lights.start - batch.lights.start) * point_count,
                    adds: u32::from(evaluated > 0),
                    multiple: u32::from(settings.multiple == Multiple::Zinke2008),
                    padding: [0; 2],
                };
                let uniform = gpu.uniform_of("shade", &uniform);
                let bound = kernel.bind(
                    gpu,
                    &[
                        (0, &uniform),
                        (1, &strands.vertices),
                        (2, inputs.params),
                        (3, inputs.lights),
                        (4, frames),
                        (5, directions),
                        (6, &batch.visibility),
                        (7, &batch.path),
                        (8, inputs.transmittance.averages_table()),
                        (9, &strands.radiance),
                        (10, &self.tables),
                    ],
                );
                kernel.run(gpu, &bound, strands.vertex_count);
                evaluated += u64::from(strands.vertex_count) * lights.len() as u64;
            }
        }
        if evaluated == 0 {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            encoder.clear_buffer(&strands.radiance, 0, None);
            gpu.queue.submit([encoder.finish()]);
        }
        Ok(evaluated)
    }
}
