// Items of a groom (points or refined vertices) that a pass has to do (Rust: gpu::work_list).

struct WorkList {
    count: u32,
    items: array<u32>,
}
