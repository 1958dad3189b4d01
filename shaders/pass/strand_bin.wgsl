// Strand segments to pixels, twice: first every pixel's fragments are counted, then (STORE) written into its list.
// One thread a segment; it walks the pixels along its major axis.

//!use lib/camera.wgsl
//!use lib/coverage.wgsl
//!use lib/fragment.wgsl
//!use lib/refined.wgsl

override STORE: bool = false;

@group(0) @binding(0) var<uniform> camera: CameraUniform;
@group(0) @binding(1) var<storage, read> vertices: array<RefinedVertex>;
@group(0) @binding(2) var<storage, read> segments: array<Segment>;
@group(0) @binding(3) var<storage, read_write> counts: array<atomic<u32>>;    // one a pixel of the band
@group(0) @binding(4) var<storage, read> offsets: array<u32>;                  // first fragment of each pixel's list
@group(0) @binding(5) var<storage, read_write> fragments: array<u32>;
// Nearness (inverted depth bits) of the nearest strand that covers a whole pixel of the band; 0 where none does.
@group(0) @binding(6) var<storage, read_write> solid: array<atomic<u32>>;

// Below this share of a pixel's area, or of what the segment covers at most, a fragment is not worth a list entry.
const MIN_COVERAGE: f32 = 1e-5;
const MIN_SHARE: f32 = 1e-3;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * 65535u * 64u;
    if index >= camera.segment_count { return; }
    let first = segments[index].vertex;
    var a = (camera.view_from_world * vec4f(vertices[first].position, 1.0)).xyz;
    var b = (camera.view_from_world * vec4f(vertices[first + 1u].position, 1.0)).xyz;

    // What is behind the near plane is cut off; `cut` keeps the place along the whole segment.
    let behind_a = -a.z < camera.near;
    let behind_b = -b.z < camera.near;
    if behind_a && behind_b { return; }
    var cut = vec2f(0.0, 1.0);
    let at_near = (-a.z - camera.near) / (b.z - a.z);
    if behind_a { a = mix(a, b, at_near); cut.x = at_near; }
    else if behind_b { b = mix(a, b, at_near); cut.y = at_near; }

    let pa = pixel_from_view(camera, a);
    let pb = pixel_from_view(camera, b);
    let width = outline_width(camera, a, b);
    let width_a = vertices[first].diameter * width / pa.z;
    let width_b = vertices[first + 1u].diameter * width / pb.z;
    let delta = pb.xy - pa.xy;
    let extent = length(delta);
    // A segment seen end on has no direction in the picture: its disc's area is below what its neighbours show.
    if !(extent > 1e-6) || !(extent < 1e6) { return; }
    let axis = delta / extent;
    let across = vec2f(-axis.y, axis.x);
    let reach_across = pixel_reach(across) + 0.5 * max(width_a, width_b);
    let reach_along = pixel_reach(axis);

    let least_coverage = min(MIN_COVERAGE, MIN_SHARE * 0.5 * (width_a + width_b) * min(extent, 1.0));

    // Pixels are visited in columns of the major axis; x and y change roles through `steep`.
    let steep = abs(axis.y) > abs(axis.x);
    let size = vec2i(i32(camera.size.x), i32(camera.size.y));
    let band = vec2i(i32(camera.first_row), i32(camera.end_row));
    let major_limit = select(vec2i(0, size.x), band, steep);
    let minor_limit = select(band, vec2i(0, size.x), steep);
    let pa_major = select(pa.xy, pa.yx, steep);
    let pb_major = select(pb.xy, pb.yx, steep);
    let axis_major = select(axis, axis.yx, steep);
    let slope = axis_major.y / axis_major.x;
    let pad = reach_along * abs(axis_major.x) + reach_across * abs(axis_major.y);
    let from_major = max(i32(floor(min(pa_major.x, pb_major.x) - pad)), major_limit.x);
    let to_major = min(i32(floor(max(pa_major.x, pb_major.x) + pad)) + 1, major_limit.y);
    let minor_reach = reach_across / abs(axis_major.x);
    for (var m = from_major; m < to_major; m++) {
        let centre_major = f32(m) + 0.5;
        let on_axis = pa_major.y + (centre_major - pa_major.x) * slope;
        // Within the width of the strip, and between its ends.
        var minor = vec2f(on_axis - minor_reach, on_axis + minor_reach);
        if abs(axis_major.y) > 1e-4 {
            let before = (centre_major - pa_major.x) * axis_major.x;
            let ends = pa_major.y + (vec2f(-reach_along, extent + reach_along) - before) / axis_major.y;
            minor = vec2f(max(minor.x, min(ends.x, ends.y)), min(minor.y, max(ends.x, ends.y)));
        }
        let from_minor = max(i32(ceil(minor.x - 0.5)), minor_limit.x);
        let to_minor = min(i32(floor(minor.y - 0.5)) + 1, minor_limit.y);
        for (var n = from_minor; n < to_minor; n++) {
            let pixel = select(vec2i(m, n), vec2i(n, m), steep);
            let from_a = vec2f(pixel) + 0.5 - pa.xy;
            let t = dot(from_a, axis);
            let s = dot(from_a, across);
            let along = clamp(t / extent, 0.0, 1.0);
            // Depth is linear in 1/depth along the picture.
            let depth = 1.0 / mix(1.0 / pa.z, 1.0 / pb.z, along);
            let nearness = ~bitcast<u32>(depth);
            let p = u32(pixel.y - band.x) * camera.size.x + u32(pixel.x);
            if nearness < atomicLoad(&solid[p]) { continue; }
            let share = pixel_cdf(extent - t, axis) - pixel_cdf(-t, axis);
            let half_width = 0.5 * mix(width_a, width_b, along);
            // Area of the strip in this pixel, times the share of the pixel's length that lies between the ends.
            let coverage = share * (pixel_cdf(half_width - s, across) - pixel_cdf(-half_width - s, across));
            if !(coverage > least_coverage) { continue; }
            let slot = atomicAdd(&counts[p], 1u);
            if STORE {
                let base = (offsets[p] + slot) * FRAGMENT_WORDS;
                let perspective = along * depth / pb.z;
                fragments[base] = bitcast<u32>(depth);
                fragments[base + 1u] = pack_fragment_middle(min(coverage, 1.0), mix(cut.x, cut.y, perspective));
                fragments[base + 2u] = index;
            } else if coverage >= camera.solid_coverage {
                atomicMax(&solid[p], nearness);
            }
        }
    }
}
