// Composes each pixel: the shares of its strands times their radiance, over the head's four sub-samples and the background.
// Where nothing but the radiance of some vertices changed (TOUCHED), pixels that show none of them stay as they are.

//!use lib/camera.wgsl
//!use lib/composed.wgsl
//!use lib/environment.wgsl

struct ResolveUniform {
    world_from_view: mat4x4f,
    weight: f32,              // of this camera sample in the picture
    has_head: u32,
    has_background: u32,
    background_turn_rad: f32, // rotation of the environment about y
    background_scale: vec3f,  // exposure and tint of the environment
    frame: f32,               // number of this frame, as in the radiance of what it changed
    gain: vec3f,              // factor on what the lights give
    background_size: vec2u,
}

override TOUCHED: bool = false;

@group(0) @binding(0) var<uniform> camera: CameraUniform;
@group(0) @binding(1) var<uniform> resolve: ResolveUniform;
@group(0) @binding(2) var<storage, read> counts: array<u32>;            // strands that a pixel of the band shows
@group(0) @binding(3) var<storage, read> offsets: array<u32>;
@group(0) @binding(4) var<storage, read> composed: array<u32>;
@group(0) @binding(5) var<storage, read> left: array<vec2u>;            // of each sub-sample behind all strands, packed; whole picture
@group(0) @binding(6) var<storage, read> radiance: array<vec4f>;        // per refined vertex
@group(0) @binding(7) var head_colour: texture_2d<f32>;                 // 2 x 2 sub-samples a pixel; rgb radiance, a = 1 where hit
@group(0) @binding(8) var<storage, read> background: array<vec4f>;
@group(0) @binding(9) var<storage, read_write> picture: array<vec4f>;   // premultiplied, whole picture

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let p = id.x + id.y * 65535u * 64u;
    let rows = camera.end_row - camera.first_row;
    if p >= rows * camera.size.x { return; }
    let pixel = vec2u(p % camera.size.x, p / camera.size.x + camera.first_row);
    let at = pixel.y * camera.size.x + pixel.x;
    let count = counts[p];
    let base = offsets[p];
    if TOUCHED && !touched(base, count) { return; }

    var strands = vec3f(0.0);
    for (var f = 0u; f < count; f++) {
        let entry = (base + f) * COMPOSED_WORDS;
        let vertex = composed[entry];
        let along = bitcast<f32>(composed[entry + 2u]);
        strands += bitcast<f32>(composed[entry + 1u]) * mix(radiance[vertex].rgb, radiance[vertex + 1u].rgb, along);
    }

    // What is solid behind the hair.
    var solid = array<vec4f, 4>();
    if resolve.has_head != 0u {
        for (var k = 0u; k < 4u; k++) {
            let sub = vec2i(vec2u(pixel.x * 2u + (k & 1u), pixel.y * 2u + (k >> 1u)));
            solid[k] = vec4f(resolve.gain, 1.0) * textureLoad(head_colour, sub, 0);
        }
    }
    if resolve.has_background != 0u {
        let here = background_radiance(pixel);
        for (var k = 0u; k < 4u; k++) {
            if solid[k].a == 0.0 { solid[k] = vec4f(here, 1.0); }
        }
    }
    let behind = vec4f(unpack2x16unorm(left[at].x), unpack2x16unorm(left[at].y));
    var colour = resolve.gain * strands;
    var alpha = 0.0;
    for (var k = 0u; k < 4u; k++) {
        colour += 0.25 * behind[k] * solid[k].a * solid[k].rgb;
        alpha += 0.25 * (1.0 - behind[k] * (1.0 - solid[k].a));
    }
    let before = select(picture[at], vec4f(0.0), TOUCHED);
    picture[at] = before + resolve.weight * vec4f(colour, alpha);
}

// Whether this frame changed a vertex that the pixel shows.
fn touched(base: u32, count: u32) -> bool {
    for (var f = 0u; f < count; f++) {
        let vertex = composed[(base + f) * COMPOSED_WORDS];
        if radiance[vertex].a == resolve.frame || radiance[vertex + 1u].a == resolve.frame { return true; }
    }
    return false;
}

// The environment behind the picture, bilinear.
fn background_radiance(pixel: vec2u) -> vec3f {
    let at = vec2f(pixel) + 0.5 - camera.centre_px;
    let w = normalize((resolve.world_from_view * vec4f(at.x, -at.y, -camera.focal_px, 0.0)).xyz);
    let size = resolve.background_size;
    let uv = uv_from_direction(turned_about_y(w, -resolve.background_turn_rad)) * vec2f(size) - 0.5;
    let cell = vec2i(floor(uv));
    let part = uv - floor(uv);
    let x0 = u32((cell.x + i32(size.x)) % i32(size.x));
    let x1 = (x0 + 1u) % size.x;
    let y0 = u32(clamp(cell.y, 0, i32(size.y) - 1));
    let y1 = u32(clamp(cell.y + 1, 0, i32(size.y) - 1));
    let top = mix(background[y0 * size.x + x0], background[y0 * size.x + x1], part.x);
    let bottom = mix(background[y1 * size.x + x0], background[y1 * size.x + x1], part.x);
    return resolve.background_scale * mix(top, bottom, part.y).rgb;
}
