//! Fits that are told of and stopped: how often they ask.

use std::cell::{Cell, RefCell};
use std::ops::ControlFlow;

use balayage_render::light::{
    EnvironmentMap, FitError, FitSettings, HairKernel, HairProbe, fit, fit_counted, fit_lights,
};
use glam::Vec3;

use super::{GO_ON, sample};

#[test]
fn progress_rises_and_cancels() {
    let map = sample("city");
    let settings = FitSettings {
        count: 10,
        ..FitSettings::default()
    };
    let seen = RefCell::new(Vec::new());
    let record = |done| {
        seen.borrow_mut().push(done);
        ControlFlow::Continue(())
    };
    fit(&map, &settings, &record).unwrap();
    let calls = seen.borrow().len();
    assert!(
        calls > 60
            && seen.borrow().is_sorted()
            && seen.borrow().iter().all(|done| (0.0..=1.0).contains(done))
    );

    // Wherever it is cancelled, it stops there.
    for stop in [1, 2, calls / 4, calls - 1] {
        let count = RefCell::new(0);
        let cancel = |_| {
            *count.borrow_mut() += 1;
            if *count.borrow() == stop {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        assert_eq!(fit(&map, &settings, &cancel), Err(FitError::Cancelled));
        assert_eq!(*count.borrow(), stop);
    }
}

#[test]
fn no_long_work_lies_between_two_calls_of_progress() {
    let map = sample("city");
    let cold = FitSettings {
        count: 10,
        ..FitSettings::default()
    };
    let old = fit_lights(&map, &cold, GO_ON).unwrap();
    let warm = FitSettings {
        from: Some(&old),
        ..cold
    };
    for settings in [cold, warm] {
        let calls = calls_of(|count| {
            let (_, work) = fit_counted(&map, &settings, count).unwrap();
            assert!(work.evaluations > 10, "{work:?}");
            work.evaluations + work.derivatives + work.births
        });
        // Every costly part has a call of its own; the first evaluation comes before any step.
        assert!(calls.work <= calls.count + 1, "{calls:?}");
    }
}

/// A map of 2048 x 1024 pixels: a piece of work visits at most 2^20 of its pixels, for one fibre, light or sum.
#[test]
fn large_maps_are_summed_in_pieces() {
    const VISITS: usize = 1 << 20;
    let (map, _) = EnvironmentMap::from_fn(2048, 1024, |w| Vec3::new(1.1 + w.y, 1.0, 1.1 - w.x));
    let pixels = map.pixels.len();

    // The cells are summed twice, coarse and fine; one light asks least in between.
    let settings = FitSettings {
        count: 1,
        ..FitSettings::default()
    };
    let calls = calls_of(|count| {
        let (_, work) = fit_counted(&map, &settings, count).unwrap();
        work.evaluations + work.derivatives + work.births
    });
    assert!(calls.count >= calls.work - 1 + 2 * pixels / VISITS, "{calls:?}");

    // The probe averages the map down to 1024 x 512 and sums that for every fibre, once for the map and once for the lights.
    let kernel = HairKernel {
        fibres: 12,
        ..HairKernel::default()
    };
    let mut probe = None;
    let calls = calls_of(|count| {
        probe = HairProbe::with_progress(&map, kernel, count);
        pixels + 12 * pixels / 4
    });
    assert!(calls.count >= calls.work / VISITS, "{calls:?}");
    let probe = probe.unwrap();
    let lights = fit_lights(&map, &settings, GO_ON).unwrap();
    let calls = calls_of(|count| {
        assert!(probe.error_with_progress(&lights, count).is_some());
        12 * pixels / 4
    });
    assert!(calls.count >= calls.work / VISITS, "{calls:?}");
}

/// How often something asked whether to go on, and how much it did.
#[derive(Debug)]
struct Calls {
    count: usize,
    work: usize,
}

fn calls_of(work: impl FnOnce(&dyn Fn(f64) -> ControlFlow<()>) -> usize) -> Calls {
    let calls = Cell::new(0);
    let count = |_| {
        calls.set(calls.get() + 1);
        ControlFlow::Continue(())
    };
    let work = work(&count);
    Calls {
        count: calls.get(),
        work,
    }
}
