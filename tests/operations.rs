//! The operation count: exact on a small shader whose operations are known, and within its budget on the scattering functions.

use balayage_render::gpu::{Gpu, Method, Quality, operations, probe, probe_cases};
use balayage_tests::random;

/// Counts per thread: four, and by branch and loop more.
const KNOWN: &str = "
var<private> operation_count: u32;
@group(0) @binding(0) var<storage, read> inputs: array<f32>;
@group(0) @binding(1) var<storage, read_write> counts: array<u32>;

fn three(x: f32) -> vec3f { return exp(vec3f(x, 1.0, 2.0)); }

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&inputs) { return; }
    operation_count = 0u;
    let x = inputs[id.x];
    var sum = three(x).x + length(vec4f(x)) + abs(x) * 3.0 / (1.0 + x * x) + select(x, 1.0, x > 2.0);
    if x > 1.0 { sum += sin(x) + cos(x); }
    for (var k = 0u; k < u32(x); k++) { sum += sqrt(f32(k) + x); }
    switch u32(x) {
        case 3u: { sum += pow(x, 2.5) + atan2(x, 2.0) + inverseSqrt(x) + tanh(x); }
        default: { sum += floor(x); }
    }
    counts[id.x] = operation_count + select(0u, 1000u, sum == 12345.0);
}";

#[test]
fn operations_of_a_known_shader_are_counted_exactly() {
    let gpu = Gpu::headless().unwrap();
    let count = |text: &str| {
        let inputs: [f32; 3] = [0.0, 2.0, 3.0];
        operations::run(&gpu, text, &[], &[bytemuck::cast_slice(&inputs)], 3).unwrap()
    };
    assert_eq!(count(KNOWN), [4, 4 + 2 + 2, 4 + 2 + 3 + 4]);
    // One more operation is seen, in the branch that executes it alone.
    let more = KNOWN.replace("sin(x) + cos(x)", "sin(x) + cos(x) + log(x)");
    assert_eq!(count(&more), [4, 9, 14]);
    // A shader that can not be counted is refused.
    let without = KNOWN.replace("operation_count", "other_name");
    let refused = operations::run(&gpu, &without, &[], &[&[0; 4]], 1);
    assert!(refused.is_err_and(|e| e.to_string().contains("operation_count")));
}

#[test]
fn a_light_costs_at_most_what_the_published_method_costs() {
    let gpu = Gpu::headless().unwrap();
    let mut r = random(51);
    let cases: Vec<_> = (0..2000).map(|_| probe_cases::hair(&mut r, false)).collect();
    let counts = |quality| probe::operations(&gpu, &cases, &Method::of_quality(quality)).unwrap();
    // 140 is the count of Xu 2011 with four segments.
    let standard = counts(Quality::Standard);
    let most = *standard.iter().max().unwrap();
    assert!(most <= 140, "{most} operations");
    // A lobe that gets no light is skipped; a circular fibre that gets some takes no fewer than its roots.
    assert!(standard.iter().all(|count| *count > 2));
    assert!(counts(Quality::High).iter().max().unwrap() > &most);
}
