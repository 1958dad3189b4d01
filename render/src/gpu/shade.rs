//! Strand shading: which lobes and which multiple scattering, and the pass that evaluates them per refined vertex.

mod settings;

use std::ops::{AddAssign, Range};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

pub use settings::{Multiple, ShadeSettings, Terms};

use super::scattered_light::FieldBuffers;
use super::strands::StrandBuffers;
use super::tables::scattering_tables;
use super::transmittance::{LightBatch, Transmittance};
use super::work_list::Lister;
use super::{Gpu, GpuError, Kernel, Method, Quality, Saving, Savings};
use crate::photon::{DIRECTIONS, part_directions};

/// Layout of `ShadeUniform` in `shaders/pass/shade.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ShadeUniform {
    camera_position: [f32; 3],
    vertex_count: u32,
    constant: [f32; 3],
    point_count: u32,
    terms: u32,
    first_light: u32,
    light_count: u32,
    first_record: u32,
    adds: u32,
    multiple: u32,
    together_first: u32,
    together_count: u32,
}

/// What shading reads besides the strands.
pub struct ShadeInputs<'a> {
    /// World position of the eye.
    pub camera_position: Vec3,
    /// `VertexParams` per groom point.
    pub params: &'a wgpu::Buffer,
    /// Whether any of them is of an elliptic section.
    pub has_elliptic: bool,
    /// `Light` per light, those of the uniform environment at the end.
    pub lights: &'a wgpu::Buffer,
    /// Lights in front of those that stand for the uniform environment.
    pub real_light_count: u32,
    /// Radiance of the uniform environment.
    pub constant: Vec3,
    /// Records per (point, light).
    pub transmittance: &'a Transmittance,
    /// Light that fibres send each other, where it was traced.
    pub field: Option<&'a FieldBuffers>,
    /// What need not be done.
    pub savings: Savings,
    /// Number of this frame.
    pub frame: f32,
    /// While the flag is true shading ends where it is.
    pub interrupt: Option<&'a AtomicBool>,
}

/// Vertices that are shaded between two looks at the interrupt, on a GPU and in software: some hundredths of a second.
const UNINTERRUPTED: u32 = 1 << 17;
const SOFTWARE_UNINTERRUPTED: u32 = 1 << 11;

/// The passes, compiled for the variants that were used last.
pub struct ShadePass {
    variants: Vec<(Variant, ShadeKernels)>,
    /// The variant that a thread of its own compiles.
    coming: Option<(Variant, JoinHandle<Result<ShadeKernels, GpuError>>)>,
    lister: Lister,
    sum: Kernel,
    tables: wgpu::Buffer,
    /// vec4 for each quarter of the parts of a light field.
    part_directions: wgpu::Buffer,
}

/// Variants that are kept: drafts and pictures at rest of a few methods.
const MOST_VARIANTS: usize = 8;

/// What the passes are compiled for.
#[derive(Clone, Copy, PartialEq)]
struct Variant {
    method: Method,
    is_traced: bool,
    may_be_elliptic: bool,
    follows_absorbed: bool,
    skips_hidden: bool,
}

impl Variant {
    fn new(settings: &ShadeSettings, has_elliptic: bool, savings: Savings) -> Self {
        Self {
            method: settings.method,
            is_traced: settings.is_traced(),
            may_be_elliptic: has_elliptic || !savings.has(Saving::Circular),
            follows_absorbed: !savings.has(Saving::Absorbed),
            skips_hidden: savings.has(Saving::Hidden),
        }
    }
}

struct ShadeKernels {
    single: Kernel,
    multiple: MultipleKernel,
}

/// Where multiple scattering comes from.
enum MultipleKernel {
    /// The model knows none.
    None,
    /// The path sums of every light.
    Lights(Kernel),
    /// A light field.
    Field(Kernel),
}

