//! Device, passes and the frame. The only module besides the viewport that knows wgpu.

pub mod bench;
pub mod camera;
mod device;
mod frame;
pub mod head;
mod kernel;
mod lights;
mod method;
pub mod operations;
pub mod probe;
pub mod probe_cases;
pub mod raster;
mod shade;
pub mod shader;
pub mod strands;
pub mod tables;
mod transmittance;
pub mod view;
mod work_list;

pub use camera::{Camera, CameraFile};
pub use device::{Gpu, GpuError};
pub use frame::{FrameReport, Pick, PickMap, RenderSettings, Renderer};
pub use kernel::{GROUP_SIZE, Kernel, fold_groups};
pub use method::{DIRECTIONAL_GAMMAS, DIRECTIONS, Method, Model, Quality, SEGMENTS, Scheme};
pub use shade::{Multiple, ShadeSettings, Terms};
pub use transmittance::{
    AVERAGES_ENTRIES, LightBatch, MeanFibre, PATH_BYTES, Transmittance, TransmittanceReport,
    VISIBILITY_BYTES, VolumeReport,
};
pub use view::ViewTransform;
