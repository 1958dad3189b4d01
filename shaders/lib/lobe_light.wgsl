// Directions spread over an SRBF light (Rust: volume::lobe).

// A light's frame and where its directions are.
struct LobeLight {
    axis: vec3f,
    first_direction: u32,
    tangent: vec3f,
    direction_count: u32,
    bitangent: vec3f,
    mean_cosine: f32,        // length A of the lobe's mean direction
}

// One direction of a light, in the light's frame (tangent, bitangent, axis).
struct LobeDirection {
    local: vec3f,
    weight_a: f32,           // weight in a of T(w) = a + b . (w - A w_j)
    weight_b: vec3f,         // weight in b, light's frame
    solid_angle: f32,        // a light's sum to pi lambda^2 (1 - exp(-4 / lambda^2))
}
