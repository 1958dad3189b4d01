//!use lib/single_deon.wgsl
//!use lib/probe_case.wgsl
// The model of d'Eon 2011 at single points, order by order: one thread per case.

struct DeonResult {
    orders: Orders,
    uniform_light: Orders,    // of a uniform environment
    cone: f32,                // M_p of R between theta_j and the view
}

@group(0) @binding(0) var<storage, read> tables: array<vec4f>;
@group(0) @binding(1) var<storage, read> cases: array<ProbeCase>;
@group(0) @binding(2) var<storage, read_write> results: array<DeonResult>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * 65535u * 64u;
    if index >= arrayLength(&cases) {
        return;
    }
    let c = cases[index];
    let f = guarded_fibre(c.fibre);
    let view = prepare_view(f, c.theta_o, c.phi_o);
    let theta_j = guarded(c.theta_j, -HALF_PI, HALF_PI, 0.0);
    results[index].orders = scattered_orders(view, c.theta_j, c.phi_j, c.lambda_j);
    results[index].uniform_light = uniform_orders(view);
    results[index].cone = m_p(view.variance.x, theta_j, view.theta_o - 2.0 * f.alpha.x);
}
