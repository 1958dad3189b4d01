//! The refined strands on the GPU.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

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
    /// [`Segment`] each, strand after strand in an order whose every beginning is a fair sample of the hair.
    pub segments: wgpu::Buffer,
    /// u32 a vertex: how many vertices before it and (upper half) behind it the next shaded ones are; 0 for a vertex that is shaded itself.
    pub spans: wgpu::Buffer,
    /// Vertices that are interpolated where [`super::Saving::Straight`] is made.
    pub straight_vertices: u32,
    /// Index of the refined vertex of every groom point.
    pub point_vertices: wgpu::Buffer,
    /// Scene-linear radiance by multiple scattering, vec4 a groom point.
    pub multiple: wgpu::Buffer,
    /// Scene-linear radiance by single scattering, vec4 a vertex.
    pub single: wgpu::Buffer,
    /// Scene-linear radiance, vec4 a vertex; a is the number of the frame that changed it.
    pub radiance: wgpu::Buffer,
    /// Number of vertices.
    pub vertex_count: u32,
    /// Number of segments.
    pub segment_count: u32,
    /// Number of groom points.
    pub point_count: u32,
    /// u32 a vertex: 1 where it is shaded for some pixel, 2 where a pixel shows it interpolated, else 0.
    pub wanted_vertices: wgpu::Buffer,
    /// u32 a groom point, not 0 where a wanted vertex lies beside it.
    pub wanted_points: wgpu::Buffer,
    /// Vertices whose single scattering is up to date.
    pub single_work: WorkList,
    /// Groom points whose multiple scattering is up to date.
    pub multiple_work: WorkList,
    first_vertex_of_point: Vec<u32>,
    /// Segments of the first strands, and length times diameter of theirs, for every number of strands from 0 on.
    beginnings: Vec<(u32, f64)>,
}

/// Turn of the tangent over which radiance is interpolated linearly.
const STRAIGHT_RAD: f32 = 6.0 * std::f32::consts::PI / 180.0;

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
        let (segments, beginnings) = sampled_order(vertices, segments);
        let spans = spans(vertices, &point_vertices);
        Ok(Self {
            vertices: gpu.storage_of("refined vertices", vertices)?,
            segments: gpu.storage_of("segments", &segments)?,
            straight_vertices: spans.iter().filter(|span| **span != 0).count() as u32,
            spans: gpu.storage_of("straight spans", &spans)?,
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
            beginnings,
        })
    }

    /// Segments to draw for `share` of the strands (at least one strand), and the factor on their width that keeps the hair's area.
    pub fn sample(&self, share: f32) -> (u32, f32) {
        let strands = self.beginnings.len() - 1;
        let count = ((share * strands as f32).ceil() as usize).clamp(1.min(strands), strands);
        let (segments, area) = self.beginnings[count];
        let whole = self.beginnings[strands].1;
        let factor = if area > 0.0 && count < strands {
            whole / area
        } else {
            1.0
        };
        (segments, factor as f32)
    }

    /// Takes the radiance (rgb) of every vertex as it is.
    pub fn set_radiance(&self, gpu: &Gpu, radiance: &[[f32; 4]]) {
        gpu.queue
            .write_buffer(&self.radiance, 0, bytemuck::cast_slice(radiance));
    }

    /// Every vertex is wanted.
    pub fn want_everything(&self, gpu: &Gpu) {
        for (buffer, count) in [
            (&self.wanted_vertices, self.vertex_count),
            (&self.wanted_points, self.point_count),
        ] {
            gpu.queue
                .write_buffer(buffer, 0, bytemuck::cast_slice(&vec![1_u32; count as usize]));
        }
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

/// The segments with their strands in the order of a mixed index (SplitMix64), and what [`StrandBuffers::beginnings`] holds.
fn sampled_order(vertices: &[RefinedVertex], segments: &[Segment]) -> (Vec<Segment>, Vec<(u32, f64)>) {
    let mut strands: Vec<&[Segment]> = segments.chunk_by(|a, b| a.strand == b.strand).collect();
    strands.sort_by_cached_key(|segments| {
        let mut x = u64::from(segments[0].strand).wrapping_add(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    });
    let mut beginnings = vec![(0, 0.0)];
    let (mut count, mut area) = (0, 0.0);
    for strand in &strands {
        count += strand.len() as u32;
        for segment in *strand {
            let [a, b] = [0, 1].map(|k| &vertices[segment.vertex as usize + k]);
            let length = Vec3::from(a.position).distance(b.position.into());
            area += f64::from(length * 0.5 * (a.diameter + b.diameter));
        }
        beginnings.push((count, area));
    }
    (strands.concat(), beginnings)
}

/// What [`StrandBuffers::spans`] holds: between two groom points a vertex is skipped while the tangent turns by no more than [`STRAIGHT_RAD`]
/// from the last one kept to the one behind it.
fn spans(vertices: &[RefinedVertex], point_vertices: &[u32]) -> Vec<u32> {
    let mut spans = vec![0; vertices.len()];
    let ends = point_vertices.iter().skip(1).copied();
    for (first, end) in point_vertices.iter().copied().zip(ends) {
        let tangent = |i: usize| Vec3::from(vertices[i].tangent);
        let mut kept = first as usize;
        for next in first as usize + 1..=end as usize {
            let may_skip = next < end as usize
                && tangent(kept).angle_between(tangent(next + 1)) <= STRAIGHT_RAD
                && next + 1 - kept < 1 << 16;
            if may_skip {
                continue;
            }
            for (skipped, span) in spans.iter_mut().enumerate().take(next).skip(kept + 1) {
                *span = (skipped - kept) as u32 | (((next - skipped) as u32) << 16);
            }
            kept = next;
        }
    }
    spans
}
