// A strand's share of a pixel, 12 bytes: first vertex of the segment, share of the pixel's light (f32), place along the segment (f32).
const COMPOSED_WORDS: u32 = 3u;
