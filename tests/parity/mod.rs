//! Every function of `shaders/lib`, called through the GPU on random arguments of its domain and held against float64.
//!
//! A [`Parity`] names the functions it covers, the domain, the tolerance and why it is no smaller. Functions that only make sense inside a
//! pass are listed in [`HELD_ELSEWHERE`] with the test that holds them. A function that is in neither fails the suite.

mod diffusion;
mod dual;
mod geometry;
mod maths;
mod models;
mod picture;
mod schemes;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;

use balayage_render::gpu::tables::scattering_tables;
use balayage_render::gpu::{AVERAGES_ENTRIES, Gpu, Kernel, Method, Model, shader};
use balayage_tests::{random, repository};
use rand::Rng;
use rand_pcg::Pcg64Mcg;

/// Arguments of one call.
const ARGUMENTS: usize = 12;
/// Calls of a function whose reference is cheap.
const CALLS: usize = 4096;

/// Shader functions and their float64 counterpart.
#[derive(Clone)]
pub struct Parity {
    /// Functions that the call goes through.
    covers: &'static [&'static str],
    /// The library file, with all it uses.
    file: &'static str,
    /// WGSL statements that read the arguments `x[0]` to `x[11]` and set the vector `y`.
    call: &'static str,
    /// Where the arguments lie.
    domain: &'static str,
    /// Largest difference over the larger of the value and the root mean square of all values.
    tolerance: f64,
    /// Why it is not smaller.
    reason: &'static str,
    /// Calls.
    calls: usize,
    /// Draws arguments; those that are left stay zero.
    draw: fn(&mut Pcg64Mcg) -> Vec<f64>,
    /// The float64 values of `y`; components that are left must be zero.
    reference: fn(&[f64; ARGUMENTS]) -> Vec<f64>,
}

/// Functions whose arguments are a whole scene or whose value is one integral's share: (function, test that holds it and to what).
const HELD_ELSEWHERE: &[(&str, &str)] = &[
    ("sample_at", "volume_work::harmonics_see_what_marches_see"),
    // Parts of the sphere within 3 % of SRBF lights of their width.
    (
        "lobe_integrals",
        "photons::points_scatter_the_field_as_the_reference_does",
    ),
    (
        "harmonic_order",
        "photons::points_scatter_the_field_as_the_reference_does",
    ),
    (
        "meets_box",
        "dirty_paths::a_dab_marches_the_ways_that_cross_it_and_ends_as_if_all_were_marched",
    ),
    // R, TT and TRT under random lights within 0.8 to 2 % root mean square per quality level, elliptic TRT 6 %; poison values.
    (
        "single_scattering",
        "scattering::single_scattering_agrees_with_the_reference",
    ),
    (
        "scattered",
        "scattering::single_scattering_agrees_with_the_reference",
    ),
    (
        "prepare_view",
        "scattering::single_scattering_agrees_with_the_reference",
    ),
    (
        "outer_counts",
        "scattering::single_scattering_agrees_with_the_reference",
    ),
    (
        "tt_gamma_count",
        "scattering::single_scattering_agrees_with_the_reference",
    ),
    (
        "trt_gamma_count",
        "scattering::single_scattering_agrees_with_the_reference",
    ),
    (
        "azimuth_trt_elliptic",
        "scattering::elliptic_single_scattering_agrees_with_the_reference",
    ),
    (
        "meeting_at",
        "scattering::elliptic_single_scattering_agrees_with_the_reference",
    ),
    (
        "single_scattering_constant",
        "furnace::a_white_strand_in_a_white_world_sends_out_the_energy_of_its_lobes",
    ),
    // The paper's approximations have errors of their own: as a whole they give the error level that the paper's method has.
    (
        "outer_integral",
        "schemes::xu2011_has_the_error_of_the_published_method",
    ),
    (
        "inner_integral",
        "schemes::xu2011_has_the_error_of_the_published_method",
    ),
    (
        "xu_azimuth_tt",
        "schemes::xu2011_has_the_error_of_the_published_method",
    ),
    (
        "xu_azimuth_trt",
        "schemes::xu2011_has_the_error_of_the_published_method",
    ),
    (
        "xu_three",
        "schemes::xu2011_has_the_error_of_the_published_method",
    ),
    (
        "scattered_from",
        "schemes::directional_converges_to_the_reference",
    ),
    // Eq 27 under random lights within 1 to 2 % root mean square per quality level.
    (
        "global_scattering",
        "scattering::uniform_light_global_term_and_averages_agree_with_the_reference",
    ),
    (
        "window_mean",
        "scattering::uniform_light_global_term_and_averages_agree_with_the_reference",
    ),
    (
        "global_counts",
        "scattering::uniform_light_global_term_and_averages_agree_with_the_reference",
    ),
    // Orders of d'Eon's model under random lights.
    (
        "scattered_orders",
        "models::deon_agrees_with_the_reference_order_by_order",
    ),
    (
        "uniform_orders",
        "models::a_white_fibre_of_deon_sends_everything_out",
    ),
    ("lobes_of", "models::a_white_fibre_of_deon_sends_everything_out"),
    (
        "cone_counts",
        "models::deon_agrees_with_the_reference_order_by_order",
    ),
    // The march against exact rays: visibility within 0.13 root mean square, a fibre alone sees everything, a head stops all.
    ("march", "volume::visibility_of_a_ball_is_near_exact_rays"),
    ("march_begin", "volume::visibility_of_a_ball_is_near_exact_rays"),
    ("march_next", "volume::a_head_stops_light"),
    ("optical_depth", "volume::visibility_of_a_ball_is_near_exact_rays"),
    (
        "grid_from_world",
        "volume::visibility_of_a_ball_is_near_exact_rays",
    ),
    ("turn_angle", "volume::visibility_of_a_ball_is_near_exact_rays"),
    ("own_share", "volume::a_fibre_does_not_shadow_itself"),
    ("own_strand", "volume::a_fibre_does_not_shadow_itself"),
];

