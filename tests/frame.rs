//! The frame: what is not seen or not stale is not computed, and the picture does not tell.

use balayage_render::gpu::{Camera, FrameReport, Gpu, Multiple, RenderSettings, Renderer, ShadeSettings};
use balayage_render::groom::{DEFAULT_MAX_TURN_RAD, Groom, RefinedGroom};
use balayage_render::light::{LightSet, SrbfLight};
use balayage_render::param::{LobeRatios, PigmentSet, PointValues, VertexParams};
use glam::{Mat4, Vec3};

const SIZE: [u32; 2] = [64, 64];
const STRANDS: usize = 400;
const POINTS: usize = 9;

/// A curtain of hair, 40 rows deep, 10 strands wide.
pub fn curtain() -> Groom {
    let strands = (0..STRANDS).map(|i| {
        let root = Vec3::new(0.1 * (i % 10) as f32, 0.0, -0.05 * (i / 10) as f32);
        (0..POINTS)
            .map(|k| {
                let s = 0.25 * k as f32;
                root + Vec3::new(0.05 * (3.0 * s + i as f32).sin(), -s, 0.0)
            })
            .collect::<Vec<_>>()
    });
    Groom::from_strands(strands.collect::<Vec<_>>(), 0.06, 1.0)
        .unwrap()
        .0
}

fn camera(x: f32) -> Camera {
    Camera {
        world_from_camera: Mat4::from_translation(Vec3::new(x, -1.0, 4.0)),
        fov_y_rad: 0.6,
        crop: None,
    }
}

pub fn renderer(gpu: &Gpu, groom: &Groom) -> Renderer {
    let light = |x: f32, y: f32, z: f32, bandwidth| SrbfLight {
        direction: Vec3::new(x, y, z).normalize(),
        bandwidth,
        radiance: Vec3::ONE,
    };
    let mut renderer = Renderer::new(gpu).unwrap();
    renderer.set_groom(groom, None).unwrap();
    renderer.set_lights(&LightSet {
        lights: vec![light(0.3, 1.0, 1.0, 0.5), light(-1.0, 0.2, 0.4, 0.3)],
        ..Default::default()
    });
    renderer
}

pub fn plain(groom: &Groom) -> Vec<VertexParams> {
    vec![
        PointValues::default().vertex_params(PigmentSet::default(), &LobeRatios::default());
        groom.point_count()
    ]
}

/// The front row's strand 3, and one in the last row, dyed.
fn dye(params: &mut [VertexParams], strand: usize) -> std::ops::Range<u32> {
    let range = strand * POINTS..(strand + 1) * POINTS;
    for point in &mut params[range.clone()] {
        point.sigma_a = [2.0, 0.1, 0.05];
    }
    range.start as u32..range.end as u32
}

pub fn pixels(renderer: &Renderer) -> Vec<[f32; 4]> {
    renderer.picture().unwrap().pixels
}

pub fn frame(renderer: &mut Renderer, x: f32, interactive: bool) -> FrameReport {
    frame_of(renderer, x, interactive, Multiple::default())
}

pub fn frame_of(renderer: &mut Renderer, x: f32, interactive: bool, multiple: Multiple) -> FrameReport {
    let settings = RenderSettings {
        interactive,
        shade: ShadeSettings {
            multiple,
            ..Default::default()
        },
        ..Default::default()
    };
    renderer.render(&camera(x), SIZE, &settings).unwrap()
}

#[test]
fn hidden_hair_is_not_shaded_and_other_views_are_as_if_drawn_first() {
    let gpu = Gpu::headless().unwrap();
    let groom = curtain();
    let mut moved = renderer(&gpu, &groom);
    moved.set_params(&plain(&groom), &[]).unwrap();
    let first = frame(&mut moved, 0.4, false);
    let shaded = first.counter("vertices shaded") as usize;
    let all = RefinedGroom::new(&groom, DEFAULT_MAX_TURN_RAD).positions().len();
    assert!(
        shaded > 0 && shaded < all / 2,
        "{shaded} of {all} vertices of a deep curtain are seen"
    );
    let second = frame(&mut moved, 1.2, false);
    assert!(second.counter("vertices shaded") > 0);
    assert!(
        second.counter("visibility rays") < first.counter("visibility rays"),
        "records that are there are kept"
    );

    let mut fresh = renderer(&gpu, &groom);
    fresh.set_params(&plain(&groom), &[]).unwrap();
    frame(&mut fresh, 1.2, false);
    assert_eq!(pixels(&moved), pixels(&fresh));
    assert!(
        pixels(&fresh).iter().any(|p| p[1] > 0.01),
        "the picture is not dark"
    );
}

#[test]
fn painting_shades_what_was_painted_and_ends_as_if_loaded() {
    let gpu = Gpu::headless().unwrap();
    let groom = curtain();
    let mut params = plain(&groom);
    let mut painted = renderer(&gpu, &groom);
    painted.set_params(&params, &[]).unwrap();
    let first = frame(&mut painted, 0.4, false);
    let before = pixels(&painted);

    let dirty = dye(&mut params, 3);
    painted.set_params(&params, &[dirty]).unwrap();
    let stroke = frame(&mut painted, 0.4, true);
    let shaded = stroke.counter("vertices shaded");
    assert!(
        shaded > 0 && shaded < first.counter("vertices shaded") / 4,
        "{shaded}"
    );
    assert_eq!(stroke.counter("photon rays"), 0);
    assert_ne!(pixels(&painted), before, "paint is seen at once");

    let resting = frame(&mut painted, 0.4, false);
    assert!(resting.counter("photon rays") > 0);
    assert_eq!(
        resting.counter("path rays") + resting.counter("voxels painted"),
        0
    );
    assert_eq!(resting.counter("visibility rays"), 0);
    assert_eq!(
        resting.counter("vertices shaded"),
        0,
        "single scattering is up to date"
    );
    let idle = frame(&mut painted, 0.4, false);
    assert_eq!(idle.passes, [], "nothing is stale");

    let mut loaded = renderer(&gpu, &groom);
    loaded.set_params(&params, &[]).unwrap();
    frame(&mut loaded, 0.4, false);
    assert_eq!(pixels(&painted), pixels(&loaded));
}
