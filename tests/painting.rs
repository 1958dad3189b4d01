//! The laws of painting: incremental equals replay, undo is exact, a stroke does not depend on how it was drawn.

use std::{path::PathBuf, sync::Arc};

use balayage::{
    document::{Blend, Document, Edit, GroomReference, HairSettings, Layer, Project},
    paint::{
        Dab, DirtyRanges, Extra, Falloff, Mode, Nearest, Operation, OperationId, Reach, StrandIndex,
        StrokeFile, StrokeValue,
    },
};
use balayage_render::{
    groom::Groom,
    param::{Channel, PointValues, VertexParams},
};
use glam::Vec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A tuft of 400 wavy strands with 12 points each on a 20 cm square, in centimetres.
pub fn tuft() -> Arc<Groom> {
    let strands = (0..400).map(|s| {
        let root = Vec3::new((s % 20) as f32, 0.0, (s / 20) as f32);
        (0..12)
            .map(|i| {
                let t = i as f32;
                root + Vec3::new((0.9 * t + s as f32).sin() * 0.3, 1.1 * t, (0.7 * t).cos() * 0.3)
            })
            .collect::<Vec<_>>()
    });
    Arc::new(Groom::from_strands(strands, 0.008, 0.01).unwrap().0)
}

pub fn document_with(layers: Vec<Layer>) -> Document {
    let mut project = Project::new(GroomReference {
        path: "tuft.hair".into(),
        ..Default::default()
    });
    project.layers = layers;
    Document::new(tuft(), project, PathBuf::new()).unwrap()
}

pub fn document() -> Document {
    document_with(vec![Layer::new("paint", "Paint"), Layer::new("top", "Top")])
}

pub fn dab_at(groom: &Groom, strand: usize, point: usize) -> Dab {
    let range = groom.strand(strand);
    Dab {
        root: groom.positions()[range.start].into(),
        arc: groom.arc()[range.start + point],
        position: groom.positions()[range.start + point].into(),
        pressure: 1.0,
        extra: Extra::new(),
    }
}

pub fn operation(channel: Channel, mode: Mode, value: StrokeValue, dabs: Vec<Dab>) -> Operation {
    Operation {
        id: OperationId::Number(1),
        layer: "paint".into(),
        channel,
        mode,
        value,
        radius_m: 0.03,
        strength: 0.8,
        hardness: 0.3,
        falloff: Falloff::Smooth,
        reach: Reach::Surface,
        nearest: Nearest::Point,
        arc_reach: None,
        arc_range: None,
        shape: None,
        hidden: false,
        flow: 1.0,
        across: 0.0,
        seed: 0,
        dabs,
        extra: Extra::new(),
    }
}

fn random_operation(rng: &mut Pcg64Mcg, groom: &Groom, id: u64) -> Operation {
    let channel = Channel::ALL[rng.random_range(0..9)];
    let mode = [
        Mode::Replace,
        Mode::Add,
        Mode::Subtract,
        Mode::Multiply,
        Mode::Erase,
        Mode::Smooth,
    ][rng.random_range(0..6)];
    let (low, high) = channel.range().into_inner();
    let x = low + (high - low) * rng.random_range(0.0..0.3f32);
    let value = if channel == Channel::Dye {
        StrokeValue::Rgb([x, 0.5 * x, 0.25 * x])
    } else {
        StrokeValue::Scalar(x)
    };
    let dabs = (0..rng.random_range(1..12))
        .map(|_| Dab {
            pressure: rng.random_range(0.2..1.0),
            ..dab_at(groom, rng.random_range(0..400), rng.random_range(0..12))
        })
        .collect();
    Operation {
        id: OperationId::Number(id),
        layer: if rng.random_bool(0.5) { "paint" } else { "top" }.into(),
        radius_m: rng.random_range(0.005..0.06),
        strength: rng.random_range(0.1..1.0),
        hardness: rng.random_range(0.0..1.0),
        falloff: [Falloff::Smooth, Falloff::Linear, Falloff::Constant][rng.random_range(0..3)],
        reach: [Reach::Surface, Reach::Through, Reach::Strand][rng.random_range(0..3)],
        nearest: [Nearest::Point, Nearest::Place][rng.random_range(0..2)],
        arc_reach: rng.random_bool(0.5).then(|| rng.random_range(0.05..1.0)),
        ..operation(channel, mode, value, dabs)
    }
}

pub fn bits(params: &[VertexParams]) -> Vec<u32> {
    bytemuck::cast_slice(params).to_vec()
}

pub fn replayed(document: &Document) -> Document {
    Document::new(
        document.groom().clone(),
        document.project().clone(),
        PathBuf::new(),
    )
    .unwrap()
}

