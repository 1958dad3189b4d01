// Radiance of every refined vertex that a pixel shows: its single scattering (in the middle of a straight span that of the ends), and the multiple scattering of
// the two groom points around it. Its a is the number of the frame that changed it.

//!use lib/refined.wgsl

struct RadianceUniform {
    frame: f32,
    straight: u32,      // 1: vertices in the middle of a straight span are interpolated
}

@group(0) @binding(0) var<storage, read> vertices: array<RefinedVertex>;
@group(0) @binding(1) var<storage, read> scattered_once: array<vec4f>;          // per refined vertex
@group(0) @binding(2) var<storage, read> multiple: array<vec4f>;        // per groom point
@group(0) @binding(3) var<storage, read_write> radiance: array<vec4f>;
@group(0) @binding(4) var<storage, read> spans: array<u32>;             // StrandBuffers::spans
@group(0) @binding(5) var<uniform> now: RadianceUniform;
@group(0) @binding(6) var<storage, read> wanted: array<u32>;            // StrandBuffers::wanted_vertices

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * 65535u * 64u;
    if index >= arrayLength(&scattered_once) || wanted[index] == 0u { return; }
    let point = vertices[index].source_point;
    let next = min(point + 1u, arrayLength(&multiple) - 1u);
    let span = select(0u, spans[index], now.straight != 0u);
    let before = span & 0xffffu;
    let behind = span >> 16u;
    let part = f32(before) / max(f32(before + behind), 1.0);
    let once = mix(scattered_once[index - before].rgb, scattered_once[index + behind].rgb, part);
    let sum = once + mix(multiple[point], multiple[next], vertices[index].source_fraction).rgb;
    // Bit by bit: what is not a number is unequal to itself, or not, as drivers like.
    if any(bitcast<vec3u>(sum) != bitcast<vec3u>(radiance[index].rgb)) { radiance[index] = vec4f(sum, now.frame); }
}
