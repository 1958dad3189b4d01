//!use lib/single.wgsl
//!use lib/probe_case.wgsl
// Transcendental operations of single_scattering at single points: the host adds the counting (gpu::operations). What is prepared per
// vertex and view is not counted.

var<private> operation_count: u32;

@group(0) @binding(0) var<storage, read> tables: array<vec4f>;
@group(0) @binding(1) var<storage, read> cases: array<ProbeCase>;
@group(0) @binding(2) var<storage, read_write> counts: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * 65535u * 64u;
    if index >= arrayLength(&cases) {
        return;
    }
    let c = cases[index];
    let view = prepare_view(guarded_fibre(c.fibre), c.theta_o, c.phi_o);
    operation_count = 0u;
    let lobes = single_scattering(view, c.theta_j, c.phi_j, c.lambda_j);
    counts[index] = operation_count;
}
