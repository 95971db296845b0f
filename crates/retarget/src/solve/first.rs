//! Solves the first frame from home and from random poses near it, because a wrong branch would remain for the
//! whole clip.

use super::solver::Solver;

/// Number of random starts in addition to home, and their maximum distance from home, rad.
const STARTS: usize = 15;
const SPREAD_RAD: f64 = 1.6;
/// Maximum number of sweeps of each start.
const SWEEPS: usize = 40;
/// Weight of a squared radian from home when starts are compared.
const FROM_HOME: f64 = 0.01;
/// Another start is chosen only if its cost is below this share of the best, and lower by `BETTER_BY`.
const BETTER_PART: f64 = 0.6;
const BETTER_BY: f64 = 0.05;
/// A start whose step is smaller than this, rad or m, is settled: it moves by only about ten further steps of this
/// size. If it is not better than the best start by then, it never will be.
const SETTLED: f64 = 1e-3;

impl Solver {
    /// Finds the pose of a first frame, whose targets are set. Speed is unlimited.
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
            // Costs are not negative, therefore no other start can be better.
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

    /// Orients a free base like the performer.
    fn stand(&mut self) {
        let Some((body, upright, part)) = self.aims.stands else { return };
        if let Some(wanted) = self.aims.part_target(part, &self.targets) {
            self.model.turn_base(&mut self.state, body, wanted * upright.conjugate());
        }
    }

    /// Moves every joint of one coordinate randomly near home, within its range.
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

/// The generator `SplitMix64` (Steele, Lea & Flood 2014), so that starts are equal everywhere.
struct Random(u64);

impl Random {
    /// Returns a number in [0, 1).
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        (z >> 11) as f64 / (1u64 << 53) as f64
    }
}
