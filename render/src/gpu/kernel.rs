//! A compute pass: one WGSL file in `shaders/pass/`, its pipeline and its bindings.

use super::{Gpu, GpuError, Method, shader};

/// Threads per group of every one-dimensional pass.
pub const GROUP_SIZE: u32 = 64;

/// Composes and compiles `shaders/<path>` and makes a pipeline of it.
///
/// # Errors
/// [`GpuError::Refused`] with the compiler's message.
pub(super) fn with_module<T>(
    gpu: &Gpu,
    path: &str,
    instead: &[(&str, &str)],
    pipeline: impl FnOnce(&wgpu::ShaderModule) -> T,
) -> Result<T, GpuError> {
    let refused = |reason: String| GpuError::Refused {
        what: format!("shaders/{path}"),
        reason,
    };
    let mut text = shader::compose(path, instead).map_err(refused)?;
    if gpu.is_software {
        // Mesa's lavapipe compiles a shader anew for every value of a uniform that it branches on; for values in storage it does not.
        text = text.replace("var<uniform>", "var<storage, read>");
    }
    with_source(gpu, path, wgpu::ShaderSource::Wgsl(text.into()), pipeline).map_err(refused)
}

/// Compiles a shader and makes a pipeline of it, or says what the compiler said.
fn with_source<T>(
    gpu: &Gpu,
    label: &str,
    source: wgpu::ShaderSource<'_>,
    pipeline: impl FnOnce(&wgpu::ShaderModule) -> T,
) -> Result<T, String> {
    let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source,
    });
    let made = pipeline(&module);
    match pollster::block_on(scope.pop()) {
        Some(error) => Err(error.to_string()),
        None => Ok(made),
    }
}

fn compute_pipeline(
    gpu: &Gpu,
    label: &str,
    module: &wgpu::ShaderModule,
    constants: &[(&str, f64)],
) -> wgpu::ComputePipeline {
    gpu.device
        .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(label),
            layout: None,
            module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants,
                ..Default::default()
            },
            cache: None,
        })
}

/// A compiled compute pass with the bind group layout that its shader implies.
pub struct Kernel {
    pipeline: wgpu::ComputePipeline,
    label: String,
}

impl Kernel {
    /// Compiles `shaders/<path>`, entry point `main`, with pipeline-overridable `constants`.
    ///
    /// # Errors
    /// [`GpuError::Refused`] with the compiler's message.
    pub fn new(gpu: &Gpu, path: &str, constants: &[(&str, f64)]) -> Result<Self, GpuError> {
        Self::composed(gpu, path, &[], constants)
    }

    /// Compiles a pass that scatters, with the files of `method`.
    ///
    /// # Errors
    /// [`GpuError::Refused`] with the compiler's message.
    pub fn scattering(gpu: &Gpu, path: &str, method: &Method) -> Result<Self, GpuError> {
        Self::scattering_with(gpu, path, method, &[])
    }

    /// The same with `constants` of the pass itself.
    ///
    /// # Errors
    /// [`GpuError::Refused`] with the compiler's message.
    pub fn scattering_with(
        gpu: &Gpu,
        path: &str,
        method: &Method,
        constants: &[(&str, f64)],
    ) -> Result<Self, GpuError> {
        Self::scattering_instead(gpu, path, method, &[], constants)
    }

    /// The same with files standing in for others besides those of the method.
    ///
    /// # Errors
    /// [`GpuError::Refused`] with the compiler's message.
    pub(super) fn scattering_instead(
        gpu: &Gpu,
        path: &str,
        method: &Method,
        instead: &[(&str, &str)],
        constants: &[(&str, f64)],
    ) -> Result<Self, GpuError> {
        let instead = [method.files(), instead].concat();
        let text = shader::compose(path, &instead).map_err(|reason| GpuError::Refused {
            what: format!("shaders/{path}"),
            reason,
        })?;
        Self::composed(
            gpu,
            path,
            &instead,
            &[constants, &method.constants(&text)].concat(),
        )
    }

    /// Compiles a pass with files standing in for others (`shader::compose`) and pipeline-overridable `constants`, all of which the pass has.
    ///
    /// # Errors
    /// [`GpuError::Refused`] with the compiler's message.
    pub(super) fn composed(
        gpu: &Gpu,
        path: &str,
        instead: &[(&str, &str)],
        constants: &[(&str, f64)],
    ) -> Result<Self, GpuError> {
        let pipeline = with_module(gpu, path, instead, |module| {
            compute_pipeline(gpu, path, module, constants)
        })?;
        Ok(Self {
            pipeline,
            label: path.to_owned(),
        })
    }

    /// Compiles a module that was parsed and changed, entry point `main`.
    ///
    /// # Errors
    /// [`GpuError::Refused`] with the compiler's message.
    pub(super) fn of_module(
        gpu: &Gpu,
        label: &str,
        module: naga::Module,
        constants: &[(&str, f64)],
    ) -> Result<Self, GpuError> {
        let source = wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module));
        let pipeline = with_source(gpu, label, source, |module| {
            compute_pipeline(gpu, label, module, constants)
        })
        .map_err(|reason| GpuError::Refused {
            what: label.to_owned(),
            reason,
        })?;
        Ok(Self {
            pipeline,
            label: label.to_owned(),
        })
    }

    /// Binds whole buffers of group 0 by binding number.
    pub fn bind(&self, gpu: &Gpu, buffers: &[(u32, &wgpu::Buffer)]) -> wgpu::BindGroup {
        let entries: Vec<_> = buffers
            .iter()
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding: *binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        self.bind_entries(gpu, &entries)
    }

    /// Binds any resources of group 0.
    pub fn bind_entries(&self, gpu: &Gpu, entries: &[wgpu::BindGroupEntry<'_>]) -> wgpu::BindGroup {
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&self.label),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries,
        })
    }

    /// Records one dispatch of `groups` work groups.
    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, bind_group: &wgpu::BindGroup, groups: [u32; 3]) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, bind_group, &[]);
        pass.dispatch_workgroups(groups[0], groups[1], groups[2]);
    }

    /// Runs over `count` items in a submission of its own: groups of [`GROUP_SIZE`], folded into x and y above 65,535
    /// groups; the shader's index is `id.x + id.y * 65535 * 64` and has to be compared with its own count.
    pub fn run(&self, gpu: &Gpu, bind_group: &wgpu::BindGroup, count: u32) {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(&self.label),
                timestamp_writes: gpu.timer.as_ref().and_then(|timer| timer.writes(&self.label)),
            });
            self.dispatch(&mut pass, bind_group, fold_groups(count));
        }
        gpu.queue.submit([encoder.finish()]);
    }
}

/// Work groups for `count` items: x up to 65,535, the rest in y.
pub fn fold_groups(count: u32) -> [u32; 3] {
    let groups = count.div_ceil(GROUP_SIZE).max(1);
    [groups.min(65_535), groups.div_ceil(65_535), 1]
}