/// Random strokes, layer edits, undo and redo: after each the buffers are those of a replay, bit for bit.
#[test]
fn incremental_painting_equals_replay_bit_for_bit() {
    let mut document = document();
    let groom = document.groom().clone();
    let mut rng = Pcg64Mcg::seed_from_u64(7);
    for round in 0..60 {
        match rng.random_range(0..10) {
            0 => drop(document.undo()),
            1 => drop(document.redo()),
            2 => {
                let mut layer = document.project().layers[rng.random_range(0..2)].clone();
                layer.opacity = rng.random_range(0.0..1.0);
                layer.visible = rng.random_bool(0.8);
                layer.blend = [Blend::Replace, Blend::Add, Blend::Multiply][rng.random_range(0..3)];
                document.apply(Edit::SetLayer(layer)).unwrap();
            }
            3 => drop(
                document
                    .apply(Edit::MoveLayer("paint".into(), rng.random_range(0..2)))
                    .unwrap(),
            ),
            _ => {
                // The editor's way: dabs arrive in batches of random size.
                let mut stroke = random_operation(&mut rng, &groom, round);
                let mut dabs = std::mem::take(&mut stroke.dabs);
                document.begin_stroke(stroke).unwrap();
                while !dabs.is_empty() {
                    let rest = dabs.split_off(rng.random_range(1..=dabs.len()));
                    document.extend_stroke(dabs).unwrap();
                    dabs = rest;
                }
                document.commit_stroke();
            }
        }
        let again = replayed(&document);
        assert!(bits(document.params()) == bits(again.params()), "round {round}");
        assert!(document.values() == again.values(), "round {round}");
    }
    assert!(document.project().operations.len() > 20);
}

#[test]
fn undo_and_redo_restore_every_state_bit_for_bit() {
    for history_bytes in [0, 40_000, usize::MAX] {
        let mut document = document();
        document.set_history_bytes(history_bytes);
        let groom = document.groom().clone();
        let mut rng = Pcg64Mcg::seed_from_u64(11);
        let mut states = vec![(bits(document.params()), document.project().clone())];
        for i in 0..25 {
            let edit = match i {
                5 => Edit::SetHair(HairSettings {
                    base: PointValues {
                        eumelanin: 0.1,
                        ..Default::default()
                    }
                    .into(),
                    ..Default::default()
                }),
                9 => Edit::AddLayer(Layer::new("third", "Third"), 1),
                15 => Edit::RemoveLayer("top".into()),
                16 => Edit::AddLayer(Layer::new("top", "Top"), 9),
                _ => Edit::Stroke(random_operation(&mut rng, &groom, i)),
            };
            document.apply(edit).unwrap();
            states.push((bits(document.params()), document.project().clone()));
        }
        let check = |document: &Document, state: usize| {
            assert!(
                bits(document.params()) == states[state].0,
                "state {state}, {history_bytes} bytes"
            );
            assert!(
                *document.project() == states[state].1,
                "state {state}, {history_bytes} bytes"
            );
        };
        for state in (0..25).rev() {
            document.undo().unwrap();
            check(&document, state);
        }
        assert!(document.undo().is_none());
        for state in 1..=25 {
            document.redo().unwrap();
            check(&document, state);
        }
        assert!(document.redo().is_none());
        assert!(
            states.windows(2).filter(|w| w[0].0 != w[1].0).count() > 15,
            "the edits must change something"
        );
    }
}

#[test]
fn a_stroke_does_not_depend_on_order_or_repetition_of_its_dabs() {
    for mode in [Mode::Add, Mode::Multiply, Mode::Smooth] {
        let groom = tuft();
        let mut rng = Pcg64Mcg::seed_from_u64(3);
        let dabs: Vec<Dab> = (0..20)
            .map(|i| dab_at(&groom, 20 * i + rng.random_range(0..20), 5))
            .collect();
        let painted = |dabs: Vec<Dab>| {
            let mut document = document();
            // Something uneven to smooth.
            let first = operation(
                Channel::Dye,
                Mode::Add,
                StrokeValue::Scalar(0.7),
                vec![dab_at(&groom, 210, 4)],
            );
            document.apply(Edit::Stroke(first)).unwrap();
            document
                .apply(Edit::Stroke(operation(
                    Channel::Dye,
                    mode,
                    StrokeValue::Scalar(2.0),
                    dabs,
                )))
                .unwrap();
            bits(document.params())
        };
        let forward = painted(dabs.clone());
        let mut shuffled: Vec<Dab> = dabs.iter().rev().cloned().collect();
        shuffled.extend(dabs[3..9].iter().cloned());
        assert!(painted(shuffled) == forward, "{mode:?}");
        assert!(
            painted(dabs[..10].to_vec()) != forward,
            "{mode:?}: the comparison must be able to fail"
        );
    }
}

