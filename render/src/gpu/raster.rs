//! Strand drawing: fragments of every segment, listed per pixel, composed nearest first with exact sub-pixel coverage.
//!
//! A compute rasterizer: in software it is several times faster than hardware ribbons (1.3 us a triangle there), and its result
//! does not depend on the order of strands.

use bytemuck::{Pod, Zeroable};

use super::camera::CameraUniform;
use super::head::HeadTarget;
use super::strands::StrandBuffers;
use super::{Gpu, GpuError, Kernel};

/// Bytes of a fragment, `FRAGMENT_WORDS` in `shaders/lib/fragment.wgsl`.
const FRAGMENT_BYTES: u64 = 12;

/// Bytes of a composed entry, `COMPOSED_WORDS` in `shaders/lib/composed.wgsl`.
const COMPOSED_BYTES: u64 = 12;

/// What resolve needs besides the camera; layout of `ResolveUniform` in `shaders/pass/resolve.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ResolveUniform {
    /// Camera to world space.
    pub world_from_view: [[f32; 4]; 4],
    /// Weight of this camera sample in the picture.
    pub weight: f32,
    /// 1 where a head was drawn.
    pub has_head: u32,
    /// 1 where the environment is shown behind the hair.
    pub has_background: u32,
    /// Rotation of the environment about y, radians.
    pub background_turn_rad: f32,
    /// Factor on the environment's radiance, rgb.
    pub background_scale: [f32; 3],
    /// Number of this frame, as in the radiance of what it changed.
    pub frame: f32,
    /// Factor (rgb) on what the lights give.
    pub gain: [f32; 3],
    /// Alignment.
    pub pad: u32,
    /// Width and height of the environment map, pixels.
    pub background_size: [u32; 2],
    /// Alignment.
    pub pad_end: [u32; 2],
}

/// Buffers of the size of a picture.
pub struct PictureBuffers {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Premultiplied scene-linear RGBA of the whole picture.
    pub picture: wgpu::Buffer,
    /// Depth bits and segment + 1 of the strand that is seen, 0 where none is.
    pub picks: wgpu::Buffer,
    counts: wgpu::Buffer,
    offsets: wgpu::Buffer,
    /// Inverted depth bits of the nearest strand that covers the whole pixel: the largest wins, 0 where none does.
    solid: wgpu::Buffer,
    /// What each sub-sample has left behind all strands, four 16-bit shares a pixel.
    left: wgpu::Buffer,
}

impl PictureBuffers {
    /// Buffers for `size` pixels.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`].
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, GpuError> {
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        Ok(Self {
            size,
            picture: gpu.storage("picture", 16 * pixels)?,
            picks: gpu.storage("picks", 8 * pixels)?,
            counts: gpu.storage("fragment counts", 4 * pixels)?,
            offsets: gpu.storage("fragment offsets", 4 * pixels)?,
            solid: gpu.storage("solid strands", 4 * pixels)?,
            left: gpu.storage("left behind strands", 8 * pixels)?,
        })
    }
}

/// The passes of strand drawing.
pub struct Raster {
    count: Kernel,
    store: Kernel,
    alloc: Kernel,
    sort: Kernel,
    resolve: Kernel,
    resolve_touched: Kernel,
    total: wgpu::Buffer,
    fragments: wgpu::Buffer,
    composed: wgpu::Buffer,
    capacity: u64,
    /// Camera whose fragments of the whole picture the buffer holds, and how many.
    binned: Option<(CameraUniform, u64)>,
}

