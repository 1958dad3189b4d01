//!use lib/lobe_light.wgsl
// The density volume and the march through it (Rust: volume::{Grid, DensityVolume, lobe}).
// A pass that uses it declares
//   var<uniform> volume_grid: VolumeGrid;
//   var<storage, read> volume_bricks: array<u32>;
//   var<storage, read> volume_density: array<vec2u>;
// Lengths and positions here count voxels from the grid's lower corner ("grid space").

struct VolumeGrid {
    origin: vec3f,           // lower corner, groom's unit
    voxel_size: f32,         // edge of a voxel, groom's unit
    bricks: vec3u,           // bricks along each axis
    stored_voxels: u32,
}

const BRICK_SIDE: i32 = 4;
const BRICK_VOXELS: u32 = 64u;
const EMPTY_BRICK: u32 = 0xffffffffu;
const SOLID_BRICK: u32 = 0xfffffffeu;

// Densities above are the mark of an occluder.
const SOLID_RHO: f32 = 61000.0;

// An occluder counts from this far on: roots may lie a little under the skin.
const OCCLUDER_CLEARANCE: f32 = 1.5;

// The own strand is subtracted up to here; beyond it has left the ray or is one fibre among many.
const OWN_REACH: f32 = 6.0;

// Steps are one voxel near the start and this share of the distance further out.
const STEP_GROWTH: f32 = 0.125;

// What a march leaves out: the fibre that its starting point lies on, straight on both sides of the point.
struct OwnStrand {
    to_root: vec3f,          // unit vector towards the root; zero at the root
    to_tip: vec3f,           // unit vector towards the tip; zero at the tip
    diameter: f32,           // voxels; zero: nothing to leave out
}

// What the march meets in one step.
struct Crossing {
    expected: f32,           // expected number of fibres crossed in this step
    share: f32,              // chance p that one fibre of the voxel stops a path through it: m fibres let (1 - p)^m through
    sin2_theta: f32,         // mean squared sine of the inclination of w to the fibres (theta as in the fibre's frame)
    voxel: u32,              // stored voxel
    blocked: bool,           // the occluder stops the path here
}

struct Marcher {
    start: vec3f,
    w: vec3f,
    inverse_w: vec3f,
    own: OwnStrand,
    t: f32,
    t_end: f32,
}

// The own strand of the point `here` (position in grid space, diameter in voxels) from its neighbours in the point buffer; bit 0 of
// `ends` marks a root, which has no neighbour before it, bit 1 a tip.
fn own_strand(here: vec4f, before: vec3f, after: vec3f, ends: u32) -> OwnStrand {
    let to_root = select(before - here.xyz, vec3f(0.0), (ends & 1u) != 0u);
    let to_tip = select(after - here.xyz, vec3f(0.0), (ends & 2u) != 0u);
    return OwnStrand(to_root / max(length(to_root), 1e-20), to_tip / max(length(to_tip), 1e-20), here.w);
}

fn grid_from_world(position: vec3f) -> vec3f {
    return (position - volume_grid.origin) / volume_grid.voxel_size;
}

// A march from `start` (grid space) along the unit vector w; nothing before `t_begin` is counted.
fn march_begin(start: vec3f, w: vec3f, own: OwnStrand, t_begin: f32) -> Marcher {
    // A vanishing component would make 0 * infinity; its faces are never reached anyway.
    let safe_w = select(w, vec3f(1e-8), abs(w) < vec3f(1e-8));
    let inverse_w = 1.0 / safe_w;
    let size = vec3f(volume_grid.bricks * u32(BRICK_SIDE));
    let a = -start * inverse_w;
    let b = (size - start) * inverse_w;
    let enter = min(a, b);
    let leave = max(a, b);
    let t_begin_inside = max(t_begin, max(enter.x, max(enter.y, enter.z)));
    return Marcher(start, w, inverse_w, own, t_begin_inside + 0.5, min(leave.x, min(leave.y, leave.z)));
}

// Projected area of the own strand inside the voxel at `low`, and its part w^T Q w / D: the two half lines clipped to the voxel.
fn own_share(own: OwnStrand, start: vec3f, low: vec3f, w: vec3f) -> vec2f {
    var share = vec2f(0.0);
    for (var side = 0; side < 2; side++) {
        let tangent = select(own.to_root, own.to_tip, side == 1);
        let inverse = 1.0 / select(tangent, vec3f(1e-8), abs(tangent) < vec3f(1e-8));
        let a = (low - start) * inverse;
        let b = (low + 1.0 - start) * inverse;
        let enter = min(a, b);
        let leave = max(a, b);
        let length = min(leave.x, min(leave.y, leave.z)) - max(0.0, max(enter.x, max(enter.y, enter.z)));
        if (length > 0.0 && any(tangent != vec3f(0.0))) {
            let cosine = dot(tangent, w);
            share += own.diameter * length * vec2f(1.0, 1.0 - cosine * cosine);
        }
    }
    return share;
}

