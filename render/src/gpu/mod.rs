//! Device, passes and the frame. The only module besides the viewport that knows wgpu.

mod device;
mod kernel;
pub mod probe;
pub mod shader;
pub mod tables;

pub use device::{Gpu, GpuError};
pub use kernel::{GROUP_SIZE, Kernel, fold_groups};
