//! The frame: what is stale is brought up to date, in the order of the crate's front page, then drawn.

use std::ops::Range;
use std::time::Instant;

use glam::Vec3;
use serde::Serialize;

use super::camera::{Camera, CameraUniform};
use super::head::{HeadBuffers, HeadPass, HeadTarget};
use super::raster::{PictureBuffers, Raster, ResolveUniform, SolidInputs};
use super::shade::{ShadePass, ShadeSettings};
use super::strands::StrandBuffers;
use super::view::{ViewPass, ViewTransform};
use super::{Gpu, GpuError};
use crate::groom::{Groom, Mesh, RefinedGroom};
use crate::image::Picture;
use crate::light::{EnvironmentMap, LightSet};
use crate::param::{LobeRatios, VertexParams};

/// Largest turn of the tangent between two shaded points, radians (4 degrees).
const MAX_TURN_RAD: f32 = 4.0 * std::f32::consts::PI / 180.0;

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
    fn time<T>(&mut self, gpu: &Gpu, pass: &str, run: impl FnOnce(&mut Self) -> Result<T, GpuError>) -> Result<T, GpuError> {
        let start = Instant::now();
        let result = run(self)?;
        gpu.wait()?;
        self.passes.push((pass.to_owned(), start.elapsed().as_secs_f64() * 1e3));
        Ok(result)
    }

    fn count(&mut self, name: &str, value: u64) {
        self.counters.push((name.to_owned(), value));
    }

    /// The counter of that name, 0 where the work was not done.
    pub fn counter(&self, name: &str) -> u64 {
        self.counters.iter().filter(|(n, _)| n == name).map(|(_, v)| v).sum()
    }
}

/// What changed since it was last used.
#[derive(Clone, Copy, Default)]
struct Stale {
    transmittance: bool,
    head: bool,
    shading: bool,
    picture: bool,
}

impl Stale {
    const ALL: Self = Self { transmittance: true, head: true, shading: true, picture: true };
}

/// Everything on the GPU that one view of one groom needs; a cache of what the caller owns.
pub struct Renderer {
    gpu: Gpu,
    raster: Raster,
    head_pass: HeadPass,
    shade: ShadePass,
    view: ViewPass,
    transmittance: Transmittance,
    strands: Option<StrandBuffers>,
    near: f32,
    params: wgpu::Buffer,
    head: Option<HeadBuffers>,
    head_target: HeadTarget,
    ratios: LobeRatios,
    lights: LightSet,
    background: Background,
    target: Option<PictureBuffers>,
    last: Option<(CameraUniform, RenderSettings)>,
    stale: Stale,
}

/// The environment behind the picture.
struct Background {
    pixels: wgpu::Buffer,
    size: [u32; 2],
    turn_rad: f32,
    scale: f32,
}

impl Renderer {
    /// Compiles all passes.
    ///
    /// # Errors
    /// [`GpuError::Refused`] when a shader does not compile on this adapter.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            raster: Raster::new(gpu)?,
            head_pass: HeadPass::new(gpu)?,
            shade: ShadePass::new(gpu)?,
            view: ViewPass::new(gpu)?,
            transmittance: Transmittance::new(gpu)?,
            strands: None,
            near: 1e-3,
            params: gpu.storage("vertex parameters", 32)?,
            head: None,
            head_target: HeadTarget::new(gpu, [1, 1])?,
            ratios: LobeRatios::default(),
            lights: LightSet::default(),
            background: Background {
                pixels: gpu.storage("background", 16)?,
                size: [1, 1],
                turn_rad: 0.0,
                scale: 1.0,
            },
            target: None,
            last: None,
            stale: Stale::ALL,
            gpu: gpu.clone(),
        })
    }

    /// Takes a groom and the head that it grows on; parameters have to follow.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`].
    pub fn set_groom(&mut self, groom: &Groom, head: Option<&Mesh>) -> Result<(), GpuError> {
        let refined = RefinedGroom::new(groom, MAX_TURN_RAD);
        self.strands = Some(StrandBuffers::new(&self.gpu, &refined)?);
        self.near = 1e-3 * groom.bounds().1.distance(groom.bounds().0);
        self.params = self.gpu.storage("vertex parameters", (size_of::<VertexParams>() * groom.point_count()) as u64)?;
        self.head = head.map(|mesh| HeadBuffers::new(&self.gpu, mesh)).transpose()?;
        self.transmittance.set_groom(&self.gpu, groom, head)?;
        self.raster.forget();
        self.stale = Stale::ALL;
        Ok(())
    }

    /// Uploads the parameters of the groom points in `dirty` (all where it is empty) from `params`, one entry a groom point.
    ///
    /// # Panics
    /// When `params` has another length than the groom.
    pub fn set_params(&mut self, params: &[VertexParams], dirty: &[Range<u32>]) {
        assert_eq!(params.len() as u64 * size_of::<VertexParams>() as u64, self.params.size(), "one entry a groom point");
        let whole = 0..params.len() as u32;
        let dirty = if dirty.is_empty() { std::slice::from_ref(&whole) } else { dirty };
        for range in dirty {
            let slice = &params[range.start as usize..range.end as usize];
            let offset = u64::from(range.start) * size_of::<VertexParams>() as u64;
            self.gpu.queue.write_buffer(&self.params, offset, bytemuck::cast_slice(slice));
        }
        self.transmittance.set_params(params, self.ratios);
        self.stale.shading = true;
        self.stale.transmittance = true;
    }
}