#[test]
fn dirty_ranges_name_exactly_what_changed() {
    let mut document = document();
    let before = bits(document.params());
    let stroke = operation(
        Channel::Bleach,
        Mode::Replace,
        StrokeValue::Scalar(1.0),
        vec![dab_at(document.groom(), 210, 6)],
    );
    let changes = document.apply(Edit::Stroke(stroke)).unwrap();
    let after = bits(document.params());
    const WORDS: usize = size_of::<VertexParams>() / 4;
    let changed = (0..document.groom().point_count() as u32)
        .filter(|p| (0..WORDS).any(|i| before[*p as usize * WORDS + i] != after[*p as usize * WORDS + i]));
    assert_eq!(changes.points, DirtyRanges::of_points(changed.collect()));
    assert!(changes.points.point_count() > 20 && changes.points.point_count() < 500);
    assert!(!changes.diameter && !changes.light);
}

#[test]
fn modes_and_blends_reach_the_values() {
    let centre = |mode, value, layer: Layer, base: PointValues| {
        let mut document = document_with(vec![layer]);
        document
            .apply(Edit::SetHair(HairSettings {
                base: base.into(),
                ..Default::default()
            }))
            .unwrap();
        let dab = dab_at(document.groom(), 210, 6);
        let stroke = Operation {
            strength: 0.5,
            ..operation(Channel::Eumelanin, mode, StrokeValue::Scalar(value), vec![dab])
        };
        document.apply(Edit::Stroke(stroke)).unwrap();
        document.values()[210 * 12 + 6].eumelanin
    };
    let base = PointValues {
        eumelanin: 2.0,
        ..Default::default()
    };
    let layer = Layer::new("paint", "Paint");
    assert_eq!(centre(Mode::Replace, 4.0, layer.clone(), base), 3.0);
    assert_eq!(centre(Mode::Add, 4.0, layer.clone(), base), 4.0);
    assert_eq!(centre(Mode::Subtract, 1.0, layer.clone(), base), 1.5);
    assert_eq!(
        centre(Mode::Subtract, 50.0, layer.clone(), base),
        0.0,
        "clamped to the range"
    );
    assert_eq!(centre(Mode::Multiply, 3.0, layer.clone(), base), 4.0);
    let half = Layer {
        opacity: 0.5,
        ..layer.clone()
    };
    assert_eq!(centre(Mode::Replace, 4.0, half.clone(), base), 2.5);
    assert_eq!(
        centre(
            Mode::Replace,
            4.0,
            Layer {
                blend: Blend::Add,
                ..half.clone()
            },
            base
        ),
        3.0
    );
    assert_eq!(
        centre(
            Mode::Replace,
            4.0,
            Layer {
                blend: Blend::Multiply,
                ..half
            },
            base
        ),
        2.0 * 1.75
    );
    assert_eq!(
        centre(
            Mode::Replace,
            4.0,
            Layer {
                visible: false,
                ..layer
            },
            base
        ),
        2.0
    );
}

#[test]
fn erasing_restores_the_base_bit_for_bit() {
    let mut document = document();
    let clean = bits(document.params());
    let groom = document.groom().clone();
    let mut rng = Pcg64Mcg::seed_from_u64(5);
    for id in 0..10 {
        let stroke = Operation {
            layer: "paint".into(),
            channel: Channel::BetaDeg,
            ..random_operation(&mut rng, &groom, id)
        };
        let stroke = Operation {
            mode: Mode::Replace,
            value: StrokeValue::Scalar(20.0),
            ..stroke
        };
        document.apply(Edit::Stroke(stroke)).unwrap();
    }
    assert!(bits(document.params()) != clean);
    let all = Operation {
        radius_m: 10.0,
        strength: 1.0,
        hardness: 1.0,
        ..operation(
            Channel::BetaDeg,
            Mode::Erase,
            StrokeValue::default(),
            vec![dab_at(&groom, 0, 0)],
        )
    };
    document.apply(Edit::Stroke(all)).unwrap();
    assert!(bits(document.params()) == clean);
}