/// One device for all tests of this file.
fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| Gpu::headless().unwrap())
}

/// The table of averages of the default fibre, as pass/averages.wgsl fills it.
fn averages_table() -> &'static wgpu::Buffer {
    static TABLE: OnceLock<wgpu::Buffer> = OnceLock::new();
    TABLE.get_or_init(|| {
        let table = gpu().storage("averages", 16 * AVERAGES_ENTRIES as u64).unwrap();
        let tables = gpu().storage_of("tables", &scattering_tables()).unwrap();
        let fibre = gpu().uniform_of("fibre", &dual::mean_fibre());
        let kernel = Kernel::new(gpu(), "pass/averages.wgsl", &[]).unwrap();
        let bound = kernel.bind(gpu(), &[(0, &tables), (1, &fibre), (2, &table)]);
        kernel.run(gpu(), &bound, 64 * 32);
        table
    })
}

/// Values of the shader's functions at `arguments`.
fn called(parity: &Parity, arguments: &[[f32; ARGUMENTS]]) -> Vec<[f32; 4]> {
    // A model's file wants its fellows.
    let model = if parity.file.contains("_deon") {
        Model::Deon
    } else {
        Model::Marschner
    };
    let method = Method {
        model,
        ..Method::default()
    };
    let library = shader::compose(parity.file, method.files()).unwrap();
    let text = format!(
        "{library}
        @group(0) @binding(0) var<storage, read> arguments: array<array<f32, {ARGUMENTS}>>;
        @group(0) @binding(1) var<storage, read_write> values: array<vec4f>;
        @group(0) @binding(2) var<storage, read> tables: array<vec4f>;
        @group(0) @binding(3) var<storage, read> averages_table: array<vec4f>;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3u) {{
            if id.x >= arrayLength(&arguments) {{ return; }}
            _ = tables[0];
            _ = averages_table[0];
            let x = arguments[id.x];
            var y = vec4f(0.0);
            {}
            values[id.x] = y;
        }}",
        parity.call
    );
    let device = &gpu().device;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(parity.covers[0]),
        source: wgpu::ShaderSource::Wgsl(text.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(parity.covers[0]),
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let inputs = gpu().storage_of("arguments", arguments).unwrap();
    let values = gpu().storage("values", 16 * arguments.len() as u64).unwrap();
    let tables = gpu().storage_of("tables", &scattering_tables()).unwrap();
    let bound = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[&inputs, &values, &tables, averages_table()]
            .map(|buffer| buffer.as_entire_binding())
            .into_iter()
            .zip(0..)
            .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource })
            .collect::<Vec<_>>(),
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &bound, &[]);
        pass.dispatch_workgroups((arguments.len() as u32).div_ceil(64), 1, 1);
    }
    gpu().queue.submit([encoder.finish()]);
    gpu().read(&values, arguments.len()).unwrap()
}

