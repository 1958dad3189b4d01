// A quantity of every refined vertex in place of its radiance, as (value, value, 1), for a look at what shading works with. Batches of lights add up; the
// quantities of light are means weighed by the lights' power.
//!use lib/volume.wgsl
//!use lib/types.wgsl
//!use lib/refined.wgsl
//!use lib/averages_table.wgsl

struct DebugRun {
    what: u32,                // WHAT_
    point_count: u32,
    first_light: u32,
    light_count: u32,
    adds: u32,                // 0: the first batch
}

const WHAT_TRANSMITTANCE: u32 = 0u;   // share of the light that arrives unscattered
const WHAT_FIBRES: u32 = 1u;          // n: exp(-n) of the light crosses no fibre
const WHAT_FORWARD: u32 = 2u;         // a_f at normal incidence, mean of the channels
const WHAT_DENSITY: u32 = 3u;         // fibres' projected area in the vertex's voxel, over that of the voxel's face

@group(0) @binding(0) var<uniform> volume_grid: VolumeGrid;
@group(0) @binding(1) var<storage, read> volume_bricks: array<u32>;
@group(0) @binding(2) var<storage, read> volume_density: array<vec2u>;
@group(0) @binding(3) var<uniform> run: DebugRun;
@group(0) @binding(4) var<storage, read> vertices: array<RefinedVertex>;
@group(0) @binding(5) var<storage, read> params: array<VertexParams>;
@group(0) @binding(6) var<storage, read> averages_table: array<vec4f>;
@group(0) @binding(7) var<storage, read> weights: array<f32>;           // of the lights, sum 1
@group(0) @binding(8) var<storage, read> visibility: array<vec2u>;
@group(0) @binding(9) var<storage, read> paths: array<vec4u>;
@group(0) @binding(10) var<storage, read_write> radiance: array<vec4f>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * 65535u * 64u;
    if index >= arrayLength(&vertices) { return; }
    let vertex = vertices[index];
    let point = vertex.source_point;
    let next = min(point + 1u, run.point_count - 1u);
    var value = 0.0;
    if run.what == WHAT_FORWARD {
        let sigma_a = mix(params[point].sigma_a, params[next].sigma_a, vertex.source_fraction);
        for (var c = 0; c < 3; c++) { value += fibre_averages(sigma_a[c], 0.0).a_f / 3.0; }
    } else if run.what == WHAT_DENSITY {
        value = density_at(grid_from_world(vertex.position));
    } else {
        if run.adds != 0u { value = radiance[index].x; }
        for (var j = 0u; j < run.light_count; j++) {
            let record = j * run.point_count;
            let here = mix(of_light(record + point), of_light(record + next), vertex.source_fraction);
            value += weights[run.first_light + j] * here;
        }
    }
    radiance[index] = vec4f(value, value, 1.0, 1.0);
}

fn of_light(record: u32) -> f32 {
    if run.what == WHAT_TRANSMITTANCE { return saturate(unpack2x16float(visibility[record].x).x); }
    return unpack2x16float(paths[record].w).y;
}

// Projected area of the fibres in the voxel at `p` (grid space); 0 outside and inside an occluder.
fn density_at(p: vec3f) -> f32 {
    let voxel = clamp(vec3i(floor(p)), vec3i(0), vec3i(volume_grid.bricks) * BRICK_SIDE - 1);
    let brick = vec3u(voxel) / u32(BRICK_SIDE);
    let slot = volume_bricks[brick.x + volume_grid.bricks.x * (brick.y + volume_grid.bricks.y * brick.z)];
    if slot >= SOLID_BRICK { return 0.0; }
    let inside = vec3u(voxel) % u32(BRICK_SIDE);
    let rho = unpack2x16float(volume_density[slot * BRICK_VOXELS + inside.x + u32(BRICK_SIDE) * (inside.y + u32(BRICK_SIDE) * inside.z)].x).x;
    return select(rho, 0.0, rho > SOLID_RHO);
}
