//! Where hair grows on a head, and how far out the head reaches.
//!
//! The head is the mesh of a head and neck: y up, facing +z, symmetric about x = 0. Its own measure is its depth D, nose to back of the
//! head; heights are counted from the top of the head and depths from its back, both in D, so that the rules fit heads of any size.

use glam::{Vec2, Vec3};

use super::Mesh;

/// Hairline over depth: (depth from the back, lowest height with hair), both in D. From nape over the ears and sideburns to the forehead.
const HAIRLINE: [(f32, f32); 14] = [
    (0.00, -0.92),
    (0.20, -0.90),
    (0.26, -0.78),
    (0.28, -0.53),
    (0.46, -0.53),
    (0.48, -0.66),
    (0.52, -0.66),
    (0.56, -0.50),
    (0.62, -0.40),
    (0.72, -0.33),
    (0.80, -0.26),
    (0.87, -0.205),
    (0.95, -0.20),
    (1.00, -0.20),
];

/// Centre of the skull: height and depth in D; below it the envelope is measured from an axis that leans back with the neck.
const SKULL_CENTRE: Vec2 = Vec2::new(-0.42, 0.47);
const NECK_AXIS: Vec2 = Vec2::new(-1.20, 0.30);

/// Resolution of the envelope: azimuths, rows below the skull's centre, rows of elevation above it.
const AZIMUTHS: usize = 180;
const ROWS_BELOW: usize = 112;
const ROWS_ABOVE: usize = 64;

/// How far hollows are spanned, in cells.
const TENT_PASSES: usize = 60;

/// Height below the skull's centre that the rows below it cover, in D.
const DEPTH_BELOW: f32 = 0.90;

/// The measure of a head.
#[derive(Clone, Copy)]
pub(super) struct HeadMeasure {
    /// Depth D, nose to back, in the mesh's unit.
    pub depth: f32,
    top: f32,
    back: f32,
}

impl HeadMeasure {
    pub fn new(mesh: &Mesh) -> Self {
        let (min, max) = mesh.bounds();
        Self {
            depth: max.z - min.z,
            top: max.y,
            back: min.z,
        }
    }

    /// Height above the top and depth from the back, in D.
    pub fn height_depth(&self, p: Vec3) -> Vec2 {
        Vec2::new(p.y - self.top, p.z - self.back) / self.depth
    }

    /// How far above the hairline a point lies, in D; hair grows where this is positive.
    pub fn above_hairline(&self, p: Vec3) -> f32 {
        let hd = self.height_depth(p);
        hd.x - hairline(hd.y)
    }

    /// The point on the head's axis from which the envelope is measured at the height of `p`.
    fn axis(&self, p: Vec3) -> Vec3 {
        let height = ((p.y - self.top) / self.depth).min(SKULL_CENTRE.x);
        let t = ((SKULL_CENTRE.x - height) / (SKULL_CENTRE.x - NECK_AXIS.x)).clamp(0.0, 1.0);
        let depth = SKULL_CENTRE.y + t * (NECK_AXIS.y - SKULL_CENTRE.y);
        Vec3::new(
            0.0,
            self.top + height * self.depth,
            self.back + depth * self.depth,
        )
    }

    /// Whether a triangle faces away from the inside of the head (the inside of the mouth and the eyes' backs do not).
    pub fn faces_out(&self, centre: Vec3, normal: Vec3) -> bool {
        normal.dot(centre - self.axis(centre)) > 0.0
    }
}

fn hairline(depth: f32) -> f32 {
    let i = HAIRLINE
        .partition_point(|&(d, _)| d <= depth)
        .clamp(1, HAIRLINE.len() - 1);
    let ((d0, h0), (d1, h1)) = (HAIRLINE[i - 1], HAIRLINE[i]);
    h0 + (h1 - h0) * ((depth - d0) / (d1 - d0)).clamp(0.0, 1.0)
}

/// The head's outer hull: its largest distance from the axis in every direction (around and up), never less than the mesh.
pub(super) struct Envelope {
    measure: HeadMeasure,
    radius: Vec<f32>,
}

impl Envelope {
    /// Measures a mesh; samples its triangles densely enough that no cell of the map is missed by more than the dilation covers.
    pub fn new(mesh: &Mesh) -> Self {
        let measure = HeadMeasure::new(mesh);
        let mut radius = vec![0.0_f32; AZIMUTHS * (ROWS_BELOW + ROWS_ABOVE)];
        let mut envelope = Self {
            measure,
            radius: Vec::new(),
        };
        let spacing = 0.005 * measure.depth;
        for triangle in 0..mesh.triangles().len() {
            let [a, b, c] = mesh.corners(triangle);
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            let cuts = (longest / spacing).ceil().clamp(1.0, 200.0) as usize;
            for i in 0..=cuts {
                for j in 0..=cuts - i {
                    let (s, t) = (i as f32 / cuts as f32, j as f32 / cuts as f32);
                    let p = a + s * (b - a) + t * (c - a);
                    let (azimuth, row, r) = envelope.coordinates(p);
                    if row < -0.5 {
                        continue;
                    }
                    let cell = envelope.cell(azimuth.round() as i64, row.round() as i64);
                    radius[cell] = radius[cell].max(r);
                }
            }
        }
        envelope.radius = radius;
        envelope.fill_holes();
        envelope.dilate();
        for _ in 0..TENT_PASSES {
            envelope.span_hollows();
        }
        envelope
    }

