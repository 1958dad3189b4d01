//! Visibility and path sums per (point, light): uploads the density volume, runs the marches, keeps what is not stale.
//!
//! Passes, in order: `averages` (table of what one fibre does), `density_paint` (losses per voxel), `transmittance_visibility` or, once a
//! view rests, `visibility_exact`, `transmittance_path`. Visibility depends on geometry and lights; the path sums on paint as well.

mod dirty_boxes;
mod exact_lights;
mod light_buffers;
mod march;
mod mean_fibre;
mod volume_buffers;

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::{Deserialize, Serialize};

use dirty_boxes::{DirtyBox, boxes_around};
use exact_lights::ExactLights;
use light_buffers::LightBuffers;
use march::{Records, allocate_batches};
pub use mean_fibre::MeanFibre;
use volume_buffers::VolumeBuffers;

use super::sh9::Harmonics;
use super::voxel_paint::{DirtyPoints, paint_run};
use super::work_list::{DONE, Lister, WorkList};
use super::{Gpu, GpuError, Kernel, Method, Model};
use crate::gpu::tables::scattering_tables;
use crate::light::SrbfLight;
use crate::volume::lobe::LobeLight;
use crate::volume::{DensityVolume, Occluder, SolidVoxels, Strands, VolumeSettings};

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
    /// [`PATH_BYTES`] per record, or one record where they are not wanted.
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

/// What has to run again.
struct Stale {
    averages: bool,
    paint: DirtyPoints,
    lights: bool,
    /// Where voxels were painted that path sums do not know of yet.
    ways: Vec<DirtyBox>,
}

/// Points whose path sums changed with the paint.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ChangedPoints {
    None,
    Marked,
    All,
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
    changed: ChangedPoints,
    /// Lights whose records are stale where the others' are not.
    moved: Vec<u32>,
    has_paint: bool,
    interrupt: Option<Arc<AtomicBool>>,
    /// Whether path sums are wanted.
    sums_ways: bool,
    solid: Option<SolidVoxels>,
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
                ways: Vec::new(),
            },
            changed: ChangedPoints::None,
            moved: Vec::new(),
            has_paint: false,
            interrupt: None,
            sums_ways: true,
            solid: None,
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
        self.solid = SolidVoxels::of(&volume);
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
        self.stale.ways.clear();
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

    /// What stands in the light's way, for rays on the CPU; taken once.
    pub fn take_solid(&mut self) -> Option<SolidVoxels> {
        self.solid.take()
    }

    /// Whether path sums are wanted, and what they are made from. They are unless this says no.
    pub fn want_path_sums(&mut self, wanted: bool) {
        self.sums_ways = wanted;
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
        self.sums_ways && self.stale.paint != DirtyPoints::NONE
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
            let touched = volume.segment_voxels.touched(&self.stale.paint);
            report.painted_voxels = self.run_paint(gpu, volume, params, touched.as_deref())?;
            if let Some(voxels) = &touched {
                self.stale
                    .ways
                    .extend(boxes_around(&volume.stored_bricks, voxels));
            } else {
                volume.path_work.forget_all(gpu);
                self.changed = ChangedPoints::All;
            }
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
        if self.sums_ways {
            for batch in &mut self.batches {
                let bytes = PATH_BYTES * batch.lights.len() as u64 * u64::from(volume.point_count);
                if batch.path.size() < bytes {
                    batch.path = gpu.storage("path records", bytes)?;
                    volume.path_work.forget_all(gpu);
                }
            }
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
            if self.sums_ways {
                let points = again(&volume.path_work)?;
                self.march_lights(gpu, volume, lights, Records::Path, points, &self.moved)?;
                report.path_rays += u64::from(points) * moved(|light| light.path_count + 1);
            } else {
                volume.path_work.forget_all(gpu);
            }
        }
        if !self.stale.ways.is_empty() {
            // Those that no pixel shows as well: they are up to date, and few of them change.
            let every_point = &volume.every_point;
            let points = volume
                .path_work
                .collect_again(gpu, &self.lister, every_point, DONE)?;
            if points > 0 {
                let boxes = gpu.storage_of("dirty boxes", &self.stale.ways)?;
                let mut encoder = gpu.device.create_command_encoder(&Default::default());
                encoder.clear_buffer(&volume.path_marks, 0, Some(4));
                gpu.queue.submit([encoder.finish()]);
                self.march_lights(gpu, volume, lights, Records::PathAgain(&boxes), points, &every)?;
                report.path_rays += u64::from(gpu.read::<u32>(&volume.path_marks, 1)?[0]);
                if self.changed == ChangedPoints::None {
                    self.changed = ChangedPoints::Marked;
                }
            }
            self.stale.ways.clear();
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
        if self.has_paint && self.sums_ways {
            let points = volume.path_work.collect(gpu, &self.lister, wanted, DONE)?;
            if points > 0 {
                self.march_lights(gpu, volume, lights, Records::Path, points, &every)?;
                report.path_rays += u64::from(points) * rays_of(|light| light.path_count + 1);
            }
        }
        self.moved.clear();
        Ok(report)
    }

    /// What was made from the path sums of points, and is listed in `work`, is stale where paint has changed them since the last call.
    pub fn forget_changed(&mut self, gpu: &Gpu, work: &WorkList) {
        match (self.changed, &self.volume) {
            (ChangedPoints::Marked, Some(volume)) => {
                work.forget_marked(gpu, &self.lister, &volume.path_marks);
            }
            (ChangedPoints::All, _) => work.forget_all(gpu),
            _ => {}
        }
        self.changed = ChangedPoints::None;
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

    /// What surrounds every point ([`crate::volume::Neighbours`]).
    pub fn neighbours(&self) -> Option<&wgpu::Buffer> {
        self.volume.as_ref().map(|volume| &volume.neighbours)
    }

    fn run_averages(&self, gpu: &Gpu, fibre: &MeanFibre) {
        let fibre = gpu.uniform_of("mean fibre", fibre);
        let pass = &self.averages_pass.1;
        let bindings = pass.bind(gpu, &[(0, &self.tables), (1, &fibre), (2, &self.averages)]);
        pass.run(gpu, &bindings, AVERAGES_NODES);
    }

    /// Paints the voxels of the list, all without one, and returns their number.
    fn run_paint(
        &self,
        gpu: &Gpu,
        volume: &VolumeBuffers,
        params: &wgpu::Buffer,
        touched: Option<&[u32]>,
    ) -> Result<u64, GpuError> {
        let (run, listed, count) = paint_run(gpu, touched, volume.stored_voxels)?;
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
