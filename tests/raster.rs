//! Strand drawing: coverage is the true area, whatever the angle, width and order.

use balayage_render::gpu::bench::{Ribbons, true_alpha};
use balayage_render::gpu::camera::CameraUniform;
use balayage_render::gpu::head::HeadTarget;
use balayage_render::gpu::raster::{PictureBuffers, Raster, ResolveInputs, ResolveUniform};
use balayage_render::gpu::strands::{RefinedVertex, Segment, StrandBuffers};
use balayage_render::gpu::{Camera, Gpu};
use balayage_render::volume::{SegmentGrid, Strands};
use bytemuck::Zeroable;
use glam::{Mat4, Vec3};

const SIZE: [u32; 2] = [64, 64];

/// A camera at the origin that looks along -z; at depth 1 a pixel is 1/64 wide.
fn camera(segment_count: u32) -> CameraUniform {
    let camera = Camera {
        world_from_camera: Mat4::IDENTITY,
        fov_y_rad: 2.0 * 0.5f32.atan(),
        crop: None,
    };
    CameraUniform::new(&camera, SIZE, [0.0; 2], 1e-3, segment_count)
}

/// Polylines through the middle of the picture, `width_px` wide there, with one radiance each, drawn; RGBA of every pixel.
fn draw(gpu: &Gpu, strands: &[(Vec<Vec3>, f32, [f32; 3])]) -> Vec<[f32; 4]> {
    draw_hiding(gpu, strands, 1.0).0
}

/// The same where a strand hides what is behind it from some coverage on, and the fragments that were made room for.
fn draw_hiding(
    gpu: &Gpu,
    strands: &[(Vec<Vec3>, f32, [f32; 3])],
    solid_coverage: f32,
) -> (Vec<[f32; 4]>, u64) {
    let (mut vertices, mut segments, mut radiance) = (Vec::new(), Vec::new(), Vec::new());
    for (strand, (points, width_px, colour)) in strands.iter().enumerate() {
        for (k, p) in points.iter().enumerate() {
            if k + 1 < points.len() {
                segments.push(Segment {
                    vertex: vertices.len() as u32,
                    strand: strand as u32,
                });
            }
            let diameter = width_px / 64.0 * -p.z;
            vertices.push(RefinedVertex {
                position: p.to_array(),
                diameter,
                ..Zeroable::zeroed()
            });
            radiance.push([colour[0], colour[1], colour[2], 0.0]);
        }
    }
    let buffers = StrandBuffers::from_parts(gpu, &vertices, &segments).unwrap();
    buffers.set_radiance(gpu, &radiance);
    let target = PictureBuffers::new(gpu, SIZE).unwrap();
    let head = HeadTarget::new(gpu, [1, 1]).unwrap();
    let background = gpu.storage("background", 16).unwrap();
    let resolve = ResolveUniform {
        weight: 1.0,
        gain: [1.0; 3],
        ..Zeroable::zeroed()
    };
    let inputs = ResolveInputs {
        strands: &buffers,
        head: &head,
        background: &background,
        target: &target,
        has_head: false,
        interpolates_straight: false,
        touched_only: false,
    };
    let mut raster = Raster::new(gpu).unwrap();
    let camera = CameraUniform {
        solid_coverage,
        ..camera(segments.len() as u32)
    };
    let fragments = raster.draw(gpu, &camera, &resolve, &inputs, || Ok(())).unwrap();
    (gpu.read(&target.picture, 64 * 64).unwrap(), fragments)
}

/// A straight strand through the picture's middle at `angle`, `length_px` long, in `pieces` segments.
fn straight(angle: f32, length_px: f32, pieces: usize) -> Vec<Vec3> {
    let half = 0.5 * length_px / 64.0 * Vec3::new(angle.cos(), angle.sin(), 0.0);
    let centre = Vec3::new(0.003, -0.007, -1.0);
    (0..=pieces)
        .map(|k| centre + half * (2.0 * k as f32 / pieces as f32 - 1.0))
        .collect()
}

fn total_alpha(picture: &[[f32; 4]]) -> f32 {
    picture.iter().map(|p| p[3]).sum()
}

#[test]
fn coverage_is_the_true_area_at_any_angle() {
    let gpu = Gpu::headless().unwrap();
    for width in [0.05, 0.4, 1.0, 3.0, 12.0] {
        for k in 0..12 {
            let angle = k as f32 * 0.2718;
            let got = total_alpha(&draw(&gpu, &[(straight(angle, 40.0, 1), width, [1.0; 3])]));
            let area = 40.0 * width;
            let error = (got / area - 1.0).abs();
            assert!(
                error < 0.01,
                "width {width} px at {angle} rad: area {got} instead of {area}"
            );
        }
    }
}

