//! How much a picture may hold while a hand moves: learnt from what the last ones cost.

use balayage_render::gpu::{Quality, RenderSettings};

/// Milliseconds that a picture may take while a hand moves, on a GPU and in software.
const BUDGET_MS: f64 = 33.0;
const SOFTWARE_BUDGET_MS: f64 = 150.0;

/// Least share of the strands.
const LEAST_SHARE: f32 = 1.0 / 32.0;

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
    /// pixels come back once all strands take less than a third of the budget.
    pub(crate) fn learn(&mut self, milliseconds: f64) {
        let remembered = (REMEMBERED * self.slowest_ms).min(AT_MOST * milliseconds);
        self.slowest_ms = milliseconds.max(remembered).max(0.1);
        let room = (self.budget_ms / self.slowest_ms) as f32;
        // Within some tenths the picture keeps its strands: another choice of them shimmers.
        if !(1.0..1.7).contains(&room) {
            let aim = (0.8 * room).clamp(0.25, 2.0);
            let share = (self.strand_share * aim).clamp(LEAST_SHARE, 1.0);
            self.slowest_ms *= f64::from(share / self.strand_share);
            self.strand_share = share;
        }
        if self.divisor == 2 && self.strand_share == 1.0 && room > 3.0 {
            self.divisor = 1;
        } else if self.divisor == 1 && room < 0.9 && self.strand_share < 0.5 {
            self.divisor = 2;
        }
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
            for whole in [5.0, 60.0, 400.0, 1000.0] {
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
                    ms <= budget || pace.strand_share == LEAST_SHARE,
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
