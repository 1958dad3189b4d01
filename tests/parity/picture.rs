//! View transforms.

use super::{CALLS, Parity, between, hold, log_between};

/// Khronos PBR Neutral of a grey, by its specification: an offset below 0.08, a knee at 0.76, no chroma to lose.
fn neutral_grey(x: f64) -> f64 {
    let offset = if x < 0.08 { x - 6.25 * x * x } else { 0.04 };
    let peak = x - offset;
    let knee = 0.76;
    if peak < knee {
        return peak;
    }
    1.0 - (1.0 - knee).powi(2) / (peak + 1.0 - 2.0 * knee)
}

pub const PARITIES: &[Parity] = &[
    Parity {
        covers: &["pbr_neutral"],
        file: "lib/view.wgsl",
        call: "
            let grey = pbr_neutral(vec3f(x[0]));
            let colour = pbr_neutral(vec3f(x[1], 0.5 * x[1], 0.08));
            y = vec4f(grey.x, grey.y - grey.z, max(colour.x - 1.0, 0.0), select(0.0, colour.x - x[1] + 0.04, x[1] < 0.8));",
        domain: "greys 1e-4 to 1e4 by the specification; a colour stays below 1, and less its offset what it was below the knee",
        tolerance: 1e-6,
        reason: "a few roundings",
        calls: CALLS,
        draw: |r| vec![log_between(r, 1e-4, 1e4), log_between(r, 0.16, 1e3)],
        reference: |x| vec![neutral_grey(x[0])],
    },
    Parity {
        covers: &["agx", "agx_curve"],
        file: "lib/view.wgsl",
        call: "
            let h = 1e-3;
            let grey = agx(vec3f(x[0]));
            y.x = max(grey.x - grey.y, grey.y - grey.x);
            y.y = agx_curve(0.0) + agx_curve(1.0);
            y.z = (agx_curve(0.6060606 + h) - agx_curve(0.6060606 - h)) / (2.0 * h);
            y.w = agx(vec3f(0.18)).x + select(0.0, 1.0, agx_curve(x[1]) > agx_curve(x[1] + 0.01));",
        domain: "greys stay grey; the curve ends at 0 and 1, has slope 2.4 at the pivot, rises; middle grey is 0.18^(2.2 / 2.4)",
        tolerance: 1e-3,
        reason: "the inset's rows sum to one within 2e-4, and a difference over 2e-3 has two digits less",
        calls: CALLS,
        draw: |r| vec![log_between(r, 1e-4, 1e3), between(r, 0.0, 0.98)],
        reference: |_| vec![0.0, 1.0, 2.4, 0.18_f64.powf(2.2 / 2.4)],
    },
    Parity {
        covers: &["srgb_from_linear"],
        file: "lib/view.wgsl",
        call: "y = vec4f(srgb_from_linear(vec3f(x[0], x[1], 2.0)), 0.0);",
        domain: "-0.1 to 1.1 and 2: clamped to [0, 1]",
        tolerance: 1e-5,
        reason: "pow of f32",
        calls: CALLS,
        draw: |r| vec![between(r, -0.1, 1.1), log_between(r, 1e-4, 1e-2)],
        reference: |x| {
            let encoded = |c: f64| if c <= 0.0031308 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
            vec![encoded(x[0].clamp(0.0, 1.0)), encoded(x[1]), 1.0]
        },
    },
];

#[test]
fn view_transforms_agree_with_float64() {
    hold(PARITIES);
}
