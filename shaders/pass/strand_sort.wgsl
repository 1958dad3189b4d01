// Sorts the strand fragments of each pixel, nearest first, over the head's four sub-samples: what share of the pixel each one gives, what is
// left for what is solid behind them, which strand is seen, and which vertices have to be shaded.
// Fragments are taken in runs of the RUN nearest not yet seen, so that dense hair stops after a few runs. Where thousands of strands, each
// far finer than the pixel, leave it transparent after the runs that it may have, the others are taken by slices of depth.

//!use lib/camera.wgsl
//!use lib/composed.wgsl
//!use lib/fragment.wgsl
//!use lib/refined.wgsl

struct SortUniform {
    has_head: u32,
    straight: u32,       // 1: vertices in the middle of a straight span are not wanted, their ends are
}

@group(0) @binding(0) var<uniform> camera: CameraUniform;
@group(0) @binding(1) var<uniform> settings: SortUniform;
@group(0) @binding(2) var<storage, read> segments: array<Segment>;
@group(0) @binding(3) var<storage, read_write> counts: array<u32>;      // fragments of a pixel, then those that it shows
@group(0) @binding(4) var<storage, read> offsets: array<u32>;
@group(0) @binding(5) var<storage, read> fragments: array<u32>;
@group(0) @binding(6) var<storage, read_write> composed: array<u32>;
@group(0) @binding(7) var<storage, read_write> left: array<vec2u>;      // of each sub-sample behind all strands, packed; whole picture
@group(0) @binding(8) var head_depth: texture_2d<f32>;                  // 2 x 2 sub-samples a pixel; FAR where there is no head
@group(0) @binding(9) var<storage, read_write> picks: array<vec2u>;     // depth bits and segment + 1 of the strand that is seen
@group(0) @binding(10) var<storage, read> vertices: array<RefinedVertex>;
@group(0) @binding(11) var<storage, read> spans: array<u32>;            // StrandBuffers::spans
@group(0) @binding(12) var<storage, read_write> wanted_vertices: array<u32>;
@group(0) @binding(13) var<storage, read_write> wanted_points: array<u32>;
@group(0) @binding(14) var head_colour: texture_2d<f32>;                // a = 1 where the head is

