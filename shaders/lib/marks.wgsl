// Items of a work list that something happened to (Rust: gpu::work_list).

struct Marks {
    count: atomic<u32>,      // work that was done on the way
    items: array<u32>,       // 1: marked
}
