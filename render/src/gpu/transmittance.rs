//! Visibility and path sums per (point, light): uploads the density volume, runs the marches, keeps what is not stale.
//!
//! Passes, in order: `averages` (table of what one fibre does), `density_paint` (losses per voxel), `transmittance_visibility` or, once a
//! view rests, `visibility_exact`, `transmittance_path`. Visibility depends on geometry and lights; the path sums on paint as well.

mod exact_lights;
mod mean_fibre;
mod volume_buffers;

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

use exact_lights::ExactLights;
pub use mean_fibre::MeanFibre;
use volume_buffers::VolumeBuffers;

use super::sh9::Harmonics;
use super::voxel_paint::{DirtyPoints, paint_run};
use super::work_list::{DONE, Lister, WorkList};
use super::{Gpu, GpuError, Kernel, Method, Model};
use crate::gpu::tables::scattering_tables;
use crate::light::SrbfLight;
use crate::volume::lobe::{LobeDirection, LobeLight, lobe_tables};
use crate::volume::{DensityVolume, Occluder, Strands, VolumeSettings};

/// Bytes of a visibility record: a, b of T(w) = a + b . (w - A w_j) as four half floats.
pub const VISIBILITY_BYTES: u64 = 8;

/// Bytes of a path record: T_f rgb, spread, 2 sum k rgb, n as eight half floats.
pub const PATH_BYTES: u64 = 16;

/// Nodes of the table of averages: 32 absorptions times 64 inclinations.
const AVERAGES_NODES: u32 = 32 * 64;

/// Entries of the table of averages: three per node of `shaders/lib/averages_table.wgsl`, one per absorption after them.
pub const AVERAGES_ENTRIES: usize = 3 * AVERAGES_NODES as usize + 32;

/// Records of consecutive lights, light-major: the record of light `j` at point `i` is number `(j - lights.start) * point_count + i`.
pub struct LightBatch {
    /// The lights of the batch.
    pub lights: Range<u32>,
    /// [`VISIBILITY_BYTES`] per record.
    pub visibility: wgpu::Buffer,
    /// [`PATH_BYTES`] per record.
    pub path: wgpu::Buffer,
}

/// Where a light's visibility comes from before exact rays refine it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum VisibilitySource {
    /// Marches through the voxels towards every light.
    #[default]
    Voxel,
    /// Nine spherical harmonics per block of voxels, with gradients (Xing 2012); exact rays do not refine them.
    Sh9,
}

/// Size of a density volume, for reports.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VolumeReport {
    /// Edge of a voxel, groom's unit.
    pub voxel_size: f32,
    /// Voxels along each axis, stored or not.
    pub voxels: [u32; 3],
    /// Voxels that are stored.
    pub stored_voxels: u32,
    /// Segments that were clipped.
    pub segments: usize,
    /// Parts that they were cut into: fibres in voxels.
    pub shares: usize,
    /// Voxels that a fibre crosses.
    pub filled_voxels: usize,
    /// GPU bytes of all of the volume's buffers.
    pub bytes: u64,
}

/// What one [`Transmittance::update`] did: zeros where nothing was stale.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TransmittanceReport {
    /// Voxels whose losses were computed again.
    pub painted_voxels: u64,
    /// Rays marched for visibility.
    pub visibility_rays: u64,
    /// Rays tested against fibres for visibility.
    pub exact_rays: u64,
    /// Rays marched for path sums.
    pub path_rays: u64,
}

/// The lights on the GPU.
struct LightBuffers {
    frames: Vec<LobeLight>,
    lights: wgpu::Buffer,
    directions: wgpu::Buffer,
    exact: Option<ExactLights>,
}

/// One light of a march, same layout as `LightRun` in the passes.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct LightRun {
    point_count: u32,
    light: u32,
    first_record: u32,
    prior: f32,
}