/// Largest difference over the larger of the value and the root mean square of all values; infinite where something is no number.
fn largest_error(got: &[[f64; 4]], want: &[[f64; 4]]) -> f64 {
    let size: f64 = want.iter().flatten().map(|w| w * w).sum();
    let size = (size / want.iter().flatten().filter(|w| **w != 0.0).count().max(1) as f64).sqrt();
    got.iter()
        .flatten()
        .zip(want.iter().flatten())
        .map(|(g, w)| (g - w).abs() / w.abs().max(size))
        .map(|error| if error.is_nan() { f64::INFINITY } else { error })
        .fold(0.0, f64::max)
}

/// Holds each of `parities`, and lets each comparison fail once.
fn hold(parities: &[Parity]) {
    let mut failures = Vec::new();
    for (index, parity) in parities.iter().enumerate() {
        let mut r = random(index as u64);
        let arguments: Vec<[f32; ARGUMENTS]> = (0..parity.calls)
            .map(|_| {
                let drawn = (parity.draw)(&mut r);
                std::array::from_fn(|i| drawn.get(i).copied().unwrap_or(0.0) as f32)
            })
            .collect();
        let got: Vec<[f64; 4]> = called(parity, &arguments)
            .iter()
            .map(|y| y.map(f64::from))
            .collect();
        // The reference sees the numbers that the shader sees.
        let want: Vec<[f64; 4]> = arguments
            .iter()
            .map(|x| {
                let values = (parity.reference)(&x.map(f64::from));
                std::array::from_fn(|i| values.get(i).copied().unwrap_or(0.0))
            })
            .collect();
        let error = largest_error(&got, &want);
        println!(
            "{}: {error:.1e} of {:.1e} ({}; {})",
            parity.covers.join(", "),
            parity.tolerance,
            parity.domain,
            parity.reason
        );
        if error > parity.tolerance {
            let worst = (0..got.len())
                .max_by(|a, b| {
                    let of = |i: &usize| largest_error(&got[*i..=*i], &want[*i..=*i]);
                    of(a).total_cmp(&of(b))
                })
                .unwrap();
            failures.push(format!(
                "{:?}: {error:.2e} above {:.1e}; worst at {:?}: {:?} instead of {:?}",
                parity.covers, parity.tolerance, arguments[worst], got[worst], want[worst]
            ));
        }
        let shifted: Vec<[f64; 4]> = want
            .iter()
            .map(|w| w.map(|w| w * (1.0 + 10.0 * parity.tolerance.max(1e-9))))
            .collect();
        assert!(
            largest_error(&shifted, &want) > parity.tolerance,
            "{:?}: the comparison can not fail",
            parity.covers
        );
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn every_library_function_is_held_once() {
    let mut holders: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    let parities = [
        maths::PARITIES,
        geometry::PARITIES,
        picture::PARITIES,
        dual::PARITIES,
        diffusion::PARITIES,
        schemes::PARITIES,
        models::PARITIES,
    ]
    .concat();
    for parity in &parities {
        for function in parity.covers {
            holders.entry(function).or_default().push(parity.file);
        }
    }
    for (function, test) in HELD_ELSEWHERE {
        let (file, name) = test.split_once("::").unwrap();
        let text = std::fs::read_to_string(repository("tests").join(file).with_extension("rs")).unwrap();
        assert!(text.contains(&format!("\nfn {name}(")), "there is no test {test}");
        holders.entry(function).or_default().push(test);
    }
    let functions: BTreeSet<&str> = shader::SOURCES
        .iter()
        .filter(|(path, _)| path.starts_with("lib/"))
        .flat_map(|(_, text)| text.lines())
        .filter_map(|line| line.strip_prefix("fn ")?.split('(').next())
        .collect();
    let missing: Vec<_> = functions.iter().filter(|f| !holders.contains_key(**f)).collect();
    assert!(missing.is_empty(), "no test holds {missing:?}");
    let unknown: Vec<_> = holders.keys().filter(|f| !functions.contains(**f)).collect();
    assert!(unknown.is_empty(), "no such function: {unknown:?}");
}

/// A number of [low, high).
fn between(r: &mut Pcg64Mcg, low: f64, high: f64) -> f64 {
    r.random_range(low..high)
}

/// A number of [low, high), its logarithm uniform.
fn log_between(r: &mut Pcg64Mcg, low: f64, high: f64) -> f64 {
    between(r, low.ln(), high.ln()).exp()
}
