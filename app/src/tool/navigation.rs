//! Orbit, pan, zoom and frame.

use balayage_render::gpu::{Camera, CameraFile};
use glam::{Mat4, Quat, Vec2, Vec3};

use crate::document::CameraPose;

/// A camera and the point that it turns about, in the groom's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewCamera {
    camera: Camera,
    pivot: Vec3,
    /// Half the picture's height at the pivot that zooming out ends at.
    widest: f32,
}

/// The nearest that zooming comes to the pivot, as a share of a step's start.
const MIN_ZOOM: f32 = 0.2;

/// Zooming out ends where hair that filled the picture takes this part of its height. Strands cover a pixel independently of one another:
/// where the whole hair is less than eight pixels high its edges grow, and with them its light, by more than 1 % in a step of 4 %.
const MOST_ZOOM_OUT: f32 = 15.0;

/// The steepest tilt, degrees: beyond it "up" would flip.
const MAX_TILT_DEG: f32 = 88.0;

impl ViewCamera {
    /// Frames the box between two corners in a viewport of that width to height.
    pub fn framing(bounds: (Vec3, Vec3), aspect: f32) -> Self {
        let camera = Camera::framing(bounds, aspect);
        let pivot = 0.5 * (bounds.0 + bounds.1);
        Self {
            camera,
            pivot,
            widest: MOST_ZOOM_OUT * camera.position().distance(pivot) * slope(&camera),
        }
    }

    /// The camera of a project; it turns about the middle of the box.
    pub fn from_pose(pose: &CameraPose, bounds: (Vec3, Vec3)) -> Option<Self> {
        let file = CameraFile {
            world_from_camera: pose.world_from_camera,
            fov_y_deg: pose.fov_y_deg,
        };
        let camera = Camera::try_from(file).ok()?;
        Some(Self {
            camera,
            ..Self::framing(bounds, 1.0)
        })
    }

    /// The camera as a project keeps it.
    pub fn pose(&self) -> CameraPose {
        let file = CameraFile::from(self.camera);
        CameraPose {
            world_from_camera: file.world_from_camera,
            fov_y_deg: file.fov_y_deg,
            extra: Default::default(),
        }
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Turns about the pivot: a drag over the height of the viewport is half a turn.
    ///
    /// `drag` is in heights of the viewport, y down.
    pub fn orbit(&mut self, drag: Vec2) {
        let pose = self.camera.world_from_camera;
        let right = pose.x_axis.truncate();
        // Tilting stops short of the poles.
        let up_now = pose.z_axis.y.clamp(-1.0, 1.0).asin();
        let limit = MAX_TILT_DEG.to_radians();
        let tilt = (up_now + drag.y * std::f32::consts::PI).clamp(-limit, limit) - up_now;
        let turn =
            Quat::from_rotation_y(-drag.x * std::f32::consts::PI) * Quat::from_axis_angle(right, -tilt);
        let about_pivot =
            Mat4::from_translation(self.pivot) * Mat4::from_quat(turn) * Mat4::from_translation(-self.pivot);
        self.set(about_pivot * pose);
    }

    /// Moves with the pointer at the pivot's depth.
    pub fn pan(&mut self, drag: Vec2) {
        let height = 2.0 * self.pivot_depth() * slope(&self.camera);
        let pose = self.camera.world_from_camera;
        let offset = height * (drag.y * pose.y_axis.truncate() - drag.x * pose.x_axis.truncate());
        self.pivot += offset;
        self.set(Mat4::from_translation(offset) * pose);
    }

    /// Comes nearer by the factor exp(`amount`); going away ends where the hair is small ([`MOST_ZOOM_OUT`]).
    pub fn zoom(&mut self, amount: f32) {
        let depth = self.pivot_depth();
        // A camera that stands further away stays there.
        let farthest = (self.widest / slope(&self.camera)).max(depth);
        let step = depth - (depth * (-amount).exp().max(MIN_ZOOM)).min(farthest);
        let pose = self.camera.world_from_camera;
        self.set(Mat4::from_translation(-step * pose.z_axis.truncate()) * pose);
    }

    /// Looks at the pivot from `side`, a unit vector from the pivot to the eye, at the same distance; from above and below the front
    /// of the hair is at the bottom of the picture, or at its top.
    pub fn face(&mut self, side: Vec3) {
        let steep = side.y.abs() > MAX_TILT_DEG.to_radians().sin();
        let back = if steep { Vec3::Z } else { side };
        let distance = self.camera.position().distance(self.pivot);
        self.camera = Camera::look_at(self.pivot + distance * back, self.pivot, self.camera.fov_y_rad);
        if steep {
            // As far up or down as tilting goes.
            self.orbit(Vec2::new(0.0, side.y.signum()));
        }
    }

    /// Pixels that a length at `depth` takes, for a viewport of `height` pixels.
    pub fn pixels(&self, length: f32, depth: f32, height: f32) -> f32 {
        0.5 * height * length / (depth.max(f32::MIN_POSITIVE) * slope(&self.camera))
    }

    /// Depth of the pivot along the axis, never zero.
    pub fn pivot_depth(&self) -> f32 {
        let pose = self.camera.world_from_camera;
        let depth = (self.camera.position() - self.pivot).dot(pose.z_axis.truncate());
        depth.abs().max(1e-6 * self.pivot.length().max(1e-3))
    }

    /// Takes a pose, without the rounding that many small turns pile up.
    fn set(&mut self, pose: Mat4) {
        let z = pose.z_axis.truncate().normalize();
        let x = pose.y_axis.truncate().cross(z).normalize();
        let y = z.cross(x);
        self.camera.world_from_camera =
            Mat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), pose.w_axis);
    }
}

