// Composes each pixel, twice: first (MARK) the vertices that it shows are noted, so that only they are shaded, then: its strand fragments nearest first over the head's four sub-samples and the background.
// Where nothing but the radiance of some vertices changed (TOUCHED), pixels that show none of them stay as they are.
// Fragments are taken in runs of the RUN nearest not yet seen, so that dense hair stops after a few runs and nothing is written back.

//!use lib/camera.wgsl
//!use lib/fragment.wgsl
//!use lib/refined.wgsl
//!use lib/environment.wgsl

struct ResolveUniform {
    world_from_view: mat4x4f,
    weight: f32,              // of this camera sample in the picture
    has_head: u32,
    has_background: u32,
    background_turn_rad: f32, // rotation of the environment about y
    background_scale: vec3f,  // exposure and tint of the environment
    straight: u32,            // 1: vertices in the middle of a straight span are not wanted, their ends are
    background_size: vec2u,
    frame: f32,               // number of this frame, as in the radiance of what it changed
    gain: vec3f,              // factor on what the lights give
}

override MARK: bool = false;
override TOUCHED: bool = false;

@group(0) @binding(0) var<uniform> camera: CameraUniform;
@group(0) @binding(1) var<uniform> resolve: ResolveUniform;
@group(0) @binding(2) var<storage, read> segments: array<Segment>;
@group(0) @binding(3) var<storage, read> counts: array<u32>;
@group(0) @binding(4) var<storage, read> offsets: array<u32>;
@group(0) @binding(5) var<storage, read> fragments: array<u32>;
@group(0) @binding(6) var<storage, read> radiance: array<vec4f>;        // per refined vertex
@group(0) @binding(7) var head_colour: texture_2d<f32>;                 // 2 x 2 sub-samples a pixel; rgb radiance, a = 1 where hit
@group(0) @binding(8) var head_depth: texture_2d<f32>;
@group(0) @binding(9) var<storage, read> background: array<vec4f>;
@group(0) @binding(10) var<storage, read_write> picture: array<vec4f>;  // premultiplied, whole picture
@group(0) @binding(11) var<storage, read_write> picks: array<vec2u>;    // depth bits and segment + 1 of the strand that is seen

@group(0) @binding(12) var<storage, read> vertices: array<RefinedVertex>;
@group(0) @binding(13) var<storage, read_write> wanted_vertices: array<u32>;
@group(0) @binding(14) var<storage, read_write> wanted_points: array<u32>;
@group(0) @binding(15) var<storage, read> spans: array<u32>;            // StrandBuffers::spans

