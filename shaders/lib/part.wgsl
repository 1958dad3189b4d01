//!use lib/maths.wgsl
// Parts of the sphere of directions, all of one solid angle: the equal-area octahedral map in squares (Rust: photon::field).

const PARTS_PER_SIDE: u32 = 8u;
const PARTS: u32 = 64u;

// Directions that stand for a part, one for each quarter of its square.
const PART_QUARTERS: u32 = 4u;

// Variance of a quarter's directions along an arc, radians: a square of its solid angle.
const PART_VARIANCE: f32 = 0.00409;

// The middle of a quarter of a part.
fn part_direction(part: u32, quarter: u32) -> vec3f {
    let at = 2u * vec2u(part % PARTS_PER_SIDE, part / PARTS_PER_SIDE) + vec2u(quarter & 1u, quarter >> 1u);
    let square = (vec2f(at) + 0.5) / f32(PARTS_PER_SIDE) - 1.0;
    let above = 1.0 - abs(square.x) - abs(square.y);
    let r = 1.0 - abs(above);
    let azimuth = ((abs(square.y) - abs(square.x)) / r + 1.0) * (0.25 * PI);
    let across = r * sqrt(2.0 - r * r);
    return vec3f(across * vec2f(cos(azimuth), sin(azimuth)) * sign(square), (1.0 - r * r) * sign(above));
}
