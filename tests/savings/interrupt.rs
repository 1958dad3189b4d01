//! Pictures that nobody waits for are given up, and what was done of them is not done again.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use balayage_render::gpu::GpuError;

use super::*;

/// Points of the groom, so many that shading looks at the flag several times.
const LEAST_VERTICES: u64 = 10_000;

fn thick_hair(gpu: &Gpu) -> Scene {
    let strands = (0..1000).map(|i| {
        let root = Vec3::new(0.04 * (i % 40) as f32, 0.0, -0.04 * (i / 40) as f32);
        (0..12)
            .map(|k| root + Vec3::new(0.0, -0.1 * k as f32, 0.02 * (k * k) as f32))
            .collect::<Vec<_>>()
    });
    let (groom, _) = Groom::from_strands(strands.collect::<Vec<_>>(), 0.02, 1.0).unwrap();
    Scene::new(gpu, groom, &lights(12))
}

#[test]
fn a_picture_that_was_given_up_is_finished_later_and_is_the_same() {
    let gpu = Gpu::headless().unwrap();
    // All vertices: those that are hidden would make the groom smaller than it is.
    let settings = RenderSettings {
        savings: Savings::ALL.without(Saving::Unseen).without(Saving::Straight),
        visibility_rays: 4,
        ..RenderSettings::default()
    };
    let mut scene = thick_hair(&gpu);
    let whole = scene.frame(&settings);
    assert!(whole.counter("vertices shaded") > LEAST_VERTICES);
    let wanted = scene.renderer.picture().unwrap();

    let mut scene = thick_hair(&gpu);
    let stop = Arc::new(AtomicBool::new(true));
    scene.renderer.set_interrupt(Some(stop.clone()));
    let given_up = |scene: &mut Scene| {
        let drawn = scene.renderer.render(&scene.camera, SIZE, &settings);
        matches!(drawn, Err(GpuError::Interrupted))
    };
    assert!(given_up(&mut scene), "the flag is up before it begins");

    // From time to time the hand moves: the rays are traced in one go, and what was shaded stays.
    let mut times = 0;
    loop {
        stop.store(false, Ordering::Relaxed);
        let flag = stop.clone();
        let hand = thread::spawn(move || {
            thread::sleep(Duration::from_millis(40 << times));
            flag.store(true, Ordering::Relaxed);
        });
        let was_given_up = given_up(&mut scene);
        hand.join().unwrap();
        if !was_given_up {
            break;
        }
        times += 1;
        assert!(times < 12, "it never ends");
    }
    let got = scene.renderer.picture().unwrap();
    assert!(
        got.pixels == wanted.pixels,
        "{times} times: {}",
        rmse(&got, &wanted)
    );

    // Better visibility is in the picture, and was when it was finished.
    let coarse = thick_hair(&gpu).picture(&RenderSettings {
        visibility_rays: 0,
        ..settings
    });
    assert!(rmse(&coarse, &wanted) > 1e-3);
    assert_eq!(scene.frame(&settings).counter("vertices shaded"), 0);
}
