// The ribbons' picture: mean radiance of what a pixel shows, as much of it as is covered.

//!use lib/camera.wgsl

@group(0) @binding(0) var<uniform> camera: CameraUniform;
@group(0) @binding(1) var sums: texture_2d<f32>;
@group(0) @binding(2) var left: texture_2d<f32>;                        // what gets past all ribbons
@group(0) @binding(3) var<storage, read_write> picture: array<vec4f>;   // premultiplied

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let p = id.x + id.y * 65535u * 64u;
    if p >= camera.size.x * camera.size.y { return; }
    let pixel = vec2u(p % camera.size.x, p / camera.size.x);
    let sum = textureLoad(sums, pixel, 0);
    let alpha = 1.0 - textureLoad(left, pixel, 0).r;
    picture[p] = alpha * vec4f(sum.rgb / max(sum.a, 1e-6), 1.0);
}