#[test]
fn a_strand_in_a_corner_covers_what_rays_meet() {
    let gpu = Gpu::headless().unwrap();
    // Towards the corner, and across that: the outlines lie apart differently.
    for [from, to] in [[(0.2, 0.25), (0.45, 0.4)], [(0.25, 0.4), (0.4, 0.2)]] {
        let points: Vec<Vec3> = [from, to].map(|(x, y)| Vec3::new(x, y, -1.0)).to_vec();
        let strands = Strands {
            positions: &points,
            diameters: &[4.0 / 64.0; 2],
            first_point: &[0, 2],
        };
        let grid = SegmentGrid::new(&strands);
        let per_side = 64 * 8;
        let met = (0..per_side * per_side)
            .filter(|i| {
                let at = |k: i32| (k as f32 + 0.5) / per_side as f32 - 0.5;
                let way = Vec3::new(at(i % per_side), at(i / per_side), -1.0);
                !grid.is_free(Vec3::ZERO, way.normalize(), None)
            })
            .count();
        let area = met as f32 / 64.0;
        let got = total_alpha(&draw(&gpu, &[(points, 4.0, [1.0; 3])]));
        assert!((got / area - 1.0).abs() < 0.015, "area {got} instead of {area}");
    }
}

#[test]
fn cutting_a_strand_into_segments_changes_nothing() {
    let gpu = Gpu::headless().unwrap();
    let whole = draw(&gpu, &[(straight(0.5, 40.0, 1), 2.0, [1.0; 3])]);
    for pieces in [7, 60] {
        let cut = draw(&gpu, &[(straight(0.5, 40.0, pieces), 2.0, [1.0; 3])]);
        let worst = whole
            .iter()
            .zip(&cut)
            .map(|(a, b)| (a[3] - b[3]).abs())
            .fold(0.0, f32::max);
        assert!(worst < 0.02, "{pieces} pieces: alpha differs by {worst}");
    }
}

#[test]
fn the_order_of_strands_does_not_matter_and_the_nearer_one_hides() {
    let gpu = Gpu::headless().unwrap();
    let near = (
        straight(0.3, 40.0, 3).iter().map(|p| *p * 0.9).collect(),
        4.0,
        [1.0, 0.0, 0.0],
    );
    let far = (straight(1.4, 40.0, 3), 4.0, [0.0, 1.0, 0.0]);
    let one = draw(&gpu, &[near.clone(), far.clone()]);
    let other = draw(&gpu, &[far, near]);
    assert_eq!(one, other);
    let middle = one[32 * 64 + 32];
    assert!(
        middle[0] > 0.99 && middle[1] < 0.01,
        "the crossing shows {middle:?}"
    );
}

#[test]
fn behind_a_strand_that_covers_its_pixels_nothing_is_listed() {
    let gpu = Gpu::headless().unwrap();
    let strands: Vec<_> = (0..40)
        .map(|k| {
            let depth = 1.0 + 0.1 * ((k * 17) % 40) as f32;
            let points = straight(0.7 * k as f32, 30.0, 3);
            let points = points.iter().map(|p| *p * depth).collect();
            (points, 6.0, [0.02 * k as f32, 1.0 - 0.02 * k as f32, 0.5])
        })
        .collect();
    let (all, every) = draw_hiding(&gpu, &strands, 2.0);
    let (hiding, fewer) = draw_hiding(&gpu, &strands, 1.0);
    assert!(hiding == all, "the same picture");
    assert!(3 * fewer < 2 * every, "{fewer} of {every} fragments");
    // Where half a pixel would do, something is missing.
    assert!(
        draw_hiding(&gpu, &strands, 0.5).0 != all,
        "the comparison sees it"
    );
}

#[test]
fn dense_thin_hair_composes_to_the_product_of_what_it_lets_through() {
    let gpu = Gpu::headless().unwrap();
    let layers = 100;
    let strands: Vec<_> = (0..layers)
        .map(|k| {
            let depth = 1.0 + 0.01 * k as f32;
            (
                straight(0.7, 50.0, 1).iter().map(|p| *p * depth).collect(),
                0.03,
                [1.0; 3],
            )
        })
        .collect();
    let one = draw(&gpu, &strands[..1]);
    let all = draw(&gpu, &strands);
    for (a, b) in one.iter().zip(&all) {
        let expected = 1.0 - (1.0 - a[3]).powi(layers);
        assert!(
            (b[3] - expected).abs() < 4e-3,
            "alpha {} instead of {expected}",
            b[3]
        );
        assert!(
            (b[0] - b[3]).abs() < 1e-4,
            "white strands have radiance = alpha, got {b:?}"
        );
    }
}

