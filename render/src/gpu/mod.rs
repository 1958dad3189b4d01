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
mod pick_map;
pub mod probe;
pub mod probe_cases;
pub mod probe_deon;
pub mod probe_kajiya_kay;
pub mod raster;
mod records;
mod report;
mod savings;
mod scattered_light;
mod scene_lights;
mod sh9;
mod shade;
pub mod shader;
pub mod stale;
pub mod strands;
pub mod tables;
mod tables_kajiya_kay;
mod timer;
mod transmittance;
pub mod view;
mod voxel_paint;
mod work_list;

pub use camera::{Camera, CameraFile, Crop};
pub use device::{Gpu, GpuError};
pub use frame::{DebugView, FalseColours, RenderSettings, Renderer};
pub use kernel::{GROUP_SIZE, Kernel, fold_groups};
pub use method::{DIRECTIONAL_GAMMAS, DIRECTIONS, Method, Model, Quality, SEGMENTS, Scheme};
pub use pick_map::{Pick, PickMap};
pub use report::FrameReport;
pub use savings::{Saving, Savings};
pub use scattered_light::{CELL_VOXELS, PHOTON_RAYS};
pub use shade::{Multiple, ShadeSettings, Terms};
pub use transmittance::{
    AVERAGES_ENTRIES, LightBatch, MeanFibre, PATH_BYTES, Transmittance, TransmittanceReport,
    VISIBILITY_BYTES, VisibilitySource, VolumeReport,
};
pub use view::ViewTransform;
