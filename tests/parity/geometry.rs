//! Directions, frames, coverage, packing and the camera.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec2, DVec3};

use super::{CALLS, Parity, between, hold, log_between};

pub(super) fn direction(theta: f64, phi: f64) -> DVec3 {
    DVec3::new(theta.sin(), theta.cos() * phi.cos(), theta.cos() * phi.sin())
}

/// An orthonormal frame of three angles.
fn frame(a: f64, b: f64, c: f64) -> DMat3 {
    DMat3::from_euler(glam::EulerRot::XYZ, a, b, c)
}

/// Area of the unit square around zero whose coordinate along `axis` is below `x`: the square cut by a line, corner by corner.
fn area_below(x: f64, axis: DVec2) -> f64 {
    let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(x, y)| DVec2::new(x, y));
    let mut kept: Vec<DVec2> = Vec::new();
    for i in 0..4 {
        let (from, to) = (corners[i], corners[(i + 1) % 4]);
        let (inside, outside) = (from.dot(axis) - x, to.dot(axis) - x);
        if inside <= 0.0 {
            kept.push(from);
        }
        if inside * outside < 0.0 {
            kept.push(from + (to - from) * (inside / (inside - outside)));
        }
    }
    let twice: f64 = (0..kept.len())
        .map(|i| kept[i].perp_dot(kept[(i + 1) % kept.len()]))
        .sum();
    0.5 * twice.abs()
}

/// The nine harmonics as polynomials of any vector, times `c`.
fn polynomial(c: &[f64], w: DVec3) -> f64 {
    let (x, y, z) = (w.x, w.y, w.z);
    let root = f64::sqrt;
    c[0] + root(3.0) * (c[1] * x + c[2] * y + c[3] * z)
        + root(15.0) * (c[4] * y * z + c[5] * x * z + c[6] * x * y + 0.5 * c[7] * (x * x - y * y))
        + 0.5 * root(5.0) * c[8] * (2.0 * z * z - x * x - y * y)
}