/// Pairs of a light and a point that are marched in one submission, where the points of one light are not more.
const MARCHED_AT_ONCE: u32 = 1 << 15;

/// What has to run again.
struct Stale {
    averages: bool,
    paint: DirtyPoints,
    lights: bool,
}

/// The transmittance of a groom under its lights.
pub struct Transmittance {
    density_paint: Kernel,
    visibility: Kernel,
    visibility_exact: Kernel,
    path: Kernel,
    harmonics: Option<Harmonics>,
    lister: Lister,
    /// The model whose averages the table holds, and the pass that fills it.
    averages_pass: (Model, Kernel),
    averages: wgpu::Buffer,
    tables: wgpu::Buffer,
    fibre: Option<MeanFibre>,
    volume: Option<VolumeBuffers>,
    params: Option<wgpu::Buffer>,
    srbf: Vec<SrbfLight>,
    lights: Option<LightBuffers>,
    batches: Vec<LightBatch>,
    stale: Stale,
    /// Lights whose records are stale where the others' are not.
    moved: Vec<u32>,
    has_paint: bool,
    interrupt: Option<Arc<AtomicBool>>,
    /// Exact rays that no report has told of yet.
    traced: u64,
}

/// Points that exact rays are traced for between two looks at the interrupt: some tenths of a second.
fn uninterrupted(gpu: &Gpu) -> u32 {
    if gpu.is_software { 1 << 9 } else { 1 << 14 }
}

