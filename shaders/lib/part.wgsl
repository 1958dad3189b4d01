// Parts of the sphere of directions: the octahedral map in squares (Rust: photon::field).

const PARTS_PER_SIDE: u32 = 8u;
const PARTS: u32 = 64u;

// Variance of a part's directions along an arc, radians: a square of its solid angle.
const PART_VARIANCE: f32 = 0.01636;

// The middle of a part.
fn part_direction(part: u32) -> vec3f {
    let square = 2.0 * (vec2f(f32(part % PARTS_PER_SIDE), f32(part / PARTS_PER_SIDE)) + 0.5) / f32(PARTS_PER_SIDE) - 1.0;
    let z = 1.0 - abs(square.x) - abs(square.y);
    return normalize(vec3f(square - max(-z, 0.0) * sign(square), z));
}
