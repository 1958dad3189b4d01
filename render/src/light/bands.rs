//! Rows of a map in groups, so that long sums over a large map can be told of and stopped in between.

use std::ops::Range;

/// Pixels that one piece of work may visit between two calls of a progress callback, each for one fibre, light or sum: some
/// hundredths of a second.
pub(super) const VISITS: usize = 1 << 20;

/// All of `rows` in order, in groups of at most [`VISITS`] where a row takes `per_row` of them; a group has one row at least.
pub(super) fn bands(rows: usize, per_row: usize) -> impl Iterator<Item = Range<usize>> {
    let step = (VISITS / per_row.max(1)).max(1);
    (0..rows)
        .step_by(step)
        .map(move |start| start..(start + step).min(rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_hold_every_row_once_and_no_more_visits_than_allowed() {
        // A small map, the largest one for a sum and for 500 fibres, a row that is too much by itself.
        for (rows, per_row) in [
            (256, 512),
            (4096, 8192),
            (4096, 500 * 8192),
            (3, 2 * VISITS),
            (0, 7),
            (5, 0),
        ] {
            let groups: Vec<Range<usize>> = bands(rows, per_row).collect();
            let visited: Vec<usize> = groups.iter().cloned().flatten().collect();
            assert_eq!(visited, (0..rows).collect::<Vec<usize>>());
            let most = groups.iter().map(Range::len).max().unwrap_or(0);
            assert!(most <= 1 || most * per_row <= VISITS, "{most} rows of {per_row}");
        }
        assert_eq!(bands(256, 512).count(), 1, "a small map is one piece");
    }
}
