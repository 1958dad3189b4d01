//! Device, passes and the frame. The only module besides the viewport that knows wgpu.

pub mod camera;
mod device;
pub mod head;
mod kernel;
pub mod raster;
pub mod shader;
pub mod strands;
pub mod view;

pub use camera::Camera;
pub use device::{Gpu, GpuError};
pub use kernel::{GROUP_SIZE, Kernel, fold_groups};