/// What shading evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShadeReport {
    /// Refined vertices whose single scattering was stale and that a pixel shows.
    pub vertices: u64,
    /// (refined vertex, light) pairs of single scattering.
    pub single: u64,
    /// Of these, pairs whose fibre is of elliptic section.
    pub elliptic: u64,
    /// (groom point, light) pairs of multiple scattering; with a light field, parts of the sphere that light came from.
    pub multiple: u64,
    /// Pairs of both kinds that were left out because next to nothing of the light arrives.
    pub hidden: u64,
    /// Variants of the passes that had to be compiled first, because nobody had them prepared.
    pub compiled: u64,
}

impl AddAssign for ShadeReport {
    fn add_assign(&mut self, other: Self) {
        self.vertices += other.vertices;
        self.single += other.single;
        self.elliptic += other.elliptic;
        self.multiple += other.multiple;
        self.hidden += other.hidden;
        self.compiled += other.compiled;
    }
}

impl Drop for ShadePass {
    /// A driver must not be unloaded under a thread that compiles.
    fn drop(&mut self) {
        if let Some((_, thread)) = self.coming.take() {
            // What it made, or why it made nothing, is of no interest any more.
            let _ = thread.join();
        }
    }
}

impl ShadePass {
    /// Uploads the scattering tables; the passes are compiled at the first frame, when their quality is known.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`].
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let parts: Vec<[f32; 4]> = (0..DIRECTIONS)
            .flat_map(part_directions)
            .map(|direction| direction.extend(0.0).to_array())
            .collect();
        Ok(Self {
            variants: Vec::new(),
            coming: None,
            lister: Lister::new(gpu)?,
            sum: Kernel::new(gpu, "pass/strand_radiance.wgsl", &[])?,
            tables: gpu.storage_of("scattering tables", &scattering_tables())?,
            part_directions: gpu.storage_of("parts of the sphere", &parts)?,
        })
    }

    /// What is shaded of the wanted vertices counts as done less well than `quality`; the picture keeps it until then.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    pub fn demote(&self, gpu: &Gpu, strands: &StrandBuffers, quality: Quality) -> Result<(), GpuError> {
        let (wanted, below) = (&strands.wanted_vertices, level(quality) - 1);
        strands
            .single_work
            .collect_again(gpu, &self.lister, wanted, below)?;
        Ok(())
    }

    /// Brings the radiance of the strands' wanted vertices up to date.
    ///
    /// # Errors
    /// [`GpuError::Refused`] when a shader does not compile, [`GpuError::Interrupted`] (what was shaded until then is kept),
    /// [`GpuError::Lost`].
    pub fn run(
        &mut self,
        gpu: &Gpu,
        settings: &ShadeSettings,
        strands: &StrandBuffers,
        inputs: &ShadeInputs<'_>,
    ) -> Result<ShadeReport, GpuError> {
        let lights = runs(settings, strands, inputs);
        // What no pass fills is dark.
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        if !settings.scatters_often() || lights.is_empty() || (settings.is_traced() && inputs.field.is_none())
        {
            encoder.clear_buffer(&strands.multiple, 0, None);
        }
        if lights.is_empty() {
            encoder.clear_buffer(&strands.single, 0, None);
            encoder.clear_buffer(&strands.radiance, 0, None);
        }
        gpu.queue.submit([encoder.finish()]);

        let most = match inputs.interrupt {
            None => u32::MAX,
            Some(_) if gpu.is_software => SOFTWARE_UNINTERRUPTED,
            Some(_) => UNINTERRUPTED,
        };
        let quality = settings.method.quality;
        let multiple_level = level(multiple_quality(quality));
        let mut report = ShadeReport::default();
        let mut left = !lights.is_empty();
        while left {
            if inputs.interrupt.is_some_and(|flag| flag.load(Ordering::Relaxed)) {
                return Err(GpuError::Interrupted);
            }
            let (points, vertices) = (&strands.multiple_work, &strands.single_work);
            let points = if settings.scatters_often() {
                points.collect_some(gpu, &self.lister, &strands.wanted_points, multiple_level, most)?
            } else {
                0
            };
            let vertices =
                vertices.collect_some(gpu, &self.lister, &strands.wanted_vertices, level(quality), most)?;
            report += self.scatter(gpu, settings, strands, inputs, &lights, [vertices, points])?;
            report.vertices += u64::from(vertices);
            left = vertices.max(points) == most;
        }

        let uniform = gpu.uniform_of(
            "radiance",
            &RadianceUniform {
                frame: inputs.frame,
                straight: u32::from(inputs.savings.has(Saving::Straight)),
                pad: [0; 2],
            },
        );
        let sum = [
            (0, &strands.vertices),
            (1, &strands.single),
            (2, &strands.multiple),
            (3, &strands.radiance),
            (4, &strands.spans),
            (5, &uniform),
            (6, &strands.wanted_vertices),
        ];
        self.sum.run(gpu, &self.sum.bind(gpu, &sum), strands.vertex_count);
        Ok(report)
    }

    /// Adds what the lights numbered `few` give to the wanted vertices that are up to date but for them; a negative radiance takes away. Vertices that are up to date and not wanted become stale.
    ///
    /// # Errors
    /// [`GpuError::Refused`] when a shader does not compile, [`GpuError::Lost`].
    pub fn add(
        &mut self,
        gpu: &Gpu,
        settings: &ShadeSettings,
        strands: &StrandBuffers,
        inputs: &ShadeInputs<'_>,
        few: &[u32],
    ) -> Result<ShadeReport, GpuError> {
        if few.is_empty() {
            return Ok(ShadeReport::default());
        }
        let mut lights = Vec::new();
        for light in few {
            let holds = |batch: &&LightBatch| batch.lights.contains(light);
            if let Some(batch) = inputs.transmittance.batches().iter().find(holds) {
                let range = *light..*light + 1;
                let uniform = uniform(settings, strands, inputs, batch, range);
                lights.push(Run { batch, uniform });
            }
        }
        let (lister, best) = (&self.lister, u32::MAX);
        // A light field holds all lights.
        let points = if settings.sums_ways() {
            strands
                .multiple_work
                .collect_again(gpu, lister, &strands.wanted_points, best)?
        } else {
            0
        };
        let vertices = strands
            .single_work
            .collect_again(gpu, lister, &strands.wanted_vertices, best)?;
        self.scatter(gpu, settings, strands, inputs, &lights, [vertices, points])
    }

    /// Scatters `lights` at the listed vertices (single) and points (multiple).
    fn scatter(
        &mut self,
        gpu: &Gpu,
        settings: &ShadeSettings,
        strands: &StrandBuffers,
        inputs: &ShadeInputs<'_>,
        lights: &[Run<'_>],
        [vertices, points]: [u32; 2],
    ) -> Result<ShadeReport, GpuError> {
        let mut report = ShadeReport::default();
        let buffers = (
            inputs.transmittance.light_buffer(),
            inputs.transmittance.direction_buffer(),
            inputs.transmittance.neighbours(),
        );
        let (Some(frames), Some(directions), Some(neighbours)) = buffers else {
            return Ok(report);
        };
        if lights.is_empty() || vertices.max(points) == 0 {
            return Ok(report);
        }
        let variant = Variant::new(settings, inputs.has_elliptic, inputs.savings);
        report.compiled = u64::from(self.compile(gpu, variant)?);
        let Some((_, kernels)) = self.variants.last() else {
            return Ok(report);
        };
        let evaluated = gpu.storage("evaluated lights", 16)?;
        let common = [
            (1, &strands.vertices),
            (2, inputs.params),
            (3, inputs.lights),
            (4, frames),
            (5, &self.tables),
        ];
        let mut pairs = 0;
        if let (1.., MultipleKernel::Field(kernel), Some(field)) = (points, &kernels.multiple, inputs.field) {
            let uniform = gpu.uniform_of("shade", &lights[0].uniform);
            let buffers = [
                (0, &uniform),
                (1, &strands.vertices),
                (2, inputs.params),
                (3, &field.grid),
                (4, &field.numbers),
                (5, &self.tables),
                (6, &field.fibres),
                (7, &strands.multiple),
                (8, &field.radiance),
                (9, &self.part_directions),
                (10, &strands.point_vertices),
                (11, &strands.multiple_work.items),
                (12, &evaluated),
            ];
            kernel.run(gpu, &kernel.bind(gpu, &buffers), points);
        }
        for run in lights {
            let count = u64::from(run.uniform.light_count);
            let uniform = gpu.uniform_of("shade", &run.uniform);
            if let (1.., MultipleKernel::Lights(kernel)) = (points, &kernels.multiple) {
                let own = [
                    (0, &uniform),
                    (6, &run.batch.path),
                    (7, &strands.multiple),
                    (8, directions),
                    (9, inputs.transmittance.averages_table()),
                    (10, &strands.point_vertices),
                    (11, &strands.multiple_work.items),
                    (12, &evaluated),
                ];
                kernel.run(gpu, &kernel.bind(gpu, &[&common[..], &own].concat()), points);
                pairs += u64::from(points) * count;
            }
            if vertices > 0 {
                let own = [
                    (0, &uniform),
                    (6, &run.batch.visibility),
                    (7, &strands.single),
                    (8, &strands.single_work.items),
                    (9, &evaluated),
                    (10, neighbours),
                ];
                let bound = kernels.single.bind(gpu, &[&common[..], &own].concat());
                kernels.single.run(gpu, &bound, vertices);
                pairs += u64::from(vertices) * count;
            }
        }
        let evaluated = gpu.read::<u32>(&evaluated, 3)?;
        [report.single, report.elliptic, report.multiple] = [0, 1, 2].map(|k| u64::from(evaluated[k]));
        let of_lights = report.single + if settings.is_traced() { 0 } else { report.multiple };
        report.hidden = pairs - of_lights;
        Ok(report)
    }

    /// Compiles what a later picture will be shaded with, in a thread of its own, unless it is there or another one is under way.
    pub fn prepare(&mut self, gpu: &Gpu, settings: &ShadeSettings, has_elliptic: bool, savings: Savings) {
        let variant = Variant::new(settings, has_elliptic, savings);
        let is_there = self.variants.iter().any(|(v, _)| *v == variant);
        if !is_there && self.coming.is_none() {
            let gpu = gpu.clone();
            self.coming = Some((variant, thread::spawn(move || ShadeKernels::new(&gpu, variant))));
        }
    }

    /// Compiles a variant that was not used lately; it is the last one then. Returns whether it had to.
    fn compile(&mut self, gpu: &Gpu, variant: Variant) -> Result<bool, GpuError> {
        let is_done = |(v, thread): &mut (Variant, JoinHandle<_>)| *v == variant || thread.is_finished();
        if let Some((coming, thread)) = self.coming.take_if(is_done) {
            // A thread that failed or panicked has made nothing: what is wanted is compiled below, and the reason told there.
            if let Ok(Ok(kernels)) = thread.join() {
                self.variants.push((coming, kernels));
            }
        }
        let there = self.variants.iter().position(|(v, _)| *v == variant);
        let entry = match there {
            Some(place) => self.variants.remove(place),
            None => (variant, ShadeKernels::new(gpu, variant)?),
        };
        self.variants.push(entry);
        if self.variants.len() > MOST_VARIANTS {
            self.variants.remove(0);
        }
        Ok(there.is_none())
    }
}

