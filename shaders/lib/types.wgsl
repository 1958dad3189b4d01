// Structures that host and shaders share; a test holds their layouts against the Rust side.

// What a user painted at one groom point (Rust: param::VertexParams).
struct VertexParams {
    sigma_a: vec3f,          // absorption per fibre radius, linear Rec.709
    alpha_rad: f32,          // cuticle tilt of R, negative towards the root
    beta_rad: f32,           // standard deviation of R in theta_h
    azimuthal_width: f32,    // bandwidth w_c of Xu 2011
    eta: f32,                // index of refraction
    eccentricity: f32,       // a of Xu 2011 Eq 24, 1 = circular
    alpha_ratios: vec2f,     // tilt of TT, TRT over R's
    beta_ratios: vec2f,      // width of TT, TRT over R's
}
