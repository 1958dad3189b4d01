// Makes what is marked stale and wipes the marks. One thread an item.
//!use lib/marks.wgsl

@group(0) @binding(0) var<storage, read_write> marks: Marks;
@group(0) @binding(1) var<storage, read_write> done: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let item = id.x + id.y * 65535u * 64u;
    if item >= min(arrayLength(&done), arrayLength(&marks.items)) || marks.items[item] == 0u { return; }
    done[item] = 0u;
    marks.items[item] = 0u;
}
