// One strand segment's share of one pixel, 12 bytes: depth, coverage and place along the segment, segment.

struct Fragment {
    depth: f32,
    coverage: f32,     // of the pixel, 0 to 1
    along: f32,        // 0 at the segment's first vertex, 1 at its second
    segment: u32,
}

const FRAGMENT_WORDS: u32 = 3u;

// Below 1/64 the root of the coverage is kept: far away a segment covers a millionth of a pixel that thousands of them fill.
fn pack_fragment_middle(coverage: f32, along: f32) -> u32 {
    let kept = select(0.125 + (coverage - 0.015625) / 1.125, sqrt(coverage), coverage < 0.015625);
    return pack2x16unorm(vec2f(kept, along));
}

fn unpack_fragment(words: vec3u) -> Fragment {
    let middle = unpack2x16unorm(words.y);
    let coverage = select(0.015625 + (middle.x - 0.125) * 1.125, middle.x * middle.x, middle.x < 0.125);
    return Fragment(bitcast<f32>(words.x), coverage, middle.y, words.z);
}
