//! What each change makes stale: the dependency graph of a frame, and the one place that says so.
//!
//! A frame keeps [`Product`]s, each made from [`Input`]s and from products above it in the list. A change of an input makes stale what is
//! made from it, directly or through others, and nothing else. Within a product, ranges and work lists keep what a change did not touch.

/// What a frame is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum Input {
    /// Strands, their thickness, and the head.
    Geometry = 1,
    /// Painted parameters of some groom points.
    Parameters = 1 << 1,
    /// Model of the fibre, scheme, terms and the way light is scattered on.
    Method = 1 << 2,
    /// Node counts of the integrals, number of exact rays: better values replace worse ones, never the other way round.
    Quality = 1 << 3,
    /// Directions and bandwidths of lights.
    LightPlaces = 1 << 4,
    /// Radiances of lights.
    LightColours = 1 << 5,
    /// A factor (rgb) on all lights.
    LightGain = 1 << 6,
    /// Where the camera stands.
    Eye = 1 << 7,
    /// How the camera looks from there: orientation, field of view, pixels, samples, share of the strands.
    Lens = 1 << 8,
    /// What is seen behind hair and head.
    Background = 1 << 9,
    /// Exposure and transform of the display, backdrop.
    Display = 1 << 10,
}

/// What a frame makes and keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum Product {
    /// Fibres in voxels.
    Density = 1,
    /// What light loses in each voxel.
    Losses = 1 << 1,
    /// Share of each light that arrives, per groom point.
    Visibility = 1 << 2,
    /// Sums along the way from each light, per groom point.
    PathSums = 1 << 3,
    /// Radiance by multiple scattering, per groom point.
    Multiple = 1 << 4,
    /// Radiance by single scattering, per refined vertex.
    Single = 1 << 5,
    /// Radiance of the head's vertices.
    Head = 1 << 6,
    /// Which strands every pixel shows.
    Fragments = 1 << 7,
    /// Scene-linear pixels.
    Picture = 1 << 8,
    /// Display pixels.
    View = 1 << 9,
    /// Light that fibres send each other, in cells of the hair.
    Scattered = 1 << 10,
}

impl Product {
    /// All products, each after what it is made from.
    pub const ALL: [Self; 11] = [
        Self::Density,
        Self::Losses,
        Self::Visibility,
        Self::PathSums,
        Self::Scattered,
        Self::Multiple,
        Self::Single,
        Self::Head,
        Self::Fragments,
        Self::Picture,
        Self::View,
    ];

    /// The graph: what a product is made from.
    pub const fn made_from(self) -> (&'static [Input], &'static [Self]) {
        use Input::{
            Background, Display, Eye, Geometry, Lens, LightColours, LightGain, LightPlaces, Method,
            Parameters, Quality,
        };
        match self {
            Self::Density => (&[Geometry], &[]),
            Self::Losses => (&[Parameters, Method], &[Self::Density]),
            Self::Visibility => (&[LightPlaces, Quality], &[Self::Density]),
            Self::PathSums => (&[LightPlaces], &[Self::Losses]),
            Self::Scattered => (
                &[Geometry, Parameters, Method, Quality, LightPlaces, LightColours],
                &[],
            ),
            Self::Multiple => (
                &[Parameters, Method, Quality, LightColours, Eye],
                &[Self::PathSums, Self::Scattered],
            ),
            Self::Single => (
                &[Parameters, Method, Quality, LightColours, Eye],
                &[Self::Visibility],
            ),
            Self::Head => (&[LightPlaces, LightColours], &[Self::Density]),
            Self::Fragments => (&[Geometry, Eye, Lens], &[]),
            Self::Picture => (
                &[LightGain, Background],
                &[Self::Multiple, Self::Single, Self::Head, Self::Fragments],
            ),
            Self::View => (&[Display], &[Self::Picture]),
        }
    }
}

/// Inputs that changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Changes(u16);

impl Changes {
    /// Everything changed.
    pub const ALL: Self = Self(u16::MAX);

    /// Notes a change.
    pub fn note(&mut self, input: Input) {
        self.0 |= input as u16;
    }

    /// Whether `input` changed.
    pub const fn has(self, input: Input) -> bool {
        self.0 & input as u16 != 0
    }

    /// What the changes make stale.
    pub fn stale(self) -> Stale {
        Product::ALL.into_iter().fold(Stale(0), |stale, product| {
            let (inputs, products) = product.made_from();
            if inputs.iter().any(|i| self.has(*i)) || products.iter().any(|p| stale.has(*p)) {
                Stale(stale.0 | product as u16)
            } else {
                stale
            }
        })
    }
}

impl From<Input> for Changes {
    fn from(input: Input) -> Self {
        Self(input as u16)
    }
}

/// Products that are not up to date.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stale(u16);

impl Stale {
    /// Whether `product` is among them.
    pub const fn has(self, product: Product) -> bool {
        self.0 & product as u16 != 0
    }
}