impl Raster {
    /// Compiles the passes.
    ///
    /// # Errors
    /// [`GpuError::Refused`].
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            count: Kernel::new(gpu, "pass/strand_bin.wgsl", &[("STORE", 0.0)])?,
            store: Kernel::new(gpu, "pass/strand_bin.wgsl", &[("STORE", 1.0)])?,
            alloc: Kernel::new(gpu, "pass/strand_alloc.wgsl", &[])?,
            sort: Kernel::new(gpu, "pass/strand_sort.wgsl", &[])?,
            resolve: Kernel::new(gpu, "pass/resolve.wgsl", &[])?,
            resolve_touched: Kernel::new(gpu, "pass/resolve.wgsl", &[("TOUCHED", 1.0)])?,
            total: gpu.storage("fragment total", 4)?,
            fragments: gpu.storage("fragments", FRAGMENT_BYTES)?,
            composed: gpu.storage("composed strands", COMPOSED_BYTES)?,
            capacity: 1,
            binned: None,
        })
    }

    /// Whether the fragments of the whole picture by this camera are there.
    pub fn holds(&self, camera: &CameraUniform) -> bool {
        self.binned.is_some_and(|(binned, _)| binned == *camera)
    }

    /// The strands changed: fragments of earlier frames are worth nothing.
    pub fn forget(&mut self) {
        self.binned = None;
    }

    /// Adds one camera sample to the picture and returns for how many fragments room was made: what `Saving::Covered` hides is fewer.
    ///
    /// Before fragments become colours, the vertices that they show are marked as wanted and `shade` brings those up to date.
    /// Where the fragments of the whole picture exceed what the adapter binds, the picture is drawn in bands of rows. What is
    /// sorted is used again while camera and strands stay (0 fragments are made then).
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] when one row alone is too much, [`GpuError::Lost`].
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        camera: &CameraUniform,
        resolve: &ResolveUniform,
        inputs: &ResolveInputs<'_>,
        mut shade: impl FnMut() -> Result<(), GpuError>,
    ) -> Result<u64, GpuError> {
        if self.holds(camera) {
            shade()?;
            let kernel = if inputs.touched_only {
                &self.resolve_touched
            } else {
                &self.resolve
            };
            self.resolve_band(gpu, kernel, camera, resolve, inputs);
            return Ok(0);
        }
        self.binned = None;
        let limits = gpu.device.limits();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
            / FRAGMENT_BYTES.max(COMPOSED_BYTES);
        let mut bands = vec![(0, camera.size[1])];
        let mut made = 0;
        while let Some((first_row, end_row)) = bands.pop() {
            let band = CameraUniform {
                first_row,
                end_row,
                ..*camera
            };
            let needed = self.count_fragments(gpu, &band, inputs)?;
            if needed > limit {
                if end_row - first_row < 2 {
                    return Err(GpuError::TooLarge {
                        what: format!("the strand fragments of picture row {first_row}"),
                        needed: needed * FRAGMENT_BYTES,
                        limit: limit * FRAGMENT_BYTES,
                    });
                }
                let middle = first_row.midpoint(end_row);
                bands.extend([(first_row, middle), (middle, end_row)]);
                continue;
            }
            if needed > self.capacity {
                // A little room to grow, so that a slowly moving camera does not allocate every frame.
                self.capacity = (needed + needed / 4).min(limit);
                self.fragments = gpu.storage("fragments", self.capacity * FRAGMENT_BYTES)?;
                self.composed = gpu.storage("composed strands", self.capacity * COMPOSED_BYTES)?;
            }
            self.bin(gpu, &self.store, &band, inputs);
            self.sort_band(gpu, &band, inputs);
            shade()?;
            self.resolve_band(gpu, &self.resolve, &band, resolve, inputs);
            if end_row - first_row == camera.size[1] {
                self.binned = Some((*camera, needed));
            }
            made += needed;
        }
        Ok(made)
    }

    /// Strand segments that every pixel of the picture that was drawn last shows.
    ///
    /// # Errors
    /// [`GpuError::Refused`] where it was drawn in bands, [`GpuError::Lost`].
    pub fn overdraw(&self, gpu: &Gpu, target: &PictureBuffers) -> Result<Vec<u32>, GpuError> {
        if self.binned.is_none() {
            return Err(GpuError::Refused {
                what: "the overdraw of the picture".to_owned(),
                reason: "its fragments exceed what the adapter binds at once; draw a smaller picture"
                    .to_owned(),
            });
        }
        gpu.read(&target.counts, target.size[0] as usize * target.size[1] as usize)
    }

    fn count_fragments(
        &self,
        gpu: &Gpu,
        band: &CameraUniform,
        inputs: &ResolveInputs<'_>,
    ) -> Result<u64, GpuError> {
        let target = inputs.target;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&target.counts, 0, None);
        encoder.clear_buffer(&target.solid, 0, None);
        encoder.clear_buffer(&self.total, 0, None);
        gpu.queue.submit([encoder.finish()]);
        self.bin(gpu, &self.count, band, inputs);
        let pixels = (band.end_row - band.first_row) * band.size[0];
        let pixel_count = gpu.uniform_of("pixel count", &[pixels, 0, 0, 0]);
        let alloc = self.alloc.bind(
            gpu,
            &[
                (0, &pixel_count),
                (1, &target.counts),
                (2, &target.offsets),
                (3, &self.total),
            ],
        );
        self.alloc.run(gpu, &alloc, pixels);
        Ok(u64::from(gpu.read::<u32>(&self.total, 1)?[0]))
    }

    fn bin(&self, gpu: &Gpu, kernel: &Kernel, band: &CameraUniform, inputs: &ResolveInputs<'_>) {
        let camera = gpu.uniform_of("camera", band);
        let bound = kernel.bind(
            gpu,
            &[
                (0, &camera),
                (1, &inputs.strands.vertices),
                (2, &inputs.strands.segments),
                (3, &inputs.target.counts),
                (4, &inputs.target.offsets),
                (5, &self.fragments),
                (6, &inputs.target.solid),
            ],
        );
        kernel.run(gpu, &bound, band.segment_count);
    }

    /// Brings the fragments of each pixel in order and marks what they show as wanted.
    fn sort_band(&self, gpu: &Gpu, band: &CameraUniform, inputs: &ResolveInputs<'_>) {
        let camera = gpu.uniform_of("camera", band);
        let settings = [
            u32::from(inputs.has_head),
            u32::from(inputs.interpolates_straight),
            0,
            0,
        ];
        let settings = gpu.uniform_of("sort", &settings);
        let (strands, target) = (inputs.strands, inputs.target);
        let buffers = [
            (0, &camera),
            (1, &settings),
            (2, &strands.segments),
            (3, &target.counts),
            (4, &target.offsets),
            (5, &self.fragments),
            (6, &self.composed),
            (7, &target.left),
            (9, &target.picks),
            (10, &strands.vertices),
            (11, &strands.spans),
            (12, &strands.wanted_vertices),
            (13, &strands.wanted_points),
        ];
        let textures = [(8, &inputs.head.depth), (14, &inputs.head.colour)];
        run_over_pixels(gpu, &self.sort, &buffers, &textures, band);
    }

    /// Adds the band to the picture.
    fn resolve_band(
        &self,
        gpu: &Gpu,
        kernel: &Kernel,
        band: &CameraUniform,
        resolve: &ResolveUniform,
        inputs: &ResolveInputs<'_>,
    ) {
        let camera = gpu.uniform_of("camera", band);
        let resolve = gpu.uniform_of("resolve", resolve);
        let buffers = [
            (0, &camera),
            (1, &resolve),
            (2, &inputs.target.counts),
            (3, &inputs.target.offsets),
            (4, &self.composed),
            (5, &inputs.target.left),
            (6, &inputs.strands.radiance),
            (8, inputs.background),
            (9, &inputs.target.picture),
        ];
        run_over_pixels(gpu, kernel, &buffers, &[(7, &inputs.head.colour)], band);
    }
}