const RUN: u32 = 16u;           // fragments sorted at a time
const OPAQUE: f32 = 4e-3;       // transmittance below which nothing behind can be told
const PICK_ALPHA: f32 = 0.3;
const FAR: f32 = 3.0e38;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let p = id.x + id.y * 65535u * 64u;
    let rows = camera.end_row - camera.first_row;
    if p >= rows * camera.size.x { return; }
    let pixel = vec2u(p % camera.size.x, p / camera.size.x + camera.first_row);
    let count = counts[p];
    let base = offsets[p];
    if TOUCHED && !touched(base, count) { return; }

    // Depth and colour of what is solid behind the hair, at four sub-samples.
    var solid_depth = vec4f(FAR);
    var solid = array<vec4f, 4>();
    if resolve.has_head != 0u {
        for (var k = 0u; k < 4u; k++) {
            let at = vec2i(vec2u(pixel.x * 2u + (k & 1u), pixel.y * 2u + (k >> 1u)));
            solid[k] = vec4f(resolve.gain, 1.0) * textureLoad(head_colour, at, 0);
            solid_depth[k] = select(FAR, textureLoad(head_depth, at, 0).x, solid[k].a > 0.0);
        }
    }
    if resolve.has_background != 0u {
        let here = background_radiance(pixel);
        for (var k = 0u; k < 4u; k++) {
            if solid[k].a == 0.0 { solid[k] = vec4f(here, 1.0); }
        }
    }

    var colour = vec3f(0.0);
    var transmittance = vec4f(1.0);      // towards each sub-sample, before the current strand
    var strand_coverage = vec4f(0.0);    // of the current strand, its segments added up
    var strand = 0xffffffffu;
    var last_vertex = 0u;
    var pick = vec2u(0u);
    var last_key = vec2u(0u);            // depth bits, segment + 1 of the last fragment taken
    var taken = 0u;
    while taken < count {
        // The RUN nearest fragments behind the last one taken, sorted; equal depths by segment, so that the result has one order.
        var keys: array<vec2u, RUN>;
        var places: array<u32, RUN>;
        var found = 0u;
        for (var f = 0u; f < count; f++) {
            let word = (base + f) * FRAGMENT_WORDS;
            let key = vec2u(fragments[word], fragments[word + 2u] + 1u);
            if !before(last_key, key) { continue; }
            if found == RUN && !before(key, keys[RUN - 1u]) { continue; }
            var slot = min(found, RUN - 1u);
            while slot > 0u && before(key, keys[slot - 1u]) {
                keys[slot] = keys[slot - 1u];
                places[slot] = places[slot - 1u];
                slot--;
            }
            keys[slot] = key;
            places[slot] = word;
            found = min(found + 1u, RUN);
        }
        for (var k = 0u; k < found; k++) {
            let word = places[k];
            let fragment = unpack_fragment(vec3u(fragments[word], fragments[word + 1u], fragments[word + 2u]));
            let segment = segments[fragment.segment];
            // Neighbouring segments of one strand share the pixel: their coverages add up instead of hiding each other.
            let joins = segment.strand == strand && max(segment.vertex, last_vertex) - min(segment.vertex, last_vertex) <= 2u;
            if !joins {
                transmittance *= 1.0 - strand_coverage;
                strand_coverage = vec4f(0.0);
                strand = segment.strand;
            }
            last_vertex = segment.vertex;
            let in_front = select(vec4f(0.0), vec4f(1.0), vec4f(fragment.depth) < solid_depth);
            let coverage = in_front * min(vec4f(fragment.coverage), 1.0 - strand_coverage);
            let share = 0.25 * dot(transmittance, coverage);
            if MARK && share > 0.0 {
                want(segment.vertex);
                want(segment.vertex + 1u);
            }
            let light = resolve.gain * mix(radiance[segment.vertex].rgb, radiance[segment.vertex + 1u].rgb, fragment.along);
            colour += share * light;
            // The strand that is seen is the one at which the pixel has become PICK_ALPHA opaque, else the last one.
            if share > 0.0 && dot(transmittance * (1.0 - strand_coverage), vec4f(0.25)) > 1.0 - PICK_ALPHA {
                // In the groom's own order a strand has one segment less than vertices.
                pick = vec2u(bitcast<u32>(fragment.depth), segment.vertex - segment.strand + 1u);
            }
            strand_coverage += coverage;
        }
        taken += found;
        if found == 0u { break; }
        last_key = keys[found - 1u];
        if all(transmittance * (1.0 - strand_coverage) < vec4f(OPAQUE)) { break; }
    }
    if MARK { return; }
    transmittance *= 1.0 - strand_coverage;
    var alpha = 0.0;
    for (var k = 0u; k < 4u; k++) {
        colour += 0.25 * transmittance[k] * solid[k].a * solid[k].rgb;
        alpha += 0.25 * (1.0 - transmittance[k] * (1.0 - solid[k].a));
    }
    let at = pixel.y * camera.size.x + pixel.x;
    let before = select(picture[at], vec4f(0.0), TOUCHED);
    picture[at] = before + resolve.weight * vec4f(colour, alpha);
    picks[at] = pick;
}

// Whether this frame changed a vertex that the pixel's fragments lie beside.
fn touched(base: u32, count: u32) -> bool {
    for (var f = 0u; f < count; f++) {
        let vertex = segments[fragments[(base + f) * FRAGMENT_WORDS + 2u]].vertex;
        if radiance[vertex].a == resolve.frame || radiance[vertex + 1u].a == resolve.frame { return true; }
    }
    return false;
}

// A vertex that a pixel shows, or the two between which it is interpolated, and the groom points it lies between.
fn want(vertex: u32) {
    let span = select(0u, spans[vertex], resolve.straight != 0u);
    wanted_vertices[vertex - (span & 0xffffu)] = 1u;
    wanted_vertices[vertex + (span >> 16u)] = 1u;
    let point = vertices[vertex].source_point;
    wanted_points[point] = 1u;
    wanted_points[min(point + 1u, arrayLength(&wanted_points) - 1u)] = 1u;
}

fn before(a: vec2u, b: vec2u) -> bool {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}

// The environment behind the picture, bilinear.
fn background_radiance(pixel: vec2u) -> vec3f {
    let at = vec2f(pixel) + 0.5 - camera.centre_px;
    let w = normalize((resolve.world_from_view * vec4f(at.x, -at.y, -camera.focal_px, 0.0)).xyz);
    let size = resolve.background_size;
    let uv = uv_from_direction(turned_about_y(w, -resolve.background_turn_rad)) * vec2f(size) - 0.5;
    let cell = vec2i(floor(uv));
    let part = uv - floor(uv);
    let x0 = u32((cell.x + i32(size.x)) % i32(size.x));
    let x1 = (x0 + 1u) % size.x;
    let y0 = u32(clamp(cell.y, 0, i32(size.y) - 1));
    let y1 = u32(clamp(cell.y + 1, 0, i32(size.y) - 1));
    let top = mix(background[y0 * size.x + x0], background[y0 * size.x + x1], part.x);
    let bottom = mix(background[y1 * size.x + x0], background[y1 * size.x + x1], part.x);
    return resolve.background_scale * mix(top, bottom, part.y).rgb;
}
