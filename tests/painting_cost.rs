//! What painting costs: only what a dab touches is composited, sent and shaded; the history keeps to its limit.

use balayage::{
    document::{Blend, Edit, LEAST_HISTORY_BYTES, Layer},
    paint::{Mode, Operation, OperationId, StrokeValue},
};
use balayage_render::{
    gpu::{Camera, Gpu, RenderSettings, Renderer},
    groom::{DEFAULT_MAX_TURN_RAD, RefinedGroom},
    light::{LightSet, SrbfLight},
    param::{Channel, VertexParams},
};
use glam::Vec3;

use crate::painting::{bits, dab_at, document, document_with, operation, replayed};

/// Counted from the dab to the picture: what was not touched is neither composited nor sent nor shaded again.
#[test]
fn only_what_a_dab_touches_is_computed_again() {
    let mut document = document();
    let groom = document.groom().clone();
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(&gpu).unwrap();
    renderer.set_groom(&groom, None).unwrap();
    renderer.set_lights(&LightSet {
        lights: vec![SrbfLight {
            direction: Vec3::Y,
            bandwidth: 0.5,
            radiance: Vec3::ONE,
        }],
        ..Default::default()
    });
    renderer.set_params(document.params(), &[]).unwrap();
    let camera = Camera::framing(groom.bounds(), 1.0);
    let settings = RenderSettings {
        interactive: true,
        ..RenderSettings::default()
    };
    let frame = |renderer: &mut Renderer| renderer.render(&camera, [96, 96], &settings).unwrap();
    let first = frame(&mut renderer);
    let whole = (groom.point_count() * size_of::<VertexParams>()) as u64;
    assert_eq!(first.counter("parameter bytes uploaded"), whole);

    let empty = operation(Channel::Dye, Mode::Add, StrokeValue::Scalar(1.0), Vec::new());
    document.begin_stroke(empty).unwrap();
    let refined = RefinedGroom::new(&groom, DEFAULT_MAX_TURN_RAD);
    let mut shaded = 0;
    for strand in [30, 190, 210, 390] {
        let before = document.paint_work();
        let dirty = document.extend_stroke(vec![dab_at(&groom, strand, 6)]).unwrap();
        let work = document.paint_work();
        renderer.set_params(document.params(), dirty.ranges()).unwrap();
        let report = frame(&mut renderer);

        // The brush looks at a neighbourhood; from there on nothing but touched points counts.
        let (blended, composed) = (work.blended - before.blended, work.composed - before.composed);
        assert!(work.measured - before.measured < groom.point_count() as u64);
        assert_eq!(composed, blended);
        assert_eq!(work.changed - before.changed, dirty.point_count() as u64);
        assert!(dirty.point_count() > 0 && dirty.point_count() as u64 <= blended);
        assert!(blended < groom.point_count() as u64 / 4, "{blended}");
        assert_eq!(
            report.counter("parameter bytes uploaded"),
            (dirty.point_count() * size_of::<VertexParams>()) as u64
        );
        let is_dirty = |point: u32| dirty.ranges().iter().any(|range| range.contains(&point));
        let beside = refined.source_point().iter();
        let beside = beside
            .filter(|point| is_dirty(**point) || is_dirty(**point + 1))
            .count();
        assert!(report.counter("vertices shaded") <= beside as u64);
        shaded += report.counter("vertices shaded");
    }
    document.commit_stroke();
    assert!(shaded > 0, "some of it is seen");
    let at_rest = frame(&mut renderer);
    assert_eq!(
        at_rest.counter("vertices shaded") + at_rest.counter("parameter bytes uploaded"),
        0
    );
}

/// Whatever is done and undone, the history takes no more than its limit, and what is left of it can be undone bit for bit.
#[test]
fn the_history_keeps_to_its_limit() {
    let mut document = document();
    let groom = document.groom().clone();
    let stroke = |id: u64| {
        let dabs = (0..40)
            .map(|i| dab_at(&groom, ((7 * id + i) % 400) as usize, 5))
            .collect();
        Operation {
            id: OperationId::Number(id),
            radius_m: 0.01,
            ..operation(Channel::Dye, Mode::Add, StrokeValue::Scalar(0.01), dabs)
        }
    };
    let mut states = Vec::new();
    for limit in [8 << 20, 3 << 20, 0] {
        document.set_history_bytes(limit);
        let most = limit.max(LEAST_HISTORY_BYTES);
        for round in 0..40 {
            let id = document.next_operation_number();
            document.apply(Edit::Stroke(stroke(id))).unwrap();
            // Steps that hold operations: a layer with many that is removed, and merged ones.
            if round % 10 == 9 {
                let copy = format!("copy-{limit}-{round}");
                document
                    .apply(Edit::DuplicateLayer("paint".into(), copy.clone()))
                    .unwrap();
                document.apply(Edit::RemoveLayer(copy)).unwrap();
            }
            assert!(
                document.history_bytes() <= most,
                "{} of {most}",
                document.history_bytes()
            );
            states.push((bits(document.params()), document.history_labels().1));
        }
    }
    let is_modified = document.is_modified();
    let mut undone = 0;
    while document.undo().is_some() {
        undone += 1;
        assert!(document.history_bytes() <= LEAST_HISTORY_BYTES);
        if undone % 8 == 0 {
            assert!(bits(document.params()) == bits(replayed(&document).params()));
        }
    }
    assert!(undone > 5, "{undone}");
    assert!(
        document.project().operations.len() > 20,
        "the oldest steps are forgotten"
    );
    assert!(
        is_modified && document.is_modified(),
        "what is forgotten is not saved"
    );
    while document.redo().is_some() {}
    assert!(document.history_bytes() <= LEAST_HISTORY_BYTES);
    assert!(bits(document.params()) == bits(replayed(&document).params()));
}

#[test]
fn each_channel_of_a_layer_has_its_blend() {
    let values = |channel_blends: &[(Channel, Blend)]| {
        let layer = Layer {
            blend: Blend::Add,
            channel_blends: channel_blends.iter().copied().collect(),
            ..Layer::new("paint", "Paint")
        };
        let mut document = document_with(vec![layer]);
        let dab = dab_at(document.groom(), 210, 6);
        for (channel, value) in [(Channel::Eumelanin, 2.0), (Channel::Pheomelanin, 2.0)] {
            let stroke = operation(
                channel,
                Mode::Replace,
                StrokeValue::Scalar(value),
                vec![dab.clone()],
            );
            let stroke = Operation {
                strength: 1.0,
                ..stroke
            };
            document.apply(Edit::Stroke(stroke)).unwrap();
        }
        let text = balayage::document::json::to_text(document.project()).unwrap();
        assert_eq!(
            balayage::document::Project::parse(&text).unwrap(),
            *document.project()
        );
        assert!(bits(document.params()) == bits(replayed(&document).params()));
        let values = document.values()[210 * 12 + 6];
        [values.eumelanin, values.pheomelanin]
    };
    // The unpainted hair has 1.3 and 0.2.
    assert_eq!(values(&[]), [1.3 + 2.0, 0.2 + 2.0]);
    assert_eq!(values(&[(Channel::Eumelanin, Blend::Replace)]), [2.0, 0.2 + 2.0]);
    assert_eq!(
        values(&[(Channel::Pheomelanin, Blend::Multiply)]),
        [1.3 + 2.0, 0.2 * 2.0]
    );
}
