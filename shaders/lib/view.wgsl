// View transforms: scene-linear Rec.709 to what a display shows.

// Khronos PBR Neutral tone mapper (specification 2024): colours below the knee stay as they are, highlights roll off and lose chroma.
fn pbr_neutral(scene: vec3f) -> vec3f {
    let start_compression = 0.8 - 0.04;
    let desaturation = 0.15;
    let low = min(scene.r, min(scene.g, scene.b));
    let offset = select(0.04, low - 6.25 * low * low, low < 0.08);
    let c = scene - offset;
    let peak = max(c.r, max(c.g, c.b));
    if peak < start_compression { return c; }
    let d = 1.0 - start_compression;
    let new_peak = 1.0 - d * d / (peak + d - start_compression);
    let g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
    return mix(c * (new_peak / peak), vec3f(new_peak), g);
}

// AgX (Sobotka): inset, log2 encoding over [-12.47393, 4.026069] stops around middle grey, sigmoid, outset. Result is linear.
// The sigmoid is AgX's own piecewise curve: slope 2.4 through the pivot (0.18 maps to 0.18^(1/2.2)), toe and shoulder power 1.5.
fn agx(scene: vec3f) -> vec3f {
    let inset = mat3x3f(
        0.842479062253094, 0.0423282422610123, 0.0423756549057051,
        0.0784335999999992, 0.878468636469772, 0.0784336,
        0.0792237451477643, 0.0791661274605434, 0.879142973793104);
    let outset = mat3x3f(
        1.19687900512017, -0.0528968517574562, -0.0529716355144438,
        -0.0980208811401368, 1.15190312990417, -0.0980434501171241,
        -0.0990297440797205, -0.0989611768448433, 1.15107367264116);
    let low = -12.47393;
    let high = 4.026069;
    let stops = clamp(log2(max(inset * scene, vec3f(1e-10))), vec3f(low), vec3f(high));
    let x = (stops - low) / (high - low);
    let shown = vec3f(agx_curve(x.x), agx_curve(x.y), agx_curve(x.z));
    return max(pow(max(outset * shown, vec3f(0.0)), vec3f(2.2)), vec3f(0.0));
}

fn agx_curve(x: f32) -> f32 {
    let pivot_x = 0.6060606;      // middle grey in the log encoding
    let pivot_y = 0.48943708;     // 0.18^(1/2.4) on the display's scale
    let slope = 2.4;
    let power = 1.5;
    // A limb of the sigmoid ends at 1 (0): scale chosen so that it passes through (1, 1) or (0, 0).
    let above = x >= pivot_x;
    let room_x = select(pivot_x, 1.0 - pivot_x, above);
    let room_y = select(pivot_y, 1.0 - pivot_y, above);
    let rise = slope * room_x;
    let scale = rise / pow(pow(rise / room_y, power) - 1.0, 1.0 / power);
    let t = slope * abs(x - pivot_x);
    let limb = t / pow(1.0 + pow(t / scale, power), 1.0 / power);
    return pivot_y + select(-limb, limb, above);
}

// sRGB's transfer function.
fn srgb_from_linear(c: vec3f) -> vec3f {
    let x = clamp(c, vec3f(0.0), vec3f(1.0));
    return select(1.055 * pow(x, vec3f(1.0 / 2.4)) - 0.055, 12.92 * x, x <= vec3f(0.0031308));
}
