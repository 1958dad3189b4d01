//! The refined strands on the GPU.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};

use super::work_list::WorkList;
use super::{Gpu, GpuError};
use crate::groom::RefinedGroom;

/// Layout of `RefinedVertex` in `shaders/lib/refined.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct RefinedVertex {
    /// World position, groom units.
    pub position: [f32; 3],
    /// Fibre diameter, groom units.
    pub diameter: f32,
    /// Unit tangent, root to tip.
    pub tangent: [f32; 3],
    /// Place between `source_point` and the next groom point, in [0, 1].
    pub source_fraction: f32,
    /// Unit normal v, rotation-minimizing along the strand.
    pub normal: [f32; 3],
    /// Groom point before this vertex; the next one belongs to the same strand.
    pub source_point: u32,
}

/// Layout of `Segment` in `shaders/lib/refined.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Segment {
    /// First refined vertex; the second one follows it.
    pub vertex: u32,
    /// Strand that it belongs to.
    pub strand: u32,
}

/// Vertices, segments and the radiance that shading leaves on the vertices.
pub struct StrandBuffers {
    /// [`RefinedVertex`] each.
    pub vertices: wgpu::Buffer,
    /// [`Segment`] each.
    pub segments: wgpu::Buffer,
    /// Index of the refined vertex of every groom point.
    pub point_vertices: wgpu::Buffer,
    /// Scene-linear radiance by multiple scattering, vec4 a groom point.
    pub multiple: wgpu::Buffer,
    /// Scene-linear radiance by single scattering, vec4 a vertex.
    pub single: wgpu::Buffer,
    /// Scene-linear radiance, vec4 a vertex.
    pub radiance: wgpu::Buffer,
    /// Number of vertices.
    pub vertex_count: u32,
    /// Number of segments.
    pub segment_count: u32,
    /// Number of groom points.
    pub point_count: u32,
    /// u32 a vertex, not 0 where some pixel shows it.
    pub wanted_vertices: wgpu::Buffer,
    /// u32 a groom point, not 0 where a wanted vertex lies beside it.
    pub wanted_points: wgpu::Buffer,
    /// Vertices whose single scattering is up to date.
    pub single_work: WorkList,
    /// Groom points whose multiple scattering is up to date.
    pub multiple_work: WorkList,
    first_vertex_of_point: Vec<u32>,
}

impl StrandBuffers {
    /// Uploads `groom`.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`].
    pub fn new(gpu: &Gpu, groom: &RefinedGroom) -> Result<Self, GpuError> {
        let first_point = groom.first_point();
        let mut vertices = Vec::with_capacity(groom.positions().len());
        let mut segments = Vec::with_capacity(vertices.capacity());
        for (strand, ends) in first_point.windows(2).enumerate() {
            for i in ends[0]..ends[1] {
                let k = i as usize;
                vertices.push(RefinedVertex {
                    position: groom.positions()[k].to_array(),
                    diameter: groom.diameters()[k],
                    tangent: groom.tangents()[k].to_array(),
                    source_fraction: groom.source_fraction()[k],
                    normal: groom.normals()[k].to_array(),
                    source_point: groom.source_point()[k],
                });
                if i + 1 < ends[1] {
                    segments.push(Segment {
                        vertex: i,
                        strand: strand as u32,
                    });
                }
            }
        }
        Self::from_parts(gpu, &vertices, &segments)
    }

    /// Uploads vertices and segments as they are.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`].
    pub fn from_parts(gpu: &Gpu, vertices: &[RefinedVertex], segments: &[Segment]) -> Result<Self, GpuError> {
        // The refined vertex at a groom point is the first one that has it as its source.
        let mut point_vertices = Vec::new();
        for (index, vertex) in vertices.iter().enumerate() {
            if vertex.source_point as usize == point_vertices.len() {
                point_vertices.push(index as u32);
            }
        }
        Ok(Self {
            vertices: gpu.storage_of("refined vertices", vertices)?,
            segments: gpu.storage_of("segments", segments)?,
            point_vertices: gpu.storage_of("point vertices", &point_vertices)?,
            multiple: gpu.storage("multiple scattering", 16 * point_vertices.len() as u64)?,
            single: gpu.storage("single scattering", 16 * vertices.len() as u64)?,
            radiance: gpu.storage("strand radiance", 16 * vertices.len() as u64)?,
            wanted_vertices: gpu.storage("wanted vertices", 4 * vertices.len() as u64)?,
            wanted_points: gpu.storage("wanted points", 4 * point_vertices.len() as u64)?,
            single_work: WorkList::new(gpu, "single scattering to do", vertices.len() as u32)?,
            multiple_work: WorkList::new(gpu, "multiple scattering to do", point_vertices.len() as u32)?,
            vertex_count: vertices.len() as u32,
            segment_count: segments.len() as u32,
            point_count: point_vertices.len() as u32,
            first_vertex_of_point: point_vertices,
        })
    }

    /// No vertex is wanted any more.
    pub fn want_nothing(&self, gpu: &Gpu) {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&self.wanted_vertices, 0, None);
        encoder.clear_buffer(&self.wanted_points, 0, None);
        gpu.queue.submit([encoder.finish()]);
    }

    /// All shading is stale.
    pub fn forget_shading(&self, gpu: &Gpu) {
        self.single_work.forget_all(gpu);
        self.multiple_work.forget_all(gpu);
    }

    /// Shading that depends on the parameters of these groom points is stale: theirs, and that of the vertices from the point before on.
    pub fn forget_points(&self, gpu: &Gpu, ranges: &[Range<u32>]) {
        let vertex = |point: u32| {
            let first = self.first_vertex_of_point.get(point as usize);
            first.copied().unwrap_or(self.vertex_count)
        };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        for points in ranges {
            let vertices = vertex(points.start.saturating_sub(1))..vertex(points.end);
            self.single_work.forget(&mut encoder, vertices);
            self.multiple_work.forget(&mut encoder, points.clone());
        }
        gpu.queue.submit([encoder.finish()]);
    }
}
