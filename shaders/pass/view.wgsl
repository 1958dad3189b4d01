// The picture as it is shown: exposure, view transform, sRGB; over a backdrop where the picture is not covered.

//!use lib/view.wgsl

struct ViewUniform {
    backdrop: vec4f,       // display-referred linear colour, a = 1: opaque, 0: keep the picture's alpha
    size: vec2u,
    scale: f32,            // 2^exposure
    transform: u32,        // 0 neutral, 1 AgX, 2 raw
}

@group(0) @binding(0) var<uniform> view: ViewUniform;
@group(0) @binding(1) var<storage, read> picture: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> bad_pixels: atomic<u32>;    // non-finite, shown in magenta
@group(0) @binding(3) var shown: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= view.size) { return; }
    let p = picture[id.y * view.size.x + id.x];
    if !is_finite(p.r + p.g + p.b + p.a) {
        atomicAdd(&bad_pixels, 1u);
        textureStore(shown, id.xy, vec4f(1.0, 0.0, 1.0, 1.0));
        return;
    }
    // The transform acts on the colour of what covers the pixel, not on its mixture with nothing.
    let alpha = clamp(p.a, 0.0, 1.0);
    let scene = view.scale * p.rgb / max(alpha, 1e-6);
    var display = scene;
    if view.transform == 0u { display = pbr_neutral(scene); }
    else if view.transform == 1u { display = agx(scene); }
    let over = mix(view.backdrop.rgb, clamp(display, vec3f(0.0), vec3f(1.0)), alpha);
    let straight = select(display, over, view.backdrop.a > 0.0);
    textureStore(shown, id.xy, vec4f(srgb_from_linear(straight), max(alpha, view.backdrop.a)));
}

// The exponent's bits are read: a compiler may assume that x == x.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}