impl Transmittance {
    /// Compiles the passes.
    ///
    /// # Errors
    /// [`GpuError::Refused`] where a shader does not compile.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            density_paint: Kernel::new(gpu, "pass/density_paint.wgsl", &[])?,
            visibility: Kernel::new(gpu, "pass/transmittance_visibility.wgsl", &[])?,
            visibility_exact: Kernel::new(gpu, "pass/visibility_exact.wgsl", &[])?,
            path: Kernel::new(gpu, "pass/transmittance_path.wgsl", &[])?,
            harmonics: None,
            lister: Lister::new(gpu)?,
            averages_pass: (Model::default(), averages_pass(gpu, Model::default())?),
            tables: gpu.storage_of("scattering tables", &scattering_tables())?,
            fibre: None,
            averages: gpu.storage(
                "averages table",
                (AVERAGES_ENTRIES * size_of::<[f32; 4]>()) as u64,
            )?,
            volume: None,
            params: None,
            srbf: Vec::new(),
            lights: None,
            batches: Vec::new(),
            stale: Stale {
                averages: false,
                paint: DirtyPoints::NONE,
                lights: false,
            },
            moved: Vec::new(),
            has_paint: false,
            interrupt: None,
            traced: 0,
        })
    }

    /// Takes new strands (and an occluder) and builds their volume. The records' points are the strands' points.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] where a table exceeds what the adapter binds.
    pub fn set_strands(
        &mut self,
        gpu: &Gpu,
        strands: &Strands<'_>,
        occluder: Option<&Occluder<'_>>,
        settings: &VolumeSettings,
    ) -> Result<VolumeReport, GpuError> {
        let volume = DensityVolume::build(strands, occluder, settings);
        let buffers = VolumeBuffers::upload(gpu, &volume, strands)?;
        let bytes = volume.bytes() as u64
            + 32 * u64::from(volume.grid.stored_voxels)
            + buffers.points.size()
            + buffers.point_ends.size();
        self.volume = Some(buffers);
        self.batches.clear();
        if let Some(harmonics) = &mut self.harmonics {
            harmonics.forget();
        }
        self.stale.paint = DirtyPoints::All;
        self.has_paint = false;
        Ok(VolumeReport {
            voxel_size: volume.grid.voxel_size,
            voxels: volume.grid.voxels().to_array(),
            stored_voxels: volume.grid.stored_voxels,
            segments: (0..strands.strand_count())
                .map(|strand| strands.segments(strand).len())
                .sum(),
            shares: volume.shares.len(),
            filled_voxels: volume
                .first_share
                .windows(2)
                .filter(|ends| ends[0] < ends[1])
                .count(),
            bytes,
        })
    }

    /// Takes the painted parameters, one `VertexParams` per point, and their mean; call it again after every change of the
    /// buffer's content, with the points that changed (all where `dirty` is empty).
    pub fn set_params(&mut self, params: &wgpu::Buffer, mean: MeanFibre, dirty: &[Range<u32>]) {
        self.params = Some(params.clone());
        if self.fibre != Some(mean) {
            self.stale.averages = true;
            self.stale.paint = DirtyPoints::All;
        }
        self.fibre = Some(mean);
        self.stale.paint.add(dirty);
    }

    /// Takes where visibility comes from.
    ///
    /// # Errors
    /// [`GpuError::Refused`] where a shader does not compile.
    pub fn set_visibility_source(&mut self, gpu: &Gpu, source: VisibilitySource) -> Result<(), GpuError> {
        let is_sh9 = source == VisibilitySource::Sh9;
        if self.harmonics.is_some() != is_sh9 {
            self.harmonics = is_sh9.then(|| Harmonics::new(gpu)).transpose()?;
            self.stale.lights = true;
        }
        Ok(())
    }

    /// While the flag is true, exact rays stop after the points that they are traced for and [`Self::update`] fails with
    /// [`GpuError::Interrupted`]; what was traced until then is kept, and the next update goes on from there.
    pub fn set_interrupt(&mut self, interrupt: Option<Arc<AtomicBool>>) {
        self.interrupt = interrupt;
    }

    /// Takes the model whose averages light loses and spreads by on its way; a model without multiple scattering changes nothing.
    ///
    /// # Errors
    /// [`GpuError::Refused`] where a shader does not compile.
    pub fn set_model(&mut self, gpu: &Gpu, model: Model) -> Result<(), GpuError> {
        if model.scatters_often() && self.averages_pass.0 != model {
            self.averages_pass = (model, averages_pass(gpu, model)?);
            self.stale.averages = true;
            self.stale.paint = DirtyPoints::All;
        }
        Ok(())
    }

    /// True where the last update kept losses of an earlier paint.
    pub fn lags(&self) -> bool {
        self.stale.paint != DirtyPoints::NONE
    }

    /// Takes the lights and returns those that are marched in another way than before; the records of the others stay.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] where their table exceeds what the adapter binds.
    pub fn set_lights(&mut self, gpu: &Gpu, lights: &[SrbfLight]) -> Result<Vec<u32>, GpuError> {
        let (frames, directions) = lobe_tables(lights);
        let count = frames.len() as u32;
        let moved = self.moved_among(&frames);
        if !moved.is_empty() || self.lights.is_none() {
            self.lights = Some(LightBuffers {
                lights: gpu.storage_of("lobe lights", &frames)?,
                directions: gpu.storage_of::<LobeDirection>("lobe directions", &directions)?,
                frames,
                exact: None,
            });
            self.srbf = lights.to_vec();
        }
        // Going through the lists once for a few lights is worth it where most records stay.
        if 4 * moved.len() as u32 > count {
            self.stale.lights = true;
        } else {
            self.moved.extend(&moved);
        }
        Ok(moved)
    }

    /// What [`Self::set_lights`] would return.
    pub fn moved_by(&self, lights: &[SrbfLight]) -> Vec<u32> {
        self.moved_among(&lobe_tables(lights).0)
    }

    fn moved_among(&self, frames: &[LobeLight]) -> Vec<u32> {
        match &self.lights {
            Some(old) if old.frames.len() == frames.len() => {
                let pairs = (0..).zip(old.frames.iter().zip(frames));
                let moved = pairs.filter(|(_, (old, new))| !old.is_marched_as(new));
                moved.map(|(light, _)| light).collect()
            }
            _ => (0..frames.len() as u32).collect(),
        }
    }

    /// Nothing that was marched counts any more.
    pub fn forget(&mut self) {
        self.stale.lights = true;
        self.stale.paint = DirtyPoints::All;
        self.has_paint = false;
    }

    /// Runs what is stale, as far as strands, parameters and lights are there, for the points that `wanted` (u32 a point) does not hold
    /// a 0 for; for all points without it. With `paint_may_lag` the path sums of an earlier paint stay where there are any, and so does
    /// what voxels lose ([`Self::lags`]). Visibility comes from the voxels, with `rays` > 0 refined by so many exact rays per point and light
    /// (fewer for faint lights); records of more rays than asked for stay.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] where the records of one light exceed what the adapter binds, [`GpuError::Interrupted`], [`GpuError::Lost`].
    pub fn update(
        &mut self,
        gpu: &Gpu,
        wanted: Option<&wgpu::Buffer>,
        paint_may_lag: bool,
        rays: u32,
    ) -> Result<TransmittanceReport, GpuError> {
        let mut report = TransmittanceReport::default();
        let Some(volume) = &self.volume else {
            return Ok(report);
        };

        if let (true, Some(params), Some(fibre)) = (
            self.lags() && !(paint_may_lag && self.has_paint),
            &self.params,
            &self.fibre,
        ) {
            if self.stale.averages {
                self.run_averages(gpu, fibre);
                self.stale.averages = false;
            }
            report.painted_voxels = self.run_paint(gpu, volume, params)?;
            volume.path_work.forget_all(gpu);
            self.stale.paint = DirtyPoints::NONE;
            self.has_paint = true;
        }
        if let Some(lights) = &mut self.lights
            && rays > 0
            && lights.exact.as_ref().is_none_or(|exact| exact.rays != rays)
        {
            lights.exact = Some(ExactLights::new(gpu, &self.srbf, rays)?);
        }
        let Some(lights) = &self.lights else {
            return Ok(report);
        };

        let light_count = lights.frames.len() as u32;
        if self.batches.last().map_or(0, |batch| batch.lights.end) != light_count {
            self.batches = allocate_batches(gpu, volume.point_count, light_count)?;
        }
        // Harmonics hold all lights at once.
        if self.stale.lights || (self.harmonics.is_some() && !self.moved.is_empty()) {
            volume.visibility_work.forget_all(gpu);
            volume.path_work.forget_all(gpu);
            self.stale.lights = false;
            self.moved.clear();
        }
        let wanted = wanted.unwrap_or(&volume.every_point);
        let rays_of =
            |count: fn(&LobeLight) -> u32| lights.frames.iter().map(|l| u64::from(count(l))).sum::<u64>();
        let every: Vec<u32> = (0..light_count).collect();
        if !self.moved.is_empty() {
            self.moved.sort_unstable();
            self.moved.dedup();
            let moved = |count: fn(&LobeLight) -> u32| {
                let counts = self.moved.iter().map(|l| count(&lights.frames[*l as usize]));
                counts.map(u64::from).sum::<u64>()
            };
            let again = |work: &WorkList| work.collect_again(gpu, &self.lister, wanted, DONE);
            let points = again(&volume.visibility_work)?;
            self.march_lights(gpu, volume, lights, Records::Visibility, points, &self.moved)?;
            report.visibility_rays += u64::from(points) * moved(|light| light.visibility_count);
            let points = again(&volume.path_work)?;
            self.march_lights(gpu, volume, lights, Records::Path, points, &self.moved)?;
            report.path_rays += u64::from(points) * moved(|light| light.path_count + 1);
        }
        let points = volume.visibility_work.collect(gpu, &self.lister, wanted, DONE)?;
        match &mut self.harmonics {
            Some(harmonics) if points > 0 => {
                let items = &volume.visibility_work.items;
                harmonics.run(gpu, &volume.parts(), &lights.lights, &self.batches, items, points)?;
            }
            None if points > 0 => {
                self.march_lights(gpu, volume, lights, Records::Visibility, points, &every)?;
                report.visibility_rays += u64::from(points) * rays_of(|light| light.visibility_count);
            }
            _ => {}
        }
        if let (1.., Some(exact), None) = (rays, &lights.exact, &self.harmonics) {
            let work = &volume.visibility_work;
            let most = self.interrupt.as_ref().map_or(u32::MAX, |_| uninterrupted(gpu));
            loop {
                // What is queued cannot be called back.
                gpu.wait()?;
                if self
                    .interrupt
                    .as_ref()
                    .is_some_and(|flag| flag.load(Ordering::Relaxed))
                {
                    return Err(GpuError::Interrupted);
                }
                let points = work.collect_some(gpu, &self.lister, wanted, DONE + rays, most)?;
                if points > 0 {
                    self.march_lights(gpu, volume, lights, Records::Exact(exact), points, &every)?;
                    self.traced += u64::from(points) * exact.total_rays;
                }
                if points < most {
                    break;
                }
            }
            report.exact_rays = std::mem::take(&mut self.traced);
        }
        if self.has_paint {
            let points = volume.path_work.collect(gpu, &self.lister, wanted, DONE)?;
            if points > 0 {
                self.march_lights(gpu, volume, lights, Records::Path, points, &every)?;
                report.path_rays += u64::from(points) * rays_of(|light| light.path_count + 1);
            }
        }
        self.moved.clear();
        Ok(report)
    }

    /// The records, batch after batch.
    pub fn batches(&self) -> &[LightBatch] {
        &self.batches
    }

    /// Frames of the lights (`LobeLight`), as the marches read them.
    pub fn light_buffer(&self) -> Option<&wgpu::Buffer> {
        self.lights.as_ref().map(|lights| &lights.lights)
    }

    /// Directions of the lights (`LobeDirection`), as the marches read them.
    pub fn direction_buffer(&self) -> Option<&wgpu::Buffer> {
        self.lights.as_ref().map(|lights| &lights.directions)
    }

    /// The table that `shaders/lib/averages_table.wgsl` looks up: [`AVERAGES_ENTRIES`] times four floats.
    pub fn averages_table(&self) -> &wgpu::Buffer {
        &self.averages
    }

    /// Uniform `VolumeGrid`, brick table and densities, for other passes that march (`shaders/lib/volume.wgsl`).
    pub fn volume_buffers(&self) -> Option<[&wgpu::Buffer; 3]> {
        self.volume
            .as_ref()
            .map(|volume| [&volume.grid, &volume.bricks, &volume.density])
    }

    fn run_averages(&self, gpu: &Gpu, fibre: &MeanFibre) {
        let fibre = gpu.uniform_of("mean fibre", fibre);
        let pass = &self.averages_pass.1;
        let bindings = pass.bind(gpu, &[(0, &self.tables), (1, &fibre), (2, &self.averages)]);
        pass.run(gpu, &bindings, AVERAGES_NODES);
    }

    /// Paints the voxels that are stale and returns their number.
    fn run_paint(&self, gpu: &Gpu, volume: &VolumeBuffers, params: &wgpu::Buffer) -> Result<u64, GpuError> {
        let touched = volume.segment_voxels.touched(&self.stale.paint);
        let (run, listed, count) = paint_run(gpu, touched.as_deref(), volume.stored_voxels)?;
        let buffers = [
            (0, &volume.first_share),
            (1, &volume.shares),
            (2, params),
            (3, &self.averages),
            (4, &volume.forward),
            (5, &volume.behind),
            (6, &run),
            (7, &listed),
        ];
        self.density_paint
            .run(gpu, &self.density_paint.bind(gpu, &buffers), count);
        Ok(u64::from(count))
    }

    /// Marches from the listed points to those of `lights` that are numbered, in submissions small enough that a slow adapter stays
    /// responsive between them.
    fn march_lights(
        &self,
        gpu: &Gpu,
        volume: &VolumeBuffers,
        lights: &LightBuffers,
        records: Records<'_>,
        listed_points: u32,
        numbered: &[u32],
    ) -> Result<(), GpuError> {
        let lights_at_once = (MARCHED_AT_ONCE / listed_points.max(1)).max(1) as usize;
        for batch in self.batches.iter().filter(|_| listed_points > 0) {
            let numbered = numbered.iter().copied();
            let runs: Vec<LightRun> = numbered
                .filter(|light| batch.lights.contains(light))
                .map(|light| LightRun {
                    point_count: volume.point_count,
                    light,
                    first_record: (light - batch.lights.start) * volume.point_count,
                    prior: match records {
                        Records::Exact(exact) => exact.prior[light as usize],
                        Records::Visibility | Records::Path => 0.0,
                    },
                })
                .collect();
            for runs in runs.chunks(lights_at_once) {
                let run_table = gpu.storage_of("light runs", runs)?;
                let (light_table, directions) = match records {
                    Records::Exact(exact) => (&exact.lights, &exact.directions),
                    Records::Visibility | Records::Path => (&lights.lights, &lights.directions),
                };
                let common = [
                    (0, &volume.grid),
                    (1, &volume.bricks),
                    (2, &volume.density),
                    (3, &volume.points),
                    (4, &volume.point_ends),
                    (5, light_table),
                    (6, directions),
                    (7, &run_table),
                ];
                let (kernel, own): (_, &[(u32, &wgpu::Buffer)]) = match records {
                    Records::Visibility => (
                        &self.visibility,
                        &[(8, &batch.visibility), (9, &volume.visibility_work.items)],
                    ),
                    Records::Exact(_) => (
                        &self.visibility_exact,
                        &[
                            (8, &batch.visibility),
                            (9, &volume.visibility_work.items),
                            (10, &volume.first_share),
                            (11, &volume.shares),
                        ],
                    ),
                    Records::Path => (
                        &self.path,
                        &[
                            (8, &volume.forward),
                            (9, &volume.behind),
                            (10, &batch.path),
                            (11, &volume.path_work.items),
                        ],
                    ),
                };
                let bindings = kernel.bind(gpu, &[&common, own].concat());
                kernel.run(gpu, &bindings, listed_points * runs.len() as u32);
            }
        }
        Ok(())
    }
}

