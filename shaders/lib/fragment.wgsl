// One strand segment's share of one pixel, 12 bytes: depth, coverage and place along the segment, segment.

struct Fragment {
    depth: f32,
    coverage: f32,     // of the pixel, 0 to 1
    along: f32,        // 0 at the segment's first vertex, 1 at its second
    segment: u32,
}

const FRAGMENT_WORDS: u32 = 3u;

// The root of the coverage is kept: far away a segment covers a millionth of a pixel that thousands of them fill.
fn pack_fragment_middle(coverage: f32, along: f32) -> u32 {
    return pack2x16unorm(vec2f(sqrt(coverage), along));
}

fn unpack_fragment(words: vec3u) -> Fragment {
    let middle = unpack2x16unorm(words.y);
    return Fragment(bitcast<f32>(words.x), middle.x * middle.x, middle.y, words.z);
}
