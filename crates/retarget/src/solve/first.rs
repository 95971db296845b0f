//! The first frame: from home and from random poses near it, since a wrong branch would stay for the whole clip.

use super::solver::Solver;

/// Random starts beside home, and how far from it they lie, rad.
const STARTS: usize = 15;
const SPREAD_RAD: f64 = 1.6;
/// Sweeps of each start.
const SWEEPS: usize = 40;
/// What a radian away from home counts when starts are compared.
const FROM_HOME: f64 = 0.01;
/// Another start wins only if it is below this part of the best, and lower by this.
const BETTER_PART: f64 = 0.6;
const BETTER_BY: f64 = 0.05;
/// A start whose steps are smaller, rad or m, moves by some ten of them more: what does not win there never does.
const SETTLED: f64 = 1e-3;

impl Solver {
    /// Finds the pose of a first frame, whose targets are set. Speed is free.
    pub(super) fn find_first(&mut self) {
        let mut random = Random(1);
        let mut best: Option<(f64, Vec<f64>)> = None;
        for start in 0..=STARTS {
            let home = self.model.home.clone();
            self.state.q.copy_from_slice(&home);
            self.model.place(&mut self.state);
            self.stand();
            if start > 0 {
                self.scatter(&mut random);
            }
            self.begin();
            let wins = |cost: f64| {
                let better =
                    |(least, _): &(f64, _)| cost < BETTER_PART * least && cost < least - BETTER_BY;
                best.as_ref().is_none_or(better)
            };
            for _ in 0..SWEEPS {
                if self.sweep(None) < SETTLED && !wins(self.first_cost()) {
                    break;
                }
            }
            let cost = self.first_cost();
            if wins(cost) {
                best = Some((cost, self.state.q.clone()));
            }
            // No cost is negative: nothing could win any more.
            if best.as_ref().is_some_and(|(least, _)| *least <= BETTER_BY) {
                break;
            }
        }
        if let Some((_, q)) = best {
            self.state.q.copy_from_slice(&q);
            self.model.place(&mut self.state);
        }
        self.begin();
    }

    fn first_cost(&mut self) -> f64 {
        let [errors, from_home] = self.cost();
        errors + FROM_HOME * from_home
    }

    /// Turns a free base as the performer stands.
    fn stand(&mut self) {
        let Some((body, upright, part)) = self.aims.stands else { return };
        if let Some(wanted) = self.aims.part_target(part, &self.targets) {
            self.model.turn_base(&mut self.state, body, wanted * upright.conjugate());
        }
    }

    /// Moves every joint of one coordinate somewhere near home, within its range.
    fn scatter(&mut self, random: &mut Random) {
        for dof in &self.unknown {
            let Some(coordinate) = self.model.coordinates[*dof] else { continue };
            if self.model.slides[*dof] {
                continue;
            }
            let [least, most] = self.model.ranges[*dof];
            let away = SPREAD_RAD * (2.0 * random.next() - 1.0);
            self.state.q[coordinate] = (self.model.home[coordinate] + away).clamp(least, most);
        }
        self.model.place(&mut self.state);
    }
}

/// `SplitMix64` (Steele, Lea & Flood 2014): the same starts everywhere.
struct Random(u64);

impl Random {
    /// In [0, 1).
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        (z >> 11) as f64 / (1u64 << 53) as f64
    }
}
