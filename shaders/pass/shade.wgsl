// Strand shading: the radiance that every refined vertex sends to the camera under one batch of lights.
// One thread a vertex; batches add up. The last batch of a constant environment weighs its exact integral by the visible share.

//!use lib/types.wgsl
//!use lib/refined.wgsl
//!use lib/marschner.wgsl
//!use lib/volume.wgsl
//!use lib/multiple.wgsl
//!use lib/frame.wgsl

struct ShadeUniform {
    camera_position: vec3f,
    vertex_count: u32,
    constant: vec3f,           // radiance of the uniform environment that this batch stands for, 0 for real lights
    point_count: u32,
    alpha_ratios: vec2f,       // TT, TRT to R
    beta_ratios: vec2f,
    terms: u32,                // bits: 1 R, 2 TT, 4 TRT, 8 D, 16 L, 32 U
    first_light: u32,
    light_count: u32,
    adds: u32,                 // 0: this batch is the first one
}
