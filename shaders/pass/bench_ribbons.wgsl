// Strands as camera-facing ribbons of hardware triangles, the other way to draw them (Rust: gpu::bench::ribbons): at least a pixel wide, what
// they are wider than the strand taken out of their coverage. Blended without order (McGuire and Bavoil 2013, weighted blended OIT).

//!use lib/camera.wgsl
//!use lib/refined.wgsl

@group(0) @binding(0) var<uniform> camera: CameraUniform;
@group(0) @binding(1) var<storage, read> vertices: array<RefinedVertex>;
@group(0) @binding(2) var<storage, read> segments: array<Segment>;
@group(0) @binding(3) var<storage, read> radiance: array<vec4f>;

// End and side of the six corners of a ribbon's two triangles, a bit each.
const ENDS: u32 = 0x16u;
const SIDES: u32 = 0x34u;

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) seen: vec4f,               // radiance, coverage
    @location(1) depth: f32,
}

struct Blended {
    @location(0) sum: vec4f,                // weighted radiance times coverage, weighted coverage: added up
    @location(1) coverage: f32,             // what is behind is multiplied with 1 - coverage
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    let corner = index % 6u;
    let first = segments[index / 6u].vertex;
    let end = (ENDS >> corner) & 1u;
    let a = (camera.view_from_world * vec4f(vertices[first].position, 1.0)).xyz;
    let b = (camera.view_from_world * vec4f(vertices[first + 1u].position, 1.0)).xyz;
    // What begins or ends before the near plane is left out whole, as a triangle without area.
    if min(-a.z, -b.z) < camera.near { return Corner(vec4f(2.0, 2.0, 0.5, 1.0), vec4f(0.0), 1.0); }

    let pa = pixel_from_view(camera, a);
    let pb = pixel_from_view(camera, b);
    let along = normalize(pb.xy - pa.xy + vec2f(1e-9, 0.0));
    let here = select(pa, pb, end == 1u);
    let width = vertices[first + end].diameter * outline_width(camera, a, b) / here.z;
    let drawn = max(width, 1.0);
    let side = select(-0.5, 0.5, ((SIDES >> corner) & 1u) == 1u);
    let pixel = here.xy + side * drawn * vec2f(-along.y, along.x);
    let clip = vec2f(2.0, -2.0) * pixel / vec2f(camera.size) + vec2f(-1.0, 1.0);
    return Corner(
        vec4f(clip * here.z, 0.5 * here.z, here.z),
        vec4f(radiance[first + end].rgb, width / drawn),
        here.z,
    );
}

@fragment
fn fragment(corner: Corner) -> Blended {
    // The nearest strand counts most; `near` lies just before it.
    let relative = camera.near / corner.depth;
    let weight = corner.seen.a * pow(relative, 8.0);
    return Blended(weight * vec4f(corner.seen.rgb, 1.0), corner.seen.a);
}
