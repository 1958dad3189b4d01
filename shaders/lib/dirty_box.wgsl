// Where paint changed voxels, in grid space (Rust: gpu::transmittance::dirty_boxes).

struct DirtyBox {
    low: vec3f,
    high: vec3f,
}

// Whether the ray from `start` along the unit vector w meets the box.
fn meets_box(box: DirtyBox, start: vec3f, w: vec3f) -> bool {
    // As in a march, a vanishing component is none.
    let inverse_w = 1.0 / select(w, vec3f(1e-8), abs(w) < vec3f(1e-8));
    let a = (box.low - start) * inverse_w;
    let b = (box.high - start) * inverse_w;
    let enter = min(a, b);
    let leave = max(a, b);
    return min(leave.x, min(leave.y, leave.z)) >= max(0.0, max(enter.x, max(enter.y, enter.z)));
}
