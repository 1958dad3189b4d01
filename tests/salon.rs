//! Salon operations and masks: replayed, re-editable, the same on a thinner groom; bad ones are refused.

use std::{path::PathBuf, sync::Arc};

use balayage::{
    document::{Document, Edit, GroomReference, LEAST_HISTORY_BYTES, Layer, Project},
    paint::{
        Balayage, Curve, Dab, Extra, Falloff, Gradient, Grey, Mask, MaskKind, MaskPart, Mode, Operation,
        OperationId, Reach, Regrowth, Shape, StrokeFile, StrokeValue, TipFade,
    },
};
use balayage_render::{
    groom::Groom,
    param::{Channel, LobeRatios, PointValues, VertexParams},
};
use balayage_tests::{POISON, damage, random};
use glam::Vec3;
use rand::Rng;

/// Points of a strand of [`head`], and of a thinner one.
const POINTS: usize = 25;
const THIN: usize = 13;

/// 3,600 wavy strands of 12 to 24 cm on half a sphere of 9 cm, metres; every `step`th of them, with `points` points each.
fn head(step: usize, points: usize) -> Arc<Groom> {
    let strands = (0..3600).step_by(step).map(|s| {
        let turn = 2.399_963 * s as f32;
        let height = s as f32 / 3600.0;
        let radius = (1.0 - height * height).sqrt();
        let normal = Vec3::new(radius * turn.cos(), height, radius * turn.sin());
        let length = 0.12 + 0.12 * (0.5 + 0.5 * (7.0 * height).sin());
        let strand = move |i: usize| {
            let t = length * i as f32 / (points - 1) as f32;
            let wave = 0.004 * Vec3::new((40.0 * t).sin(), 0.0, (40.0 * t).cos() - 1.0);
            0.09 * normal + t * (0.3 * normal - 0.95 * Vec3::Y).normalize() + wave
        };
        (0..points).map(strand).collect::<Vec<_>>()
    });
    Arc::new(Groom::from_strands(strands, 0.0005, 1.0).unwrap().0)
}

fn document(groom: Arc<Groom>) -> Document {
    let mut project = Project::new(GroomReference {
        path: "head.hair".into(),
        ..Default::default()
    });
    project.layers.push(Layer::new("top", "Top"));
    Document::new(groom, project, PathBuf::new()).unwrap()
}

fn shaped(id: u64, channel: Channel, value: f32, shape: Shape) -> Operation {
    Operation {
        channel,
        value: StrokeValue::Scalar(value),
        ..Operation::shaped(OperationId::Number(id), "paint", shape, 5)
    }
}

fn bits(document: &Document) -> Vec<u32> {
    let params: &[VertexParams] = document.params();
    bytemuck::cast_slice(params).to_vec()
}

/// What holds after every edit: the buffers are those of a replay, all values are in range.
fn check_invariants(document: &Document) {
    let again = Document::new(
        document.groom().clone(),
        document.project().clone(),
        PathBuf::new(),
    )
    .unwrap();
    assert!(bits(&again) == bits(document), "incremental differs from replay");
    assert!(document.values().iter().all(|v| v.out_of_range().is_none()));
}

fn bleach(document: &Document) -> Vec<f32> {
    document.values().iter().map(|v| v.bleach).collect()
}

fn part(kind: MaskKind) -> MaskPart {
    MaskPart { kind, invert: false }
}