/// Runs a pass over the pixels of a band.
fn run_over_pixels(
    gpu: &Gpu,
    kernel: &Kernel,
    buffers: &[(u32, &wgpu::Buffer)],
    textures: &[(u32, &wgpu::Texture)],
    band: &CameraUniform,
) {
    let views = textures
        .iter()
        .map(|(binding, texture)| (*binding, texture.create_view(&Default::default())));
    let views: Vec<_> = views.collect();
    let buffers = buffers.iter().map(|(binding, b)| wgpu::BindGroupEntry {
        binding: *binding,
        resource: b.as_entire_binding(),
    });
    let textures = views.iter().map(|(binding, view)| wgpu::BindGroupEntry {
        binding: *binding,
        resource: wgpu::BindingResource::TextureView(view),
    });
    let bound = kernel.bind_entries(gpu, &buffers.chain(textures).collect::<Vec<_>>());
    kernel.run(gpu, &bound, (band.end_row - band.first_row) * band.size[0]);
}

/// What drawing reads and writes.
pub struct ResolveInputs<'a> {
    /// The strands with their radiance.
    pub strands: &'a StrandBuffers,
    /// The head's sub-samples (1 x 1 where there is no head).
    pub head: &'a HeadTarget,
    /// Pixels of the environment map, vec4 each (any buffer where it is not shown).
    pub background: &'a wgpu::Buffer,
    /// The picture.
    pub target: &'a PictureBuffers,
    /// Whether a head was drawn.
    pub has_head: bool,
    /// Whether vertices in the middle of a straight span are not wanted, the ends of the span are.
    pub interpolates_straight: bool,
    /// Whether, where fragments are used again, pixels without changed vertices stay as they are.
    pub touched_only: bool,
}
