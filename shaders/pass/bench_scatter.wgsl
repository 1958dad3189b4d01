//!use lib/single.wgsl
//!use lib/probe_case.wgsl
// Single scattering of many lights per case, as strand shading evaluates it: what `bench scatter` times.

// Lights of a case (Rust: gpu::bench::LIGHTS).
override lights: u32 = 40u;

@group(0) @binding(0) var<storage, read> tables: array<vec4f>;
@group(0) @binding(1) var<storage, read> cases: array<ProbeCase>;
@group(0) @binding(2) var<storage, read_write> results: array<vec4f>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * 65535u * 64u;
    if index >= arrayLength(&cases) {
        return;
    }
    let c = cases[index];
    let view = prepare_view(guarded_fibre(c.fibre), c.theta_o, c.phi_o);
    var sum = vec3f(0.0);
    for (var j = 0u; j < lights; j++) {
        // Lights around the case's own, no two alike: nothing can be carried over from one to the next.
        let step = f32(j);
        let lobes = single_scattering(view, c.theta_j * (1.0 - 1e-3 * step), c.phi_j + 2.4 * step, c.lambda_j * (1.0 + 1e-3 * step));
        sum += lobes.r + lobes.tt + lobes.trt;
    }
    results[index] = vec4f(sum, 1.0);
}
