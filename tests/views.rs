//! Pictures of parts, of many sizes and of what lies behind the light: tiles, zoom, false colours.

use balayage_render::gpu::{Camera, DebugView, Gpu, GpuError, RenderSettings, Renderer};
use balayage_render::light::{EnvironmentMap, LightSet, SrbfLight};
use glam::{Mat4, Vec3};

use crate::cli::balayage;
use crate::frame::{curtain, plain, renderer};

const SIZE: [u32; 2] = [70, 52];

fn camera(fov_y_rad: f32) -> Camera {
    Camera {
        world_from_camera: Mat4::from_translation(Vec3::new(0.45, -1.0, 4.0)),
        fov_y_rad,
        crop: None,
    }
}

/// The curtain with its paint in front of a map that is no one colour.
fn scene(gpu: &Gpu) -> Renderer {
    let groom = curtain();
    let mut renderer = renderer(gpu, &groom);
    renderer.set_params(&plain(&groom), &[]).unwrap();
    let map = EnvironmentMap::from_fn(64, 32, |w| 0.5 + 0.5 * w).0;
    renderer.set_background(Some(&map)).unwrap();
    renderer
}

fn settings(samples: u32) -> RenderSettings {
    RenderSettings {
        samples,
        show_background: true,
        ..RenderSettings::default()
    }
}

/// The picture put together from tiles of at most so many pixels a side, and their number; each tile moved by `slip` pixels.
fn tiled(renderer: &mut Renderer, most_side: u32, slip: usize) -> (Vec<[f32; 4]>, usize) {
    let width = SIZE[0] as usize;
    let mut whole = vec![[0.0; 4]; width * SIZE[1] as usize];
    let mut tiles = 0;
    renderer
        .render_tiles::<GpuError>(
            &camera(0.6),
            SIZE,
            &settings(3),
            Some(most_side),
            |renderer, tile| {
                tiles += 1;
                let [left, top] = tile.origin.map(|n| n as usize);
                for (row, line) in renderer
                    .picture()?
                    .pixels
                    .chunks_exact(tile.size[0] as usize)
                    .enumerate()
                {
                    for (column, pixel) in line.iter().enumerate() {
                        let at = (top + row) * width + (left + column + slip) % width;
                        whole[at] = *pixel;
                    }
                }
                Ok(())
            },
        )
        .unwrap();
    (whole, tiles)
}

#[test]
fn tiles_join_to_the_whole_picture() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = scene(&gpu);
    renderer.render(&camera(0.6), SIZE, &settings(3)).unwrap();
    let whole = renderer.picture().unwrap().pixels;
    let worst = |tiles: &[[f32; 4]]| {
        let pairs = whole.iter().flatten().zip(tiles.iter().flatten());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    };
    let (one, count) = tiled(&mut renderer, 4096, 0);
    assert!(
        count == 1 && worst(&one) == 0.0,
        "a picture that fits is one tile"
    );
    let (joined, count) = tiled(&mut renderer, 24, 0);
    assert!(count > 4, "{count} tiles");
    // Positions in a tile are other numbers of f32.
    assert!(worst(&joined) < 2e-3, "tiles differ by {}", worst(&joined));
    let (slipped, _) = tiled(&mut renderer, 24, 1);
    assert!(worst(&slipped) > 0.05, "a slip of one pixel is noticed");
}

#[test]
fn light_does_not_jump_while_zooming() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = scene(&gpu);
    let converged = RenderSettings {
        samples: 8,
        ..RenderSettings::default()
    };
    let mut last: Option<f64> = None;
    let mut extent = 0;
    // From hair that fills the picture to a 15th of it, the least that the editor's camera shows, in steps of 4 %.
    let mut slope = 0.26_f32;
    while slope < 15.0 * 0.26 {
        renderer
            .render(&camera(2.0 * slope.atan()), [128, 128], &converged)
            .unwrap();
        let picture = renderer.picture().unwrap();
        extent = picture.pixels.iter().filter(|p| p[3] > 0.01).count();
        // The hair's share of the sky does not change, its share of the picture does.
        let area = f64::from(slope * slope);
        let light: f64 = picture.pixels.iter().map(|p| f64::from(p[1])).sum::<f64>() * area;
        if let Some(last) = last {
            let change: f64 = light / last - 1.0;
            assert!(
                change.abs() < 0.01,
                "at slope {slope} the light changes by {change}"
            );
        }
        last = Some(light);
        slope *= 1.04;
    }
    assert!(extent < 80, "the sweep ends with small hair, {extent} pixels");
}