// Advances to the next voxel with content; false at the end of the volume. Empty bricks are passed at once.
fn march_next(m: ptr<function, Marcher>, crossing: ptr<function, Crossing>) -> bool {
    let last = vec3i(volume_grid.bricks) * BRICK_SIDE - 1;
    while ((*m).t < (*m).t_end) {
        let t = (*m).t;
        let step = max(1.0, STEP_GROWTH * t);
        let p = (*m).start + t * (*m).w;
        let voxel = clamp(vec3i(floor(p)), vec3i(0), last);
        let brick = vec3u(voxel) / u32(BRICK_SIDE);
        let slot = volume_bricks[brick.x + volume_grid.bricks.x * (brick.y + volume_grid.bricks.y * brick.z)];

        if (slot >= SOLID_BRICK) {
            if (slot == SOLID_BRICK && t > OCCLUDER_CLEARANCE) {
                (*crossing).blocked = true;
                return true;
            }
            let low = vec3f(brick * u32(BRICK_SIDE));
            let face = select(low, low + f32(BRICK_SIDE), (*m).inverse_w > vec3f(0.0));
            let to_face = (face - p) * (*m).inverse_w;
            (*m).t = t + max(min(to_face.x, min(to_face.y, to_face.z)), 0.0) + 0.5 * step;
            continue;
        }

        (*m).t = t + step;
        let inside = vec3u(voxel) % u32(BRICK_SIDE);
        let stored = slot * BRICK_VOXELS + inside.x + u32(BRICK_SIDE) * (inside.y + u32(BRICK_SIDE) * inside.z);
        let words = volume_density[stored];
        var rho = unpack2x16float(words.x).x;
        if (rho == 0.0) {
            continue;
        }
        if (rho > SOLID_RHO) {
            if (t > OCCLUDER_CLEARANCE) {
                (*crossing).blocked = true;
                return true;
            }
            continue;
        }

        // w^T Q w / rho with Q's trace 2 rho.
        let w = (*m).w;
        let diagonal = unpack4x8unorm(words.x).zw;
        let mixed = unpack4x8snorm(words.y).xyz;
        let sin2_normal = diagonal.x * w.x * w.x + diagonal.y * w.y * w.y + (2.0 - diagonal.x - diagonal.y) * w.z * w.z
            + mixed.x * w.y * w.z + mixed.y * w.x * w.z + mixed.z * w.x * w.y;
        var area = vec2f(rho, rho * clamp(sin2_normal, 0.0, 1.0));
        if (t < OWN_REACH && (*m).own.diameter > 0.0) {
            // What remains of the own strand is rounding of the stored density.
            area = max(area - own_share((*m).own, (*m).start, vec3f(voxel), w), vec2f(0.0));
            if (area.x < 0.01 * rho) {
                continue;
            }
        }
        let per_voxel = sqrt(area.x * area.y);
        (*crossing).expected = step * per_voxel;
        (*crossing).share = min(min(per_voxel, (*m).own.diameter), 0.9);
        (*crossing).sin2_theta = clamp(1.0 - area.y / area.x, 0.0, 1.0);
        (*crossing).voxel = stored;
        return true;
    }
    return false;
}

// -ln of the share of paths that a step lets through when each fibre takes the share `loss` of what meets it. Fibres in a voxel
// are few and as wide as `share` of it, so this is more than the Poisson value expected * loss: expected / p fibres let (1 - p loss) each through.
fn optical_depth(crossing: Crossing, loss: f32) -> f32 {
    let p = crossing.share * loss;
    return crossing.expected * loss * (1.0 + p * (0.5 + p / 3.0));
}

// Optical depth from `start` (grid space) along w: exp(-n) is the share of paths that cross no fibre; counting stops above n_max,
// an occluder counts n_max.
fn march(start: vec3f, w: vec3f, own: OwnStrand, n_max: f32) -> f32 {
    var m = march_begin(start, w, own, 0.0);
    var crossing: Crossing;
    var n = 0.0;
    while (n < n_max && march_next(&m, &crossing)) {
        n = select(n + optical_depth(crossing, 1.0), n_max, crossing.blocked);
    }
    return min(n, n_max);
}

// A hash of the point and the light as an angle in [0, 2 pi): turns a light's directions from point to point, so that errors
// of few directions do not line up. (A 32-bit integer mixer of two multiplications.)
fn turn_angle(point: u32, light: u32) -> f32 {
    var x = point * 0x9e3779b9u + light * 0x85ebca6bu;
    x = (x ^ (x >> 16u)) * 0x7feb352du;
    x = (x ^ (x >> 15u)) * 0x846ca68bu;
    x = x ^ (x >> 16u);
    return f32(x >> 8u) * (6.283185307 / 16777216.0);
}
