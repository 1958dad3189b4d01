// Lists the items that are wanted and not yet done, and calls them done. One thread an item; what is done with an item does not depend
// on its place in the list.

struct GrowingList {
    count: atomic<u32>,
    items: array<u32>,
}

@group(0) @binding(0) var<storage, read> wanted: array<u32>;           // 0: not seen by any pixel
@group(0) @binding(1) var<storage, read_write> done: array<u32>;       // 0: stale
@group(0) @binding(2) var<storage, read_write> list: GrowingList;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let item = id.x + id.y * 65535u * 64u;
    if item >= arrayLength(&wanted) || wanted[item] == 0u || done[item] != 0u { return; }
    done[item] = 1u;
    list.items[atomicAdd(&list.count, 1u)] = item;
}
