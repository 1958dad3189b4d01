//! Guards, the fibre, and the tables of the integrals.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use balayage_render::optics::azimuthal::CrossSection;
use balayage_render::optics::bessel::i0e;
use balayage_render::optics::fresnel::fresnel;
use balayage_render::optics::{Direction, Fibre, scattering_function};

use glam::{DMat3, DVec3};

use super::geometry::direction;
use super::{CALLS, Parity, between, hold, log_between};

/// Mean of `f` over the von Mises density of concentration kappa around zero, by the trapezoid rule, which converges spectrally.
fn von_mises_mean(kappa: f64, f: impl Fn(f64) -> f64) -> f64 {
    let steps = 4096;
    let (mut sum, mut norm) = (0.0, 0.0);
    for i in 0..steps {
        // Shifted by a half, so that a kink at zero or pi weighs alike on both sides.
        let x = TAU * ((f64::from(i) + 0.5) / f64::from(steps)) - PI;
        let density = (kappa * (x.cos() - 1.0)).exp();
        sum += density * f(x);
        norm += density;
    }
    sum / norm
}

/// A light of concentration `light` around an azimuth `x` off, smoothed by the normalised circular Gaussian of sharpness `smooth`.
fn von_mises_mean_of(smooth: f64, light: f64, x: f64) -> f64 {
    let steps = 512;
    let (mut sum, mut norm) = (0.0, 0.0);
    for i in 0..steps {
        let t = TAU * (f64::from(i) + 0.5) / f64::from(steps) - PI;
        let density = (smooth * (t.cos() - 1.0)).exp();
        sum += density * (light * ((x - t).cos() - 1.0)).exp();
        norm += density;
    }
    sum / norm
}