#[test]
fn smoothing_brings_neighbours_on_a_strand_together() {
    let mut document = document();
    let groom = document.groom().clone();
    let dab = dab_at(&groom, 210, 6);
    let spot = Operation {
        radius_m: 0.005,
        ..operation(
            Channel::Dye,
            Mode::Replace,
            StrokeValue::Scalar(4.0),
            vec![dab.clone()],
        )
    };
    document.apply(Edit::Stroke(spot)).unwrap();
    let spread = |document: &Document| {
        let dye: Vec<f32> = groom.strand(210).map(|p| document.values()[p].dye[0]).collect();
        dye.windows(2).map(|w| (w[0] - w[1]).abs()).sum::<f32>()
    };
    let rough = spread(&document);
    document
        .apply(Edit::Stroke(operation(
            Channel::Dye,
            Mode::Smooth,
            StrokeValue::default(),
            vec![dab],
        )))
        .unwrap();
    assert!(
        spread(&document) < 0.6 * rough,
        "{} of {rough}",
        spread(&document)
    );
}

#[test]
fn reach_strand_paints_along_whole_strands_and_within_its_arcs() {
    let groom = tuft();
    let painted = |reach, arc_reach| {
        let mut document = document();
        let stroke = operation(
            Channel::Bleach,
            Mode::Replace,
            StrokeValue::Scalar(1.0),
            vec![dab_at(&groom, 210, 6)],
        );
        document
            .apply(Edit::Stroke(Operation {
                reach,
                arc_reach,
                radius_m: 0.015,
                ..stroke
            }))
            .unwrap();
        let values = document.values();
        (0..400)
            .map(|s| groom.strand(s).filter(|p| values[*p].bleach > 0.0).count())
            .collect::<Vec<_>>()
    };
    let sphere = painted(Reach::Surface, None);
    let whole = painted(Reach::Strand, None);
    let part = painted(Reach::Strand, Some(0.3));
    assert!(sphere[210] < 6 && whole[210] == 12);
    assert!(part[210] > sphere[210] && part[210] < 12);
    assert!((0..400).all(|s| (sphere[s] > 0) == (whole[s] > 0) && whole[s] % 12 == 0));
}

/// The grid finds what a walk over all points finds.
#[test]
fn the_strand_index_finds_every_point_near_a_place() {
    let groom = tuft();
    let index = StrandIndex::new(groom.clone());
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    for _ in 0..200 {
        let centre = Vec3::from_array(std::array::from_fn(|_| rng.random_range(-10.0..30.0)));
        let radius = rng.random_range(0.01..15.0);
        let mut found = Vec::new();
        index.for_each_near(centre, radius, |p, d| {
            assert_eq!(d, groom.positions()[p as usize].distance(centre));
            found.push(p);
        });
        found.sort_unstable();
        let expected: Vec<u32> = (0..groom.point_count() as u32)
            .filter(|p| groom.positions()[*p as usize].distance(centre) < radius)
            .collect();
        assert_eq!(found, expected);
    }
    index.for_each_near(Vec3::splat(1e30), 1.0, |_, _| panic!("nothing is there"));
}

/// Every number of a stroke, poisoned: refused with its place, and the document is as before.
#[test]
fn poison_in_a_stroke_is_refused() {
    let mut document = document();
    let good = operation(
        Channel::Dye,
        Mode::Replace,
        StrokeValue::Rgb([1.0; 3]),
        vec![dab_at(document.groom(), 3, 3)],
    );
    let before = bits(document.params());
    for poison in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e38, -1e38, -1e-3] {
        type Field<'a> = (&'a str, &'a dyn Fn(&mut Operation));
        let fields: [Field; 7] = [
            ("radius_m", &|o| o.radius_m = poison),
            ("strength", &|o| o.strength = poison),
            ("hardness", &|o| o.hardness = poison),
            ("arc_reach", &|o| o.arc_reach = Some(poison)),
            ("value", &|o| o.value = StrokeValue::Rgb([0.0, poison, 0.0])),
            ("dabs[0].arc", &|o| o.dabs[0].arc = poison),
            ("dabs[0].pressure", &|o| o.dabs[0].pressure = poison),
        ];
        for (place, poisoned) in fields {
            let mut bad = good.clone();
            poisoned(&mut bad);
            let problem = document.apply(Edit::Stroke(bad)).unwrap_err();
            assert_eq!(problem.place, place, "{poison}: {problem}");
        }
        if poison.abs() > 1.0 || poison.is_nan() {
            let mut bad = good.clone();
            bad.dabs[0].position[1] = poison;
            assert_eq!(
                document.apply(Edit::Stroke(bad)).unwrap_err().place,
                "dabs[0].position"
            );
            let mut hair = document.project().hair.clone();
            hair.base.known.eta = poison;
            assert_eq!(
                document.apply(Edit::SetHair(hair)).unwrap_err().place,
                "hair.base.eta"
            );
            let mut light = document.project().light.clone();
            light.exposure_ev = poison;
            assert_eq!(
                document.apply(Edit::SetLight(light)).unwrap_err().place,
                "light.exposure_ev"
            );
        }
    }
    let unknown = Operation {
        layer: "nowhere".into(),
        ..good
    };
    assert_eq!(document.apply(Edit::Stroke(unknown)).unwrap_err().place, "layer");
    assert!(bits(document.params()) == before && document.undo_label().is_none() && !document.is_modified());
}

