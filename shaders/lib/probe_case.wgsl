//!use lib/fibre.wgsl
// One point at which the scattering functions are evaluated (Rust: gpu::probe::GpuCase).

struct ProbeCase {
    fibre: Fibre,
    theta_o: f32,
    phi_o: f32,
    theta_j: f32,
    phi_j: f32,
    lambda_j: f32,
    sigma_f: f32,
}