#[test]
fn each_operation_covers_what_its_name_says() {
    let groom = head(4, POINTS);
    let painted = |shape: Shape| {
        let mut document = document(groom.clone());
        let changes = document
            .apply(Edit::Stroke(shaped(1, Channel::Bleach, 1.0, shape)))
            .unwrap();
        assert!(!changes.points.is_empty());
        check_invariants(&document);
        bleach(&document)
    };
    let along_mm = |strand: usize, i: usize| {
        let points = groom.strand(strand);
        let p = &groom.positions()[points.start..=points.start + i];
        1000.0 * p.windows(2).map(|w| w[0].distance(w[1])).sum::<f32>()
    };
    let each = |values: &[f32], check: &dyn Fn(f32, f32, f32)| {
        for strand in 0..groom.strand_count() {
            let length = along_mm(strand, POINTS - 1);
            for i in 0..POINTS {
                check(values[strand * POINTS + i], along_mm(strand, i), length);
            }
        }
    };

    let regrowth = painted(Shape::Regrowth(Regrowth {
        length_mm: 30.0,
        soften_mm: 4.0,
        vary_mm: 0.0,
    }));
    each(&regrowth, &|x, s, _| {
        assert!(
            if s < 27.5 { x == 1.0 } else { s <= 32.5 || x == 0.0 },
            "{x} at {s} mm"
        );
    });

    let ombre = painted(Shape::Gradient(Gradient {
        start_mm: 40.0,
        length_mm: 60.0,
        vary_mm: 0.0,
        curve: Curve::linear(),
    }));
    each(&ombre, &|x, s, _| {
        assert!(
            (x - ((s - 40.0) / 60.0).clamp(0.0, 1.0)).abs() < 1e-3,
            "{x} at {s} mm"
        );
    });

    let tips = painted(Shape::TipFade(TipFade {
        length_mm: 30.0,
        vary_mm: 0.0,
        curve: Curve::linear(),
    }));
    each(&tips, &|x, s, length| {
        assert!((x - (1.0 - (length - s) / 30.0).clamp(0.0, 1.0)).abs() < 1e-3);
    });

    // Grey and balayage take about the share of strands that was asked for, whole strands or sections.
    let share_of_tips = |values: &[f32]| {
        let tips = (0..groom.strand_count()).filter(|s| values[s * POINTS + POINTS - 1] > 0.5);
        tips.count() as f32 / groom.strand_count() as f32
    };
    let grey = |patches| {
        painted(Shape::Grey(Grey {
            share: 0.2,
            patches,
            ..Grey::default()
        }))
    };
    for patches in [0.0, 1.0] {
        let grey = grey(patches);
        assert!(
            (share_of_tips(&grey) - 0.2).abs() < 0.07,
            "{}",
            share_of_tips(&grey)
        );
        assert!(
            grey.chunks(POINTS)
                .all(|strand| strand.iter().all(|x| *x == strand[0]))
        );
    }
    let balayage = painted(Shape::Balayage(Balayage {
        share: 0.5,
        ..Balayage::default()
    }));
    assert!(
        (0.25..0.75).contains(&share_of_tips(&balayage)),
        "{}",
        share_of_tips(&balayage)
    );
    each(&balayage, &|x, s, _| {
        assert!(s > 25.0 || x == 0.0, "the roots stay");
    });
    for shape in Shape::all() {
        painted(shape);
    }
}

#[test]
fn operations_can_be_adjusted_hidden_and_removed_and_undone_bit_for_bit() {
    for limit in [0, usize::MAX] {
        let mut document = document(head(8, POINTS));
        document.set_history_bytes(limit);
        let mut states = vec![(bits(&document), document.project().clone())];
        let note = |document: &Document, states: &mut Vec<_>| {
            check_invariants(document);
            states.push((bits(document), document.project().clone()));
        };
        for (i, shape) in Shape::all().into_iter().enumerate() {
            document
                .apply(Edit::Stroke(shaped(
                    i as u64 + 1,
                    Channel::Bleach,
                    0.1 + 0.1 * i as f32,
                    shape,
                )))
                .unwrap();
            note(&document, &mut states);
        }
        let changed = |document: &Document, index: usize, change: &dyn Fn(&mut Operation)| {
            let mut operation = document.project().operations[index].clone();
            change(&mut operation);
            Edit::SetOperation(index, operation)
        };
        type Change<'a> = (usize, &'a dyn Fn(&mut Operation));
        let edits: [Change<'_>; 4] = [
            (2, &|o| o.strength = 0.4),
            (2, &|o| o.hidden = true),
            (1, &|o| o.channel = Channel::Eumelanin),
            (1, &|o| o.layer = "top".into()),
        ];
        for (index, change) in edits {
            document.apply(changed(&document, index, change)).unwrap();
            note(&document, &mut states);
        }
        document.apply(Edit::RemoveOperation(0)).unwrap();
        note(&document, &mut states);
        document
            .apply(Edit::DuplicateLayer("paint".into(), "copy".into()))
            .unwrap();
        note(&document, &mut states);
        document.apply(Edit::RemoveLayer("paint".into())).unwrap();
        note(&document, &mut states);

        let last = states.len() - 1;
        for state in (0..last).rev() {
            document.undo().unwrap();
            assert!(
                bits(&document) == states[state].0 && *document.project() == states[state].1,
                "{state}"
            );
        }
        assert!(document.undo().is_none());
        for state in &states[1..] {
            document.redo().unwrap();
            assert!(bits(&document) == state.0 && *document.project() == state.1);
        }
        assert!(document.history_bytes() <= limit.max(LEAST_HISTORY_BYTES));
        let different = states.windows(2).filter(|w| w[0].0 != w[1].0).count();
        assert!(different >= 8, "the edits must change something: {different}");
    }
}