/// How well a vertex is done by a quality: better ones stay when less is asked for.
fn level(quality: Quality) -> u32 {
    2 + quality as u32
}

/// Multiple scattering is an approximation of some percent: only pictures to compare with want its integrals finer.
fn multiple_quality(quality: Quality) -> Quality {
    match quality {
        Quality::High => Quality::Standard,
        Quality::Draft | Quality::Standard => Quality::Draft,
    }
}

/// Layout of `RadianceUniform` in `shaders/pass/strand_radiance.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct RadianceUniform {
    frame: f32,
    straight: u32,
    pad: [u32; 2],
}

impl ShadeKernels {
    fn new(gpu: &Gpu, variant: Variant) -> Result<Self, GpuError> {
        let _scope = tracing::info_span!("compile shading").entered();
        let method = variant.method;
        let quality = multiple_quality(method.quality);
        let skips_hidden = ("skips_hidden", f64::from(u8::from(variant.skips_hidden)));
        let single = [
            skips_hidden,
            ("may_be_elliptic", f64::from(u8::from(variant.may_be_elliptic))),
            ("follows_absorbed", f64::from(u8::from(variant.follows_absorbed))),
        ];
        let often = Method { quality, ..method };
        let multiple = if variant.is_traced {
            let instead = [("lib/window_series.wgsl", "lib/part_series.wgsl")];
            MultipleKernel::Field(Kernel::scattering_instead(
                gpu,
                "pass/shade_field.wgsl",
                &often,
                &instead,
                &[],
            )?)
        } else if method.model.scatters_often() {
            let path = "pass/shade_multiple.wgsl";
            MultipleKernel::Lights(Kernel::scattering_with(gpu, path, &often, &[skips_hidden])?)
        } else {
            MultipleKernel::None
        };
        Ok(Self {
            single: Kernel::scattering_with(gpu, "pass/shade.wgsl", &method, &single)?,
            multiple,
        })
    }
}

