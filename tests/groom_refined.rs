//! The refined curve: spline, subdivision, frames.

use balayage_render::groom::{DEFAULT_MAX_TURN_RAD, Groom, RefinedGroom};
use balayage_tests::{POISON, random, test_data};
use glam::{Quat, Vec3};
use rand::Rng;

use crate::groom::wild_groom;

/// One strand of `points` points on a helix of radius 1 and slope `rise` per radian over `turns`.
fn helix(points: usize, turns: f32, rise: f32) -> Groom {
    let strand: Vec<Vec3> = (0..points)
        .map(|i| {
            let t = i as f32 / (points - 1) as f32 * turns * std::f32::consts::TAU;
            Vec3::new(t.cos(), rise * t, t.sin())
        })
        .collect();
    Groom::from_strands([strand], 0.01, 1.0).unwrap().0
}

/// Frames are orthonormal, the turn is bounded, the groom's points are kept, sources are right.
fn assert_laws(groom: &Groom, refined: &RefinedGroom, max_turn: f32) {
    assert_eq!(refined.strand_count(), groom.strand_count());
    let mut turns_beyond = 0;
    for strand in 0..groom.strand_count() {
        let (range, source) = (refined.strand(strand), groom.strand(strand));
        for i in range.clone() {
            let (u, v) = (refined.tangents()[i], refined.normals()[i]);
            assert!((u.length() - 1.0).abs() < 1.0e-5 && (v.length() - 1.0).abs() < 1.0e-5);
            assert!(u.dot(v).abs() < 1.0e-5);
            let fraction = refined.source_fraction()[i];
            assert!((0.0..1.0).contains(&fraction));
            let point = refined.source_point()[i] as usize;
            assert!(source.contains(&point));
            if fraction == 0.0 {
                assert_eq!(refined.positions()[i], groom.positions()[point]);
                assert_eq!(refined.diameters()[i], groom.diameters()[point]);
            } else {
                let (a, b) = (groom.diameters()[point], groom.diameters()[point + 1]);
                assert!((a.min(b)..=a.max(b)).contains(&refined.diameters()[i]));
            }
        }
        // Every point of the groom occurs, in order.
        let kept: Vec<u32> = range
            .clone()
            .filter(|&i| refined.source_fraction()[i] == 0.0)
            .map(|i| refined.source_point()[i])
            .collect();
        assert_eq!(kept, source.map(|p| p as u32).collect::<Vec<_>>());
        turns_beyond += range
            .clone()
            .take(range.len() - 1)
            .filter(|&i| refined.tangents()[i].angle_between(refined.tangents()[i + 1]) > max_turn + 2.0e-3)
            .count();
    }
    assert!(
        turns_beyond == 0 || refined.capped_segments() > 0,
        "{turns_beyond} turns beyond {max_turn}"
    );
}

#[test]
fn laws_hold_on_random_strands() {
    let groom = wild_groom(11, 200, false);
    for max_turn in [DEFAULT_MAX_TURN_RAD, 0.02, 0.5] {
        let refined = RefinedGroom::new(&groom, max_turn);
        assert_laws(&groom, &refined, max_turn);
        assert_eq!(refined, RefinedGroom::new(&groom, max_turn));
    }
    let (coarse, fine) = (RefinedGroom::new(&groom, 0.5), RefinedGroom::new(&groom, 0.02));
    assert!(fine.point_count() > 5 * coarse.point_count());
}

#[test]
fn laws_hold_on_real_hair() {
    for name in [
        "sintel_hair_k4.hair",
        "tressfx_ratboy_mohawk_k2.tfx",
        "tressfx3_bear_k8.tfx",
    ] {
        let Some(path) = test_data(&format!("fetched/hair/{name}")) else {
            return;
        };
        let groom = balayage_render::groom::read_groom(path, None).unwrap().groom;
        let started = std::time::Instant::now();
        let refined = RefinedGroom::new(&groom, DEFAULT_MAX_TURN_RAD);
        println!(
            "{name}: {} points -> {} refined, {} segments capped, {:.0} ms",
            groom.point_count(),
            refined.point_count(),
            refined.capped_segments(),
            1.0e3 * started.elapsed().as_secs_f64()
        );
        assert_laws(&groom, &refined, DEFAULT_MAX_TURN_RAD);
    }
}

#[test]
fn straight_strand_is_not_subdivided() {
    let strand: Vec<Vec3> = (0..6).map(|i| Vec3::new(0.1, 0.2, -0.3) * i as f32).collect();
    let refined = RefinedGroom::new(
        &Groom::from_strands([strand], 0.01, 1.0).unwrap().0,
        DEFAULT_MAX_TURN_RAD,
    );
    assert_eq!((refined.point_count(), refined.capped_segments()), (6, 0));
}

