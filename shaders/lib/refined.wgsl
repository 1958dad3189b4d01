// A point of the smooth strand at which light is evaluated (Rust: gpu::strands::RefinedVertex).

struct RefinedVertex {
    position: vec3f,
    diameter: f32,           // groom units
    tangent: vec3f,          // u: root to tip
    source_fraction: f32,    // from the groom point `source_point` to the next one
    normal: vec3f,           // v: rotation-minimizing
    source_point: u32,
}

// First vertex of a segment and the strand it belongs to.
struct Segment {
    vertex: u32,
    strand: u32,
}