#[test]
fn dragging_a_slider_of_an_operation_is_one_entry() {
    let mut document = document(head(8, POINTS));
    let edit = |length_mm, share| {
        let shape = Shape::Regrowth(Regrowth {
            length_mm,
            ..Regrowth::default()
        });
        let mut operation = shaped(1, Channel::Bleach, 1.0, shape);
        operation.strength = share;
        operation
    };
    document.apply(Edit::Stroke(edit(20.0, 1.0))).unwrap();
    document
        .apply(Edit::Stroke(shaped(
            2,
            Channel::Bleach,
            0.3,
            Shape::all()[4].clone(),
        )))
        .unwrap();
    let before = bits(&document);
    for i in 0..10 {
        document
            .apply_continuing(Edit::SetOperation(0, edit(20.0 + 5.0 * i as f32, 0.9)))
            .unwrap();
        check_invariants(&document);
    }
    let (labels, done) = document.history_labels();
    assert_eq!((labels.len(), done, labels[2]), (3, 3, "Change regrowth bleach"));
    document.undo().unwrap();
    assert!(bits(&document) == before);
}

#[test]
fn masks_limit_a_layer_and_follow_every_edit() {
    let groom = head(4, POINTS);
    let mut document = document(groom.clone());
    let fill = shaped(1, Channel::Bleach, 1.0, Shape::all()[6].clone());
    document.apply(Edit::Stroke(fill)).unwrap();
    let mut masked = |mask: Mask| {
        let layer = Layer {
            mask,
            ..document.project().layers[0].clone()
        };
        document.apply(Edit::SetLayer(layer)).unwrap();
        check_invariants(&document);
        bleach(&document)
    };
    let of = |kind| Mask {
        parts: vec![part(kind)],
        invert: false,
    };
    let arc = groom.arc();

    let middle = masked(of(MaskKind::Arc {
        from: 0.25,
        to: 0.75,
        soften: 0.0,
    }));
    assert!(
        middle
            .iter()
            .zip(&arc)
            .all(|(x, a)| (*x == 1.0) == (0.25..=0.75).contains(a))
    );
    let soft = masked(of(MaskKind::Arc {
        from: 0.3,
        to: 1.0,
        soften: 0.4,
    }));
    assert!(soft.iter().any(|x| *x > 0.2 && *x < 0.8) && soft[POINTS - 1] > 0.49);
    let inverted = masked(Mask {
        invert: true,
        ..of(MaskKind::Arc {
            from: 0.25,
            to: 0.75,
            soften: 0.0,
        })
    });
    assert!(inverted.iter().zip(&middle).all(|(a, b)| *a == 1.0 - b));

    let some = masked(of(MaskKind::Strands { share: 0.3, seed: 9 }));
    let share = some.iter().sum::<f32>() / some.len() as f32;
    assert!((share - 0.3).abs() < 0.05, "{share}");
    let outline =
        [(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)].map(|(x, z)| [0.09 * x, 0.078, 0.09 * z]);
    let crown = masked(of(MaskKind::Region {
        outline: outline.to_vec(),
        soften_mm: 0.0,
    }));
    for strand in 0..groom.strand_count() {
        let root = groom.positions()[strand * POINTS];
        let inside = root.x.abs() < 0.045 && root.z.abs() < 0.045;
        let on_rim = (root.x.abs() - 0.045).abs() < 1e-4 || (root.z.abs() - 0.045).abs() < 1e-4;
        assert!(on_rim || (crown[strand * POINTS] == 1.0) == inside, "{root}");
    }
    let roots = masked(of(MaskKind::Roots {
        places: vec![[0.0, 0.09, 0.0]],
        radius_mm: 30.0,
        soften_mm: 5.0,
    }));
    assert!(roots.contains(&1.0) && roots.contains(&0.0));

    // Paint on the mask channel hides the layer where it is; undo and redo follow.
    masked(Mask::default());
    let stroke = Operation {
        shape: None,
        radius_m: 0.04,
        dabs: vec![dab(&groom, 40, 12)],
        mode: Mode::Replace,
        value: StrokeValue::Scalar(0.0),
        ..shaped(2, Channel::Mask, 0.0, Shape::all()[6].clone())
    };
    document.apply(Edit::Stroke(stroke)).unwrap();
    check_invariants(&document);
    let hidden = bleach(&document);
    assert!(hidden[40 * POINTS + 12] == 0.0 && hidden.contains(&1.0));
    document.undo().unwrap();
    check_invariants(&document);
    assert!(bleach(&document).iter().all(|x| *x == 1.0));
    document.redo().unwrap();
    assert!(bleach(&document) == hidden);
    let mut softened = document.project().layers[0].clone();
    softened.mask = of(MaskKind::Painted { soften_mm: 60.0 });
    document.apply(Edit::SetLayer(softened)).unwrap();
    check_invariants(&document);
    assert!(bleach(&document) != hidden);
}

