// Fills the table of lib/averages_table.wgsl for the groom's mean fibre: one work group per absorption, one thread per inclination.
//!use lib/averages.wgsl
//!use lib/averages_table.wgsl
//!use lib/backward.wgsl

@group(0) @binding(0) var<storage, read> tables: array<vec4f>;
@group(0) @binding(1) var<uniform> mean_fibre: Fibre;
@group(0) @binding(2) var<storage, read_write> averages_table: array<vec4f>;

// cos(theta) and cos(theta) a_b / (1 - a_f + k) of every inclination.
var<workgroup> reflected: array<vec2f, 64>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) node: u32) {
    let sigma = group.x;
    let theta = averages_theta(node);
    let raw = scattering_averages(guarded_fibre(mean_fibre), averages_sigma(sigma), theta);
    // A fibre can not send out more than it gets, one that loses nothing no less; quadrature and the lobes' norm may say a little else, which
    // over hundreds of fibres would be all.
    var whole = raw;
    if IS_LOSSLESS { whole = scattering_averages(guarded_fibre(mean_fibre), 0.0, theta); }
    let excess = select(max(raw.a_f + raw.a_b, 1.0), whole.a_f + whole.a_b, IS_LOSSLESS);
    let a_f = raw.a_f / excess;
    let a_b = raw.a_b / excess;
    let k = decay_per_fibre(a_f, a_b);
    let entry = AVERAGES_ENTRY * (sigma * AVERAGES_THETAS + node);
    averages_table[entry] = vec4f(a_f, a_b, raw.beta_f, raw.beta_b);
    averages_table[entry + 1u] = vec4f(raw.alpha_f, raw.alpha_b, k, 0.0);
    averages_table[entry + 2u] = backward_of(FibreAverages(a_f, a_b, raw.beta_f, raw.beta_b, raw.alpha_f, raw.alpha_b, k));

    reflected[node] = cos(theta) * vec2f(1.0, a_b / (1.0 - a_f + k));
    workgroupBarrier();
    if node == 0u {
        var sum = vec2f(0.0);
        for (var i = 0u; i < AVERAGES_THETAS; i++) {
            sum += reflected[i];
        }
        averages_table[AVERAGES_ENTRY * AVERAGES_SIGMAS * AVERAGES_THETAS + sigma] = vec4f(sum.y / sum.x, 0.0, 0.0, 0.0);
    }
}
