//! Work that a frame need not do. Each saving can be switched off, to see what it saves and what it costs in accuracy.

use std::fmt;
use std::str::FromStr;

/// One way to do less.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Saving {
    /// Vertices that no pixel shows are neither shaded nor asked for their light.
    Unseen = 1,
    /// What nothing changed for is kept from the frame before.
    Untouched = 1 << 1,
    /// A factor that all lights have in common rescales the picture.
    Gain = 1 << 2,
    /// A change of a few lights' radiance evaluates those only, while a hand is moving.
    FewLights = 1 << 3,
    /// Lights of which next to nothing arrives are not evaluated.
    Hidden = 1 << 4,
    /// Hair of circular section runs code that knows no other.
    Circular = 1 << 5,
    /// Paths through fibres that let next to nothing through are not evaluated.
    Absorbed = 1 << 6,
    /// Vertices between two others where the strand hardly turns are interpolated.
    Straight = 1 << 7,
    /// Strands much finer than a pixel are drawn as fewer, wider ones.
    Levels = 1 << 8,
    /// Multiple scattering stays while a hand turns the view by less than two degrees.
    Turning = 1 << 9,
    /// Behind a strand that covers its whole pixel no other is listed.
    Covered = 1 << 10,
}

impl Saving {
    /// All of them.
    pub const ALL: [Self; 11] = [
        Self::Unseen,
        Self::Untouched,
        Self::Gain,
        Self::FewLights,
        Self::Hidden,
        Self::Circular,
        Self::Absorbed,
        Self::Straight,
        Self::Levels,
        Self::Turning,
        Self::Covered,
    ];

    /// Its name on the command line and in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Unseen => "unseen",
            Self::Untouched => "untouched",
            Self::Gain => "gain",
            Self::FewLights => "few-lights",
            Self::Hidden => "hidden",
            Self::Circular => "circular",
            Self::Absorbed => "absorbed",
            Self::Straight => "straight",
            Self::Levels => "levels",
            Self::Turning => "turning",
            Self::Covered => "covered",
        }
    }

    /// Most that it may change a picture by: root mean square over the covered pixels, relative to theirs.
    pub const fn bound(self) -> f64 {
        match self {
            // The same numbers, or the same up to the order in which they are added.
            Self::Unseen | Self::Untouched | Self::Covered => 0.0,
            Self::Gain | Self::Circular => 1e-5,
            Self::FewLights => 1e-3,
            Self::Absorbed => 2e-3,
            Self::Hidden => 1e-2,
            Self::Straight | Self::Turning => 2e-2,
            Self::Levels => 3e-2,
        }
    }
}

/// A set of savings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Savings(u32);

impl Savings {
    /// Every saving.
    pub const ALL: Self = Self((1 << Saving::ALL.len()) - 1);
    /// Everything is computed.
    pub const NONE: Self = Self(0);

    /// Whether `saving` is made.
    pub const fn has(self, saving: Saving) -> bool {
        self.0 & saving as u32 != 0
    }

    /// The same without `saving`.
    #[must_use]
    pub const fn without(self, saving: Saving) -> Self {
        Self(self.0 & !(saving as u32))
    }

    /// Those that change nothing but the order in which numbers are added.
    #[must_use]
    pub fn exact(self) -> Self {
        Saving::ALL
            .into_iter()
            .filter(|saving| saving.bound() > 1e-4)
            .fold(self, Self::without)
    }

    /// The same with `saving`.
    #[must_use]
    pub const fn with(self, saving: Saving) -> Self {
        Self(self.0 | saving as u32)
    }
}

impl Default for Savings {
    fn default() -> Self {
        Self::ALL
    }
}

impl fmt::Display for Savings {
    /// What [`FromStr`] reads.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let made = Saving::ALL.into_iter().filter(|saving| self.has(*saving));
        let names: Vec<_> = made.map(Saving::name).collect();
        match names.len() {
            0 => f.write_str("none"),
            n if n == Saving::ALL.len() => f.write_str("all"),
            _ => f.write_str(&names.join(",")),
        }
    }
}

impl FromStr for Savings {
    type Err = String;

    /// `all`, `none`, or names joined by commas.
    fn from_str(text: &str) -> Result<Self, String> {
        text.split(',')
            .map(str::trim)
            .try_fold(Self::NONE, |savings, word| match word {
                "all" => Ok(Self::ALL),
                "none" => Ok(savings),
                name => {
                    let known = Saving::ALL.into_iter().find(|saving| saving.name() == name);
                    known.map(|saving| savings.with(saving)).ok_or_else(|| {
                        let names = Saving::ALL.map(Saving::name).join(", ");
                        format!("no saving is called {word:?}; write all, none, or some of {names}")
                    })
                }
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        let some = Savings::NONE.with(Saving::Unseen).with(Saving::Levels);
        for savings in [
            Savings::ALL,
            Savings::NONE,
            some,
            Savings::ALL.without(Saving::Gain),
        ] {
            assert_eq!(savings.to_string().parse(), Ok(savings));
        }
        assert_eq!(some.to_string(), "unseen,levels");
        let refused = "unseen,lazy".parse::<Savings>().unwrap_err();
        assert!(
            refused.contains("lazy") && refused.contains("few-lights"),
            "{refused}"
        );
    }
}
