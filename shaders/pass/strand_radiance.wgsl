// Radiance of every refined vertex: its single scattering, and the multiple scattering of the two groom points around it.

//!use lib/refined.wgsl

@group(0) @binding(0) var<storage, read> vertices: array<RefinedVertex>;
@group(0) @binding(1) var<storage, read> scattered_once: array<vec4f>;          // per refined vertex
@group(0) @binding(2) var<storage, read> multiple: array<vec4f>;        // per groom point
@group(0) @binding(3) var<storage, read_write> radiance: array<vec4f>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * 65535u * 64u;
    if index >= arrayLength(&scattered_once) { return; }
    let point = vertices[index].source_point;
    let next = min(point + 1u, arrayLength(&multiple) - 1u);
    radiance[index] = vec4f(scattered_once[index].rgb + mix(multiple[point], multiple[next], vertices[index].source_fraction).rgb, 1.0);
}