pub const PARITIES: &[Parity] = &[
    Parity {
        covers: &["guarded"],
        file: "lib/maths.wgsl",
        call: "
            let nan = bitcast<f32>(0x7fc00000u);
            y.x = guarded(x[0], -1.0, 2.0, 0.5);
            y.y = guarded(select(nan, -nan, x[0] > 0.0), -1.0, 2.0, 0.5);
            y.z = guarded(bitcast<f32>(0x7f800000u), -1.0, 2.0, 0.5);
            y.w = guarded(bitcast<f32>(0xff800000u), -1.0, 2.0, 0.5);",
        domain: "[-1e30, 1e30], NaN of either sign, both infinities",
        tolerance: 0.0,
        reason: "exact",
        calls: CALLS,
        draw: |r| vec![between(r, -1.0, 1.0).signum() * log_between(r, 1e-30, 1e30)],
        reference: |x| vec![x[0].clamp(-1.0, 2.0), 0.5, 2.0, -1.0],
    },
    Parity {
        covers: &["guarded_azimuth", "wrapped"],
        file: "lib/maths.wgsl",
        call: "
            y.x = cos(guarded_azimuth(x[0]));
            y.y = sin(wrapped(x[0]));
            y.z = guarded_azimuth(bitcast<f32>(0x7fc00000u)) + guarded_azimuth(1e7);
            y.w = max(abs(wrapped(x[0])) - 3.1416, 0.0);",
        domain: "|phi| <= 20 by its cosine and sine; NaN and 1e7 count as 0; the result is in [-pi, pi]",
        tolerance: 3e-6,
        reason: "f32 holds 2 pi to 1.7e-7 of each of three turns, sines and cosines of f32 are good to 5e-7",
        calls: CALLS,
        draw: |r| vec![between(r, -20.0, 20.0)],
        reference: |x| vec![x[0].cos(), x[0].sin()],
    },
    Parity {
        covers: &["guarded_fibre", "fibre_from_params"],
        file: "lib/fibre.wgsl",
        call: "
            let f = fibre_from_params(VertexParams(vec3f(x[0], x[1], x[2]), x[3], x[4], x[5], x[6], x[7],
                vec2f(-0.5, -1.5), vec2f(0.5, 2.0)));
            y = select(select(vec4f(f.sigma_a, f.eta), vec4f(f.alpha, f.azimuthal_width), x[8] == 1.0),
                vec4f(f.beta, f.eccentricity), x[8] == 2.0);",
        domain: "every field from far below to far above its range",
        tolerance: 1e-6,
        reason: "one rounding of a product",
        calls: CALLS,
        draw: |r| {
            let mut wide = || between(r, -1.0, 1.0).signum() * log_between(r, 1e-6, 1e6);
            let mut drawn: Vec<f64> = (0..8).map(|_| wide()).collect();
            drawn.push(between(r, 0.0, 3.0).floor());
            drawn
        },
        reference: |x| match x[8] as u32 {
            0 => vec![x[0].clamp(0.0, 1e4), x[1].clamp(0.0, 1e4), x[2].clamp(0.0, 1e4), x[6].clamp(1.0, 3.0)],
            1 => {
                let tilt = |ratio: f64| (x[3] * ratio).clamp(-FRAC_PI_2, FRAC_PI_2);
                vec![tilt(1.0), tilt(-0.5), tilt(-1.5), x[5].clamp(1e-3, 4.0)]
            }
            _ => {
                let width = |ratio: f64| (x[4] * ratio).clamp(1e-3, 1.5);
                vec![width(1.0), width(0.5), width(2.0), x[7].clamp(0.5, 2.0)]
            }
        },
    },
    Parity {
        covers: &["eccentric_index"],
        file: "lib/fibre.wgsl",
        call: "let i = eccentric_index(x[0], x[1]); y.x = i.x + i.y * cos(x[2]);",
        domain: "eta 1 to 3, a 0.5 to 2, any 2 phi_h",
        tolerance: 1e-6,
        reason: "four roundings",
        calls: CALLS,
        draw: |r| vec![between(r, 1.0, 3.0), between(r, 0.5, 2.0), between(r, -PI, PI)],
        reference: |x| {
            // Xu 2011, Eq 24, as printed.
            let index = |a: f64| 2.0 * (x[0] - 1.0) * a * a - x[0] + 2.0;
            let (eta_1, eta_2) = (index(x[1]), index(1.0 / x[1]));
            vec![0.5 * ((eta_1 + eta_2) + x[2].cos() * (eta_1 - eta_2))]
        },
    },
    Parity {
        covers: &["refraction"],
        file: "lib/fibre.wgsl",
        call: "let r = refraction(x[0], x[1]); y = vec4f(r.eta_p * x[1], r.inv_cos_theta_t, r.eta, r.cos_theta_d);",
        domain: "eta 1 to 3, cos theta_d 0.01 to 1; eta' times cos theta_d, which has no pole",
        tolerance: 1e-6,
        reason: "five roundings: nothing cancels",
        calls: CALLS,
        draw: |r| vec![between(r, 1.0001, 3.0), between(r, 0.01, 1.0)],
        reference: |x| {
            let sin2_d = 1.0 - x[1] * x[1];
            vec![
                (x[0] * x[0] - sin2_d).sqrt(),
                1.0 / (1.0 - sin2_d / (x[0] * x[0])).sqrt(),
                x[0],
                x[1],
            ]
        },
    },
    Parity {
        covers: &["fresnel_dielectric", "fresnel_at"],
        file: "lib/fibre.wgsl",
        call: "y.x = fresnel_dielectric(x[0], x[1]);",
        domain: "cos 0 to 1, eta 1 to 3",
        tolerance: 1e-5,
        reason: "differences of cosines that are near each other for small eta",
        calls: CALLS,
        draw: |r| vec![between(r, 0.0, 1.0), between(r, 1.0, 3.0)],
        reference: |x| vec![fresnel(x[1], x[0])],
    },
    Parity {
        covers: &["path_at", "passage_at"],
        file: "lib/paths.wgsl",
        call: "
            let p = path_at(refraction(x[0], x[1]), vec3f(x[2]), u32(x[3]), sin(x[4]), cos(x[4]));
            y = vec4f(p.energy.x, p.exit, p.spread * p.energy.y);",
        domain: "eta 1.2 to 2.5, cos theta_d 0.1 to 1, sigma_a 0 to 5, p 0 to 2, gamma 0 to 1.5",
        tolerance: 5e-6,
        reason: "Fresnel's 2e-6 squared; the exit azimuth is twice a sum of angles",
        calls: CALLS,
        draw: |r| {
            vec![
                between(r, 1.2, 2.5),
                between(r, 0.1, 1.0),
                between(r, 0.0, 5.0),
                between(r, 0.0, 3.0).floor(),
                between(r, 0.0, 1.5),
            ]
        },
        reference: |x| {
            let section = CrossSection::new(x[0], x[1].acos());
            let energy = section.attenuation(x[3] as u32, x[4], &[x[2]; 3])[0];
            let eta_p = (x[0] * x[0] - 1.0 + x[1] * x[1]).sqrt() / x[1];
            let azimuth = |gamma: f64| 2.0 * x[3] * (gamma.sin() / eta_p).asin() - 2.0 * gamma + x[3] * PI;
            let step = 1e-6;
            let slope = (azimuth(x[4] + step) - azimuth(x[4] - step)) / (2.0 * step);
            let phi = azimuth(x[4]);
            vec![energy, phi.cos(), phi.sin(), slope.abs() * energy]
        },
    },
    Parity {
        covers: &["absorption", "absorbed"],
        file: "lib/paths.wgsl",
        call: "let r = refraction(x[0], x[1]); y.x = absorbed(absorption(r, vec3f(x[2]), u32(x[3])), sqrt(1.0 - x[4] * x[4] / (r.eta_p * r.eta_p))).x;",
        domain: "eta 1.2 to 2.5, cos theta_d 0.1 to 1, sigma_a 0 to 5, p 1 or 2, h 0 to 1",
        tolerance: 1e-3,
        reason: "a polynomial about the middle of the chords: its error is a share of a dying exponential",
        calls: CALLS,
        draw: |r| {
            vec![
                between(r, 1.2, 2.5),
                between(r, 0.1, 1.0),
                between(r, 0.0, 5.0),
                between(r, 1.0, 3.0).floor(),
                between(r, 0.0, 1.0),
            ]
        },
        reference: |x| {
            let eta_cos = (x[0] * x[0] - 1.0 + x[1] * x[1]).sqrt();
            let cos_gamma_t = (1.0 - (x[4] * x[1] / eta_cos).powi(2)).sqrt();
            vec![(-2.0 * x[3] * x[2] * cos_gamma_t * x[0] / eta_cos).exp()]
        },
    },
    Parity {
        covers: &["sine", "cosine", "doubled_angle"],
        file: "lib/maths.wgsl",
        call: "y = vec4f(sine(x[0]), cosine(x[0]), doubled_angle(vec2f(cosine(x[0]), sine(x[0]))));",
        domain: "[-pi/2, pi/2]",
        tolerance: 1e-6,
        reason: "f32 holds the argument to 1e-7; the polynomial is good to 4e-9",
        calls: CALLS,
        draw: |r| vec![between(r, -FRAC_PI_2, FRAC_PI_2)],
        reference: |x| vec![x[0].sin(), x[0].cos(), (2.0 * x[0]).cos(), (2.0 * x[0]).sin()],
    },
    Parity {
        covers: &["table_slot"],
        file: "lib/tables.wgsl",
        call: "let s = table_slot(x[0], 64u); y = vec4f(f32(s.index) + s.fraction, f32(s.index > 63u), 0.0, 0.0);",
        domain: "[-1, 2], 64 intervals",
        tolerance: 1e-6,
        reason: "one product",
        calls: CALLS,
        draw: |r| vec![between(r, -1.0, 2.0)],
        reference: |x| vec![64.0 * x[0].clamp(0.0, 1.0)],
    },
    Parity {
        covers: &["truncated_gauss"],
        file: "lib/tables.wgsl",
        call: "
            for (var k = 0u; k < u32(x[0]); k++) {
                let rule = truncated_gauss(u32(x[0]), k, x[1]);
                y += rule.y * vec4f(1.0, rule.x, rule.x * rule.x, rule.x * rule.x * rule.x);
            }",
        domain: "2 to 6 nodes, truncated at -1.9 to 2.9: moments 0 to 3 of exp(-x^2)",
        tolerance: 3e-3,
        reason: "nodes and weights are linear between 64 places of the truncation",
        calls: 200,
        draw: |r| vec![between(r, 2.0, 7.0).floor(), between(r, -1.9, 2.9)],
        reference: |x| {
            let steps = 4000;
            let low = -8.0;
            let width = (x[1] - low) / f64::from(steps);
            let mut moments = vec![0.0; 4];
            for i in 0..steps {
                let t = low + (f64::from(i) + 0.5) * width;
                for (power, moment) in moments.iter_mut().enumerate() {
                    *moment += width * (-t * t).exp() * t.powi(power as i32);
                }
            }
            moments
        },
    },
    Parity {
        covers: &["gamma_node"],
        file: "lib/tables.wgsl",
        call: "
            for (var k = 0u; k < u32(x[0]); k++) {
                let node = gamma_node(u32(x[0]), k);
                y += vec4f(node.w, node.z, node.w * node.x * node.y, node.w * (node.x * node.x + node.y * node.y));
            }",
        domain: "3 to 16 nodes: integrals over [0, pi/2] of 1, cos / 2, sin cos and sin^2 + cos^2",
        tolerance: 1e-3,
        reason: "three nodes integrate sin cos to 3e-4",
        calls: CALLS,
        draw: |r| vec![between(r, 3.0, 17.0).floor()],
        reference: |_| vec![FRAC_PI_2, 0.5, 0.5, FRAC_PI_2],
    },
    Parity {
        covers: &["concentration_coordinate", "von_mises"],
        file: "lib/tables.wgsl",
        call: "
            let v = von_mises(x[0]);
            let one_minus_cos = 2.0 * v.half.y * v.half.y;
            let c = 1.0 - one_minus_cos;
            y.x = v.i0e * sqrt(1.0 + x[0]);
            y.y = (1.0 - 2.0 * v.outer_weight * one_minus_cos - x[1]) * (1.0 + x[0]);
            y.z = 1.0 - 2.0 * v.outer_weight * (2.0 - 2.0 * c * c) - x[2];
            y.w = concentration_coordinate(x[0]);",
        domain: "kappa 1e-3 to 1e4: i0e, and the means of cos x and cos 2x by the three nodes less the true ones",
        tolerance: 1e-3,
        reason: "entries are linear between 256 places; the means' errors are held against 1 / (1 + kappa) and 1",
        calls: 200,
        draw: |r| {
            let kappa = log_between(r, 1e-3, 1e4);
            let kappa = f64::from(kappa as f32);
            let wide = |m: f64| von_mises_mean(kappa, |x| (m * x).cos());
            vec![kappa, wide(1.0), wide(2.0)]
        },
        reference: |x| vec![i0e(x[0]) * (1.0 + x[0]).sqrt(), 0.0, 0.0, 1.0 / (1.0 + x[0].sqrt())],
    },
    Parity {
        covers: &["convolved"],
        file: "lib/tables.wgsl",
        call: "y.x = convolved(x[0], von_mises(x[0]).convolution, x[1]) * x[2];",
        domain: "kappa 0.1 to 300 with a density of kappa 10 to 300: 1 / kappa of the density whose mean cosine is the product of theirs",
        tolerance: 0.01,
        reason: "the approximation is exact for the first order in 1 / kappa_2",
        calls: 50,
        draw: |r| {
            let kappa = f64::from(log_between(r, 0.1, 300.0) as f32);
            let other = f64::from(log_between(r, 10.0, 300.0) as f32);
            let mean = |kappa: f64| von_mises_mean(kappa, f64::cos);
            let target = mean(kappa) * mean(other);
            let (mut low, mut high) = (0.0, kappa);
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                if mean(middle) < target { low = middle } else { high = middle }
            }
            vec![kappa, other, 1.0 / high]
        },
        reference: |_| vec![1.0],
    },
    Parity {
        covers: &["mean_cosine_powers"],
        file: "lib/tables.wgsl",
        call: "let p = mean_cosine_powers(x[0], x[1]); y = vec4f(p.low.x, p.low.z, p.high.x, p.high.w);",
        domain: "kappa 1e-3 to 2e3, y 0 to 1: powers 1, 3, 5 and 8 of |cos(phi/2)|",
        tolerance: 5e-3,
        reason: "bilinear between 64 x 64 places",
        calls: 200,
        draw: |r| vec![log_between(r, 1e-3, 2e3), between(r, 0.0, 1.0)],
        reference: |x| {
            let centre = 2.0 * x[1].acos();
            [1, 3, 5, 8]
                .map(|power| von_mises_mean(x[0], |t| (0.5 * (centre + t)).cos().abs().powi(power)))
                .to_vec()
        },
    },
    Parity {
        covers: &["window_cosine_powers"],
        file: "lib/tables.wgsl",
        call: "let p = window_cosine_powers(x[0]); y = vec4f(p.low.x, p.low.z, p.high.x, p.high.w);",
        domain: "y 0 to 1: powers 1, 3, 5 and 8",
        tolerance: 5e-4,
        reason: "linear between 64 places",
        calls: 200,
        draw: |r| vec![between(r, 0.0, 1.0)],
        reference: |x| {
            let centre = 2.0 * x[0].acos();
            let steps = 2000;
            [1, 3, 5, 8]
                .map(|power| {
                    let at = |i: i32| centre + PI * ((f64::from(i) + 0.5) / f64::from(steps) - 0.5);
                    (0..steps).map(|i| (0.5 * at(i)).cos().abs().powi(power)).sum::<f64>() / f64::from(steps)
                })
                .to_vec()
        },
    },
    Parity {
        covers: &["fresnel_polynomial"],
        file: "lib/tables.wgsl",
        call: "
            let f = fresnel_polynomial(x[0]);
            let c = x[1];
            let p = vec4f(1.0, c, c * c, c * c * c);
            y.x = dot(f.low, p) + p.w * c * dot(f.high, p);",
        domain: "eta 1.2 to 2, cos 0.05 to 1",
        tolerance: 0.01,
        reason: "a polynomial of degree 7, least squares: worst where the reflectance rises to one",
        calls: CALLS,
        draw: |r| vec![between(r, 1.2, 2.0), between(r, 0.05, 1.0)],
        reference: |x| vec![fresnel(x[0], x[1])],
    },
    Parity {
        covers: &["azimuth_r", "mean_n_r"],
        file: "lib/azimuth_r.wgsl",
        call: "y.x = azimuth_r(fresnel_polynomial(x[0]), x[1], x[2], x[3]);",
        domain: "eta 1.3 to 1.8, cos theta_d 0.3 to 1, kappa 0.1 to 500, y 0 to 1",
        tolerance: 3e-3,
        reason: "the polynomial of the reflectance and the table of the cosine's powers",
        calls: 200,
        draw: |r| vec![between(r, 1.3, 1.8), between(r, 0.3, 1.0), log_between(r, 0.1, 500.0), between(r, 0.0, 1.0)],
        reference: |x| {
            let centre = 2.0 * x[3].acos();
            let n_r = |phi: f64| {
                let c = (0.5 * phi).cos().abs();
                0.25 * c * fresnel(x[0], x[1] * c)
            };
            vec![TAU * i0e(x[2]) * von_mises_mean(x[2], |t| n_r(centre + t))]
        },
    },
    Parity {
        covers: &["n_tt"],
        file: "lib/azimuth_tt.wgsl",
        call: "let r = refraction(x[0], x[1]); y.x = n_tt(r, absorption(r, vec3f(x[2]), 1u), abs(sin(0.5 * x[3]))).x;",
        domain: "eta 1.3 to 1.8, cos theta_d 0.3 to 1, sigma_a 0 to 3, all azimuths",
        tolerance: 2e-4,
        reason: "the absorption's polynomial; a few roundings: nothing cancels at the lobe's edge",
        calls: CALLS,
        draw: |r| vec![between(r, 1.3, 1.8), between(r, 0.3, 1.0), between(r, 0.0, 3.0), between(r, -PI, PI)],
        reference: |x| vec![CrossSection::new(x[0], x[1].acos()).n_smooth(1, &[x[2]; 3], x[3])[0]],
    },
    Parity {
        covers: &["azimuth_tt"],
        file: "lib/azimuth_tt.wgsl",
        call: "y.x = azimuth_tt(refraction(x[0], x[1]), vec3f(x[2]), x[3], vec2f(cos(0.5 * x[4]), sin(0.5 * x[4]))).x;",
        domain: "eta 1.3 to 1.8, cos theta_d 0.3 to 1, sigma_a 0 to 3, kappa 0.1 to 500, all azimuths",
        tolerance: 0.03,
        reason: "three nodes of a light as wide as an edge of the lobe",
        calls: 200,
        draw: |r| {
            vec![
                between(r, 1.3, 1.8),
                between(r, 0.3, 1.0),
                between(r, 0.0, 3.0),
                log_between(r, 0.1, 500.0),
                between(r, -PI, PI),
            ]
        },
        reference: |x| {
            let section = CrossSection::new(x[0], x[1].acos());
            let n = |phi: f64| section.n_smooth(1, &[x[2]; 3], phi)[0];
            vec![TAU * i0e(x[3]) * von_mises_mean(x[3], |t| n(x[4] - t))]
        },
    },
    Parity {
        covers: &["azimuth_trt", "trt_path"],
        file: "lib/azimuth_trt.wgsl",
        call: "y.x = azimuth_trt(refraction(x[0], x[1]), vec3f(x[2]), x[3], x[4], vec2f(cos(0.5 * x[5]), sin(0.5 * x[5]))).x;",
        domain: "eta 1.3 to 1.8, cos theta_d 0.4 to 1, sigma_a 0 to 2, w_c 0.1 to 0.45, kappa 0.5 to 200, all azimuths",
        tolerance: 0.06,
        reason: "five nodes of gamma: ripples where light and w_c are narrow",
        calls: 100,
        draw: |r| {
            vec![
                between(r, 1.3, 1.8),
                between(r, 0.4, 1.0),
                between(r, 0.0, 2.0),
                between(r, 0.1, 0.45),
                log_between(r, 0.5, 200.0),
                between(r, -PI, PI),
            ]
        },
        reference: |x| {
            // The energy of every gamma leaves at its azimuth, smoothed by w_c and gathered by the light.
            let section = CrossSection::new(x[0], x[1].acos());
            let eta_p = (x[0] * x[0] - 1.0 + x[1] * x[1]).sqrt() / x[1];
            let smooth = 2.0 / (x[3] * x[3]);
            let gathered: Vec<f64> = (0..720)
                .map(|i| von_mises_mean_of(smooth, x[4], f64::from(i) * TAU / 720.0))
                .collect();
            let steps = 2000;
            let mut sum = 0.0;
            for i in 0..steps {
                let gamma = FRAC_PI_2 * ((f64::from(i) + 0.5) / f64::from(steps) * 2.0 - 1.0);
                let phi = 4.0 * (gamma.sin() / eta_p).asin() - 2.0 * gamma;
                let place = (x[5] - phi).rem_euclid(TAU) / TAU * 720.0;
                let (low, part) = (place.floor() as usize, place.fract());
                let light = gathered[low % 720] + (gathered[(low + 1) % 720] - gathered[low % 720]) * part;
                sum += section.attenuation(2, gamma, &[x[2]; 3])[0] * gamma.cos() * light;
            }
            vec![0.5 * sum * PI / f64::from(steps)]
        },
    },
    Parity {
        covers: &["product_gaussian", "outer_node"],
        file: "lib/longitudinal.wgsl",
        call: "
            let inv_lambda_sq = 1.0 / (x[4] * x[4]);
            let g = product_gaussian(x[0], x[1], x[2], x[3], inv_lambda_sq);
            for (var k = 0u; k < 6u; k++) {
                y.x += outer_node(g, 6u, k, x[0], x[1], x[2], x[3], inv_lambda_sq, false).weight;
            }",
        domain: "means -1.4 to 1.4, beta 0.03 to 0.3, |theta_o| <= 1.4, |theta_j| <= 1.5, lambda 0.06 to 1.4: integral over theta_i",
        tolerance: 2e-3,
        reason: "six nodes; the rule is linear between 64 places of the truncation",
        calls: 200,
        draw: |r| {
            vec![
                between(r, -1.4, 1.4),
                log_between(r, 0.03, 0.3),
                between(r, -1.4, 1.4),
                between(r, -1.5, 1.5),
                log_between(r, 0.06, 1.4),
            ]
        },
        reference: |x| {
            let steps = 20_000;
            let width = PI / f64::from(steps);
            let std = 2.0 * x[1];
            let at = |theta: f64| {
                let light = (-(2.0 * (0.5 * (theta - x[3])).sin() / x[4]).powi(2)).exp();
                let m = (-0.5 * ((theta - x[0]) / std).powi(2)).exp() / (TAU.sqrt() * std);
                light * m * (theta.cos() / (0.5 * (x[2] - theta)).cos()).powi(2)
            };
            vec![(0..steps).map(|i| width * at(width * (f64::from(i) + 0.5) - FRAC_PI_2)).sum()]
        },
    },
    Parity {
        covers: &["lobe_means", "lobe_concentrations", "seen_light", "mean_seen", "azimuth_vector"],
        file: "lib/single.wgsl",
        call: "
            let f = Fibre(vec3f(0.3), 1.55, vec3f(-0.07, 0.035, 0.105), 1.0, vec3f(0.1, 0.05, 0.2), 0.25);
            let light = vec3f(sine(x[2]), cosine(x[2]) * azimuth_vector(0.5));
            let seen = seen_light(x[5], vec3f(x[6], x[7], x[8]), light, x[3], 1.0);
            let means = lobe_means(prepare_view(f, x[0], x[1]), x[2], 0.5, x[3], seen);
            y.x = means[u32(x[4])];",
        domain: "narrow lights, lambda 0.01 to 0.03, inside the lobe: the mean over the light",
        tolerance: 0.04,
        reason: "a lobe moves the mean by at most three bandwidths",
        calls: CALLS,
        draw: |r| {
            let theta_o = between(r, -0.8, 0.8);
            vec![
                theta_o,
                between(r, -PI, PI),
                -theta_o + between(r, -0.1, 0.1),
                between(r, 0.01, 0.03),
                between(r, 0.0, 3.0).floor(),
                between(r, 0.0, 1.0),
                between(r, -1.0, 1.0),
                between(r, -1.0, 1.0),
                between(r, -1.0, 1.0),
            ]
        },
        reference: |x| vec![x[5]],
    },
    Parity {
        covers: &["lobe_means", "seen_light", "mean_seen"],
        file: "lib/single.wgsl",
        call: "
            let f = Fibre(vec3f(0.3), 1.55, vec3f(-0.07, 0.035, 0.105), 1.0, vec3f(0.1, 0.05, 0.2), 0.25);
            let light = vec3f(sine(x[2]), cosine(x[2]) * azimuth_vector(0.5));
            let kappa = 2.0 / (x[3] * x[3]);
            let mean_cosine = 1.0 / tanh(kappa) - 1.0 / kappa;
            let seen = seen_light(x[8], vec3f(x[9], x[10], x[11]), light, x[3], mean_cosine);
            let view = prepare_view(f, x[0], x[1]);
            let lobes = single_scattering(view, x[2], 0.5, x[3]);
            let sent = vec3f(lobes.r.x, lobes.tt.x, lobes.trt.x);
            y.x = dot(sent, lobe_means(view, x[2], 0.5, x[3], seen)) / dot(sent, vec3f(1.0));",
        domain: "lambda 0.3 to 1.2 within half a radian of the lobe, visibility Phi(t + s . w) from gradual to half-spaces: share of G S cos theta_i that is seen",
        tolerance: 0.35,
        reason: "every lobe is one von Mises density of N_t's mean direction, and a wide light is no normal in the plane",
        calls: 96,
        draw: |r| {
            let theta_o = between(r, -0.8, 0.8);
            let (theta_j, lambda) = (-theta_o + between(r, -0.5, 0.5), between(r, 0.3, 1.2));
            let t = between(r, -1.0, 1.0);
            let steep = log_between(r, 0.3, 20.0);
            let towards = direction(between(r, -1.5, 1.5), between(r, -PI, PI));
            // The half-space's edge lies within the light.
            let centre = direction(theta_j, 0.5);
            let (s, t) = (steep * towards, steep * (0.5 * lambda * t - towards.dot(centre)));
            // The regression of visibility on directions over the light, as records hold it.
            let (mut whole, mut mean, mut at) = (0.0, 0.0, DVec3::ZERO);
            let (mut product, mut square) = (DVec3::ZERO, DMat3::ZERO);
            for w in sphere() {
                let share = light_towards(centre, lambda, w) * cosine_of(w);
                let seen = normal_below(t + s.dot(w));
                whole += share;
                mean += share * seen;
                at += share * w;
                product += share * seen * w;
                square += DMat3::from_cols(w * w.x, w * w.y, w * w.z) * share;
            }
            let (mean, at) = (mean / whole, at / whole);
            let covariance = square * (1.0 / whole) - DMat3::from_cols(at * at.x, at * at.y, at * at.z);
            let change = covariance.inverse() * (product / whole - mean * at);
            vec![
                theta_o,
                between(r, -PI, PI),
                theta_j,
                lambda,
                t,
                s.x,
                s.y,
                s.z,
                mean,
                change.x,
                change.y,
                change.z,
            ]
        },
        reference: |x| {
            let tilt = f64::from(-0.07_f32);
            let fibre = Fibre {
                eta: 1.55,
                eccentricity: 1.0,
                sigma_a: [0.3; 3],
                alpha: [tilt, -0.5 * tilt, -1.5 * tilt],
                beta: [0.1, 0.05, 0.2],
                azimuthal_width: 0.25,
            };
            let view = Direction { theta: x[0], phi: x[1] };
            let centre = direction(x[2], 0.5);
            let (mut sum, mut whole) = (0.0, 0.0);
            for w in sphere() {
                let at = Direction {
                    theta: w.x.asin(),
                    phi: w.z.atan2(w.y),
                };
                let seen = normal_below(x[4] + w.dot(DVec3::new(x[5], x[6], x[7])));
                let lobes = scattering_function(&fibre, at, view, 1e-2).unwrap();
                // Once for the fibre's projected width, once for the grid.
                let sent = light_towards(centre, x[3], w) * lobes.sum()[0] * cosine_of(w) * cosine_of(w);
                sum += sent * seen;
                whole += sent;
            }
            vec![sum / whole]
        },
    },
];