/// One dispatch: lights of one batch that are weighed alike.
struct Run<'a> {
    batch: &'a LightBatch,
    uniform: ShadeUniform,
}

/// The dispatches of a frame: batch after batch, the user's lights apart from those that stand for the uniform environment.
fn runs<'a>(settings: &ShadeSettings, strands: &StrandBuffers, inputs: &ShadeInputs<'a>) -> Vec<Run<'a>> {
    let mut runs: Vec<Run<'a>> = Vec::new();
    let batches = inputs.transmittance.batches();
    let all_uniform = inputs.real_light_count..batches.last().map_or(0, |batch| batch.lights.end);
    for batch in batches {
        let split = inputs
            .real_light_count
            .clamp(batch.lights.start, batch.lights.end);
        let parts = [
            (batch.lights.start..split, Vec3::ZERO),
            (split..batch.lights.end, inputs.constant),
        ];
        // Lights that stand for a uniform environment are weighed by the sum of all of them, whatever batch holds them.
        let most = settings.method.lights_per_dispatch() as usize;
        let [(real, none), constant_lights] = parts;
        let chunks = real.clone().step_by(most).map(|first| {
            let last = real.end.min(first.saturating_add(most as u32));
            (first..last, none)
        });
        for (lights, constant) in chunks
            .chain([constant_lights])
            .filter(|(lights, _)| !lights.is_empty())
        {
            let together = if constant == Vec3::ZERO {
                lights.clone()
            } else {
                all_uniform.clone()
            };
            let uniform = ShadeUniform {
                constant: constant.to_array(),
                adds: u32::from(!runs.is_empty()),
                together_first: together.start,
                together_count: together.len() as u32,
                ..uniform(settings, strands, inputs, batch, lights)
            };
            runs.push(Run { batch, uniform });
        }
    }
    runs
}

/// The uniform of a dispatch for consecutive lights of a batch, which add to what is there.
fn uniform(
    settings: &ShadeSettings,
    strands: &StrandBuffers,
    inputs: &ShadeInputs<'_>,
    batch: &LightBatch,
    lights: Range<u32>,
) -> ShadeUniform {
    ShadeUniform {
        camera_position: inputs.camera_position.to_array(),
        vertex_count: strands.vertex_count,
        constant: [0.0; 3],
        point_count: strands.point_count,
        terms: settings.terms.0,
        first_light: lights.start,
        light_count: lights.len() as u32,
        first_record: (lights.start - batch.lights.start) * strands.point_count,
        adds: 1,
        multiple: match settings.multiple {
            Multiple::M3 | Multiple::Traced | Multiple::Off => 0,
            Multiple::Zinke2008 => 1,
            Multiple::M2 => 2,
        },
        together_first: lights.start,
        together_count: lights.len() as u32,
    }
}
