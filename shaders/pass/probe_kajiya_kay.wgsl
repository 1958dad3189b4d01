//!use lib/single_kajiya_kay.wgsl
//!use lib/probe_case.wgsl
// The model of Kajiya and Kay at single points: one thread per case.

struct KajiyaKayResult {
    single: Lobes,
    uniform_light: Lobes,    // single scattering of a uniform environment
    diffuse: f32,            // with K_d = 1
    specular: f32,           // with K_s = 1
}

@group(0) @binding(0) var<storage, read> tables: array<vec4f>;
@group(0) @binding(1) var<storage, read> cases: array<ProbeCase>;
@group(0) @binding(2) var<storage, read_write> results: array<KajiyaKayResult>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * 65535u * 64u;
    if index >= arrayLength(&cases) {
        return;
    }
    let c = cases[index];
    let view = prepare_view(guarded_fibre(c.fibre), c.theta_o, c.phi_o);
    let theta_j = guarded(c.theta_j, -HALF_PI, HALF_PI, 0.0);
    let width = guarded(c.lambda_j, 1e-3, 1e3, 1.0);
    results[index].single = single_scattering(view, c.theta_j, c.phi_j, c.lambda_j);
    results[index].uniform_light = single_scattering_constant(view);
    results[index].diffuse = kajiya_kay_diffuse(theta_j, width);
    results[index].specular = kajiya_kay_specular(view.exponent, view.axis, theta_j, 1.0 / (width * width), outer_counts().x);
}
