//! How much a picture may hold while a hand moves: learnt from what the last ones cost.

use balayage_render::gpu::{Quality, RenderSettings};

/// Milliseconds that a picture may take while a hand moves, on a GPU and in software.
const BUDGET_MS: f64 = 33.0;
const SOFTWARE_BUDGET_MS: f64 = 150.0;

/// Least share of the strands, and least pixels.
const LEAST_SHARE: f32 = 1.0 / 64.0;
const LARGEST_DIVISOR: u32 = 4;

/// Above this one pixels are given up only where the strands are as few as can be.
const USUAL_DIVISOR: u32 = 2;

/// What the next quick picture is drawn with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pace {
    /// Share of the strands.
    pub(crate) strand_share: f32,
    /// Pixels of the viewport's side to one of the picture's.
    divisor: u32,
    /// Milliseconds that a picture may take.
    pub(crate) budget_ms: f64,
    /// Milliseconds of the slowest of the last pictures, had it held what the next one does.
    slowest_ms: f64,
}

/// Some pictures while a hand moves do more than the others: how long a slow one is remembered (share that is left of it after each picture),
/// and how many times the present one it counts at most, so that one that compiled something is forgotten.
const REMEMBERED: f64 = 0.95;
const AT_MOST: f64 = 2.5;

impl Pace {
    /// Before anything is known: little enough that the first picture comes soon.
    pub(crate) fn unknown(is_software: bool) -> Self {
        Self {
            strand_share: if is_software { 0.125 } else { 1.0 },
            divisor: if is_software { 2 } else { 1 },
            budget_ms: if is_software {
                SOFTWARE_BUDGET_MS
            } else {
                BUDGET_MS
            },
            slowest_ms: 0.0,
        }
    }

    /// A quick picture's settings, where `full` are those of a view at rest.
    pub(crate) fn settings(&self, full: RenderSettings) -> RenderSettings {
        let mut quick = RenderSettings {
            interactive: true,
            samples: 1,
            strand_share: self.strand_share,
            ..full
        };
        quick.shade.method.quality = Quality::Draft;
        quick
    }

    /// Size of the picture for a viewport of `size` pixels.
    pub(crate) fn size(&self, size: [u32; 2]) -> [u32; 2] {
        size.map(|side| (side / self.divisor).max(1))
    }

    /// Learns from a picture that took so long. Its cost grows with the strands: strands are given up first in proportion, then pixels;
    /// pixels come back once they take less than a third of the budget, all of them only with all strands.
    pub(crate) fn learn(&mut self, milliseconds: f64) {
        let remembered = (REMEMBERED * self.slowest_ms).min(AT_MOST * milliseconds);
        self.slowest_ms = milliseconds.max(remembered).max(0.1);
        let room = (self.budget_ms / self.slowest_ms) as f32;
        let (share, divisor) = (self.strand_share, self.divisor);
        // Within some tenths the picture keeps its strands: another choice of them shimmers.
        if room < 1.0 || (room >= 1.7 && divisor <= USUAL_DIVISOR) {
            let aim = (0.8 * room).clamp(0.25, 2.0);
            self.strand_share = (share * aim).clamp(LEAST_SHARE, 1.0);
        }
        let may_lose_pixels = (divisor < USUAL_DIVISOR && self.strand_share < 0.5)
            || (divisor < LARGEST_DIVISOR && share == LEAST_SHARE);
        if room > 3.0 && (share == 1.0 || divisor > USUAL_DIVISOR) {
            self.divisor = (divisor - 1).max(1);
        } else if room < 0.9 && may_lose_pixels {
            self.divisor += 1;
        }
        // What is remembered is what it would have cost with these.
        self.slowest_ms *=
            f64::from(self.strand_share / share) * f64::from(divisor) / f64::from(self.divisor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Milliseconds of a picture that costs `whole` with all strands, a tenth of it whatever it holds.
    fn cost(pace: &Pace, whole: f64) -> f64 {
        whole * (0.1 + 0.9 * f64::from(pace.strand_share)) / f64::from(pace.divisor)
    }

    #[test]
    fn the_pace_finds_its_budget_and_keeps_it() {
        for (is_software, budget) in [(true, SOFTWARE_BUDGET_MS), (false, BUDGET_MS)] {
            for whole in [5.0, 60.0, 400.0, 1000.0, 4000.0] {
                let mut pace = Pace::unknown(is_software);
                // Every other picture does twice the work.
                let learn = |pace: &mut Pace, k: u32| pace.learn(cost(pace, whole * f64::from(1 + k % 2)));
                for k in 0..40 {
                    learn(&mut pace, k);
                }
                let found = pace.strand_share;
                for k in 0..20 {
                    learn(&mut pace, k);
                    assert_eq!(pace.strand_share, found, "it rests");
                }
                let ms = cost(&pace, 2.0 * whole);
                assert!(
                    ms <= budget || (pace.strand_share, pace.divisor) == (LEAST_SHARE, LARGEST_DIVISOR),
                    "{ms} ms of {budget} at {whole}: {pace:?}"
                );
                // Cheap scenes get everything, and no scene is thinned more than it has to be.
                assert!(pace.strand_share == 1.0 || ms > 0.5 * budget, "{ms}: {pace:?}");
            }
        }
    }

    #[test]
    fn a_slow_picture_thins_the_next_one() {
        let mut pace = Pace::unknown(false);
        pace.learn(1000.0);
        assert_eq!((pace.strand_share, pace.divisor), (0.25, 2));
        // The next ones show that it was an accident.
        for _ in 0..4 {
            pace.learn(5.0);
        }
        assert_eq!(pace.strand_share, 1.0);
        assert_eq!(pace.size([1001, 1]), [500, 1]);
    }
}
