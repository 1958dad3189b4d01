// Strand shading: the radiance that every refined vertex sends to the camera under one batch of lights. One thread a vertex; batches add up.
// Lights that stand for a uniform environment only weigh its exact integral by the share of them that is seen.

//!use lib/types.wgsl
//!use lib/refined.wgsl
//!use lib/marschner.wgsl
//!use lib/multiple.wgsl
//!use lib/volume.wgsl
//!use lib/light.wgsl

struct ShadeUniform {
    camera_position: vec3f,
    vertex_count: u32,
    constant: vec3f,           // radiance of the uniform environment that this batch stands for; 0: the lights are what they are
    point_count: u32,
    alpha_ratios: vec2f,       // TT, TRT to R
    beta_ratios: vec2f,
    terms: u32,                // TERM_ bits
    first_light: u32,
    light_count: u32,
    adds: u32,                 // 0: the first batch of the frame
}


const TERM_R: u32 = 1u;
const TERM_TT: u32 = 2u;
const TERM_TRT: u32 = 4u;
const TERM_D: u32 = 8u;
const TERM_L: u32 = 16u;
const TERM_U: u32 = 32u;