/// Directions on a grid of even steps in inclination and azimuth; [`cosine_of`] weighs them.
fn sphere() -> impl Iterator<Item = DVec3> {
    let (rows, columns) = (64, 48);
    (0..rows * columns).map(move |i| {
        let theta = PI * ((f64::from(i / columns) + 0.5) / f64::from(rows) - 0.5);
        direction(theta, TAU * (f64::from(i % columns) + 0.5) / f64::from(columns))
    })
}

/// Cosine of the inclination.
fn cosine_of(w: DVec3) -> f64 {
    (1.0 - w.x * w.x).max(0.0).sqrt()
}

fn light_towards(centre: DVec3, lambda: f64, w: DVec3) -> f64 {
    (2.0 * (centre.dot(w) - 1.0) / (lambda * lambda)).exp()
}

/// Share of the normal distribution below `x`, within 1e-3: Simpson's rule on its density.
fn normal_below(x: f64) -> f64 {
    let (x, steps) = (x.clamp(-6.0, 6.0), 32);
    let density = |t: f64| (-0.5 * t * t).exp() / TAU.sqrt();
    let width = x / f64::from(steps);
    let sum: f64 = (0..steps)
        .map(|i| {
            let left = width * f64::from(i);
            density(left) + 4.0 * density(left + 0.5 * width) + density(left + width)
        })
        .sum();
    0.5 + sum * width / 6.0
}

#[test]
fn maths_and_tables_agree_with_float64() {
    hold(PARITIES);
}