#[test]
fn false_colours_tell_what_shading_works_with() {
    let gpu = Gpu::headless().unwrap();
    let groom = curtain();
    let mut renderer = scene(&gpu);
    let plain_settings = RenderSettings::default();
    let report = renderer.render(&camera(0.6), SIZE, &plain_settings).unwrap();
    let before = renderer.picture().unwrap().pixels;
    let view = |renderer: &mut Renderer, view| {
        let colours = renderer
            .debug_view(&camera(0.6), SIZE, &plain_settings, view)
            .unwrap();
        assert_eq!(colours.rgba().len(), 4 * colours.values.len());
        assert!(colours.legend().contains("mean"), "{}", colours.legend());
        colours
    };
    let mean = |values: &[Option<f32>]| {
        let seen: Vec<f32> = values.iter().flatten().copied().collect();
        seen.iter().sum::<f32>() / seen.len() as f32
    };

    let overdraw = view(&mut renderer, DebugView::Overdraw);
    // What is hidden behind opaque hair is a fragment that no pixel shows.
    let shown: f32 = overdraw.values.iter().flatten().sum();
    let fragments = report.counter("fragments");
    assert!(
        shown > 0.1 * fragments as f32 && (shown as u64) < fragments,
        "{shown} of {fragments}"
    );
    let seen = view(&mut renderer, DebugView::Transmittance);
    assert!(seen.values.iter().flatten().all(|v| (0.0..=1.001).contains(v)));
    let fibres = view(&mut renderer, DebugView::Fibres);
    let (seen, n) = (mean(&seen.values), mean(&fibres.values));
    assert!(
        seen > 0.05 && seen < 0.95 && n > 0.0,
        "transmittance {seen}, n {n}"
    );
    let density = view(&mut renderer, DebugView::Density);
    assert!(mean(&density.values) > 0.0 && density.range[1] > density.range[0]);

    // Black hair passes less on.
    let brown = mean(&view(&mut renderer, DebugView::Forward).values);
    let mut params = plain(&groom);
    params.iter_mut().for_each(|p| p.sigma_a = [8.0; 3]);
    renderer.set_params(&params, &[]).unwrap();
    let black = mean(&view(&mut renderer, DebugView::Forward).values);
    assert!(black < 0.7 * brown && brown <= 1.0, "a_f {brown} and {black}");

    // Nothing is bad until something is.
    let bad = |renderer: &mut Renderer| {
        let found = view(renderer, DebugView::NonFinite).values;
        found.iter().flatten().filter(|v| **v > 0.0).count()
    };
    assert_eq!(bad(&mut renderer), 0);
    let endless = LightSet {
        lights: vec![SrbfLight {
            direction: Vec3::Z,
            bandwidth: 0.5,
            radiance: Vec3::INFINITY,
        }],
        ..LightSet::default()
    };
    renderer.set_lights(&endless);
    let found = bad(&mut renderer);
    assert!(found > 0 && found < before.len(), "{found} pixels");

    // A look leaves no trace.
    let mut renderer = scene(&gpu);
    view(&mut renderer, DebugView::Density);
    renderer.render(&camera(0.6), SIZE, &plain_settings).unwrap();
    assert_eq!(renderer.picture().unwrap().pixels, before);
}

#[test]
fn the_command_line_draws_false_colours_and_refuses_what_makes_none() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let groom = file("tuft.hair");
    balayage_render::groom::write_groom(&groom, &crate::painting::tuft()).unwrap();
    let (png, exr) = (file("n.png"), file("n.exr"));
    let of = |out: &str, more: &[&str]| {
        let base = [
            "render",
            &groom,
            "-o",
            out,
            "--env",
            "preset:uniform",
            "--size",
            "32x32",
            "--samples",
            "1",
        ];
        balayage(&[&base[..], more].concat())
    };
    let (code, out, err) = of(&png, &["--debug-view", "fibres", "--transmittance", "sh9"]);
    assert!(
        code == 0 && out.contains("dark blue 0.000 to yellow"),
        "{out}{err}"
    );
    for (output, more, reason) in [
        (&exr, &["--debug-view", "fibres"][..], "--debug-view"),
        (&png, &["--debug-view", "colour"], "non-finite"),
        (&png, &["--transmittance", "sh9", "--visibility-rays", "4"], "sh9"),
        (&png, &["--transmittance", "sh9", "--reference-visibility"], "sh9"),
    ] {
        let (code, _, err) = of(output, more);
        assert!(code == 2 && err.contains(reason), "{more:?}: {code} {err}");
    }
    assert!(!std::path::Path::new(&exr).exists());
}