const RUN: u32 = 16u;           // fragments sorted at a time
const RUNS_WORK: u32 = 4000u;   // fragments looked at in all runs of a pixel; in software the loops of eight pixels end after 65,535 rounds
const SLICES: u32 = 32u;
const OPAQUE: f32 = 4e-3;       // transmittance below which nothing behind can be told
const PICK_ALPHA: f32 = 0.3;
const FAR: f32 = 3.0e38;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let p = id.x + id.y * 65535u * 64u;
    let rows = camera.end_row - camera.first_row;
    if p >= rows * camera.size.x { return; }
    let pixel = vec2u(p % camera.size.x, p / camera.size.x + camera.first_row);
    let at = pixel.y * camera.size.x + pixel.x;
    let count = counts[p];
    let base = offsets[p];

    // Depth of what is solid behind the hair, at four sub-samples.
    var solid_depth = vec4f(FAR);
    if settings.has_head != 0u && count > 0u {
        for (var k = 0u; k < 4u; k++) {
            let sub = vec2i(vec2u(pixel.x * 2u + (k & 1u), pixel.y * 2u + (k >> 1u)));
            if textureLoad(head_colour, sub, 0).a > 0.0 { solid_depth[k] = textureLoad(head_depth, sub, 0).x; }
        }
    }

    var transmittance = vec4f(1.0);      // towards each sub-sample, before the current strand
    var strand_coverage = vec4f(0.0);    // of the current strand, its segments added up
    var strand = 0xffffffffu;
    var last_vertex = 0u;
    var pick = vec2u(0u);
    var last_key = vec2u(0u);            // depth bits, segment + 1 of the last fragment taken
    var taken = 0u;
    var shown = 0u;
    for (var run = 0u; taken < count && run * count < RUNS_WORK; run++) {
        // The RUN nearest fragments behind the last one taken, sorted; equal depths by segment, so that the result has one order.
        var keys: array<vec2u, RUN>;
        var places: array<u32, RUN>;
        var found = 0u;
        for (var f = 0u; f < count; f++) {
            let word = (base + f) * FRAGMENT_WORDS;
            let key = key_at(word);
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
            let fragment = fragment_at(word);
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
            if share > 0.0 {
                show(base + shown, fragment, segment.vertex, share);
                shown++;
                // The strand that is seen is the one at which the pixel has become PICK_ALPHA opaque, else the last one.
                if dot(transmittance * (1.0 - strand_coverage), vec4f(0.25)) > 1.0 - PICK_ALPHA {
                    // In the groom's own order a strand has one segment less than vertices.
                    pick = vec2u(bitcast<u32>(fragment.depth), segment.vertex - segment.strand + 1u);
                }
            }
            strand_coverage += coverage;
        }
        taken += found;
        if found == 0u { break; }
        last_key = keys[found - 1u];
        if all(transmittance * (1.0 - strand_coverage) < vec4f(OPAQUE)) { taken = count; }
    }
    transmittance *= 1.0 - strand_coverage;
    if taken < count {
        var farthest = last_key.x;
        for (var f = 0u; f < count; f++) { farthest = max(farthest, fragments[(base + f) * FRAGMENT_WORDS]); }
        let nearest = bitcast<f32>(last_key.x);
        let per_depth = f32(SLICES) / max(bitcast<f32>(farthest) - nearest, 1e-6 * nearest);
        // Within a slice every fragment is as likely as another to be the nearer one.
        var thickness = array<vec4f, SLICES>();
        for (var f = 0u; f < count; f++) {
            let word = (base + f) * FRAGMENT_WORDS;
            let key = key_at(word);
            if !before(last_key, key) { continue; }
            let fragment = fragment_at(word);
            thickness[slice_of(fragment, nearest, per_depth)] += thickness_of(fragment, solid_depth);
        }
        var visible = array<vec4f, SLICES>();   // of a slice's strands, per thickness
        var before_slice = array<f32, SLICES>();
        for (var i = 0u; i < SLICES; i++) {
            before_slice[i] = dot(transmittance, vec4f(0.25));
            let passed = exp(-thickness[i]);
            visible[i] = transmittance * (1.0 - passed) / max(thickness[i], vec4f(1e-20));
            transmittance *= passed;
        }
        for (var f = 0u; f < count; f++) {
            let word = (base + f) * FRAGMENT_WORDS;
            let key = key_at(word);
            if !before(last_key, key) { continue; }
            let fragment = fragment_at(word);
            let slice = slice_of(fragment, nearest, per_depth);
            let share = 0.25 * dot(visible[slice], thickness_of(fragment, solid_depth));
            if share <= 0.0 || before_slice[slice] < OPAQUE { continue; }
            let segment = segments[fragment.segment];
            show(base + shown, fragment, segment.vertex, share);
            shown++;
            if before_slice[slice] > 1.0 - PICK_ALPHA && key.x > pick.x { pick = vec2u(key.x, segment.vertex - segment.strand + 1u); }
        }
    }
    counts[p] = shown;
    left[at] = vec2u(pack2x16unorm(transmittance.xy), pack2x16unorm(transmittance.zw));
    picks[at] = pick;
}

fn fragment_at(word: u32) -> Fragment {
    return unpack_fragment(vec3u(fragments[word], fragments[word + 1u], fragments[word + 2u]));
}

// Depth bits, segment + 1.
fn key_at(word: u32) -> vec2u {
    return vec2u(fragments[word], fragments[word + 2u] + 1u);
}

fn slice_of(fragment: Fragment, nearest: f32, per_depth: f32) -> u32 {
    return min(u32(max((fragment.depth - nearest) * per_depth, 0.0)), SLICES - 1u);
}

// -ln of what a fragment lets pass towards each sub-sample.
fn thickness_of(fragment: Fragment, solid_depth: vec4f) -> vec4f {
    let in_front = select(vec4f(0.0), vec4f(1.0), vec4f(fragment.depth) < solid_depth);
    // 1 - c would round a millionth away.
    let c = min(fragment.coverage, 0.999);
    return in_front * select(-log(1.0 - c), c * (1.0 + 0.5 * c), c < 1e-2);
}

fn show(entry: u32, fragment: Fragment, vertex: u32, share: f32) {
    want(vertex);
    want(vertex + 1u);
    let word = entry * COMPOSED_WORDS;
    composed[word] = vertex;
    composed[word + 1u] = bitcast<u32>(share);
    composed[word + 2u] = bitcast<u32>(fragment.along);
}

// A vertex that a pixel shows, or the two between which it is interpolated, and the groom points it lies between.
fn want(vertex: u32) {
    let span = select(0u, spans[vertex], settings.straight != 0u);
    if span != 0u { wanted_vertices[vertex] = 2u; }
    wanted_vertices[vertex - (span & 0xffffu)] = 1u;
    wanted_vertices[vertex + (span >> 16u)] = 1u;
    let point = vertices[vertex].source_point;
    wanted_points[point] = 1u;
    wanted_points[min(point + 1u, arrayLength(&wanted_points) - 1u)] = 1u;
}

fn before(a: vec2u, b: vec2u) -> bool {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}
