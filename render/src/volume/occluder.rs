//! A closed mesh, the head, as opaque voxels.

use glam::{DVec3, IVec3, Vec3};

use super::Grid;

/// Borrowed triangles of a mesh that stops light, in the groom's unit and space.
#[derive(Clone, Copy, Debug)]
pub struct Occluder<'a> {
    /// Vertex positions.
    pub positions: &'a [Vec3],
    /// Vertex indices, three a triangle, counter-clockwise seen from outside.
    pub triangles: &'a [[u32; 3]],
}

impl Occluder<'_> {
    /// Lower and upper corner of the box around all vertices; `None` without vertices.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let &first = self.positions.first()?;
        Some(
            self.positions
                .iter()
                .fold((first, first), |(low, high), &p| (low.min(p), high.max(p))),
        )
    }

    /// The voxels deep inside: their centre and their six neighbours' centres are inside the mesh. One flag per
    /// voxel, in the order of [`Grid::address`].
    ///
    /// The margin of one voxel keeps roots, which lie on the skin, in the open. A centre is inside where at least two of the
    /// three axis-parallel lines through it have a winding number other than zero, so a mesh with a hole (a neck that is cut off)
    /// is filled too.
    pub fn solid_voxels(&self, grid: &Grid) -> Vec<bool> {
        let mut votes = vec![0_u8; grid.brick_count() * super::BRICK_VOXELS as usize];
        for axis in 0..3 {
            self.vote_along(axis, grid, &mut votes);
        }
        let size = grid.voxels().as_ivec3();
        let inside = |v: IVec3| {
            v.cmpge(IVec3::ZERO).all() && v.cmplt(size).all() && votes[grid.address(v) as usize] >= 2
        };
        let mut solid = vec![false; votes.len()];
        for z in 0..size.z {
            for y in 0..size.y {
                for x in 0..size.x {
                    let v = IVec3::new(x, y, z);
                    let deep = inside(v) && IVec3::AXES.iter().all(|&a| inside(v + a) && inside(v - a));
                    solid[grid.address(v) as usize] = deep;
                }
            }
        }
        solid
    }

    /// Adds one vote to every voxel whose centre has a non-zero winding number along `axis`.
    fn vote_along(&self, axis: usize, grid: &Grid, votes: &mut [u8]) {
        let size = grid.voxels().as_ivec3();
        let (u_axis, v_axis) = ((axis + 1) % 3, (axis + 2) % 3);
        let (u_size, v_size) = (size[u_axis], size[v_axis]);
        let mut columns: Vec<Vec<(f64, i32)>> = vec![Vec::new(); (u_size * v_size) as usize];

        // Lines run through the voxel centres, moved by an irrational hair's breadth so that none meets an edge of a symmetric mesh.
        let line = |i: i32| f64::from(i) + 0.5 + 1e-5 * std::f64::consts::SQRT_2;
        for triangle in self.triangles {
            let corners = triangle.map(|i| grid.grid_from_world(self.positions[i as usize]));
            let flat = corners.map(|p: DVec3| (p[u_axis], p[v_axis]));
            let cross = |a: (f64, f64), b: (f64, f64), p: (f64, f64)| {
                (b.0 - a.0) * (p.1 - a.1) - (b.1 - a.1) * (p.0 - a.0)
            };
            let area = cross(flat[0], flat[1], flat[2]);
            if area == 0.0 {
                continue;
            }
            let range = |values: [f64; 3], size: i32| {
                let low = values.into_iter().fold(f64::INFINITY, f64::min).floor().max(0.0) as i32;
                let high = values
                    .into_iter()
                    .fold(f64::NEG_INFINITY, f64::max)
                    .ceil()
                    .min(f64::from(size)) as i32;
                low..high
            };
            for v in range(flat.map(|p| p.1), v_size) {
                for u in range(flat.map(|p| p.0), u_size) {
                    let p = (line(u), line(v));
                    let weights = [
                        cross(flat[1], flat[2], p),
                        cross(flat[2], flat[0], p),
                        cross(flat[0], flat[1], p),
                    ]
                    .map(|w| w / area);
                    if weights.iter().all(|&w| w >= 0.0) {
                        let depth = (0..3).map(|i| weights[i] * corners[i][axis]).sum();
                        columns[(u + u_size * v) as usize].push((depth, if area > 0.0 { 1 } else { -1 }));
                    }
                }
            }
        }

        // Walk every column from below and count the surfaces that lie under each centre.
        for v in 0..v_size {
            for u in 0..u_size {
                let column = &mut columns[(u + u_size * v) as usize];
                column.sort_by(|a, b| a.0.total_cmp(&b.0));
                let (mut winding, mut passed) = (0, 0);
                for depth in 0..size[axis] {
                    while passed < column.len() && column[passed].0 <= f64::from(depth) + 0.5 {
                        winding += column[passed].1;
                        passed += 1;
                    }
                    let mut voxel = IVec3::ZERO;
                    (voxel[axis], voxel[u_axis], voxel[v_axis]) = (depth, u, v);
                    votes[grid.address(voxel) as usize] += u8::from(winding != 0);
                }
            }
        }
    }
}
