// Lists the items that are wanted and not yet done as well as asked, and calls them done so well. One thread an item; what is done with an
// item does not depend on its place in the list. AGAIN: lists those that are wanted and done in some way, to change what was done, calls them
// done no better than asked, and forgets those that are not wanted.

override AGAIN: bool = false;

struct GrowingList {
    count: atomic<u32>,
    items: array<u32>,
}

@group(0) @binding(0) var<storage, read> wanted: array<u32>;           // 0: not seen by any pixel
@group(0) @binding(1) var<storage, read_write> done: array<u32>;       // how well an item is done; 0: stale
@group(0) @binding(2) var<storage, read_write> list: GrowingList;
@group(0) @binding(3) var<uniform> level: u32;                         // how well it shall be done, 1 or more

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let item = id.x + id.y * 65535u * 64u;
    if item >= arrayLength(&wanted) { return; }
    if AGAIN {
        done[item] = select(min(done[item], level), 0u, wanted[item] == 0u);
        if done[item] == 0u { return; }
    } else {
        if wanted[item] == 0u || done[item] >= level { return; }
        done[item] = level;
    }
    list.items[atomicAdd(&list.count, 1u)] = item;
}
