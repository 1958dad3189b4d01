// Multiple scattering of listed groom points to the camera: what the fibre there makes of the light that the others send it, read off the cells of a
// light field (Rust: photon, gpu::scattered_light). Smooth along a strand, so that the refined vertices between two points interpolate it.
// One thread a point. lib/part_series.wgsl stands in for lib/window_series.wgsl.

//!use lib/shade.wgsl
//!use lib/forward.wgsl
//!use lib/part.wgsl
//!use lib/work_list.wgsl

@group(0) @binding(0) var<uniform> shade: ShadeUniform;
@group(0) @binding(1) var<storage, read> vertices: array<RefinedVertex>;
@group(0) @binding(2) var<storage, read> params: array<VertexParams>;
@group(0) @binding(3) var<storage, read> field_grid: LightFieldGrid;
@group(0) @binding(4) var<storage, read> cell_numbers: array<u32>;
@group(0) @binding(5) var<storage, read> tables: array<vec4f>;
@group(0) @binding(6) var<storage, read> cell_fibres: array<vec4f>;    // mean place (in cells from the corner) and area of a cell's fibres
@group(0) @binding(7) var<storage, read_write> multiple: array<vec4f>;
@group(0) @binding(8) var<storage, read> cell_radiance: array<vec2u>;    // 3 x f16 per cell and part
@group(0) @binding(9) var<storage, read> part_directions: array<vec4f>;  // PART_QUARTERS a part
@group(0) @binding(10) var<storage, read> point_vertices: array<u32>;    // the refined vertex of each groom point
@group(0) @binding(11) var<storage, read> work: WorkList;
@group(0) @binding(12) var<storage, read_write> evaluated: array<atomic<u32>, 4>;  // its third: parts of the sphere that light came from

struct LightFieldGrid {
    low: vec3f,              // lower corner, groom's unit
    cell: f32,               // edge of a cell, groom's unit
    cells: vec3i,            // cells along each axis
    scale: f32,              // factor on the stored values: radiance times solid angle
}

const NO_CELL: u32 = 0xffffffffu;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * 65535u * 64u;
    if index >= work.count { return; }
    let point = work.items[index];
    let vertex = vertices[point_vertices[point]];
    let fibre = fibre_from_params(params[point]);
    let local_from_world = fibre_from_world(vertex);
    let towards_eye = local_from_world * normalize(shade.camera_position - vertex.position);
    let view = prepare_forward(fibre, angles(towards_eye).x);
    let eye_across = normalize(towards_eye.yz + vec2f(1e-9, 0.0));

    // What cells hold stands for the mean place of their fibres. That of the cells around lies further inside than a point at the rim of the hair,
    // where light changes most: it is asked for as far beyond the point.
    let place = (vertex.position - field_grid.low) / field_grid.cell;
    var around = cells_around(place);
    let off = place - around.place;
    let beyond = cells_around(place + off * min(1.0, 0.5 * inverseSqrt(max(dot(off, off), 1e-12))));
    if beyond.area > 0.0 {
        around = beyond;
    }

    var by_lobe = array<vec3f, 3>();
    var sums = vec3f(0.0);
    var part_count = 0u;
    for (var part = 0u; part < PARTS; part++) {
        var light = vec3f(0.0);
        for (var corner = 0u; corner < 8u; corner++) {
            if around.cells[corner] != NO_CELL {
                let words = cell_radiance[around.cells[corner] + part];
                light += around.weights[corner] * vec3f(unpack2x16float(words.x), unpack2x16float(words.y).x);
            }
        }
        let is_lit = any(light != vec3f(0.0));
        part_count += u32(is_lit);
        for (var quarter = 0u; quarter < PART_QUARTERS; quarter++) {
            let source = local_from_world * part_directions[part * PART_QUARTERS + quarter].xyz;
            let lobes = lobes_at(view, vec3f(asin(clamp(source.x, -1.0, 1.0))), PART_VARIANCE);
            sums += lobes;
            if !is_lit { continue; }
            let cos_x = dot(eye_across, normalize(source.yz + vec2f(1e-9, 0.0)));
            for (var lobe = 0u; lobe < 3u; lobe++) {
                by_lobe[lobe] += light * lobes[lobe] * window_at(view.series[lobe], cos_x);
            }
        }
    }
    // A lobe is not much wider than a part: how many parts' middles it holds depends on how the fibre lies to them. What it makes of light from
    // everywhere does not.
    let wanted = lobe_integrals(view) * f32(PARTS) / (4.0 * PI);
    let evened = clamp(wanted / max(sums, vec3f(1e-6)), vec3f(0.5 / f32(PART_QUARTERS)), vec3f(2.0 / f32(PART_QUARTERS)));
    var out = by_lobe[0] * evened.x + by_lobe[1] * evened.y + by_lobe[2] * evened.z;
    out *= field_grid.scale / max(around.area, 1e-30);
    // Cut-off series swing a little below zero. What is not finite stays so.
    let is_below = (out < vec3f(0.0)) & (out > vec3f(-1e30));
    multiple[point] = vec4f(select(out, vec3f(0.0), is_below), 1.0);
    atomicAdd(&evaluated[2], part_count);
}

// The eight cells around a place, each by its fibres' area: where there are none there is no light to be known.
struct Cells {
    cells: array<u32, 8>,        // first entry in the radiance of cells, or NO_CELL
    weights: array<f32, 8>,
    area: f32,                   // their sum
    place: vec3f,                // their fibres' mean
}

fn cells_around(place: vec3f) -> Cells {
    var around: Cells;
    let first = vec3i(floor(place - 0.5));
    let inside = fract(place - 0.5);
    for (var corner = 0u; corner < 8u; corner++) {
        let upper = vec3u(corner & 1u, (corner >> 1u) & 1u, corner >> 2u);
        let cell = first + vec3i(upper);
        around.cells[corner] = NO_CELL;
        if any(cell < vec3i(0)) || any(cell >= field_grid.cells) { continue; }
        let number = cell_numbers[cell.x + field_grid.cells.x * (cell.y + field_grid.cells.y * cell.z)];
        if number == NO_CELL { continue; }
        let fibres = cell_fibres[number];
        let share = select(1.0 - inside, inside, upper == vec3u(1u));
        let weight = share.x * share.y * share.z * fibres.w;
        around.cells[corner] = number * PARTS;
        around.weights[corner] = weight;
        around.area += weight;
        around.place += weight * fibres.xyz;
    }
    around.place /= max(around.area, 1e-30);
    return around;
}
