// The pinhole camera of a frame and the band of rows that is being drawn (Rust: gpu::camera::CameraUniform).

struct CameraUniform {
    view_from_world: mat4x4f,
    position: vec3f,         // world space, groom units
    focal_px: f32,           // pixels per unit of slope
    centre_px: vec2f,        // image point of the optical axis, sub-pixel jitter included
    near: f32,               // nearest depth that is drawn
    first_row: u32,          // rows [first_row, end_row) are drawn
    size: vec2u,             // of the whole picture
    end_row: u32,
    segment_count: u32,      // that are drawn, from the first one on
    width_factor: f32,       // on the width of the strands: fewer of them stand for all
    solid_coverage: f32,     // from which a strand hides all that is behind it in a pixel; above 1: never
}

// Image point in pixels (x right, y down) and depth along the axis of a view-space point in front of the camera.
fn pixel_from_view(camera: CameraUniform, p: vec3f) -> vec3f {
    let depth = -p.z;
    let slope = camera.focal_px / depth;
    return vec3f(camera.centre_px.x + p.x * slope, camera.centre_px.y - p.y * slope, depth);
}

// Width in pixels at depth 1 of a fibre of diameter 1 from a to b (view space): its outlines lie half a diameter beside the axis, normal to the
// plane through axis and eye. The farther from the optical axis, the wider it is in the picture than seen head-on.
fn outline_width(camera: CameraUniform, a: vec3f, b: vec3f) -> f32 {
    let normal = cross(b - a, a);
    return camera.width_factor * camera.focal_px * length(normal) / max(length(normal.xy), 1e-30);
}