/// Half the picture's height at a depth of 1.
fn slope(camera: &Camera) -> f32 {
    (0.5 * camera.fov_y_rad).tan()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> ViewCamera {
        ViewCamera::framing((Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 2.0, 1.0)), 1.5)
    }

    #[test]
    fn orbiting_keeps_the_distance_and_stays_rigid() {
        let mut view = view();
        let distance = view.camera.position().distance(view.pivot);
        for i in 0..500 {
            view.orbit(Vec2::new(0.013, if i < 250 { 0.02 } else { -0.03 }));
            assert!((view.camera.position().distance(view.pivot) - distance).abs() < 1e-3 * distance);
            assert!(crate::document::check_camera(&view.pose()).is_ok());
            assert!(
                view.camera.world_from_camera.y_axis.y > 0.0,
                "the horizon stays level"
            );
        }
    }

    #[test]
    fn panning_there_and_back_and_zooming_in_and_out_return() {
        let start = view();
        let mut view = start;
        view.pan(Vec2::new(0.3, -0.2));
        assert!(view != start);
        view.pan(Vec2::new(-0.3, 0.2));
        view.zoom(0.5);
        assert!(view.pivot_depth() < start.pivot_depth());
        view.zoom(-0.5);
        assert!(view.camera.position().distance(start.camera.position()) < 1e-4);
    }

    #[test]
    fn zooming_out_ends_where_hair_is_small_and_goes_back() {
        let start = view();
        let mut view = start;
        for _ in 0..200 {
            view.zoom(-0.1);
        }
        let factor = view.pivot_depth() / start.pivot_depth();
        assert!((factor / MOST_ZOOM_OUT - 1.0).abs() < 1e-3, "{factor}");
        view.zoom(0.5);
        assert!(view.pivot_depth() < 0.61 * MOST_ZOOM_OUT * start.pivot_depth());
        // A wide lens sees as much from nearer by; a project's camera that stands further away is not pulled in.
        let bounds = (Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 2.0, 1.0));
        let mut pose = start.pose();
        pose.fov_y_deg = 120.0;
        pose.world_from_camera[2][3] += 1000.0;
        let mut far = ViewCamera::from_pose(&pose, bounds).unwrap();
        let depth = far.pivot_depth();
        far.zoom(-1.0);
        assert!((far.pivot_depth() / depth - 1.0).abs() < 1e-5);
    }

    #[test]
    fn every_side_can_be_faced_and_left_again() {
        let start = view();
        let distance = start.camera.position().distance(start.pivot);
        for (side, right) in [
            (Vec3::Z, Vec3::X),
            (Vec3::NEG_Z, Vec3::NEG_X),
            (Vec3::X, Vec3::NEG_Z),
            (Vec3::NEG_X, Vec3::Z),
            (Vec3::Y, Vec3::X),
            (Vec3::NEG_Y, Vec3::X),
        ] {
            let mut view = start;
            view.face(side);
            let pose = view.camera.world_from_camera;
            assert!(pose.z_axis.truncate().dot(side) > 0.999, "{side}");
            assert!(pose.x_axis.truncate().dot(right) > 0.999, "{side}");
            assert!((view.camera.position().distance(view.pivot) - distance).abs() < 1e-4 * distance);
            view.orbit(Vec2::new(0.1, 0.05));
            assert!(crate::document::check_camera(&view.pose()).is_ok());
        }
    }

    #[test]
    fn a_pose_comes_back() {
        let start = view();
        let again = ViewCamera::from_pose(
            &start.pose(),
            (Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 2.0, 1.0)),
        );
        let again = again.unwrap();
        assert!(
            again
                .camera
                .world_from_camera
                .abs_diff_eq(start.camera.world_from_camera, 1e-6)
        );
    }
}
