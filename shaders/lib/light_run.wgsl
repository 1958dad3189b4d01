// One light's rays from all listed points (Rust: gpu::transmittance::LightRun). A march runs one thread a pair of light and listed point,
// light after light.

struct LightRun {
    point_count: u32,
    light: u32,              // index among all lights
    first_record: u32,       // where this light's records begin in the batch
    prior: f32,              // weight of the march's record; exact rays only
    first_ray: u32,          // of the light's exact rays that this run traces
    end_ray: u32,
    is_again: u32,           // 1: records of ways without new paint stay; path sums only
}
