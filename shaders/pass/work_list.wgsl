// Lists the items that are wanted and not yet done as well as asked, as many as there is room for, and calls these done so well. One thread
// an item; what is done with an item does not depend on its place in the list. AGAIN: lists those that are wanted and done in some way, to
// change what was done, calls them done no better than asked, and forgets those that are not wanted.

override AGAIN: bool = false;

struct Asked {
    level: u32,        // how well it shall be done, 1 or more
    most: u32,         // items that the list has room for
}

struct GrowingList {
    count: atomic<u32>,
    items: array<u32>,
}

@group(0) @binding(0) var<storage, read> wanted: array<u32>;           // odd: a pixel shows what is done with it
@group(0) @binding(1) var<storage, read_write> done: array<u32>;       // how well an item is done; 0: stale
@group(0) @binding(2) var<storage, read_write> list: GrowingList;
@group(0) @binding(3) var<uniform> asked: Asked;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let item = id.x + id.y * 65535u * 64u;
    if item >= arrayLength(&wanted) { return; }
    if AGAIN {
        done[item] = select(min(done[item], asked.level), 0u, (wanted[item] & 1u) == 0u);
        if done[item] == 0u { return; }
    } else if (wanted[item] & 1u) == 0u || done[item] >= asked.level {
        return;
    }
    let place = atomicAdd(&list.count, 1u);
    if place >= asked.most {
        atomicSub(&list.count, 1u);
        return;
    }
    if !AGAIN { done[item] = asked.level; }
    list.items[place] = item;
}
