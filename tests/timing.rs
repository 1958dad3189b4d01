//! What a frame says of its own times: shaders on the GPU, scopes in a trace, variants compiled before they are wanted.

use balayage_render::gpu::{Gpu, RenderSettings, Renderer};
use balayage_render::groom::ball;
use balayage_render::light::{LightSet, SrbfLight};
use balayage_render::param::{LobeRatios, PigmentSet, PointValues};
use glam::Vec3;

fn hairy(gpu: &Gpu) -> (Renderer, balayage_render::gpu::Camera) {
    let groom = ball(200, 0.02, 1).unwrap();
    let hair = PointValues::default().vertex_params(PigmentSet::default(), &LobeRatios::default());
    let mut renderer = Renderer::new(gpu).unwrap();
    renderer.set_groom(&groom, None).unwrap();
    renderer
        .set_params(&vec![hair; groom.point_count()], &[])
        .unwrap();
    renderer.set_lights(&LightSet {
        lights: vec![SrbfLight {
            direction: Vec3::Y,
            bandwidth: 0.3,
            radiance: Vec3::ONE,
        }],
        ..LightSet::default()
    });
    (
        renderer,
        balayage_render::gpu::Camera::framing(groom.bounds(), 1.0),
    )
}

#[test]
fn the_gpu_times_its_shaders_where_it_is_asked() {
    let mut gpu = Gpu::headless().unwrap();
    let settings = RenderSettings::default();
    let (mut renderer, camera) = hairy(&gpu);
    let untimed = renderer.render(&camera, [48, 48], &settings).unwrap();
    assert!(!gpu.is_software || untimed.shaders.is_empty(), "{untimed:?}");

    gpu.time_passes();
    let (mut renderer, camera) = hairy(&gpu);
    let report = renderer.render(&camera, [48, 48], &settings).unwrap();
    let wall: f64 = report.passes.iter().map(|(_, ms)| ms).sum();
    let inside: f64 = report.shaders.iter().map(|(_, ms)| ms).sum();
    for shader in [
        "pass/shade.wgsl",
        "pass/shade_field.wgsl",
        "pass/strand_sort.wgsl",
    ] {
        let found = report.shaders.iter().find(|(name, _)| name == shader);
        assert!(found.is_some_and(|(_, ms)| *ms > 0.0), "{shader}: {report:?}");
    }
    assert!(inside <= wall, "{inside} ms in shaders of {wall} ms: {report:?}");

    // A frame tells of itself alone.
    let mut brighter = settings;
    brighter.view_exposure_ev = 1.0;
    let second = renderer.render(&camera, [48, 48], &brighter).unwrap();
    assert!(
        !second.shaders.iter().any(|(name, _)| name.contains("shade")),
        "{second:?}"
    );
}

#[test]
fn what_is_prepared_is_not_compiled_again() {
    let gpu = Gpu::headless().unwrap();
    let settings = RenderSettings::default();
    let compiled = |prepares: bool| {
        let (mut renderer, camera) = hairy(&gpu);
        if prepares {
            renderer.prepare(&settings);
        }
        let report = renderer.render(&camera, [48, 48], &settings).unwrap();
        (
            report.counter("shader variants compiled"),
            renderer.picture().unwrap().pixels,
        )
    };
    let ((unprepared, wanted), (prepared, got)) = (compiled(false), compiled(true));
    assert_eq!((unprepared, prepared), (1, 0));
    assert!(wanted == got, "the same shaders, the same picture");
}

/// Exit code and what was said.
fn balayage(args: &[&str]) -> (u8, String) {
    let mut err = Vec::new();
    let args = [&["balayage"], args].concat();
    let code = balayage::cli::run(args, &mut Vec::new(), &mut err);
    (code, String::from_utf8(err).unwrap())
}

#[test]
fn a_trace_holds_the_scopes_of_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (picture, trace) = (path("p.png"), path("trace.json"));
    let refused = balayage(&[
        "render",
        "-o",
        &picture,
        "--size",
        "32x32",
        "--trace",
        &path("no/t.json"),
    ]);
    assert_eq!(refused.0, 1, "{refused:?}");
    assert!(refused.1.contains("--trace"), "{refused:?}");

    let done = balayage(&["render", "-o", &picture, "--size", "32x32", "--trace", &trace]);
    assert_eq!(done.0, 0, "{done:?}");
    let events: Vec<serde_json::Value> = serde_json::from_slice(&std::fs::read(trace).unwrap()).unwrap();
    for scope in ["frame", "strand shading", "density volume", "refine strands"] {
        let times = |phase: &str| {
            let is_it = |event: &&serde_json::Value| event["name"] == scope && event["ph"] == phase;
            events.iter().filter(is_it).count()
        };
        assert!(times("B") > 0 && times("E") > 0, "{scope}");
    }
}