pub const PARITIES: &[Parity] = &[
    Parity {
        covers: &["harmonics", "lobe_mean"],
        file: "lib/harmonics.wgsl",
        call: "
            let c = array<f32, 9>(x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8]);
            let w = vec3f(sin(x[9]), cos(x[9]) * cos(x[10]), cos(x[9]) * sin(x[10]));
            let kappa = 2.0 / (x[11] * x[11]);
            y = vec4f(lobe_mean(c, w, 1.0 / tanh(kappa) - 1.0 / kappa, x[11]), 0.0, 0.0, 0.0);",
        domain: "coefficients -1 to 1, any axis, bandwidth 0.2 to 1.5; the reference is the mean over the lobe, sampled",
        tolerance: 1e-4,
        reason: "the factor of degree 2 is a difference of numbers near one",
        calls: 512,
        draw: |r| {
            let mut x: Vec<f64> = (0..9).map(|_| between(r, -1.0, 1.0)).collect();
            x.extend([between(r, -1.5, 1.5), between(r, -PI, PI), between(r, 0.2, 1.5)]);
            x
        },
        reference: |x| {
            let axis = direction(x[9], x[10]);
            let (tangent, bitangent) = axis.any_orthonormal_pair();
            let (mut sum, mut weight) = (0.0, 0.0);
            let lowest = (1.0 - 20.0 * x[11] * x[11]).max(-1.0);
            for i in 0..2000 {
                let cos = lowest + (1.0 - lowest) * (f64::from(i) + 0.5) / 2000.0;
                let (sin, g) = ((1.0 - cos * cos).sqrt(), (2.0 * (cos - 1.0) / (x[11] * x[11])).exp());
                // Six azimuths are exact for degree 2.
                for k in 0..6 {
                    let (s, c) = (TAU * f64::from(k) / 6.0).sin_cos();
                    sum += g * polynomial(x, axis * cos + (tangent * c + bitangent * s) * sin);
                    weight += g;
                }
            }
            vec![sum / weight]
        },
    },
    Parity {
        covers: &["harmonics_slope"],
        file: "lib/harmonics.wgsl",
        call: "
            let c = array<f32, 9>(x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8]);
            y = vec4f(harmonics_slope(c, vec3f(x[9], x[10], x[11])), 0.0);",
        domain: "coefficients and vector -1 to 1; the reference is a difference of the polynomials, exact for degree 2",
        tolerance: 1e-6,
        reason: "rounding of f32",
        calls: CALLS,
        draw: |r| (0..12).map(|_| between(r, -1.0, 1.0)).collect(),
        reference: |x| {
            let w = DVec3::new(x[9], x[10], x[11]);
            let slope = |e: DVec3| polynomial(x, w + 0.5 * e) - polynomial(x, w - 0.5 * e);
            [DVec3::X, DVec3::Y, DVec3::Z].map(slope).to_vec()
        },
    },
    Parity {
        covers: &["direction", "angles"],
        file: "lib/shade.wgsl",
        call: "
            let w = direction(vec2f(x[0], x[1]));
            let back = angles(w);
            y = vec4f(w, cos(x[0]) * cos(back.y - x[1]) + back.x);",
        domain: "theta -1.5 to 1.5, phi -pi to pi; the angles of the direction are the angles it came from",
        tolerance: 2e-3,
        reason: "asin of f32 is good to 1e-3 near its ends on software adapters",
        calls: CALLS,
        draw: |r| vec![between(r, -1.5, 1.5), between(r, -PI, PI)],
        reference: |x| {
            let w = direction(x[0], x[1]);
            vec![w.x, w.y, w.z, x[0].cos() + x[0]]
        },
    },
    Parity {
        covers: &["mixed_params"],
        file: "lib/shade.wgsl",
        call: "
            let x01 = vec2f(x[0], x[1]);
            let x56 = vec2f(x[5], x[6]);
            let a = VertexParams(vec3f(x[0], x[1], x[2]), x[3], x[4], x[0], x[1], x[2], x01, x01.yx);
            let b = VertexParams(vec3f(x[5], x[6], x[7]), x[8], x[9], x[5], x[6], x[7], x56, x56.yx);
            let m = mixed_params(a, b, x[10]);
            y = vec4f(m.sigma_a.x + m.sigma_a.z, m.alpha_rad + m.alpha_ratios.x, m.beta_rad + m.beta_ratios.x, m.azimuthal_width + 2.0 * m.eta + 3.0 * m.eccentricity);",
        domain: "[0, 3], fraction 0 to 1",
        tolerance: 1e-6,
        reason: "sums of up to three roundings",
        calls: CALLS,
        draw: |r| {
            let mut drawn: Vec<f64> = (0..10).map(|_| between(r, 0.0, 3.0)).collect();
            drawn.push(between(r, 0.0, 1.0));
            drawn
        },
        reference: |x| {
            let mixed = |i: usize| x[i] + (x[i + 5] - x[i]) * x[10];
            let sums = [mixed(0) + mixed(2), mixed(3) + mixed(0), mixed(4) + mixed(1)];
            vec![sums[0], sums[1], sums[2], mixed(0) + 2.0 * mixed(1) + 3.0 * mixed(2)]
        },
    },
    Parity {
        covers: &["fibre_from_world"],
        file: "lib/shade.wgsl",
        call: "
            let v = RefinedVertex(vec3f(0.0), 1.0, vec3f(x[0], x[1], x[2]), 0.0, vec3f(x[3], x[4], x[5]), 0u);
            y = vec4f(fibre_from_world(v) * vec3f(x[6], x[7], x[8]), 0.0);",
        domain: "any frame and vector of the unit cube",
        tolerance: 1e-6,
        reason: "three products of rounded axes",
        calls: CALLS,
        draw: |r| {
            let axes = frame(between(r, -PI, PI), between(r, -1.5, 1.5), between(r, -PI, PI));
            let mut drawn = [axes.x_axis.to_array(), axes.y_axis.to_array()].concat();
            drawn.extend((0..3).map(|_| between(r, -1.0, 1.0)));
            drawn
        },
        reference: |x| {
            let (u, v) = (DVec3::from_slice(&x[0..3]), DVec3::from_slice(&x[3..6]));
            let w = DVec3::from_slice(&x[6..9]);
            vec![u.dot(w), v.dot(w), u.cross(v).dot(w)]
        },
    },
    Parity {
        covers: &["uv_from_direction", "turned_about_y"],
        file: "lib/environment.wgsl",
        call: "
            let w = vec3f(sin(x[0]) * sin(x[1]), cos(x[1]), -cos(x[0]) * sin(x[1]));
            let uv = uv_from_direction(w);
            let turned = uv_from_direction(turned_about_y(w, x[2]));
            y = vec4f(cos(6.2831853 * uv.x - x[0]), uv.y, sin(6.2831853 * (turned.x - uv.x) + x[2]), turned.y);",
        domain: "azimuth 0 to 2 pi, polar angle 0.1 to 3.04: u 2 pi, v pi; a turn moves u back by the angle and keeps v",
        tolerance: 1e-3,
        reason: "acos of f32 is good to 1e-3 near its ends on software adapters",
        calls: CALLS,
        draw: |r| vec![between(r, 0.0, TAU), between(r, 0.1, 3.04), between(r, -PI, PI)],
        reference: |x| vec![1.0, x[1] / PI, 0.0, x[1] / PI],
    },
    Parity {
        covers: &["pixel_cdf"],
        file: "lib/coverage.wgsl",
        call: "y.x = pixel_cdf(x[0], vec2f(cos(x[1]), sin(x[1])));",
        domain: "-1 to 1 pixel, any axis: area of the unit square below a line",
        tolerance: 1e-4,
        reason: "the ramp is at least 1e-4 wide",
        calls: CALLS,
        draw: |r| vec![between(r, -1.0, 1.0), between(r, -PI, PI)],
        reference: |x| vec![area_below(x[0], DVec2::from_angle(x[1]))],
    },
    Parity {
        covers: &["pixel_reach"],
        file: "lib/coverage.wgsl",
        call: "y.x = pixel_reach(vec2f(cos(x[0]), sin(x[0])));",
        domain: "any axis: the farthest corner of the unit square along it",
        tolerance: 1e-6,
        reason: "a sine and a cosine of f32",
        calls: CALLS,
        draw: |r| vec![between(r, -PI, PI)],
        reference: |x| {
            let axis = DVec2::from_angle(x[0]);
            let corners = [DVec2::new(0.5, 0.5), DVec2::new(0.5, -0.5)];
            vec![corners.map(|c| c.dot(axis).abs()).into_iter().fold(0.0, f64::max)]
        },
    },
    Parity {
        covers: &["pack_fragment_middle", "unpack_fragment"],
        file: "lib/fragment.wgsl",
        call: "
            let f = unpack_fragment(vec3u(bitcast<u32>(x[0]), pack_fragment_middle(x[1], x[2]), u32(x[3])));
            y = vec4f(f.coverage, f.along, f.depth / 1e3, f32(f.segment) / 1e6);",
        domain: "depth to 1000, coverage and place 0 to 1, a million segments",
        tolerance: 2e-5,
        reason: "16 bits of 0 to 1",
        calls: CALLS,
        draw: |r| {
            vec![
                log_between(r, 1e-3, 1e3),
                between(r, 0.0, 1.0),
                between(r, 0.0, 1.0),
                between(r, 0.0, 1e6).floor(),
            ]
        },
        reference: |x| vec![x[1], x[2], x[0] / 1e3, x[3] / 1e6],
    },
    Parity {
        covers: &["pixel_from_view"],
        file: "lib/camera.wgsl",
        call: "
            var c: CameraUniform;
            c.focal_px = x[0];
            c.centre_px = vec2f(x[1], x[2]);
            y = vec4f(pixel_from_view(c, vec3f(x[3], x[4], -x[5])), 0.0);",
        domain: "focal length 100 to 4000 pixels, depth 0.1 to 10",
        tolerance: 1e-6,
        reason: "three roundings",
        calls: CALLS,
        draw: |r| {
            vec![
                log_between(r, 100.0, 4e3),
                between(r, 0.0, 2e3),
                between(r, 0.0, 2e3),
                between(r, -2.0, 2.0),
                between(r, -2.0, 2.0),
                log_between(r, 0.1, 10.0),
            ]
        },
        reference: |x| vec![x[1] + x[0] * x[3] / x[5], x[2] - x[0] * x[4] / x[5], x[5]],
    },
    Parity {
        covers: &["outline_width"],
        file: "lib/camera.wgsl",
        call: "
            var c: CameraUniform;
            c.focal_px = x[0];
            c.width_factor = x[7];
            y.x = outline_width(c, vec3f(x[1], x[2], -x[3]), vec3f(x[1] + x[4], x[2] + x[5], -x[3] + x[6]));",
        domain: "fields of view up to 90 degrees, segments in many directions; the reference projects points of both outlines",
        tolerance: 1e-4,
        reason: "a short segment is a difference of two places",
        calls: CALLS,
        draw: |r| {
            let depth = log_between(r, 1.0, 10.0);
            let (theta, phi) = (between(r, -1.2, 1.2), between(r, -PI, PI));
            let step = log_between(r, 0.01, 0.5) * direction(theta, phi);
            vec![
                log_between(r, 100.0, 4e3),
                depth * between(r, -1.0, 1.0),
                depth * between(r, -1.0, 1.0),
                depth,
                step.y,
                step.x,
                0.3 * step.z,
                log_between(r, 1.0, 64.0),
            ]
        },
        reference: |x| {
            let (a, b) = (DVec3::new(x[1], x[2], -x[3]), DVec3::new(x[1] + x[4], x[2] + x[5], -x[3] + x[6]));
            let pixel = |p: DVec3| DVec2::new(p.x, -p.y) * (x[0] / -p.z);
            let tiny = 1e-5 * x[3];
            let beside = a.cross(b).normalize() * (0.5 * tiny);
            let line = (pixel(b) - pixel(a)).normalize();
            let width = (pixel(a + beside) - pixel(a - beside)).perp_dot(line).abs();
            vec![x[7] * width / tiny * x[3]]
        },
    },
    Parity {
        covers: &["common_depth"],
        file: "lib/hot_spot.wgsl",
        call: "
            let eye = vec3f(sin(x[0]), cos(x[0]) * cos(x[1]), cos(x[0]) * sin(x[1]));
            let light = vec3f(sin(x[2]), cos(x[2]) * cos(x[3]), cos(x[2]) * sin(x[3]));
            y.x = common_depth(vec2f(x[4], 0.0), eye, light, 0.0);",
        domain: "parallel fibres, azimuths 0.3 to 2.9 apart; the reference counts the places from which a fibre hides both ways",
        tolerance: 0.01,
        reason: "the places are counted on a grid",
        calls: 256,
        draw: |r| {
            let phi = between(r, -PI, PI);
            vec![
                between(r, -1.2, 1.2),
                phi,
                between(r, -1.2, 1.2),
                phi + between(r, 0.3, 2.9),
                between(r, 0.001, 0.1),
            ]
        },
        reference: |x| {
            // In the plane across fibres of radius 1 there are 4 filled / diameter^2 = `filled` axes per area.
            let (eye, light) = (DVec2::from_angle(x[1]), DVec2::from_angle(x[3]));
            let hides = |p: DVec2, way: DVec2| p.dot(way) > 0.0 && p.perp_dot(way).abs() < 1.0;
            let (reach, steps) = (8.0, 800);
            let cell = 2.0 * reach / f64::from(steps);
            let place = |i: i32| (f64::from(i) + 0.5) * cell - reach;
            let count = (0..steps * steps)
                .map(|i| DVec2::new(place(i % steps), place(i / steps)))
                .filter(|p| hides(*p, eye) && hides(*p, light))
                .count();
            vec![x[4] * cell * cell * count as f64]
        },
    },
    Parity {
        covers: &["world_from_lobe"],
        file: "lib/lobe_light.wgsl",
        call: "
            var light: LobeLight;
            light.axis = vec3f(0.0, 0.0, 1.0);
            light.tangent = vec3f(1.0, 0.0, 0.0);
            light.bitangent = vec3f(0.0, 1.0, 0.0);
            y = vec4f(world_from_lobe(light, vec3f(x[0], x[1], x[2]), vec2f(cos(x[3]), sin(x[3]))), 0.0);",
        domain: "any vector of the unit cube, any turn about the axis",
        tolerance: 1e-6,
        reason: "a sine and a cosine of f32",
        calls: CALLS,
        draw: |r| {
            let mut drawn: Vec<f64> = (0..3).map(|_| between(r, -1.0, 1.0)).collect();
            drawn.push(between(r, -PI, PI));
            drawn
        },
        reference: |x| {
            let turned = DVec2::from_angle(x[3]).rotate(DVec2::new(x[0], x[1]));
            vec![turned.x, turned.y, x[2]]
        },
    },
];

#[test]
fn geometry_agrees_with_float64() {
    hold(PARITIES);
}