#[test]
fn thousands_of_strands_in_a_pixel_hide_each_other_by_depth() {
    let gpu = Gpu::headless().unwrap();
    let count = 5000;
    let width_px = 6e-4;
    let colour_at = |place: usize| {
        if 2 * place < count {
            [1.0, 0.0, 0.0]
        } else {
            [0.0, 1.0, 0.0]
        }
    };
    let strands: Vec<_> = (0..count)
        .map(|k| {
            let place = k * 1237 % count;
            let depth = 1.0 + 2e-4 * place as f32;
            let points = straight(0.7, 12.0, 1).iter().map(|p| *p * depth).collect();
            (points, width_px, colour_at(place))
        })
        .collect();
    let one = draw(&gpu, &[(straight(0.7, 12.0, 1), 0.03, [1.0; 3])]);
    let all = draw(&gpu, &strands);
    let (mut seen, mut worst) = (0, 0f32);
    for (a, b) in one.iter().zip(&all) {
        let thickness = 0.5 * count as f32 * a[3] * (width_px / 0.03);
        let (front, behind) = (1.0 - (-thickness).exp(), 1.0 - (-2.0 * thickness).exp());
        seen += usize::from(behind > 0.8);
        worst = worst
            .max((b[0] - front).abs())
            .max((b[1] - (behind - front)).abs())
            .max((b[3] - behind).abs());
    }
    assert!(seen >= 8, "dense in {seen} pixels");
    assert!(worst < 0.02, "wrong by {worst}");
}

/// The same strands over a map of `checks` x `checks` black and white fields, whose picture without strands comes first.
fn over_checkerboard(gpu: &Gpu, points: &[Vec3], width_px: f32) -> [Vec<[f32; 4]>; 2] {
    const MAP: [u32; 2] = [512, 256];
    let field = |i: u32| f32::from(u8::from((i % MAP[0] / 4 + i / MAP[0] / 4).is_multiple_of(2)));
    let map: Vec<[f32; 4]> = (0..MAP[0] * MAP[1]).map(|i| [field(i); 4]).collect();
    let background = gpu.storage_of("background", &map).unwrap();
    let vertices: Vec<RefinedVertex> = points
        .iter()
        .map(|p| RefinedVertex {
            position: p.to_array(),
            diameter: width_px / 64.0 * -p.z,
            ..Zeroable::zeroed()
        })
        .collect();
    let segments: Vec<Segment> = (1..points.len() as u32)
        .map(|i| Segment {
            vertex: i - 1,
            strand: 0,
        })
        .collect();
    let strands = StrandBuffers::from_parts(gpu, &vertices, &segments).unwrap();
    let resolve = ResolveUniform {
        world_from_view: Mat4::IDENTITY.to_cols_array_2d(),
        weight: 1.0,
        has_background: 1,
        background_scale: [1.0; 3],
        background_size: MAP,
        ..Zeroable::zeroed()
    };
    [0, segments.len() as u32].map(|drawn| {
        let inputs = ResolveInputs {
            strands: &strands,
            head: &HeadTarget::new(gpu, [1, 1]).unwrap(),
            background: &background,
            target: &PictureBuffers::new(gpu, SIZE).unwrap(),
            has_head: false,
            interpolates_straight: false,
            touched_only: false,
        };
        Raster::new(gpu)
            .unwrap()
            .draw(gpu, &camera(drawn), &resolve, &inputs, || Ok(()))
            .unwrap();
        gpu.read(&inputs.target.picture, 64 * 64).unwrap()
    })
}

