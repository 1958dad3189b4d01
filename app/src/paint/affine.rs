//! What a layer does to a value: an affine map, composed stroke after stroke.
//!
//! Replace, add, subtract, multiply and erase are affine in the value they meet, and so is any sequence of them. A layer
//! is therefore one map per point and component, independent of what lies below it: changing the base or a lower layer
//! needs no replay.

use balayage_render::param::Channel;

use super::Mode;

/// The map x -> scale * x + offset, in the channel's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// Factor on the value below, in [0, 1000].
    pub scale: f32,
    /// What is added to it.
    pub offset: f32,
}

/// Strokes that multiply can stack without limit; the product stops here.
const MAX_SCALE: f32 = 1000.0;

impl Affine {
    /// The map of an unpainted point.
    pub const IDENTITY: Self = Self {
        scale: 1.0,
        offset: 0.0,
    };

    /// The image of `x`.
    pub fn of(self, x: f32) -> f32 {
        self.scale * x + self.offset
    }

    /// The map between this one and `other`, at `share` in [0, 1].
    #[must_use]
    pub fn towards(self, other: Self, share: f32) -> Self {
        Self {
            scale: (1.0 - share) * self.scale + share * other.scale,
            offset: (1.0 - share) * self.offset + share * other.offset,
        }
    }

    /// This map after a stroke of `coverage` in [0, 1]; `smoothed` is the mean map of the neighbourhood (mode smooth).
    ///
    /// The result still sends some value of the channel's range into the range, so that strokes beyond the range's end
    /// do not pile up a debt that later strokes would have to pay off first.
    #[must_use]
    pub fn stroked(self, mode: Mode, value: f32, coverage: f32, smoothed: Self, channel: Channel) -> Self {
        let kept = 1.0 - coverage;
        let (scale, offset) = match mode {
            Mode::Replace => (kept * self.scale, kept * self.offset + coverage * value),
            Mode::Add => (self.scale, self.offset + coverage * value),
            Mode::Subtract => (self.scale, self.offset - coverage * value),
            Mode::Multiply => {
                let factor = kept + coverage * value;
                (factor * self.scale, factor * self.offset)
            }
            Mode::Erase => (kept * self.scale + coverage, kept * self.offset),
            Mode::Smooth => (
                kept * self.scale + coverage * smoothed.scale,
                kept * self.offset + coverage * smoothed.offset,
            ),
        };
        let (low, high) = channel.range().into_inner();
        let scale = scale.clamp(0.0, MAX_SCALE);
        Self {
            scale,
            offset: offset.clamp(low - scale * high, high - scale * low),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: Affine = Affine::IDENTITY;

    #[test]
    fn modes_do_what_their_names_say() {
        let half = |mode, value| NONE.stroked(mode, value, 0.5, NONE, Channel::Dye).of(2.0);
        assert_eq!(half(Mode::Replace, 4.0), 3.0);
        assert_eq!(half(Mode::Add, 4.0), 4.0);
        assert_eq!(half(Mode::Subtract, 1.0), 1.5);
        assert_eq!(half(Mode::Multiply, 3.0), 4.0);
        assert_eq!(half(Mode::Erase, 9.0), 2.0);
    }

    #[test]
    fn full_erase_is_the_identity_bit_for_bit() {
        let painted = NONE.stroked(Mode::Replace, 0.3, 0.7, NONE, Channel::Bleach);
        assert_ne!(painted, NONE);
        assert_eq!(
            painted.stroked(Mode::Erase, 0.0, 1.0, NONE, Channel::Bleach),
            NONE
        );
    }

    #[test]
    fn strokes_beyond_the_range_leave_a_bounded_debt() {
        let mut map = NONE;
        for _ in 0..100 {
            map = map.stroked(Mode::Add, 1.0, 1.0, NONE, Channel::Bleach);
        }
        assert_eq!(
            map.stroked(Mode::Subtract, 1.0, 1.0, NONE, Channel::Bleach)
                .of(0.0),
            0.0
        );
        for _ in 0..100 {
            map = map.stroked(Mode::Multiply, 1000.0, 1.0, NONE, Channel::Dye);
        }
        assert!(map.scale.is_finite() && map.offset.is_finite());
    }
}
