// Directions spread over an SRBF light (Rust: volume::lobe).

// A light's frame and where its two sets of directions are.
struct LobeLight {
    axis: vec3f,
    first_visibility: u32,   // directions that visibility is fitted to
    tangent: vec3f,
    visibility_count: u32,
    bitangent: vec3f,
    first_path: u32,         // directions for multiple scattering
    path_count: u32,
    mean_cosine: f32,        // length A of the lobe's mean direction
    bandwidth: f32,          // lambda
    solid_angle: f32,        // pi lambda^2 (1 - exp(-4 / lambda^2))
}

// One direction of a light, in the light's frame (tangent, bitangent, axis).
struct LobeDirection {
    local: vec3f,
    weight_a: f32,           // weight in a of T(w) = a + b . (w - A w_j)
    weight_b: vec3f,         // weight in b, light's frame
    solid_angle: f32,        // a set's sum to the light's
}

// A vector of the light's frame, turned by an angle with the given cosine and sine about the axis, in world space.
fn world_from_lobe(light: LobeLight, local: vec3f, turn: vec2f) -> vec3f {
    let x = turn.x * local.x - turn.y * local.y;
    let y = turn.y * local.x + turn.x * local.y;
    return light.tangent * x + light.bitangent * y + light.axis * local.z;
}
