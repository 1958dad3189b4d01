// Parts of the sphere of directions, all of one solid angle: the equal-area octahedral map in squares (Rust: photon::field).

const PARTS: u32 = 64u;

// Directions that stand for a part, one for each quarter of its square.
const PART_QUARTERS: u32 = 4u;

// Variance of a quarter's directions along an arc, radians: a square of its solid angle.
const PART_VARIANCE: f32 = 0.00409;
