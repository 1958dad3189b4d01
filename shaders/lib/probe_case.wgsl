//!use lib/fibre.wgsl
// One point at which the model is evaluated (Rust: gpu::probe::ProbeCase). Radians.

struct ProbeCase {
    fibre: Fibre,
    theta_o: f32,
    phi_o: f32,
    theta_j: f32,
    phi_j: f32,
    lambda_j: f32,
    sigma_f: f32,
}
