// The head: a diffuse surface under the lights, shadowed by itself and by the hair.

//!use lib/volume.wgsl
//!use lib/light.wgsl

struct HeadUniform {
    vertex_count: u32,
    light_count: u32,
    albedo: f32,
    offset: f32,         // how far above the skin rays start, voxels
}

@group(0) @binding(0) var<uniform> volume_grid: VolumeGrid;
@group(0) @binding(1) var<storage, read> volume_bricks: array<u32>;
@group(0) @binding(2) var<storage, read> volume_density: array<vec2u>;
@group(0) @binding(3) var<storage, read> frames: array<LobeLight>;
@group(0) @binding(4) var<storage, read> directions: array<LobeDirection>;
@group(0) @binding(5) var<storage, read> lights: array<Light>;
@group(0) @binding(6) var<uniform> head: HeadUniform;
@group(0) @binding(7) var<storage, read> positions: array<vec4f>; // w: share of the skin that short hair covers
@group(0) @binding(8) var<storage, read> normals: array<vec4f>;
@group(0) @binding(9) var<storage, read_write> radiance: array<vec4f>;

// Optical depth behind which nothing arrives.
const N_MAX: f32 = 8.0;

// How much darker skin is that short hair covers.
const UNDERGROWTH: f32 = 0.8;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let vertex = id.x + id.y * 65535u * 64u;
    if vertex >= head.vertex_count { return; }
    let normal = normals[vertex].xyz;
    let start = (positions[vertex].xyz - volume_grid.origin) / volume_grid.voxel_size + head.offset * normal;
    let nobody = OwnStrand();
    var irradiance = vec3f(0.0);
    for (var j = 0u; j < head.light_count; j++) {
        let frame = frames[j];
        let angle = turn_angle(vertex, j);
        let turn = vec2f(cos(angle), sin(angle));
        for (var k = 0u; k < frame.path_count; k++) {
            let direction = directions[frame.first_path + k];
            let w = world_from_lobe(frame, direction.local, turn);
            let cosine = dot(w, normal);
            if cosine <= 0.0 { continue; }
            let n = march(start, w, nobody, N_MAX);
            if n < N_MAX { irradiance += lights[j].radiance * (cosine * direction.solid_angle * exp(-n)); }
        }
    }
    // Short hair between the roots takes its share of the light.
    let albedo = head.albedo * (1.0 - UNDERGROWTH * positions[vertex].w);
    radiance[vertex] = vec4f(irradiance * (albedo / 3.14159265), 1.0);
}