#[test]
fn a_thin_strand_darkens_a_checkerboard_by_its_true_area() {
    let gpu = Gpu::headless().unwrap();
    // The strand is black: what the bright fields lose is its coverage of them.
    for k in 0..6 {
        let offset = Vec3::new(0.37 * k as f32, 0.23 * k as f32, 0.0) / 64.0;
        let points: Vec<Vec3> = straight(0.1 + 0.2618 * k as f32, 40.0, 1)
            .iter()
            .map(|p| *p + offset)
            .collect();
        let [empty, with_strand] = over_checkerboard(&gpu, &points, 0.05);
        let bright = |p: &[f32; 4]| p[0] > 0.25;
        assert!(
            empty.iter().filter(|p| bright(p)).count() > 800,
            "the map has bright fields"
        );
        assert!(
            empty.iter().filter(|p| !bright(p)).count() > 800,
            "the map has dark fields"
        );
        let shares = empty.iter().zip(&with_strand).filter(|(e, _)| bright(e));
        let darkened: f64 = shares.map(|(e, s)| f64::from(1.0 - s[0] / e[0])).sum();
        let covered = draw(&gpu, &[(points, 0.05, [0.0; 3])]);
        let over_bright = covered.iter().zip(&empty).filter(|(_, e)| bright(e));
        let expected: f64 = over_bright.map(|(c, _)| f64::from(c[3])).sum();
        assert!(
            (darkened / expected - 1.0).abs() < 0.01,
            "{darkened} px^2 instead of {expected}"
        );
        let area = f64::from(total_alpha(&covered));
        assert!(
            (area / 2.0 - 1.0).abs() < 0.01,
            "angle {k}: area {area} instead of 2"
        );
        assert!(
            expected > 0.2 * area && expected < 0.8 * area,
            "the strand crosses both fields"
        );
    }
}

#[test]
fn coverage_is_that_of_clipped_polygons_and_ribbons_have_its_mean() {
    let gpu = Gpu::headless().unwrap();
    let width_px = 0.4;
    let strands: Vec<_> = (0..40)
        .map(|k| {
            straight(0.3 * k as f32, 40.0, 5)
                .iter()
                .map(|p| *p * (1.0 + 0.01 * k as f32))
                .collect::<Vec<_>>()
        })
        .collect();
    let positions = strands.concat();
    let diameters: Vec<f32> = positions.iter().map(|p| width_px / 64.0 * -p.z).collect();
    let first_point: Vec<u32> = (0..=40).map(|k| 6 * k).collect();
    let polylines = Strands {
        positions: &positions,
        diameters: &diameters,
        first_point: &first_point,
    };
    let segment_count = 40 * 5;
    let truth = true_alpha(&camera(segment_count), &polylines);
    let wider: Vec<f32> = diameters.iter().map(|d| 1.1 * d).collect();
    let wrong = true_alpha(
        &camera(segment_count),
        &Strands {
            diameters: &wider,
            ..polylines
        },
    );

    let mean_error = |picture: &[[f32; 4]], truth: &[f32]| {
        let errors = picture.iter().zip(truth).map(|(p, t)| (p[3] - t).abs());
        errors.sum::<f32>() / truth.iter().filter(|t| **t > 0.0).count() as f32
    };
    let drawn: Vec<_> = strands
        .into_iter()
        .map(|points| (points, width_px, [1.0; 3]))
        .collect();
    let fragments = draw(&gpu, &drawn);
    assert!(
        mean_error(&fragments, &truth) < 2e-3,
        "{}",
        mean_error(&fragments, &truth)
    );
    // Strands a tenth wider are told from these.
    assert!(
        mean_error(&fragments, &wrong) > 5e-3,
        "{}",
        mean_error(&fragments, &wrong)
    );

    let vertices: Vec<RefinedVertex> = positions
        .iter()
        .zip(&diameters)
        .map(|(p, diameter)| RefinedVertex {
            position: p.to_array(),
            diameter: *diameter,
            ..Zeroable::zeroed()
        })
        .collect();
    let segments: Vec<Segment> = (0..segment_count)
        .map(|k| Segment {
            vertex: k / 5 * 6 + k % 5,
            strand: k / 5,
        })
        .collect();
    let buffers = StrandBuffers::from_parts(&gpu, &vertices, &segments).unwrap();
    let ribbons = Ribbons::new(&gpu, SIZE).unwrap();
    let near = CameraUniform {
        near: 0.9,
        ..camera(segment_count)
    };
    ribbons.draw(&gpu, &near, &buffers);
    let blended: Vec<[f32; 4]> = gpu.read(&ribbons.picture, 64 * 64).unwrap();
    let bias = total_alpha(&blended) / truth.iter().sum::<f32>() - 1.0;
    assert!(bias.abs() < 0.03, "ribbons cover {bias} too much");
    // Their pixels are not those of the strands.
    assert!(mean_error(&blended, &truth) > 10.0 * mean_error(&fragments, &truth));
}
