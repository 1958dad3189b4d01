//! How binary USD packs bytes (LZ4 blocks) and integers (differences of one of four widths).

/// Largest unpacked size of an LZ4 block in the format.
const MAX_BLOCK: usize = 0x7e00_0000;

/// Unpacks a chunked LZ4 buffer into at most `limit` bytes; none where it is damaged.
pub(super) fn expanded(packed: &[u8], limit: usize) -> Option<Vec<u8>> {
    let (&chunks, mut rest) = packed.split_first()?;
    let mut out = Vec::new();
    if chunks == 0 {
        block(rest, limit.min(MAX_BLOCK), &mut out)?;
        return Some(out);
    }
    for _ in 0..chunks {
        let (size, tail) = rest.split_first_chunk::<4>()?;
        let size = usize::try_from(i32::from_le_bytes(*size)).ok()?;
        let (chunk, tail) = tail.split_at_checked(size)?;
        block(chunk, limit, &mut out)?;
        rest = tail;
    }
    Some(out)
}

/// Appends one LZ4 block (lz4_Block_format) to `out`, which never grows beyond `limit`.
fn block(mut input: &[u8], limit: usize, out: &mut Vec<u8>) -> Option<()> {
    let start = out.len();
    loop {
        let (&token, rest) = input.split_first()?;
        input = rest;
        let literals = length(usize::from(token >> 4), &mut input)?;
        let (bytes, rest) = input.split_at_checked(literals)?;
        if out.len() + literals > limit {
            return None;
        }
        out.extend_from_slice(bytes);
        input = rest;
        if input.is_empty() {
            return Some(());
        }

        // A match may overlap what it writes.
        let (offset, rest) = input.split_first_chunk::<2>()?;
        input = rest;
        let offset = usize::from(u16::from_le_bytes(*offset));
        let matched = length(usize::from(token & 15), &mut input)? + 4;
        let from = out
            .len()
            .checked_sub(offset)
            .filter(|from| offset > 0 && *from >= start)?;
        if out.len() + matched > limit {
            return None;
        }
        for i in 0..matched {
            out.push(out[from + i]);
        }
    }
}

/// A length of which 15 means that more bytes follow.
fn length(nibble: usize, input: &mut &[u8]) -> Option<usize> {
    let mut length = nibble;
    if nibble == 15 {
        loop {
            let (&more, rest) = input.split_first()?;
            *input = rest;
            length = length.checked_add(usize::from(more))?;
            if more != 255 {
                break;
            }
        }
    }
    Some(length)
}

/// Unpacks `count` 32-bit integers; none where the bytes do not hold that many.
pub(super) fn integers(packed: &[u8], count: u64) -> Option<Vec<i32>> {
    if count == 0 {
        return Some(Vec::new());
    }
    // A packed byte gives 255 bytes at most, and four integers take a byte at least.
    let count = usize::try_from(count).ok()?;
    let codes_len = count.checked_mul(2)?.checked_add(7)? / 8;
    if codes_len / 256 > packed.len() {
        return None;
    }
    let bytes = expanded(packed, count.checked_mul(4)?.checked_add(codes_len + 4)?)?;
    let (common, rest) = bytes.split_first_chunk::<4>()?;
    let common = i32::from_le_bytes(*common);
    let (codes, mut rest) = rest.split_at_checked(codes_len)?;
    let mut value = 0_i32;
    let mut out = Vec::with_capacity(count);
    for i in 0..count {
        let difference = match codes[i / 4] >> (2 * (i % 4)) & 3 {
            0 => common,
            1 => {
                let (b, tail) = rest.split_first()?;
                rest = tail;
                i32::from(*b as i8)
            }
            2 => {
                let (b, tail) = rest.split_first_chunk()?;
                rest = tail;
                i32::from(i16::from_le_bytes(*b))
            }
            _ => {
                let (b, tail) = rest.split_first_chunk()?;
                rest = tail;
                i32::from_le_bytes(*b)
            }
        };
        value = value.wrapping_add(difference);
        out.push(value);
    }
    Some(out)
}