#[test]
fn lobe_ratios_belong_to_a_layer() {
    let mut document = document(head(8, POINTS));
    let own = LobeRatios {
        beta_trt: 3.0,
        ..LobeRatios::default()
    };
    let layer = Layer {
        ratios: Some(own.into()),
        opacity: 0.5,
        mask: Mask {
            parts: vec![part(MaskKind::Arc {
                from: 0.5,
                to: 1.0,
                soften: 0.0,
            })],
            invert: false,
        },
        ..document.project().layers[1].clone()
    };
    document.apply(Edit::SetLayer(layer)).unwrap();
    check_invariants(&document);
    let params = document.params();
    assert_eq!(params[0].beta_ratios, [0.5, 2.0]);
    assert_eq!(params[POINTS - 1].beta_ratios, [0.5, 2.5]);
}

#[test]
fn merging_keeps_the_picture_or_is_refused() {
    let mut document = document(head(8, POINTS));
    let on = |layer: &str, operation: Operation| {
        Edit::Stroke(Operation {
            layer: layer.into(),
            ..operation
        })
    };
    document
        .apply(on(
            "top",
            shaped(1, Channel::Bleach, 0.9, Shape::all()[1].clone()),
        ))
        .unwrap();
    document
        .apply(on(
            "paint",
            shaped(2, Channel::Bleach, 0.4, Shape::all()[0].clone()),
        ))
        .unwrap();
    document
        .apply(on("paint", shaped(3, Channel::Dye, 1.0, Shape::all()[2].clone())))
        .unwrap();
    let before = document.values().to_vec();
    let project = document.project().clone();
    let half = Layer {
        opacity: 0.5,
        ..document.project().layers[1].clone()
    };
    document.apply(Edit::MergeDown("top".into())).unwrap();
    check_invariants(&document);
    assert_eq!(document.project().layers.len(), 1);
    assert!(document.project().operations.iter().all(|o| o.layer == "paint"));
    assert!(
        document
            .values()
            .iter()
            .zip(&before)
            .all(|(a, b)| (a.bleach - b.bleach).abs() < 1e-4)
    );
    document.undo().unwrap();
    assert!(*document.project() == project && document.values() == before);

    // An opacity can go into the strength of one operation, not of two that overlap.
    document.apply(Edit::SetLayer(half)).unwrap();
    document
        .apply(on(
            "top",
            shaped(4, Channel::Bleach, 0.1, Shape::all()[6].clone()),
        ))
        .unwrap();
    let project = document.project().clone();
    let problem = document.apply(Edit::MergeDown("top".into())).unwrap_err();
    assert!(problem.reason.contains("different"), "{problem}");
    assert!(*document.project() == project);
    check_invariants(&document);
    assert!(document.apply(Edit::MergeDown("paint".into())).is_err());
}