/// The pass that fills the table of averages of a model.
fn averages_pass(gpu: &Gpu, model: Model) -> Result<Kernel, GpuError> {
    let method = Method {
        model,
        ..Method::default()
    };
    // Its node counts are no matter of quality.
    Kernel::composed(gpu, "pass/averages.wgsl", method.files(), &[])
}

/// Which of the two records is written, and how.
#[derive(Clone, Copy)]
enum Records<'a> {
    Visibility,
    Exact(&'a ExactLights),
    Path,
}

/// As many lights a batch as the adapter's limits allow.
fn allocate_batches(gpu: &Gpu, point_count: u32, light_count: u32) -> Result<Vec<LightBatch>, GpuError> {
    let limit = gpu.most_bound_bytes();
    let per_light = PATH_BYTES * u64::from(point_count).max(1);
    let lights_per_batch = (limit / per_light).clamp(1, u64::from(light_count.max(1))) as usize;
    (0..light_count)
        .step_by(lights_per_batch)
        .map(|first| {
            let lights = first..(first + lights_per_batch as u32).min(light_count);
            let records = lights.len() as u64 * u64::from(point_count);
            Ok(LightBatch {
                lights,
                visibility: gpu.storage("visibility records", VISIBILITY_BYTES * records)?,
                path: gpu.storage("path records", PATH_BYTES * records)?,
            })
        })
        .collect()
}
