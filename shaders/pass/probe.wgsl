//!use lib/single.wgsl
//!use lib/probe_case.wgsl
//!use lib/global.wgsl
//!use lib/averages.wgsl
//!use lib/probe_case.wgsl
// The scattering functions at single points: one thread per case.

struct ProbeResult {
    single: Lobes,
    global: Lobes,
    uniform_light: Lobes,      // single scattering of a uniform environment
    averages: array<Averages, 3>,
}

@group(0) @binding(0) var<storage, read> tables: array<vec4f>;
@group(0) @binding(1) var<storage, read> cases: array<ProbeCase>;
@group(0) @binding(2) var<storage, read_write> results: array<ProbeResult>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * 65535u * 64u;
    if index >= arrayLength(&cases) {
        return;
    }
    let c = cases[index];
    let f = guarded_fibre(c.fibre);
    let view = prepare_view(f, c.theta_o, c.phi_o);
    results[index].single = single_scattering(view, c.theta_j, c.phi_j, c.lambda_j);
    results[index].global = global_scattering(f, c.theta_o, c.phi_o, c.theta_j, c.phi_j, c.sigma_f);
    results[index].uniform_light = single_scattering_constant(view);
    for (var channel = 0u; channel < 3u; channel++) {
        results[index].averages[channel] = scattering_averages(f, f.sigma_a[channel], c.theta_j);
    }
}