fn dab(groom: &Groom, strand: usize, point: usize) -> Dab {
    let points = groom.strand(strand);
    Dab {
        root: groom.positions()[points.start].into(),
        arc: groom.arc()[points.start + point],
        position: groom.positions()[points.start + point].into(),
        pressure: 1.0,
        extra: Extra::new(),
    }
}

/// Strokes of every mode and reach, and every salon operation, on `channel`s that differ.
fn session(groom: &Groom) -> Vec<Operation> {
    let mut rng = random(17);
    let stroke = |id, channel, mode, value, reach, dabs: Vec<Dab>| Operation {
        shape: None,
        mode,
        radius_m: 0.03,
        hardness: 0.3,
        strength: 0.9,
        falloff: Falloff::Smooth,
        reach,
        dabs,
        ..shaped(id, channel, value, Shape::all()[6].clone())
    };
    // Places that the thinner groom has as well: every fourth strand, every fourth point.
    let mut dabs = |n: usize| -> Vec<Dab> {
        (0..n)
            .map(|_| dab(groom, 4 * rng.random_range(0..900), 2 * rng.random_range(0..THIN)))
            .collect()
    };
    let mut operations = vec![
        stroke(1, Channel::Dye, Mode::Replace, 1.5, Reach::Surface, dabs(20)),
        stroke(2, Channel::Dye, Mode::Add, 0.5, Reach::Through, dabs(20)),
        stroke(3, Channel::Bleach, Mode::Replace, 0.8, Reach::Strand, dabs(8)),
        stroke(
            4,
            Channel::Eumelanin,
            Mode::Multiply,
            0.3,
            Reach::Surface,
            dabs(12),
        ),
        stroke(5, Channel::Dye, Mode::Erase, 0.0, Reach::Surface, dabs(6)),
        Operation {
            across: 0.5,
            ..stroke(6, Channel::Dye, Mode::Smooth, 0.0, Reach::Surface, dabs(6))
        },
        Operation {
            arc_range: Some([0.4, 0.9]),
            ..stroke(7, Channel::BetaDeg, Mode::Replace, 14.0, Reach::Strand, dabs(8))
        },
    ];
    for (i, shape) in Shape::all().into_iter().take(6).enumerate() {
        let channel = [Channel::AzimuthalDeg, Channel::Pheomelanin][i % 2];
        operations.push(Operation {
            strength: 0.5,
            ..shaped(20 + i as u64, channel, 10.0, shape)
        });
    }
    operations
}

/// The same strokes and operations on a quarter of the strands, with 13 or 9 points instead of 25: the same places.
#[test]
fn replay_on_a_thinner_groom_lands_on_the_same_places() {
    let full = head(1, POINTS);
    let operations = session(&full);
    let painted = |groom: &Arc<Groom>, skip: Option<usize>| {
        let mut document = document(groom.clone());
        for (i, operation) in operations.iter().enumerate() {
            if Some(i) != skip {
                document.apply(Edit::Stroke(operation.clone())).unwrap();
            }
        }
        document.values().to_vec()
    };
    let base = PointValues::default();
    let difference = |full: &[PointValues], thin: &[PointValues], points: usize| {
        let every = (POINTS - 1) / (points - 1);
        Channel::ALL.map(|channel| {
            let (mut off, mut painted) = (0.0, 0.0);
            for strand in 0..900 {
                for i in 0..points {
                    let a = full[4 * strand * POINTS + every * i].get(channel)[0];
                    let b = thin[strand * points + i].get(channel)[0];
                    off += f64::from((a - b).abs());
                    painted += f64::from((a - base.get(channel)[0]).abs());
                }
            }
            (channel, off / painted.max(1e-9), painted)
        })
    };
    let a = painted(&full, None);
    for points in [THIN, 9] {
        let thin = head(4, points);
        let b = painted(&thin, None);
        for (channel, off, painted) in difference(&a, &b, points) {
            println!(
                "{points} points, {}: {:.2} % of what was painted",
                channel.name(),
                100.0 * off
            );
            assert!(
                painted < 1e-6 || off < 0.05,
                "{points} points, {channel:?}: {off}"
            );
        }
        let lacking = painted(&thin, Some(2));
        let worst = difference(&a, &lacking, points)
            .into_iter()
            .map(|(_, off, _)| off)
            .fold(0.0, f64::max);
        assert!(worst > 0.05, "the comparison must be able to fail: {worst}");
    }
}

