//! `--set CHANNEL=VALUE`: unpainted parameters from the command line.

use std::str::FromStr;

use balayage_render::param::{Channel, LobeRatios};

use crate::document::HairSettings;

/// One `--set`.
#[derive(Clone, Debug)]
pub(super) struct HairOption {
    key: String,
    values: Vec<f32>,
}

impl FromStr for HairOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (key, list) = text
            .split_once('=')
            .ok_or("write CHANNEL=VALUE, as in eumelanin=1.3")?;
        let values = list
            .split(',')
            .map(|x| x.trim().parse::<f32>().map_err(|e| format!("\"{x}\": {e}")))
            .collect::<Result<Vec<_>, _>>()?;
        let option = Self {
            key: key.trim().to_owned(),
            values,
        };
        // Whether it can be applied does not depend on what it is applied to.
        option.apply(&mut HairSettings::default())?;
        Ok(option)
    }
}

impl HairOption {
    /// Changes `hair` as the option says.
    ///
    /// # Errors
    /// Unknown channels, wrong numbers of values, values out of range.
    pub(super) fn apply(&self, hair: &mut HairSettings) -> Result<(), String> {
        let base = &mut hair.base.known;
        let ratios = &mut hair.ratios.known;
        match self.key.as_str() {
            "sigma_a" => {
                base.dye = self.three()?;
                base.eumelanin = 0.0;
                base.pheomelanin = 0.0;
            }
            "azimuthal_width" => {
                // Xu's bandwidth in radians is sqrt(2) times the standard deviation.
                base.azimuthal_deg = (self.one()? / std::f32::consts::SQRT_2).to_degrees();
            }
            "alpha_deg" => {
                let usual = LobeRatios::default();
                let [r, tt, trt] = self.lobes(usual.alpha_tt, usual.alpha_trt)?;
                base.alpha_deg = r;
                ratios.alpha_tt = ratio(tt, r, usual.alpha_tt)?;
                ratios.alpha_trt = ratio(trt, r, usual.alpha_trt)?;
            }
            "beta_deg" => {
                let usual = LobeRatios::default();
                let [r, tt, trt] = self.lobes(usual.beta_tt, usual.beta_trt)?;
                base.beta_deg = r;
                ratios.beta_tt = ratio(tt, r, usual.beta_tt)?;
                ratios.beta_trt = ratio(trt, r, usual.beta_trt)?;
            }
            "diameter" => hair.diameter = Some(self.one()?),
            key => {
                let channel = Channel::ALL
                    .into_iter()
                    .find(|channel| channel.name() == key)
                    .ok_or_else(|| {
                        let names = Channel::ALL.map(Channel::name).join(", ");
                        format!("no channel \"{key}\"; known are sigma_a, azimuthal_width, diameter, {names}")
                    })?;
                let value = if channel == Channel::Dye {
                    self.three()?
                } else {
                    [self.one()?, 0.0, 0.0]
                };
                base.set(channel, value);
            }
        }
        crate::document::check_hair(hair).map_err(|p| p.to_string())
    }

    fn one(&self) -> Result<f32, String> {
        match self.values[..] {
            [x] => Ok(x),
            _ => Err(format!("{} takes one value", self.key)),
        }
    }

    fn three(&self) -> Result<[f32; 3], String> {
        self.values[..]
            .try_into()
            .map_err(|_| format!("{} takes three values, r,g,b", self.key))
    }

    /// R, TT, TRT: as given, or from R by the usual ratios.
    fn lobes(&self, tt: f32, trt: f32) -> Result<[f32; 3], String> {
        match self.values[..] {
            [r] => Ok([r, tt * r, trt * r]),
            [r, tt, trt] => Ok([r, tt, trt]),
            _ => Err(format!("{} takes one value (R) or three (R,TT,TRT)", self.key)),
        }
    }
}

/// A lobe's value relative to R's. Relative to nothing only nothing has a ratio, the usual one.
fn ratio(lobe: f32, r: f32, usual: f32) -> Result<f32, String> {
    match (lobe == 0.0, r == 0.0) {
        (true, true) => Ok(usual),
        (false, true) => Err("TT and TRT are kept relative to R: give R another value than 0".to_owned()),
        _ => Ok(lobe / r),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_reach_the_hair() {
        let mut hair = HairSettings::default();
        for text in [
            "sigma_a=0.1,0.2,0.3",
            "beta_deg=6,3,9",
            "alpha_deg=-4",
            "azimuthal_width=0.2",
            "diameter=0.01",
            "eta=1.6",
        ] {
            text.parse::<HairOption>().unwrap().apply(&mut hair).unwrap();
        }
        let base = hair.base.known;
        assert_eq!(
            (base.dye, base.eumelanin, base.pheomelanin),
            ([0.1, 0.2, 0.3], 0.0, 0.0)
        );
        assert_eq!(
            (
                base.beta_deg,
                hair.ratios.known.beta_tt,
                hair.ratios.known.beta_trt
            ),
            (6.0, 0.5, 1.5)
        );
        assert_eq!((base.alpha_deg, hair.ratios.known.alpha_tt), (-4.0, -0.5));
        let params = base.vertex_params(hair.pigments, &hair.ratios.known);
        assert!((params.azimuthal_width - 0.2).abs() < 1e-6 && params.eta == 1.6);
        assert_eq!(hair.diameter, Some(0.01));
    }

    #[test]
    fn nonsense_is_refused() {
        for text in [
            "eta",
            "eta=",
            "eta=x",
            "eta=nan",
            "eta=inf",
            "eta=0",
            "eta=1,2",
            "dye=1",
            "hue=3",
            "alpha_deg=0,1,1",
            "bleach=-1",
        ] {
            assert!(text.parse::<HairOption>().is_err(), "{text}");
        }
    }
}
