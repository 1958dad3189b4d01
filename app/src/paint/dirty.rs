//! Which points changed.

use std::ops::Range;

/// Sorted, disjoint, non-adjacent ranges of point indices.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DirtyRanges {
    ranges: Vec<Range<u32>>,
}

impl DirtyRanges {
    /// No point.
    pub fn none() -> Self {
        Self::default()
    }

    /// All of `count` points.
    pub fn all(count: usize) -> Self {
        Self {
            ranges: (count > 0).then_some(0..count as u32).into_iter().collect(),
        }
    }

    /// The points of `points`, in any order.
    pub fn of_points(mut points: Vec<u32>) -> Self {
        points.sort_unstable();
        let mut ranges: Vec<Range<u32>> = Vec::new();
        for point in points {
            match ranges.last_mut() {
                Some(last) if point < last.end => {}
                Some(last) if point == last.end => last.end += 1,
                _ => ranges.push(point..point + 1),
            }
        }
        Self { ranges }
    }

    /// The ranges, ascending.
    pub fn ranges(&self) -> &[Range<u32>] {
        &self.ranges
    }

    /// Every point, ascending.
    pub fn points(&self) -> impl Iterator<Item = u32> + '_ {
        self.ranges.iter().cloned().flatten()
    }

    /// Number of points.
    pub fn point_count(&self) -> usize {
        self.ranges.iter().map(ExactSizeIterator::len).sum()
    }

    /// True where no point changed.
    pub fn is_empty(&self) -> bool {
        self.ranges.is_empty()
    }

    /// Adds the points of `other`.
    pub fn merge(&mut self, other: &Self) {
        let mut both: Vec<Range<u32>> = self
            .ranges
            .drain(..)
            .chain(other.ranges.iter().cloned())
            .collect();
        both.sort_unstable_by_key(|r| r.start);
        for range in both {
            match self.ranges.last_mut() {
                Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
                _ => self.ranges.push(range),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_sorted_and_merged() {
        let mut dirty = DirtyRanges::of_points(vec![7, 3, 4, 3, 9]);
        assert_eq!(dirty.ranges(), [3..5, 7..8, 9..10]);
        dirty.merge(&DirtyRanges::of_points(vec![8, 1]));
        assert_eq!(dirty.ranges(), [1..2, 3..5, 7..10]);
        assert_eq!(dirty.point_count(), 6);
    }
}