#[test]
fn poison_in_operations_and_masks_is_refused() {
    let mut document = document(head(36, POINTS));
    let before = (bits(&document), document.project().clone());
    for poison in POISON {
        for shape in Shape::all() {
            let count = shape.clone().parameters().len();
            for i in 0..count {
                let mut bad = shape.clone();
                let mut parameters = bad.parameters();
                let refused = !parameters[i].range.contains(&poison);
                let place = format!("shape.{}", parameters[i].field);
                *parameters[i].value = poison;
                drop(parameters);
                let result = document.apply(Edit::Stroke(shaped(1, Channel::Bleach, 1.0, bad)));
                if refused {
                    assert_eq!(result.unwrap_err().place, place);
                } else {
                    assert!(result.is_ok());
                    check_invariants(&document);
                    document.undo().unwrap();
                }
            }
            let mut bad = shape.clone();
            if let Some(curve) = bad.curve_mut() {
                curve.0[1][1] = poison;
                let accepted = (0.0..=1.0).contains(&poison);
                let result = document.apply(Edit::Stroke(shaped(1, Channel::Bleach, 1.0, bad)));
                assert_eq!(result.is_ok(), accepted, "{poison}");
                if accepted {
                    document.undo().unwrap();
                }
            }
        }
        let kinds = [
            MaskKind::Arc {
                from: poison,
                to: 1.0,
                soften: 0.0,
            },
            MaskKind::Length {
                from_mm: 0.0,
                to_mm: poison,
                soften_mm: 1.0,
            },
            MaskKind::Strands {
                share: poison,
                seed: 0,
            },
            MaskKind::Region {
                outline: vec![[poison, 0.0, 0.0]; 3],
                soften_mm: 0.0,
            },
            MaskKind::Roots {
                places: vec![[0.0; 3]],
                radius_mm: poison,
                soften_mm: 1.0,
            },
            MaskKind::Painted { soften_mm: poison },
        ];
        for kind in kinds {
            let mut layer = document.project().layers[0].clone();
            layer.mask.parts = vec![part(kind)];
            if document.apply(Edit::SetLayer(layer)).is_ok() {
                check_invariants(&document);
                document.undo().unwrap();
            }
        }
        let fields: [&dyn Fn(&mut Operation); 3] = [&|o| o.flow = poison, &|o| o.across = poison, &|o| {
            o.arc_range = Some([poison, 1.0]);
        }];
        for change in fields {
            let mut stroke = Operation {
                shape: None,
                radius_m: 0.02,
                ..shaped(1, Channel::Bleach, 1.0, Shape::all()[6].clone())
            };
            change(&mut stroke);
            let acceptable = poison == 0.0 || (poison > 0.0 && poison <= 1.0);
            assert!(
                acceptable || document.apply(Edit::Stroke(stroke)).is_err(),
                "{poison}"
            );
        }
    }
    assert!((bits(&document), document.project().clone()) == before);
    assert!(
        document
            .apply(Edit::SetOperation(
                0,
                shaped(1, Channel::Dye, 0.0, Shape::all()[0].clone())
            ))
            .is_err()
    );
    assert!(document.apply(Edit::RemoveOperation(7)).is_err());
}

