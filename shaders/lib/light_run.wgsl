// One light's rays from all listed points (Rust: gpu::transmittance::LightRun). A march runs one thread a pair of light and listed point,
// light after light.

struct LightRun {
    point_count: u32,
    light: u32,              // index among all lights
    first_record: u32,       // where this light's records begin in the batch
    prior: f32,              // weight of the record that is there; exact rays only
    is_again: u32,           // 1: records of ways without new paint stay; path sums only
}
