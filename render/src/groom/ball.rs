//! A ball of straight strands without order: hair whose brightness is known where it absorbs nothing.

use glam::Vec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::{Groom, GroomError};

/// Half the length of a strand; middles lie in the unit ball.
const HALF_LENGTH: f32 = 0.25;

/// Points of a strand.
const POINTS: usize = 12;

/// Radius that holds all strands.
pub const BALL_RADIUS: f32 = 1.0 + HALF_LENGTH;

/// `strands` straight strands of length 0.5 and any direction, their middles evenly spread over the unit ball; the same for the same seed.
///
/// # Errors
/// [`GroomError`] without strands or for a diameter that is not a positive number.
pub fn ball(strands: u32, diameter: f32, seed: u64) -> Result<Groom, GroomError> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut in_unit_ball = || {
        loop {
            let p = Vec3::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0_f32)));
            if (1e-3..1.0).contains(&p.length_squared()) {
                return p;
            }
        }
    };
    let strands = (0..strands).map(|_| {
        let (middle, along) = (in_unit_ball(), in_unit_ball().normalize());
        let place = |k: usize| HALF_LENGTH * (2.0 * k as f32 / (POINTS - 1) as f32 - 1.0);
        (0..POINTS).map(|k| middle + place(k) * along).collect::<Vec<_>>()
    });
    Ok(Groom::from_strands(strands, diameter, 1.0)?.0)
}