/// The schema as the manual shows it, and 400 damaged copies: an error or a sound list, never a panic.
#[test]
fn damaged_operations_never_panic() {
    let text = r#"{"version": 2, "operations": [
        {"id": 1, "layer": "paint", "channel": "bleach", "mode": "replace", "value": 0.9, "seed": 3,
         "shape": {"balayage": {"section_mm": 20, "share": 0.4, "start_mm": 40, "length_mm": 90, "v_mm": 30, "vary_mm": 10,
                                "curve": [[0, 0], [0.5, 0.3], [1, 1]]}}},
        {"id": 2, "channel": "bleach", "mode": "replace", "value": 1, "shape": {"grey": {"share": 0.2}}, "hidden": true},
        {"id": 3, "channel": "dye", "mode": "replace", "value": [0, 1, 2], "shape": {"fill": {}}, "strength": 0.5}]}"#;
    let file = StrokeFile::parse(text).unwrap();
    assert!(file.operations[1].hidden);
    let mut document = document(head(36, POINTS));
    for operation in file.operations.clone() {
        document.apply(Edit::Stroke(operation)).unwrap();
    }
    check_invariants(&document);
    let again = balayage::document::json::to_text(&file).unwrap();
    assert_eq!(StrokeFile::parse(&again).unwrap(), file);
    for (from, to, place) in [
        ("0.4", "1.4", "operations[0].shape.share"),
        ("0.5, 0.3", "0.5, 3", "operations[0].shape.curve[1]"),
        ("\"share\": 0.2", "\"shore\": 0.2", "line"),
        ("\"grey\"", "\"green\"", "line"),
        ("{\"fill\": {}}", "null", "operations[2].radius_m"),
    ] {
        let problem = StrokeFile::parse(&text.replace(from, to)).unwrap_err();
        assert!(problem.place.starts_with(place), "{from}: {problem}");
    }
    let mut refused = 0;
    damage(again.as_bytes(), 64, 4, |bytes| {
        if let Ok(text) = std::str::from_utf8(bytes) {
            refused += usize::from(StrokeFile::parse(text).is_err());
        }
    });
    assert!(refused > 100, "{refused}");
}

/// 1,000 strokes on 46,800 points: opened and undone at once, the history within its limit.
#[test]
fn a_thousand_strokes_open_and_undo_quickly() {
    let groom = head(1, THIN);
    let mut rng = random(3);
    let stroke = |id: u64, dabs| Operation {
        shape: None,
        radius_m: 0.02,
        hardness: 0.3,
        strength: 0.7,
        dabs,
        ..shaped(id, Channel::Dye, 1.0, Shape::all()[6].clone())
    };
    let mut project = document(groom.clone()).project().clone();
    for id in 0..1000 {
        let first = rng.random_range(0..3600);
        let dabs = (0..12).map(|i| dab(&groom, (first + 8 * i) % 3600, i)).collect();
        project.operations.push(stroke(id + 1, dabs));
    }
    let text = balayage::document::json::to_text(&project).unwrap();
    let start = std::time::Instant::now();
    let project = Project::parse(&text).unwrap();
    let mut document = Document::new(groom.clone(), project, PathBuf::new()).unwrap();
    let open = start.elapsed();

    // Strokes, an operation in front of a thousand others, and their undo.
    let limit = 4 << 20;
    document.set_history_bytes(limit);
    let (mut slowest, mut painted) = (0.0_f64, 0.0_f64);
    for i in 0..20 {
        let dabs = (0..12).map(|k| dab(&groom, 150 * i + 8 * k, k)).collect();
        let start = std::time::Instant::now();
        document
            .apply(Edit::Stroke(stroke(2000 + i as u64, dabs)))
            .unwrap();
        painted = painted.max(start.elapsed().as_secs_f64());
        assert!(document.history_bytes() <= limit);
    }
    document
        .apply(Edit::Stroke(shaped(
            3000,
            Channel::Dye,
            0.2,
            Shape::all()[1].clone(),
        )))
        .unwrap();
    assert!(document.history_bytes() <= limit);
    while document.history_labels().1 > 10 {
        let start = std::time::Instant::now();
        document.undo().unwrap();
        slowest = slowest.max(start.elapsed().as_secs_f64());
    }
    println!(
        "open {:.2} s, slowest stroke {:.1} ms, slowest undo {:.1} ms, history {} KiB",
        open.as_secs_f64(),
        1e3 * painted,
        1e3 * slowest,
        document.history_bytes() >> 10
    );
    // Twice the goals of 3 s and 50 ms: the machine may have other work.
    assert!(open.as_secs_f64() < 6.0 && slowest < 0.1);
    check_invariants(&document);
}
