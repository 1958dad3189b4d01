//! The light field of a groom ([`crate::photon`]): what makes it stale, how far it is traced, its copy on the GPU.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use super::shade::Terms;
use super::{Gpu, GpuError, Model, RenderSettings};
use crate::groom::RefinedGroom;
use crate::light::SrbfLight;
use crate::param::VertexParams;
use crate::photon::{Hair, LightField, Rules, Traced};
use crate::volume::SolidVoxels;

/// Edge of a cell of the light field in voxels: at three the rim of dense white hair is up to 10 % too bright, at one and a half pictures gain nothing but
/// noise.
pub const CELL_VOXELS: f32 = 2.0;

/// Rays of a field while lights move.
const RAYS_MOVING: u64 = 1 << 15;
/// Rays of the first light field of a view at rest.
pub const PHOTON_RAYS: u64 = 1 << 17;
/// More of them for each ray that visibility is refined by.
const RAYS_REFINED: u64 = 1 << 15;

/// A light field and what it is made from.
#[derive(Default)]
pub(super) struct ScatteredLight {
    hair: Option<Hair>,
    /// Edge of the field's cells, groom's unit.
    cell: f32,
    field: Option<LightField>,
    lights: Vec<SrbfLight>,
    rules: Option<Rules>,
    done: Traced,
    /// Rays that were asked for and traced, or not needed in the dark.
    satisfied: u64,
    stale: Stale,
    buffers: Option<FieldBuffers>,
}

/// What changed since the field was traced.
#[derive(Clone, Copy, Default)]
struct Stale {
    light: bool,
    paint: bool,
}

/// The field where the shaders read it.
pub(super) struct FieldBuffers {
    /// `LightFieldGrid` of `shaders/pass/shade_field.wgsl`.
    pub(super) grid: wgpu::Buffer,
    /// u32 a cell: its number among those with fibres.
    pub(super) numbers: wgpu::Buffer,
    /// vec4 per cell with fibres: their mean place and area.
    pub(super) fibres: wgpu::Buffer,
    /// Three half floats per cell with fibres and part of the sphere.
    pub(super) radiance: wgpu::Buffer,
}

impl ScatteredLight {
    /// Takes the refined strands and what stands in the light's way; parameters and lights have to follow.
    pub(super) fn set_strands(&mut self, strands: RefinedGroom, solid: Option<SolidVoxels>, voxel_size: f32) {
        self.hair = Some(Hair::new(strands, solid));
        self.cell = CELL_VOXELS * voxel_size;
        self.field = None;
        self.buffers = None;
        self.stale.light = true;
    }

    /// Takes the parameters of the groom's points, of which those in `dirty` changed.
    pub(super) fn set_params(&mut self, params: &[VertexParams], dirty: &[Range<u32>]) {
        if let Some(hair) = &mut self.hair {
            hair.set_params(params, dirty);
            self.stale.paint = true;
        }
    }

    /// Takes the lights as strands are shaded with them.
    pub(super) fn set_lights(&mut self, lights: &[SrbfLight]) {
        if self.lights != lights {
            lights.clone_into(&mut self.lights);
            self.stale.light = true;
        }
    }

    /// Nothing that was traced counts any more.
    pub(super) fn forget(&mut self) {
        self.stale.light = true;
    }

    /// True where the field is that of an earlier paint.
    pub(super) fn lags(&self) -> bool {
        self.stale.paint
    }

    /// True where the field is coarser than a picture with `settings` wants it.
    pub(super) fn is_coarse_for(&self, settings: &RenderSettings) -> bool {
        !settings.interactive && self.buffers.is_some() && self.satisfied < wanted_rays(settings)
    }

    /// Traces what is stale or too coarse for the settings; returns the rays that it took where the field is another one than before. While
    /// a hand moves the field of an earlier paint stays.
    ///
    /// # Errors
    /// [`GpuError::Interrupted`] (photons that were traced stay), [`GpuError::TooLarge`].
    pub(super) fn update(
        &mut self,
        gpu: &Gpu,
        settings: &RenderSettings,
        interrupt: Option<&AtomicBool>,
    ) -> Result<Option<u64>, GpuError> {
        let Some(hair) = &self.hair else {
            return Ok(None);
        };
        let field = self.field.get_or_insert_with(|| hair.field(self.cell));
        let (shade, interactive) = (&settings.shade, settings.interactive);
        let rules = Rules {
            is_deon: shade.method.model == Model::Deon,
            onward: shade.terms.has(Terms::D),
            turned: shade.terms.has(Terms::U),
        };
        let may_lag = interactive && self.buffers.is_some();
        let is_other = self.stale.light || self.rules != Some(rules);
        if is_other || (self.stale.paint && !may_lag) {
            field.forget();
            self.done = Traced::default();
            self.satisfied = 0;
            self.rules = Some(rules);
            self.stale = Stale::default();
            // The field of an earlier paint serves until the new one is whole: the next stroke may begin before.
            if is_other {
                self.buffers = None;
            }
        }
        let wanted = wanted_rays(settings);
        let before = self.done.rays;
        if self.buffers.is_some() && (self.satisfied >= wanted || interactive) {
            return Ok(None);
        }
        let stop = || interrupt.is_some_and(|flag| flag.load(Ordering::Relaxed));
        let is_whole = hair.trace(&self.lights, rules, wanted, &mut self.done, field, &stop);
        is_whole.map_err(|_| GpuError::Interrupted)?;
        self.satisfied = self.satisfied.max(wanted);
        let packed = field.packed(self.done.photons as f64);
        self.buffers = Some(FieldBuffers {
            grid: gpu.storage_of("light field", &[packed.grid])?,
            numbers: gpu.storage_of("cells of the light field", packed.numbers)?,
            fibres: gpu.storage_of("fibres of the light field", &packed.fibres)?,
            radiance: gpu.storage_of("radiance of the light field", &packed.radiance)?,
        });
        Ok(Some(self.done.rays - before))
    }

    /// The field of the last update.
    pub(super) fn buffers(&self) -> Option<&FieldBuffers> {
        self.buffers.as_ref()
    }
}

/// Rays of the field that a picture is read off.
fn wanted_rays(settings: &RenderSettings) -> u64 {
    if settings.interactive {
        RAYS_MOVING
    } else {
        PHOTON_RAYS + u64::from(settings.visibility_rays) * RAYS_REFINED
    }
}
