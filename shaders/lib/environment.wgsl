// Equirectangular maps: pixel (u, v) in [0,1]^2, row 0 on top, is (sin 2 pi u sin pi v, cos pi v, -cos 2 pi u sin pi v).

const PI: f32 = 3.14159265358979;

fn uv_from_direction(w: vec3f) -> vec2f {
    return vec2f(fract(atan2(w.x, -w.z) / (2.0 * PI)), acos(clamp(w.y, -1.0, 1.0)) / PI);
}

// `w` turned by `angle_rad` about the y axis, right-handed.
fn turned_about_y(w: vec3f, angle_rad: f32) -> vec3f {
    let c = cos(angle_rad);
    let s = sin(angle_rad);
    return vec3f(c * w.x + s * w.z, w.y, c * w.z - s * w.x);
}
