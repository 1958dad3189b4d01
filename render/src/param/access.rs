//! Channels by name: what a point holds of each, and within which range.

use std::ops::RangeInclusive;

use super::{Channel, PointValues};

impl Channel {
    /// Every channel that points hold a value of, in the order of [`PointValues`].
    pub const ALL: [Self; 9] = [
        Self::Eumelanin,
        Self::Pheomelanin,
        Self::Bleach,
        Self::Dye,
        Self::AlphaDeg,
        Self::BetaDeg,
        Self::AzimuthalDeg,
        Self::Eta,
        Self::Eccentricity,
    ];

    /// The name in JSON and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Eumelanin => "eumelanin",
            Self::Pheomelanin => "pheomelanin",
            Self::Bleach => "bleach",
            Self::Dye => "dye",
            Self::AlphaDeg => "alpha_deg",
            Self::BetaDeg => "beta_deg",
            Self::AzimuthalDeg => "azimuthal_deg",
            Self::Eta => "eta",
            Self::Eccentricity => "eccentricity",
            Self::Mask => "mask",
        }
    }

    /// Values a point holds of this channel: three for dye (linear Rec.709), else one.
    pub fn components(self) -> usize {
        if self == Self::Dye { 3 } else { 1 }
    }

    /// The values that the shaders are made for, in the channel's unit; painted values are clamped to it.
    ///
    /// Hair has an index near 1.55 and an eccentricity between 0.85 and 1 (Marschner 2003); the ranges leave room for
    /// synthetic fibres and stay clear of the singular widths at zero.
    pub fn range(self) -> RangeInclusive<f32> {
        match self {
            Self::Eumelanin | Self::Pheomelanin => 0.0..=50.0,
            Self::Bleach | Self::Mask => 0.0..=1.0,
            Self::Dye => 0.0..=100.0,
            Self::AlphaDeg => -30.0..=30.0,
            Self::BetaDeg => 0.5..=60.0,
            Self::AzimuthalDeg => 0.1..=90.0,
            Self::Eta => 1.01..=3.0,
            Self::Eccentricity => 0.5..=2.0,
        }
    }
}

impl PointValues {
    /// The point's values of `channel`; of a channel with one component the other two are zero. A mask is open.
    pub fn get(&self, channel: Channel) -> [f32; 3] {
        match channel {
            Channel::Eumelanin => [self.eumelanin, 0.0, 0.0],
            Channel::Pheomelanin => [self.pheomelanin, 0.0, 0.0],
            Channel::Bleach => [self.bleach, 0.0, 0.0],
            Channel::Dye => self.dye,
            Channel::AlphaDeg => [self.alpha_deg, 0.0, 0.0],
            Channel::BetaDeg => [self.beta_deg, 0.0, 0.0],
            Channel::AzimuthalDeg => [self.azimuthal_deg, 0.0, 0.0],
            Channel::Eta => [self.eta, 0.0, 0.0],
            Channel::Eccentricity => [self.eccentricity, 0.0, 0.0],
            Channel::Mask => [1.0, 0.0, 0.0],
        }
    }

    /// Sets `channel` to the first [`Channel::components`] of `value`; a mask is no value of a point.
    pub fn set(&mut self, channel: Channel, value: [f32; 3]) {
        match channel {
            Channel::Eumelanin => self.eumelanin = value[0],
            Channel::Pheomelanin => self.pheomelanin = value[0],
            Channel::Bleach => self.bleach = value[0],
            Channel::Dye => self.dye = value,
            Channel::AlphaDeg => self.alpha_deg = value[0],
            Channel::BetaDeg => self.beta_deg = value[0],
            Channel::AzimuthalDeg => self.azimuthal_deg = value[0],
            Channel::Eta => self.eta = value[0],
            Channel::Eccentricity => self.eccentricity = value[0],
            Channel::Mask => {}
        }
    }

    /// The first channel whose value is not finite or outside [`Channel::range`], with that value.
    pub fn out_of_range(&self) -> Option<(Channel, f32)> {
        Channel::ALL.into_iter().find_map(|channel| {
            let value = self.get(channel);
            let bad = value[..channel.components()]
                .iter()
                .find(|x| !channel.range().contains(*x));
            bad.map(|x| (channel, *x))
        })
    }
}
