// The hot spot: what the eye sees, a light beside the eye reaches, since the same fibres would hide it from both (Kuusk 1985 for leaves; here for
// fibres). Visibility of a light is known on average around a point; that of a place that the eye sees is larger by exp(d), with d the expected
// number of fibres that hide a place from both. Of parallel fibres those count whose axes pass within a radius of both rays: an area of
// cot(phi / 2) diameter^2 / 4 in the plane across them, phi being the angle between the rays there.

// Optical depth that eye and light have in common. `neighbours`: those of the place (Rust: volume::Neighbours); `eye` and `light` unit
// vectors of its fibre's frame, the light's directions spread by `variance` along an arc.
fn common_depth(neighbours: vec2f, eye: vec3f, light: vec3f, variance: f32) -> f32 {
    let filled = neighbours.x;
    let spread = neighbours.y;
    // Means over the neighbours' tangents t, spread evenly around the fibre: of (t . eye)(t . light), of the rays' squared sines to t, and of
    // the squared determinant (t, eye, light).
    let along = 1.0 - 1.5 * spread;
    let together = dot(eye, light);
    let both = along * eye.x * light.x + 0.5 * spread * together;
    let eye_across = 1.0 - along * eye.x * eye.x - 0.5 * spread;
    let light_across = 1.0 - along * light.x * light.x - 0.5 * spread;
    let normal = cross(eye, light);
    let apart = along * normal.x * normal.x + 0.5 * spread * dot(normal, normal) + variance * eye_across;
    return filled * max(sqrt(max(eye_across * light_across, 0.0)) + together - both, 0.0) * inverseSqrt(max(apart, 1e-6));
}
