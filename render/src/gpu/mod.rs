//! Device, passes and the frame. The only module besides the viewport that knows wgpu.

mod device;
mod kernel;
pub mod shader;
mod tables;
mod transmittance;

pub use device::{Gpu, GpuError};
pub use kernel::{GROUP_SIZE, Kernel, fold_groups};
pub use transmittance::{
    AVERAGES_ENTRIES, LightBatch, MeanFibre, PATH_BYTES, Transmittance, TransmittanceReport, VISIBILITY_BYTES,
    VolumeReport,
};
