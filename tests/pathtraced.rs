//! Pictures held against a path tracer's, tile by tile.

use balayage_render::gpu::{Camera, CameraFile, Gpu, RenderSettings, Renderer, ShadeSettings, Terms};
use balayage_render::groom::read_groom;
use balayage_render::image::Picture;
use balayage_render::light::LightSet;
use balayage_render::param::VertexParams;
use balayage_tests::test_data;

/// Side of the tiles that pictures are compared in, pixels.
const TILE: usize = 16;

/// What the reference pictures were traced with (bandwidths 8, 6, 12 degrees).
fn reference_params(sigma_a: [f32; 3]) -> VertexParams {
    VertexParams {
        sigma_a,
        alpha_rad: (-5f32).to_radians(),
        beta_rad: 8f32.to_radians() / std::f32::consts::SQRT_2,
        azimuthal_width: 0.2,
        eta: 1.55,
        eccentricity: 1.0,
        alpha_ratios: [-0.5, -1.5],
        beta_ratios: [0.75, 1.5],
    }
}

/// Ratio of mean radiance per channel, and relative RMSE of tile means.
fn compare(got: &Picture, reference: &Picture) -> ([f64; 3], f64) {
    let difference = got.difference(reference, TILE);
    (difference.ratio, difference.tile_rmse)
}

/// Most that mean radiance may be off in a channel, and tiles.
type Limits = (f64, f64);

fn agrees((ratio, rmse): ([f64; 3], f64), (most_off, most_rmse): Limits) -> bool {
    ratio.iter().all(|r| (r - 1.0).abs() <= most_off) && rmse <= most_rmse
}

/// The negative control: ten tolerances too bright.
fn brighter(picture: &Picture) -> Picture {
    let pixels = picture.pixels.iter().map(|p| p.map(|c| 2.0 * c)).collect();
    Picture { pixels, ..*picture }
}

fn read_json<T: serde::de::DeserializeOwned>(path: &std::path::Path) -> T {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

#[test]
fn brown_hair_under_sun_and_sky() {
    let Some(groom) = test_data("../reference/pathtraced/groom.hair") else {
        return;
    };
    let folder = groom.parent().unwrap();
    let groom = read_groom(&groom, None).unwrap().groom;
    let lights: LightSet = read_json(&folder.join("lights_sunsky.json"));
    let camera = Camera::try_from(read_json::<CameraFile>(&folder.join("camera.json"))).unwrap();
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(&gpu).unwrap();
    renderer.set_groom(&groom, None).unwrap();
    renderer
        .set_params(&vec![reference_params([0.5, 0.8, 1.4]); groom.point_count()], &[])
        .unwrap();
    renderer.set_lights(&lights);
    // A first frame has its shadows from voxels, a refined one from exact rays.
    let first = [
        (0, Terms::SINGLE, "single", (0.03, 0.09)),
        (0, Terms::ALL, "multiple", (0.05, 0.09)),
    ];
    let refined = [
        (64, Terms::SINGLE, "single", (0.03, 0.08)),
        (64, Terms::ALL, "multiple", (0.05, 0.08)),
    ];
    for (visibility_rays, terms, file, limits) in [first, refined].concat() {
        let settings = RenderSettings {
            shade: ShadeSettings {
                terms,
                ..Default::default()
            },
            visibility_rays,
            ..Default::default()
        };
        renderer.render(&camera, [256, 256], &settings).unwrap();
        let picture = renderer.picture().unwrap();
        let reference = Picture::read_exr(&folder.join(format!("brown_sunsky_{file}.exr"))).unwrap();
        let (ratio, rmse) = compare(&picture, &reference);
        eprintln!(
            "{file}, {visibility_rays} rays: mean ratio {ratio:.3?}, tile RMSE {:.1} %",
            100.0 * rmse
        );
        assert_eq!(renderer.non_finite().unwrap(), 0);
        assert!(
            agrees((ratio, rmse), limits),
            "{file}: mean ratio {ratio:?}, tile RMSE {rmse}"
        );
        assert!(
            !agrees(compare(&brighter(&reference), &reference), limits),
            "the comparison accepts a wrong picture"
        );
    }
}
