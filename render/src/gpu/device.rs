//! The device: found once, asked once for what the adapter allows, shared by all passes.

use std::sync::Arc;

use bytemuck::Pod;
use wgpu::util::DeviceExt;

use super::timer::GpuTimer;

/// What can go wrong between us and the GPU.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No adapter of any backend answered.
    #[error(
        "no usable GPU adapter ({0}): install a Vulkan driver (on Debian/Ubuntu without a GPU: apt-get install mesa-vulkan-drivers)"
    )]
    NoAdapter(String),
    /// The adapter refused the device.
    #[error(
        "the GPU adapter {adapter} refused a device: {reason}; update its driver or choose another adapter with WGPU_ADAPTER_NAME"
    )]
    NoDevice {
        /// Name of the adapter.
        adapter: String,
        /// What the driver said.
        reason: String,
    },
    /// A shader did not compile or a resource was refused.
    #[error("the GPU refused {what}: {reason}")]
    Refused {
        /// Pass or resource.
        what: String,
        /// What wgpu said.
        reason: String,
    },
    /// A buffer would exceed what the adapter can bind.
    #[error(
        "{what} needs {needed} bytes, the GPU adapter binds at most {limit}; use a smaller groom or picture"
    )]
    TooLarge {
        /// The resource.
        what: String,
        /// Bytes asked for.
        needed: u64,
        /// Bytes the adapter allows.
        limit: u64,
    },
    /// Somebody asked for it: [`super::Renderer::set_interrupt`].
    #[error("the picture was given up for a newer one")]
    Interrupted,
    /// The device was lost or a read-back failed.
    #[error("the GPU device was lost while {0}; the document is safe, start the picture again")]
    Lost(String),
}

/// Device and queue, and what they can do.
#[derive(Clone)]
pub struct Gpu {
    /// The wgpu device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Name of the adapter with its backend, for reports.
    pub adapter_name: String,
    /// True where the adapter is a software rasterizer.
    pub is_software: bool,
    /// Where the GPU's own times are asked for.
    pub(super) timer: Option<Arc<GpuTimer>>,
}

impl Gpu {
    /// The features we use where the adapter has them; none is required.
    pub fn wanted_features(adapter: &wgpu::Adapter) -> wgpu::Features {
        adapter.features() & wgpu::Features::TIMESTAMP_QUERY
    }

    /// A device without a window, on the best adapter (`WGPU_BACKEND` and `WGPU_ADAPTER_NAME` choose).
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] and [`GpuError::NoDevice`].
    pub fn headless() -> Result<Self, GpuError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        }))
        .map_err(|e| GpuError::NoAdapter(e.to_string()))?;
        // OpenGL ES by itself: then no Vulkan driver is installed.
        let depth = adapter.get_texture_format_features(super::head::DEPTH_FORMAT);
        if !depth
            .allowed_usages
            .contains(wgpu::TextureUsages::RENDER_ATTACHMENT)
        {
            let info = adapter.get_info();
            return Err(GpuError::NoAdapter(format!(
                "{} ({}) draws no 32-bit float textures",
                info.name, info.backend
            )));
        }
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("balayage"),
            required_features: Self::wanted_features(&adapter),
            required_limits: adapter.limits(),
            ..Default::default()
        }))
        .map_err(|e| GpuError::NoDevice {
            adapter: adapter.get_info().name,
            reason: e.to_string(),
        })?;
        Ok(Self::from_parts(device, queue, &adapter.get_info()))
    }

    /// Wraps a device that somebody else made (the editor's window).
    pub fn from_parts(device: wgpu::Device, queue: wgpu::Queue, info: &wgpu::AdapterInfo) -> Self {
        let mut gpu = Self {
            device,
            queue,
            adapter_name: format!("{} ({})", info.name, info.backend),
            is_software: info.device_type == wgpu::DeviceType::Cpu,
            timer: None,
        };
        if !gpu.is_software {
            gpu.time_passes();
        }
        gpu
    }

    /// Has the GPU time its passes ([`super::FrameReport::shaders`]) where it can. A software adapter is not asked by itself: Mesa's writes
    /// its timestamps before the work is done, and the clock on the wall tells what it takes.
    pub fn time_passes(&mut self) {
        self.timer = GpuTimer::new(&self.device, &self.queue).map(Arc::new);
    }

    /// A storage buffer of `bytes` zeroed bytes (at least 16), that can be copied from and to.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] above the adapter's limits.
    pub fn storage(&self, label: &str, bytes: u64) -> Result<wgpu::Buffer, GpuError> {
        let limit = self.most_bound_bytes();
        if bytes > limit {
            return Err(GpuError::TooLarge {
                what: label.to_owned(),
                needed: bytes,
                limit,
            });
        }
        Ok(self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes.max(16).next_multiple_of(16),
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        }))
    }

    /// A storage buffer that holds `data`.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] above the adapter's limits.
    pub fn storage_of<T: Pod>(&self, label: &str, data: &[T]) -> Result<wgpu::Buffer, GpuError> {
        let buffer = self.storage(label, size_of_val(data) as u64)?;
        self.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(data));
        Ok(buffer)
    }

    /// A uniform buffer that holds `value`.
    pub fn uniform_of<T: Pod>(&self, label: &str, value: &T) -> wgpu::Buffer {
        self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some(label),
            contents: bytemuck::bytes_of(value),
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        })
    }

    /// Bytes of the largest storage buffer that the adapter binds.
    pub fn most_bound_bytes(&self) -> u64 {
        let limits = self.device.limits();
        limits.max_buffer_size.min(limits.max_storage_buffer_binding_size)
    }

    /// Bytes of GPU memory that this device holds, where its backend tells.
    pub fn allocated_bytes(&self) -> Option<u64> {
        let report = self.device.generate_allocator_report();
        report.map(|report| report.total_allocated_bytes)
    }

    /// Blocks until all submitted work is done.
    ///
    /// # Errors
    /// [`GpuError::Lost`] when the device does not answer.
    pub fn wait(&self) -> Result<(), GpuError> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map(|_| ())
            .map_err(|_| GpuError::Lost("waiting for the GPU".to_owned()))
    }

    /// Reads the first `count` values of a buffer back; blocks until the GPU has written them.
    ///
    /// # Errors
    /// [`GpuError::Lost`] when the device does not answer.
    pub fn read<T: Pod>(&self, buffer: &wgpu::Buffer, count: usize) -> Result<Vec<T>, GpuError> {
        let lost = |_| GpuError::Lost(format!("reading {count} values back"));
        let bytes = (count * size_of::<T>()) as u64;
        if bytes == 0 {
            return Ok(Vec::new());
        }
        let copy_bytes = bytes.next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT);
        let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read back"),
            size: copy_bytes,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, copy_bytes);
        self.queue.submit([encoder.finish()]);
        let (sender, receiver) = std::sync::mpsc::channel();
        staging.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            // The receiver is gone only when this function has already returned an error.
            let _ = sender.send(result);
        });
        self.wait()?;
        receiver
            .recv()
            .map_err(|_| ())
            .and_then(|r| r.map_err(|_| ()))
            .map_err(lost)?;
        let view = staging
            .slice(..)
            .get_mapped_range()
            .map_err(|_| GpuError::Lost("mapping a buffer".to_owned()))?;
        Ok(bytemuck::pod_collect_to_vec(&view[..bytes as usize]))
    }
}
