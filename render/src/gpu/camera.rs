//! The pinhole camera.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3};
use serde::{Deserialize, Serialize};

/// A camera that looks along -z of its own frame, y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Rigid transform from camera to world (groom) space, column vectors.
    pub world_from_camera: Mat4,
    /// Vertical field of view of the whole picture, radians.
    pub fov_y_rad: f32,
    /// The part of the whole picture that is drawn; `None`: all of it.
    pub crop: Option<Crop>,
}

/// A part of a picture, pixels of the whole one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// Width and height of the whole picture.
    pub whole: [u32; 2],
    /// Left and upper edge of the part.
    pub origin: [u32; 2],
}

/// Camera JSON (design: `world_from_camera` row-major, `fov_y_deg`).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraFile {
    /// Rows of the 4x4 matrix.
    pub world_from_camera: [[f32; 4]; 4],
    /// Vertical field of view, degrees.
    pub fov_y_deg: f32,
}

impl TryFrom<CameraFile> for Camera {
    type Error = String;

    fn try_from(file: CameraFile) -> Result<Self, String> {
        let world_from_camera = Mat4::from_cols_array_2d(&file.world_from_camera).transpose();
        let rotation = glam::Mat3::from_mat4(world_from_camera);
        let off = (rotation * rotation.transpose() - glam::Mat3::IDENTITY).to_cols_array();
        if !world_from_camera.is_finite()
            || off.iter().any(|x| x.abs() > 1e-2)
            || rotation.determinant() < 0.0
        {
            return Err(
                "world_from_camera is not a rotation and a translation: give 4 rows of finite numbers whose \
                        upper left 3x3 is a rotation"
                    .to_owned(),
            );
        }
        if !(file.fov_y_deg > 0.1 && file.fov_y_deg < 175.0) {
            return Err(format!(
                "fov_y_deg is {}: give degrees between 0.1 and 175",
                file.fov_y_deg
            ));
        }
        Ok(Self {
            world_from_camera,
            fov_y_rad: file.fov_y_deg.to_radians(),
            crop: None,
        })
    }
}

impl From<Camera> for CameraFile {
    fn from(camera: Camera) -> Self {
        Self {
            world_from_camera: camera.world_from_camera.transpose().to_cols_array_2d(),
            fov_y_deg: camera.fov_y_rad.to_degrees(),
        }
    }
}

impl Camera {
    /// A camera at `eye` that looks at `target` with y up; `eye` and `target` must differ.
    pub fn look_at(eye: Vec3, target: Vec3, fov_y_rad: f32) -> Self {
        let back = (eye - target).normalize_or(Vec3::Z);
        let up = if back.y.abs() > 0.999 { Vec3::Z } else { Vec3::Y };
        let right = up.cross(back).normalize();
        let world_from_camera = Mat4::from_cols(
            right.extend(0.0),
            back.cross(right).extend(0.0),
            back.extend(0.0),
            eye.extend(1.0),
        );
        Self {
            world_from_camera,
            fov_y_rad,
            crop: None,
        }
    }

    /// A three-quarter view that just holds the box between two corners, in a picture of `aspect` = width / height.
    pub fn framing(corners: (Vec3, Vec3), aspect: f32) -> Self {
        Self::framing_from(corners, aspect, Vec3::new(0.5, 0.18, 0.85))
    }

    /// The same seen from the side that `towards_eye` points to.
    pub fn framing_from(corners: (Vec3, Vec3), aspect: f32, towards_eye: Vec3) -> Self {
        let fov_y_rad = 35f32.to_radians();
        let target = 0.5 * (corners.0 + corners.1);
        let at_unit = Self::look_at(target + towards_eye, target, fov_y_rad);
        let [right, up, back] = [0, 1, 2].map(|axis| at_unit.world_from_camera.col(axis).truncate());
        let slope = (0.5 * fov_y_rad).tan();
        // Each corner wants its own distance to be just inside the picture; a margin of 4 % is left.
        let half = 0.5 * (corners.1 - corners.0);
        let distance = (0..8)
            .map(|k| half * Vec3::from_array([1, 2, 4].map(|bit| if k & bit == 0 { -1.0 } else { 1.0 })))
            .map(|corner| {
                let across = (corner.dot(right).abs() / aspect.max(1e-3)).max(corner.dot(up).abs());
                corner.dot(back) + 1.04 * across / slope
            })
            .fold(1e-6, f32::max);
        Self::look_at(target + distance * back, target, fov_y_rad)
    }

    /// World position of the eye.
    pub fn position(&self) -> Vec3 {
        self.world_from_camera.w_axis.truncate()
    }
}

/// A frame's camera as the shaders read it; layout of `CameraUniform` in `shaders/lib/camera.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct CameraUniform {
    /// World to camera space.
    pub view_from_world: [[f32; 4]; 4],
    /// Eye in world space.
    pub position: [f32; 3],
    /// Pixels per unit of slope.
    pub focal_px: f32,
    /// Image point of the optical axis, jitter included, pixels.
    pub centre_px: [f32; 2],
    /// Nearest depth that is drawn, world units.
    pub near: f32,
    /// First row of the band that is drawn.
    pub first_row: u32,
    /// Width and height of the whole picture, pixels.
    pub size: [u32; 2],
    /// Row behind the band.
    pub end_row: u32,
    /// Strand segments that are drawn, from the first one on.
    pub segment_count: u32,
    /// Factor on the width of the strands.
    pub width_factor: f32,
    /// Coverage from which a strand hides all that is behind it in a pixel; above 1 none does.
    pub solid_coverage: f32,
    /// Alignment.
    pub pad: [u32; 2],
}

impl CameraUniform {
    /// The uniform for a picture (or a part of one) of `size` pixels whose samples are moved by `jitter` pixels.
    pub fn new(camera: &Camera, size: [u32; 2], jitter: [f32; 2], near: f32, segment_count: u32) -> Self {
        let Crop { whole, origin } = camera.crop.unwrap_or(Crop {
            whole: size,
            origin: [0, 0],
        });
        let centre = |axis: usize| 0.5 * whole[axis] as f32 - origin[axis] as f32 - jitter[axis];
        Self {
            view_from_world: camera.world_from_camera.inverse().to_cols_array_2d(),
            position: camera.position().to_array(),
            focal_px: 0.5 * whole[1] as f32 / (0.5 * camera.fov_y_rad).tan(),
            centre_px: [centre(0), centre(1)],
            near,
            first_row: 0,
            size,
            end_row: size[1],
            segment_count,
            width_factor: 1.0,
            solid_coverage: 1.0,
            pad: [0; 2],
        }
    }
}