#[test]
fn values_stay_finite_and_in_range_under_extreme_strokes() {
    let mut document = document();
    let groom = document.groom().clone();
    for channel in Channel::ALL {
        let (low, high) = channel.range().into_inner();
        for (mode, value) in [
            (Mode::Add, high - low),
            (Mode::Multiply, 1000.0),
            (Mode::Subtract, high - low),
            (Mode::Replace, low),
        ] {
            for _ in 0..20 {
                let stroke = Operation {
                    strength: 1.0,
                    ..operation(
                        channel,
                        mode,
                        StrokeValue::Scalar(value),
                        vec![dab_at(&groom, 7, 7)],
                    )
                };
                document.apply(Edit::Stroke(stroke)).unwrap();
                assert!(
                    document.values().iter().all(|v| v.out_of_range().is_none()),
                    "{channel:?} {mode:?}"
                );
            }
        }
    }
    assert!(document.params().iter().all(|p| {
        bytemuck::cast_slice::<_, f32>(&[*p])
            .iter()
            .all(|x| x.is_finite())
    }));
}

#[test]
fn a_slider_drag_is_one_entry_and_a_cancelled_stroke_none() {
    let mut document = document();
    let clean = bits(document.params());
    let hair = |eumelanin| {
        Edit::SetHair(HairSettings {
            base: PointValues {
                eumelanin,
                ..Default::default()
            }
            .into(),
            ..Default::default()
        })
    };
    document.apply(hair(0.1)).unwrap();
    for step in 2..9 {
        document.apply_continuing(hair(0.1 * step as f32)).unwrap();
    }
    assert_eq!(document.undo().unwrap().0, "Change hair");
    assert!(document.undo().is_none() && bits(document.params()) == clean);

    let dab = dab_at(document.groom(), 100, 5);
    document
        .begin_stroke(operation(
            Channel::Dye,
            Mode::Add,
            StrokeValue::Scalar(1.0),
            Vec::new(),
        ))
        .unwrap();
    assert!(!document.extend_stroke(vec![dab]).unwrap().is_empty());
    assert!(bits(document.params()) != clean);
    assert!(!document.cancel_stroke().is_empty());
    assert!(bits(document.params()) == clean && document.undo_label().is_none());
    assert!(document.project().operations.is_empty());
}

/// The text of the contract is what is read and written.
#[test]
fn stroke_files_follow_the_contract() {
    let text = r#"{"version": 1, "groom": null, "operations": [{"id": "a", "layer": "paint", "channel": "dye", "mode": "replace",
        "value": [0.1, 0.9, 2.5], "radius_m": 0.02, "strength": 0.5, "hardness": 0.25, "falloff": "linear", "reach": "through",
        "seed": 3, "note": "kept", "dabs": [{"root": [1, 2, 3], "arc": 0.5, "position": [4, 5, 6], "pressure": 0.75}]}]}"#;
    let file = StrokeFile::parse(text).unwrap();
    let operation = &file.operations[0];
    assert_eq!(
        (operation.channel, operation.mode, operation.reach),
        (Channel::Dye, Mode::Replace, Reach::Through)
    );
    assert_eq!(operation.value, StrokeValue::Rgb([0.1, 0.9, 2.5]));
    assert_eq!(operation.dabs[0].position, [4.0, 5.0, 6.0]);
    assert_eq!(operation.extra["note"], "kept");
    let again = balayage::document::json::to_text(&file).unwrap();
    assert_eq!(StrokeFile::parse(&again).unwrap(), file);

    for (bad, place) in [
        (text.replace("\"version\": 1", "\"version\": 3"), "version"),
        (text.replace("0.02", "-0.02"), "operations[0].radius_m"),
        (text.replace("0.75", "1.5"), "operations[0].dabs[0].pressure"),
        (text.replace("0.75", "1e39"), "line 3, column 115"),
        (text.replace("linear", "wobbly"), "line 2, column 106"),
        (text[..text.len() - 9].to_owned(), "line 3, column 111"),
    ] {
        let problem = StrokeFile::parse(&bad).unwrap_err();
        assert!(
            problem.place == place && !problem.reason.is_empty() && !problem.remedy.is_empty(),
            "{problem}"
        );
    }
}
