// The head at 2 x 2 sub-samples a pixel: colour of its vertices and depth along the camera's axis.

//!use lib/camera.wgsl

@group(0) @binding(0) var<uniform> camera: CameraUniform;
@group(0) @binding(1) var<storage, read> positions: array<vec4f>;
@group(0) @binding(2) var<storage, read> radiance: array<vec4f>;

struct Varying {
    @builtin(position) position: vec4f,
    @location(0) radiance: vec3f,
    @location(1) depth: f32,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Varying {
    let p = camera.view_from_world * vec4f(positions[index].xyz, 1.0);
    // Clip space with the image plane's own pixel scale, so that sub-pixel jitter and off-centre pictures need nothing more.
    let half_size = 0.5 * vec2f(camera.size);
    let offset = (camera.centre_px - half_size) / half_size;
    let depth = -p.z;
    let clip = vec4f(
        p.x * camera.focal_px / half_size.x + offset.x * depth,
        p.y * camera.focal_px / half_size.y - offset.y * depth,
        depth - camera.near,
        depth);
    return Varying(clip, radiance[index].rgb, depth);
}

struct Pixel {
    @location(0) colour: vec4f,
    @location(1) depth: f32,
}

@fragment
fn fragment(in: Varying) -> Pixel {
    return Pixel(vec4f(in.radiance, 1.0), in.depth);
}
