//! From a pixel of the picture to a place on a strand.

use balayage_render::{
    gpu::{Camera, PickMap},
    groom::Groom,
};
use glam::{Vec2, Vec3};

use crate::paint::{Dab, Extra, StrandIndex};

/// Which strands a picture shows, and the camera that it was taken with.
pub struct PickFrame {
    /// The camera.
    pub camera: Camera,
    /// The strand and its depth at every pixel.
    pub picks: PickMap,
}

/// Pixels round the pointer that are searched for a strand, so that gaps between strands do not interrupt a stroke.
const REACH_PX: i32 = 3;

impl PickFrame {
    /// The visible place nearest to `at` (in [0, 1]^2 of the picture, y down); none where no strand is near.
    pub fn place(&self, at: Vec2) -> Option<Vec3> {
        let size = Vec2::new(self.picks.width as f32, self.picks.height as f32);
        let pixel = (at * size).floor().as_ivec2();
        let offsets = (-REACH_PX..=REACH_PX).flat_map(|y| (-REACH_PX..=REACH_PX).map(move |x| (x, y)));
        let nearest = offsets
            .filter_map(|(x, y)| {
                let (px, py) = (u32::try_from(pixel.x + x).ok()?, u32::try_from(pixel.y + y).ok()?);
                self.picks.at(px, py).map(|pick| (x * x + y * y, pick.depth))
            })
            .min_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)))?;
        Some(self.point(at, nearest.1))
    }

    /// The place at `depth` behind `at`.
    pub fn point(&self, at: Vec2, depth: f32) -> Vec3 {
        let aspect = self.picks.width as f32 / self.picks.height.max(1) as f32;
        behind(&self.camera, aspect, at, depth)
    }
}

/// The place at `depth` behind `at` (in [0, 1]^2 of a picture of `aspect` = width / height, y down).
fn behind(camera: &Camera, aspect: f32, at: Vec2, depth: f32) -> Vec3 {
    let slope = (0.5 * camera.fov_y_rad).tan();
    let x = (2.0 * at.x - 1.0) * slope * aspect;
    let y = (1.0 - 2.0 * at.y) * slope;
    camera
        .world_from_camera
        .transform_point3(depth * Vec3::new(x, y, -1.0))
}

/// How far from the pointer a strand may be where there is no picture yet, as a share of the picture's height.
const STRAND_REACH: f32 = 0.015;

/// The place behind `at` at the depth of the nearest strand that is seen about there: what is touched while no picture tells which
/// strands are hidden. Takes time in proportion to the points.
pub fn place_on_strands(camera: &Camera, aspect: f32, groom: &Groom, at: Vec2) -> Option<Vec3> {
    let view_from_world = camera.world_from_camera.inverse();
    let slope = (0.5 * camera.fov_y_rad).tan();
    let wanted = Vec2::new((2.0 * at.x - 1.0) * aspect, 1.0 - 2.0 * at.y) * slope;
    let reach = 2.0 * slope * STRAND_REACH;
    // Where a point is seen at unit depth, and one over its depth, which is linear along a segment on the screen.
    let seen = |point: &Vec3| {
        let seen = view_from_world.transform_point3(*point);
        (seen.z < 0.0).then(|| (seen.truncate() / -seen.z, -1.0 / seen.z))
    };
    let mut nearest = 0.0_f32;
    for strand in 0..groom.strand_count() {
        let mut before: Option<(Vec2, f32)> = None;
        for point in &groom.positions()[groom.strand(strand)] {
            let here = seen(point);
            if let (Some((a, near_a)), Some((b, near_b))) = (before, here) {
                let along = (wanted - a).dot(b - a) / a.distance_squared(b).max(f32::MIN_POSITIVE);
                let along = along.clamp(0.0, 1.0);
                if a.lerp(b, along).distance(wanted) < reach {
                    nearest = nearest.max(near_a + along * (near_b - near_a));
                }
            }
            before = here;
        }
    }
    (nearest > 0.0).then(|| behind(camera, aspect, at, 1.0 / nearest))
}

/// The dab at `place`, on the strand whose point is nearest; none where no point is nearer than `reach`.
pub fn dab_at(index: &StrandIndex, place: Vec3, reach: f32, pressure: f32) -> Option<Dab> {
    let mut nearest: Option<(u32, f32)> = None;
    index.for_each_near(place, reach, |point, distance| {
        // Equal distances go to the first point, whatever the order of the visit.
        if nearest.is_none_or(|(p, d)| distance < d || (distance == d && point < p)) {
            nearest = Some((point, distance));
        }
    });
    let (point, _) = nearest?;
    let groom = index.groom();
    let root = groom.strand(index.strand_of(point) as usize).start;
    Some(Dab {
        root: groom.positions()[root].into(),
        arc: index.arc(point).clamp(0.0, 1.0),
        position: place.into(),
        pressure,
        extra: Extra::new(),
    })
}

/// Dabs from the visible place through the hair behind it, one every `radius`, wherever there are strands.
pub fn dabs_through(index: &StrandIndex, eye: Vec3, place: Vec3, radius: f32, pressure: f32) -> Vec<Dab> {
    let (low, high) = index.groom().bounds();
    let direction = (place - eye).normalize_or_zero();
    let steps = ((high - low).length() / radius).ceil().min(512.0) as usize;
    (0..=steps)
        .filter_map(|step| dab_at(index, place + step as f32 * radius * direction, radius, pressure))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_picture_the_nearest_strand_under_the_pointer_counts() {
        let camera = Camera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, 0.6);
        let place = |depths: &[f32], at: Vec2| {
            // Strands from top to bottom; the pointer is far from each of their points.
            let strands = depths
                .iter()
                .map(|z| [1.0, -1.0].map(|y| Vec3::new(0.002, y, *z)));
            let (groom, _) = Groom::from_strands(strands, 0.004, 1.0).unwrap();
            place_on_strands(&camera, 1.5, &groom, at)
        };
        let middle = place(&[-1.0, 1.0], Vec2::splat(0.5)).unwrap();
        assert!(middle.distance(Vec3::new(0.0, 0.0, 1.0)) < 1e-4, "{middle}");
        assert!(place(&[-1.0, 1.0], Vec2::new(0.1, 0.1)).is_none());
        // Behind the eye there is nothing to touch.
        assert!(place(&[6.0], Vec2::splat(0.5)).is_none());
    }
}
