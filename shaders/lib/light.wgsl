// An SRBF light (Rust: gpu::lights::LightUniform): radiance * exp(2 (w . direction - 1) / bandwidth^2).

struct Light {
    direction: vec3f,    // unit, towards the light
    bandwidth: f32,      // lambda
    radiance: vec3f,     // at the centre, linear Rec.709
    share: f32,          // of all lights' power, in the channel where it is greatest
}