    /// Distance of a point from the hull along the ray from the axis, negative inside.
    pub fn distance(&self, p: Vec3) -> f32 {
        let (azimuth, row, r) = self.coordinates(p);
        r - self.radius_at(azimuth, row)
    }

    /// Direction in which the distance grows, by central differences over a hundredth of D.
    pub fn normal(&self, p: Vec3) -> Vec3 {
        let h = 0.01 * self.measure.depth;
        let along = |axis: Vec3| self.distance(p + h * axis) - self.distance(p - h * axis);
        Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z))
            .try_normalize()
            .unwrap_or(Vec3::Y)
    }

    /// The point moved outwards along the ray from the axis until its distance is at least `clearance`.
    pub fn pushed_out(&self, p: Vec3, clearance: f32) -> Vec3 {
        let missing = clearance - self.distance(p);
        let outwards = p - self.measure.axis(p);
        if missing > 0.0 {
            p + outwards.normalize_or(Vec3::Y) * missing
        } else {
            p
        }
    }

    /// Position in the map (azimuth cell, row cell) and distance from the axis.
    fn coordinates(&self, p: Vec3) -> (f32, f32, f32) {
        let from_axis = p - self.measure.axis(p);
        let turn = from_axis.x.atan2(from_axis.z) / std::f32::consts::TAU;
        let azimuth = turn.rem_euclid(1.0) * AZIMUTHS as f32;
        let radius = from_axis.length();
        let height = self.measure.height_depth(p).x - SKULL_CENTRE.x;
        let row = if height < 0.0 {
            ROWS_BELOW as f32 * (1.0 + height / DEPTH_BELOW)
        } else {
            let elevation = from_axis.y.atan2(from_axis.x.hypot(from_axis.z));
            ROWS_BELOW as f32 + elevation / std::f32::consts::FRAC_PI_2 * (ROWS_ABOVE - 1) as f32
        };
        (azimuth, row, radius)
    }

    fn cell(&self, azimuth: i64, row: i64) -> usize {
        let row = row.clamp(0, (ROWS_BELOW + ROWS_ABOVE - 1) as i64) as usize;
        row * AZIMUTHS + azimuth.rem_euclid(AZIMUTHS as i64) as usize
    }

    /// Bilinear look-up; nothing reaches below the lowest row.
    fn radius_at(&self, azimuth: f32, row: f32) -> f32 {
        if row < 0.0 {
            return 0.0;
        }
        let (a, r) = (azimuth.floor(), row.floor());
        let (fa, fr) = (azimuth - a, row - r);
        let at = |da: i64, dr: i64| self.radius[self.cell(a as i64 + da, r as i64 + dr)];
        let low = at(0, 0) * (1.0 - fa) + at(1, 0) * fa;
        let high = at(0, 1) * (1.0 - fa) + at(1, 1) * fa;
        low * (1.0 - fr) + high * fr
    }

    /// The eight cells around a cell.
    fn around(&self, cell: usize) -> impl Iterator<Item = usize> + use<'_> {
        let (row, azimuth) = ((cell / AZIMUTHS) as i64, (cell % AZIMUTHS) as i64);
        (-1..=1).flat_map(move |dr| (-1..=1).map(move |da| self.cell(azimuth + da, row + dr)))
    }

    /// Gives cells that no sample hit the largest value around them, until none is left; a map without any sample stays empty.
    fn fill_holes(&mut self) {
        for _ in 0..AZIMUTHS {
            let filled = self.map_cells(|envelope, cell| {
                let own = envelope.radius[cell];
                if own > 0.0 {
                    own
                } else {
                    envelope.largest_around(cell)
                }
            });
            let done = filled == self.radius;
            self.radius = filled;
            if done {
                break;
            }
        }
    }

    /// Raises every cell to the largest around it, so that a look-up between cells never dips below the mesh.
    fn dilate(&mut self) {
        self.radius = self.map_cells(Self::largest_around);
    }

    /// Raises every cell to the mean around it: hair spans the hollows around ears and nape like a tent.
    fn span_hollows(&mut self) {
        self.radius = self.map_cells(|envelope, cell| {
            let mean = envelope.around(cell).map(|c| envelope.radius[c]).sum::<f32>() / 9.0;
            mean.max(envelope.radius[cell])
        });
    }

    fn largest_around(&self, cell: usize) -> f32 {
        self.around(cell).map(|c| self.radius[c]).fold(0.0, f32::max)
    }

    fn map_cells(&self, value: impl Fn(&Self, usize) -> f32) -> Vec<f32> {
        (0..self.radius.len()).map(|cell| value(self, cell)).collect()
    }
}
