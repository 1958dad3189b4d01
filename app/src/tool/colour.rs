//! Colours as hair is seen in them, for the hair of a project.

use balayage_render::{
    optics::{
        Fibre, OpticsError,
        seen::{DeepHair, SolvedColour},
    },
    param::{LobeRatios, PigmentSet, PointValues},
};

/// What hair with the shape of a project's unpainted hair looks like at any absorption.
pub struct HairColour {
    values: PointValues,
    ratios: LobeRatios,
    pigments: PigmentSet,
    hair: DeepHair,
}

/// A dye for a wanted colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DyeMatch {
    /// Absorption per fibre radius.
    pub dye: [f32; 3],
    /// The colour that comes out, linear Rec.709.
    pub colour: [f32; 3],
    /// False where no absorption gives the colour.
    pub in_gamut: bool,
    /// True where the hair is darker than the colour: it has to be bleached first.
    pub wants_bleach: bool,
}

impl HairColour {
    /// For hair with these parameters.
    ///
    /// # Errors
    /// Parameters that the model refuses.
    pub fn new(values: &PointValues, ratios: &LobeRatios, pigments: PigmentSet) -> Result<Self, OpticsError> {
        let params = values.vertex_params(pigments, ratios);
        let of_lobes = |r: f32, ratios: [f32; 2]| [r, r * ratios[0], r * ratios[1]].map(f64::from);
        let fibre = Fibre {
            eta: f64::from(params.eta),
            eccentricity: 1.0,
            sigma_a: [0.0; 3],
            alpha: of_lobes(params.alpha_rad, params.alpha_ratios),
            beta: of_lobes(params.beta_rad, params.beta_ratios),
            azimuthal_width: f64::from(params.azimuthal_width),
        };
        Ok(Self {
            values: *values,
            ratios: *ratios,
            pigments,
            hair: DeepHair::new(&fibre)?,
        })
    }

    /// True where it was made for these parameters.
    pub fn is_for(&self, values: &PointValues, ratios: &LobeRatios, pigments: PigmentSet) -> bool {
        self.values == *values && self.ratios == *ratios && self.pigments == pigments
    }

    /// The colour that an absorption is seen in, linear Rec.709.
    pub fn seen(&self, sigma_a: [f32; 3]) -> [f32; 3] {
        self.hair.colour(&sigma_a.map(f64::from)).map(|x| x as f32)
    }

    /// The colour of the unpainted hair.
    pub fn natural(&self) -> [f32; 3] {
        self.seen(self.natural_absorption())
    }

    /// The dye that gives `colour`: on bleached hair all of the absorption, else what the hair's own melanin lacks.
    pub fn dye_for(&self, colour: [f32; 3], on_bleached: bool) -> DyeMatch {
        let SolvedColour {
            sigma_a, in_gamut, ..
        } = self.hair.solve(&colour.map(f64::from));
        let own = if on_bleached {
            [0.0; 3]
        } else {
            self.natural_absorption()
        };
        let missing: [f32; 3] = std::array::from_fn(|c| sigma_a[c] as f32 - own[c]);
        let dye = missing.map(|x| x.max(0.0));
        DyeMatch {
            dye,
            colour: self.seen(std::array::from_fn(|c| own[c] + dye[c])),
            in_gamut,
            wants_bleach: missing.iter().zip(own).any(|(x, own)| *x < -0.02 * own),
        }
    }

    /// Absorption of the unpainted hair.
    pub fn natural_absorption(&self) -> [f32; 3] {
        self.values.vertex_params(self.pigments, &self.ratios).sigma_a
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn brown() -> HairColour {
        let ratios = LobeRatios::default();
        HairColour::new(&PointValues::default(), &ratios, PigmentSet::default()).unwrap()
    }

    #[test]
    fn a_dye_gives_the_colour_it_was_picked_for() {
        let hair = brown();
        let copper = hair.seen([0.1, 0.6, 1.5]);
        let found = hair.dye_for(copper, true);
        assert!(found.in_gamut && !found.wants_bleach);
        assert!(
            found
                .dye
                .iter()
                .zip([0.1, 0.6, 1.5])
                .all(|(a, b)| (a - b).abs() < 1e-3 * b),
            "{found:?}"
        );

        // On the hair's own melanin less dye is needed, and a lighter colour is out of reach without bleach.
        let dark = hair.seen(hair.natural_absorption().map(|x| x + 1.0));
        let found = hair.dye_for(dark, false);
        assert!(
            !found.wants_bleach && found.dye.iter().all(|x| (x - 1.0).abs() < 1e-2),
            "{found:?}"
        );
        assert!(hair.dye_for(copper, false).wants_bleach);
        assert!(!hair.dye_for([1.0; 3], true).in_gamut);
    }
}
