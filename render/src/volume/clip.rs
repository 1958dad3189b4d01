//! A segment against the unit voxels of a grid.

use glam::DVec3;

/// Calls `visit(voxel, t0, t1)` for every unit voxel that the segment `a + t (b - a)`, t in [0, 1], passes, in order.
///
/// Coordinates count voxels; a voxel is named by its lower corner. The intervals [t0, t1] join without gap or overlap, so the
/// lengths inside the voxels sum to the segment's.
pub fn clip_segment(a: DVec3, b: DVec3, mut visit: impl FnMut([i32; 3], f64, f64)) {
    let step = b - a;
    let mut voxel = a.floor();
    let last = b.floor();

    // The parameter at which the segment leaves its voxel along each axis, and what a whole voxel costs.
    let sign = DVec3::select(step.cmpge(DVec3::ZERO), DVec3::ONE, DVec3::NEG_ONE);
    let delta = DVec3::select(step.cmpeq(DVec3::ZERO), DVec3::INFINITY, step.abs().recip());
    let to_face = DVec3::select(step.cmpge(DVec3::ZERO), voxel + 1.0 - a, a - voxel);
    let mut next = DVec3::select(step.cmpeq(DVec3::ZERO), DVec3::INFINITY, to_face * delta);

    // The number of faces crossed is known beforehand, so rounding can neither lose the end nor run past it.
    let mut left = (last - voxel).abs();
    let mut t = 0.0;
    loop {
        let axis = (0..3)
            .filter(|&axis| left[axis] > 0.0)
            .min_by(|&i, &j| next[i].total_cmp(&next[j]));
        let t_exit = axis.map_or(1.0, |axis| next[axis].clamp(t, 1.0));
        visit([voxel.x as i32, voxel.y as i32, voxel.z as i32], t, t_exit);
        let Some(axis) = axis else { return };
        t = t_exit;
        voxel[axis] += sign[axis];
        next[axis] += delta[axis];
        left[axis] -= 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_join_and_stay_inside_their_voxels() {
        let cases = [
            (DVec3::new(0.2, 0.3, 0.4), DVec3::new(5.7, -3.1, 2.2)),
            (DVec3::new(0.5, 0.5, 0.5), DVec3::new(0.6, 0.5, 0.5)),
            (DVec3::new(3.0, 2.0, 1.0), DVec3::new(-3.0, 2.0, 1.0)),
            (DVec3::new(1.0, 1.0, 1.0), DVec3::new(4.0, 4.0, 4.0)),
        ];
        for (a, b) in cases {
            let mut end = 0.0;
            clip_segment(a, b, |voxel, t0, t1| {
                assert_eq!(t0, end, "a gap before {t0}");
                assert!(t1 >= t0);
                end = t1;
                let middle = a + (b - a) * 0.5 * (t0 + t1);
                let low = DVec3::new(f64::from(voxel[0]), f64::from(voxel[1]), f64::from(voxel[2]));
                assert!(
                    (middle - low).min_element() >= -1e-12 && (middle - low).max_element() <= 1.0 + 1e-12
                );
            });
            assert_eq!(end, 1.0);
        }
    }

    #[test]
    fn a_diagonal_passes_one_voxel_per_face_crossed() {
        let mut visited = 0;
        clip_segment(
            DVec3::new(0.5, 0.25, 0.125),
            DVec3::new(4.5, 3.25, 2.125),
            |_, _, _| visited += 1,
        );
        assert_eq!(visited, 1 + 4 + 3 + 2);
    }
}
