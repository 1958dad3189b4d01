// Node counts per quality level: 0 draft, 1 standard, 2 high.

override quality: u32 = 1u;

// Whether fibres may have an elliptic section, and whether paths are followed through which next to nothing comes.
override may_be_elliptic: bool = true;
override follows_absorbed: bool = true;

// Above this product of the light's concentration and TT's span, TT is read off at azimuths; below it is summed over gamma.
const TT_NARROW: f32 = 3.5;

// Outer nodes of R, TT, TRT.
fn outer_counts() -> vec3u {
    switch quality {
        case 0u: { return vec3u(3u, 2u, 2u); }
        case 1u: { return vec3u(4u, 2u, 3u); }
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
        case 1u: { return 5u; }
        default: { return 8u; }
    }
}

// Of the global term: outer nodes of R, outer nodes of TT and TRT, gamma nodes.
fn global_counts() -> vec3u {
    switch quality {
        case 0u: { return vec3u(2u, 2u, 5u); }
        case 1u: { return vec3u(3u, 2u, 7u); }
        default: { return vec3u(5u, 5u, 16u); }
    }
}