/// The textbook form in second derivatives, solved by iteration, gives the same curve.
#[test]
fn spline_agrees_with_the_form_in_second_derivatives() {
    let mut random = random(5);
    let points: Vec<Vec3> = (0..7)
        .map(|_| Vec3::from_array(random.random::<[f32; 3]>()))
        .collect();
    let groom = Groom::from_strands([points.clone()], 0.01, 1.0).unwrap().0;
    let refined = RefinedGroom::new(&groom, 0.05);

    // m_(i-1) + 4 m_i + m_(i+1) = 6 (p_(i-1) - 2 p_i + p_(i+1)), m_0 = m_n = 0, by Gauss-Seidel in f64.
    let p: Vec<glam::DVec3> = points.iter().map(|p| p.as_dvec3()).collect();
    let mut m = [glam::DVec3::ZERO; 7];
    for _ in 0..200 {
        for i in 1..6 {
            m[i] = (6.0 * (p[i - 1] - 2.0 * p[i] + p[i + 1]) - m[i - 1] - m[i + 1]) / 4.0;
        }
    }
    let mut compared = 0;
    for i in 0..refined.point_count() - 1 {
        let (k, t) = (
            refined.source_point()[i] as usize,
            f64::from(refined.source_fraction()[i]),
        );
        let s = 1.0 - t;
        let wanted = s * p[k] + t * p[k + 1] + ((s * s * s - s) * m[k] + (t * t * t - t) * m[k + 1]) / 6.0;
        assert!(refined.positions()[i].distance(wanted.as_vec3()) < 1.0e-5);
        // The tangent is the direction of the same curve's derivative.
        let along = p[k + 1] - p[k] + ((1.0 - 3.0 * s * s) * m[k] + (3.0 * t * t - 1.0) * m[k + 1]) / 6.0;
        assert!(refined.tangents()[i].dot(along.normalize().as_vec3()) > 1.0 - 1.0e-5);
        compared += usize::from(t > 0.0);
    }
    assert!(compared > 30);
}

/// A rotation-minimizing frame on a helix turns against the Frenet frame by the torsion times the arc length.
#[test]
fn frame_on_a_helix_lags_by_the_integrated_torsion() {
    let (rise, turns) = (0.5_f32, 2.0_f32);
    let groom = helix(200, turns, rise);
    let refined = RefinedGroom::new(&groom, 0.02);
    // The Frenet normal of this helix points at the axis.
    let angle = |i: usize| {
        let (u, v, p) = (
            refined.tangents()[i],
            refined.normals()[i],
            refined.positions()[i],
        );
        let inwards = -Vec3::new(p.x, 0.0, p.z).normalize();
        let inwards = (inwards - u * u.dot(inwards)).normalize();
        v.dot(u.cross(inwards)).atan2(v.dot(inwards))
    };
    // Leave out the ends, where the natural spline leaves the helix.
    let (a, b) = (refined.point_count() / 10, refined.point_count() * 9 / 10);
    let mut turned = 0.0;
    for i in a..b {
        let step = angle(i + 1) - angle(i);
        turned += (step + std::f32::consts::PI).rem_euclid(std::f32::consts::TAU) - std::f32::consts::PI;
    }
    let arc_angle = (refined.positions()[b].y - refined.positions()[a].y) / rise;
    let torsion_times_length = rise / (1.0 + rise * rise).sqrt() * arc_angle;
    assert!(
        (turned.abs() - torsion_times_length).abs() < 0.01 * torsion_times_length,
        "turned {turned}, torsion {torsion_times_length}"
    );
}

#[test]
fn frame_of_a_plane_curve_keeps_the_plane_normal() {
    let groom = helix(60, 1.0, 0.0);
    let refined = RefinedGroom::new(&groom, 0.05);
    // In the plane y = 0 the normal's height may not change.
    let height = refined.normals()[0].y;
    assert!(refined.normals().iter().all(|v| (v.y - height).abs() < 1.0e-4));
}

/// Where the tangent at the root does not change, the frame may not: the rule is a function of the tangent.
#[test]
fn root_frame_is_stable() {
    let mut random = random(8);
    for _ in 0..200 {
        let turn = Quat::from_scaled_axis(3.0 * (Vec3::from_array(random.random::<[f32; 3]>()) - 0.5));
        let root_normal = |u: Vec3| {
            let groom = Groom::from_strands([[Vec3::ZERO, u]], 0.01, 1.0).unwrap().0;
            RefinedGroom::new(&groom, 0.1).normals()[0]
        };
        let u = turn * Vec3::Y;
        let nudged = (u + Vec3::new(1.0e-3, -2.0e-3, 1.0e-3)).normalize();
        // The rule is singular straight down only.
        if u.y > -0.9 {
            assert!(root_normal(u).distance(root_normal(nudged)) < 0.05);
        }
    }
}

#[test]
fn sharp_turns_hit_the_cap_and_are_counted() {
    let zigzag: Vec<Vec3> = (0..8)
        .map(|i| Vec3::new((i % 2) as f32, 1.0e-4 * i as f32, 0.0))
        .collect();
    let groom = Groom::from_strands([zigzag], 0.01, 1.0).unwrap().0;
    let refined = RefinedGroom::new(&groom, 0.002);
    assert!(refined.capped_segments() > 0);
    assert!(refined.point_count() <= 7 * 64 + 1);
    assert_laws(&groom, &refined, 0.002);
}

#[test]
fn every_poison_turn_gives_a_finite_curve() {
    let groom = wild_groom(12, 5, false);
    for max_turn in POISON {
        let refined = RefinedGroom::new(&groom, max_turn);
        assert!(
            refined
                .positions()
                .iter()
                .chain(refined.tangents())
                .all(|p| p.is_finite())
        );
    }
}

#[test]
fn interpolation_is_linear_between_points() {
    let groom = helix(9, 1.0, 0.3);
    let refined = RefinedGroom::new(&groom, 0.1);
    let index: Vec<f32> = (0..9).map(|i| i as f32).collect();
    let carried = refined.interpolate(&index, |a, b, t| a + t * (b - a));
    for (i, value) in carried.iter().enumerate() {
        assert!((value - refined.source_point()[i] as f32 - refined.source_fraction()[i]).abs() < 1.0e-5);
    }
    assert_eq!(carried.last(), Some(&8.0));
}
