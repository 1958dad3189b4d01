// Node counts per quality level: 0 draft, 1 standard, 2 high.

override quality: u32 = 1u;

// Above this concentration of the light TT is read off at azimuths, below it is summed over gamma.
const TT_NARROW_KAPPA: f32 = 14.0;

// Outer nodes of R, TT, TRT.
fn outer_counts() -> vec3u {
    switch quality {
        case 0u: { return vec3u(3u, 2u, 2u); }
        case 1u: { return vec3u(4u, 2u, 2u); }
        default: { return vec3u(6u, 4u, 5u); }
    }
}

fn tt_gamma_count() -> u32 {
    switch quality {
        case 0u: { return 4u; }
        case 1u: { return 5u; }
        default: { return 8u; }
    }
}

fn trt_gamma_count() -> u32 {
    switch quality {
        case 0u: { return 3u; }
        case 1u: { return 4u; }
        default: { return 8u; }
    }
}
