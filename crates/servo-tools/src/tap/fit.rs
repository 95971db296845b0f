//! Fits stiffness and damping to recorded taps, by least squares (Levenberg and Marquardt).
//!
//! All taps share stiffness, damping, drag, torque, and a delay of the step. Each tap also has its own numbers:
//! position and speed of the shaft, windup of the gear and its speed, remaining torque, and an additional delay of the
//! step. A tap's own numbers are eliminated before the shared numbers are solved.

use nalgebra::{SMatrix, SVector};

use super::joint::{Curves, Joint, Point};

/// One tap: positions of the shaft before and after a step of torque.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Tap {
    /// Time since the step was sent, s, and position in the direction of the tap, rad.
    pub(super) samples: Vec<[f64; 2]>,
    /// Step of torque, as a part of the full torque.
    pub(super) step: f64,
    /// Time that the teeth had to come to rest on each other, s.
    pub(super) meet_s: f64,
}

impl Tap {
    /// Returns the readings before a time, s.
    pub(super) fn until(&self, time_s: f64) -> Self {
        let samples = self.samples.iter().take_while(|[time, _]| *time < time_s);
        Self { samples: samples.copied().collect(), step: self.step, meet_s: self.meet_s }
    }
}

/// Result of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fitted {
    /// Inertias, friction and gear of the joint.
    pub joint: Joint,
    /// Stall torque of the motor at full supply, N m.
    pub full_nm: f64,
    /// Standard errors of stiffness and damping, relative to the values.
    pub errors: [f64; 2],
    /// First swing of the shaft, beyond the motion with a rigid gear, in counts of the encoder.
    pub ring_counts: f64,
    /// Deviation of the readings from the fit, counts.
    pub noise_counts: f64,
}

/// Number of values that all taps share: logarithms of stiffness, damping, drag and torque, relative to the expected
/// values; and the delay of the step.
const SHARED: usize = 5;
/// Number of values of a single tap, each in units of its expected size: position, speed, windup, windup speed, torque,
/// and delay.
const OWN: usize = 6;
/// Index of the delay among a tap's own values.
const DELAY: usize = 5;
/// Expected sizes of a tap's own values: 1 rad, 10 rad/s, half a count of oscillation, a third of the full torque, and
/// half a millisecond. The delay varies because the packet arrives at any time of the servo's own tick, and of a USB
/// frame.
const RING_COUNTS: f64 = 0.5;
const LEFT_OVER: f64 = 0.3;
const DELAY_S: f64 = 5e-4;
/// Expected size of the delay that all taps share, s.
const SHARED_DELAY_S: f64 = 2e-3;
/// Expected spread of the drag around its expected value, as a logarithm.
const DRAG_SPREAD: f64 = 0.1;
/// Deviation of a correct reading, counts.
const NOISE_COUNTS: f64 = 0.3;
/// Start values of the fit: factors on the expected stiffness and damping.
const STARTS: [[f64; 2]; 6] =
    [[1.0, 1.0], [1.0, 0.35], [0.4, 1.0], [0.4, 0.35], [2.5, 1.0], [2.5, 0.35]];
/// Step of a numerical difference, as a logarithm.
const DIFFERENCE: f64 = 1e-3;

type Shared = SVector<f64, SHARED>;
type Own = SVector<f64, OWN>;

/// Fits taps without an earlier result. `believed` contains the inertias and the expected values of the rest.
pub(super) fn fit(believed: &Joint, full_nm: f64, taps: &[Tap], count_rad: f64) -> Fitted {
    let problem = Problem { believed: *believed, full_nm, taps, count_rad };
    let starts = STARTS.map(|[stiffness, damping]| {
        let shared = Shared::from([stiffness.ln(), damping.ln(), 0.0, 0.0, 0.0]);
        problem.descend(State { shared, delays: vec![0.0; taps.len()] }, 8)
    });
    let best = starts.into_iter().min_by(|(a, _), (b, _)| a.total_cmp(b));
    let (_, state) = best.unwrap_or_else(|| (0.0, State::default()));
    problem.result(problem.descend(state, 30))
}

/// Fits some of the taps, starting at the result of all taps.
pub(super) fn refit(believed: &Joint, all: &Fitted, taps: &[Tap], count_rad: f64) -> Fitted {
    let problem = Problem { believed: *believed, full_nm: all.full_nm, taps, count_rad };
    let logs = [
        all.joint.stiffness_nm_rad / believed.stiffness_nm_rad,
        all.joint.damping_nm_s / believed.damping_nm_s,
        all.joint.drag_nm_s / believed.drag_nm_s,
    ]
    .map(f64::ln);
    let shared = Shared::from([logs[0], logs[1], logs[2], 0.0, 0.0]);
    problem.result(problem.descend(State { shared, delays: vec![0.0; taps.len()] }, 30))
}

struct Problem<'t> {
    believed: Joint,
    full_nm: f64,
    taps: &'t [Tap],
    count_rad: f64,
}

/// State of a descent.
#[derive(Debug, Clone, Default)]
struct State {
    shared: Shared,
    /// Delay of each tap, in [`DELAY_S`].
    delays: Vec<f64>,
}

impl State {
    /// Returns the time at which the step of a tap acted, s.
    fn delay_s(&self, index: usize) -> f64 {
        self.shared[4] * SHARED_DELAY_S + self.delays[index] * DELAY_S
    }
}

/// Sums of squares of one tap, for its own numbers and the shared numbers.
struct Sums {
    own: SMatrix<f64, OWN, OWN>,
    mixed: SMatrix<f64, OWN, SHARED>,
    shared: SMatrix<f64, SHARED, SHARED>,
    own_right: Own,
    shared_right: Shared,
}

/// Curves at a state, and with a small change of stiffness, damping and drag.
struct Tables {
    here: Curves,
    moved: [Curves; 3],
}

impl Problem<'_> {
    fn joint(&self, shared: &Shared) -> Joint {
        Joint {
            stiffness_nm_rad: self.believed.stiffness_nm_rad * shared[0].exp(),
            damping_nm_s: self.believed.damping_nm_s * shared[1].exp(),
            drag_nm_s: self.believed.drag_nm_s * shared[2].exp(),
            ..self.believed
        }
    }

    fn curves(&self, shared: &Shared) -> Curves {
        let span = |tap: &Tap| match (tap.samples.first(), tap.samples.last()) {
            (Some([first, _]), Some([last, _])) => last - first.min(0.0),
            _ => 0.0,
        };
        let longest = self.taps.iter().map(span).fold(0.0, f64::max);
        self.joint(shared).curves(longest + 4.0 * (SHARED_DELAY_S + DELAY_S))
    }

    fn tables(&self, shared: &Shared) -> Tables {
        let moved = [0, 1, 2].map(|at| {
            let mut moved = *shared;
            moved[at] += DIFFERENCE;
            self.curves(&moved)
        });
        Tables { here: self.curves(shared), moved }
    }

    /// Returns the expected sizes of a tap's own numbers except the delay, rad per unit.
    fn sizes(&self, shared: &Shared) -> [f64; 5] {
        let joint = self.joint(shared);
        let windup = RING_COUNTS * self.count_rad / joint.rotor_part();
        [1.0, 10.0, windup, windup * joint.ring_rad_s(), LEFT_OVER * self.full_nm]
    }

    /// Returns the coefficients of a tap's own numbers (except the delay) in its position, and the effect of the step:
    /// position and speed.
    fn columns(
        &self,
        shared: &Shared,
        sizes: &[f64; 5],
        free: &Point,
        step: &Point,
        part: f64,
    ) -> ([f64; 5], [f64; 2]) {
        let [coast, windup, unwinding, pushed] = free.free;
        let columns = [
            sizes[0],
            sizes[1] * coast,
            sizes[2] * windup,
            sizes[3] * unwinding,
            sizes[4] * pushed,
        ];
        let torque_nm = self.full_nm * shared[3].exp() * part;
        (columns, [torque_nm * step.free[3], torque_nm * step.pushed_rad_s])
    }

    /// Solves for a tap's own numbers except the delay. Also returns the remaining error including priors, counts².
    fn own_of(&self, curves: &Curves, state: &State, index: usize) -> (f64, [f64; 5]) {
        let (tap, delay) = (&self.taps[index], state.delays[index]);
        let sizes = self.sizes(&state.shared);
        let begin = tap.samples.first().map_or([0.0; 2], |first| *first);
        let mut matrix = SMatrix::<f64, 5, 5>::from_diagonal_element(1.0);
        let mut right = SVector::<f64, 5>::zeros();
        let mut square = delay * delay;
        let scale = 1.0 / (NOISE_COUNTS * self.count_rad);
        for [time, position] in &tap.samples {
            let free = curves.at(time - begin[0]);
            let step = curves.at(time - state.delay_s(index));
            let (columns, [wound, _]) = self.columns(&state.shared, &sizes, &free, &step, tap.step);
            let left = scale * (position - begin[1] - wound);
            square += left * left;
            for (i, a) in columns.iter().enumerate() {
                right[i] += scale * a * left;
                for (j, b) in columns.iter().enumerate().skip(i) {
                    matrix[(j, i)] += scale * scale * a * b;
                }
            }
        }
        matrix.fill_upper_triangle_with_lower_triangle();
        let Some(cholesky) = matrix.cholesky() else { return (f64::INFINITY, [0.0; 5]) };
        let own = cholesky.solve(&right);
        ((square - own.dot(&right)).max(0.0), own.into())
    }

    fn cost(&self, state: &State) -> f64 {
        let curves = self.curves(&state.shared);
        let taps: f64 =
            (0..self.taps.len()).map(|index| self.own_of(&curves, state, index).0).sum();
        taps + (state.shared[2] / DRAG_SPREAD).powi(2) + state.shared[4].powi(2)
    }

    /// Computes the sums of a tap at a state.
    fn sums(&self, tables: &Tables, state: &State, index: usize) -> Sums {
        let (tap, delay) = (&self.taps[index], state.delays[index]);
        let sizes = self.sizes(&state.shared);
        let (_, own) = self.own_of(&tables.here, state, index);
        let begin = tap.samples.first().map_or([0.0; 2], |first| *first);
        let scale = 1.0 / (NOISE_COUNTS * self.count_rad);
        let mut sums = [[0.0_f64; OWN + SHARED + 1]; OWN + SHARED];
        for [time, position] in &tap.samples {
            let [free_s, step_s] = [time - begin[0], time - state.delay_s(index)];
            let value = |curves: &Curves| {
                let (free, step) = (curves.at(free_s), curves.at(step_s));
                let (columns, [wound, speed]) =
                    self.columns(&state.shared, &sizes, &free, &step, tap.step);
                let all: f64 = columns.iter().zip(&own).map(|(column, own)| column * own).sum();
                (columns, all + wound, wound, speed)
            };
            let (columns, here, wound, speed) = value(&tables.here);
            let mut row = [0.0; OWN + SHARED + 1];
            row[..DELAY].copy_from_slice(&columns);
            row[DELAY] = -speed * DELAY_S;
            for (at, moved) in tables.moved.iter().enumerate() {
                row[OWN + at] = (value(moved).1 - here) / DIFFERENCE;
            }
            row[OWN + 3] = wound;
            row[OWN + 4] = -speed * SHARED_DELAY_S;
            row[OWN + SHARED] = position - begin[1] - here;
            for number in &mut row {
                *number *= scale;
            }
            for (a, sums) in row.iter().zip(&mut sums) {
                for (b, sum) in row.iter().zip(sums.iter_mut()) {
                    *sum += a * b;
                }
            }
        }
        // The prior of a tap's own values has its centre at 0.
        for (at, own) in own.iter().chain([&delay]).enumerate() {
            sums[at][at] += 1.0;
            sums[at][OWN + SHARED] -= own;
        }
        Sums {
            own: SMatrix::from_fn(|i, j| sums[i][j]),
            mixed: SMatrix::from_fn(|i, j| sums[i][OWN + j]),
            shared: SMatrix::from_fn(|i, j| sums[OWN + i][OWN + j]),
            own_right: SVector::from_fn(|i, _| sums[i][OWN + SHARED]),
            shared_right: SVector::from_fn(|i, _| sums[OWN + i][OWN + SHARED]),
        }
    }

    /// Returns the sums of all taps, and the equations with the taps' own numbers eliminated.
    fn reduced(&self, state: &State) -> (Vec<Sums>, SMatrix<f64, SHARED, SHARED>, Shared) {
        let tables = self.tables(&state.shared);
        let sums: Vec<Sums> =
            (0..self.taps.len()).map(|index| self.sums(&tables, state, index)).collect();
        let prior = 1.0 / (DRAG_SPREAD * DRAG_SPREAD);
        let mut matrix = SMatrix::from_diagonal(&Shared::from([1e-9, 1e-9, prior, 1e-9, 1.0]));
        let mut right = Shared::from([0.0, 0.0, -prior * state.shared[2], 0.0, -state.shared[4]]);
        for tap in &sums {
            let Some(own) = tap.own.cholesky() else { continue };
            matrix += tap.shared - tap.mixed.transpose() * own.solve(&tap.mixed);
            right += tap.shared_right - tap.mixed.transpose() * own.solve(&tap.own_right);
        }
        (sums, matrix, right)
    }

    /// Descends for at most `most` steps. Returns the cost and the state.
    fn descend(&self, start: State, most: u32) -> (f64, State) {
        let (mut state, mut caution) = (start, 1e-3);
        let mut cost = self.cost(&state);
        for _ in 0..most {
            let (sums, matrix, right) = self.reduced(&state);
            let mut careful = matrix;
            for at in 0..SHARED {
                careful[(at, at)] *= 1.0 + caution;
            }
            let Some(solved) = careful.cholesky() else { break };
            // Limits each step: a value changes by at most half.
            let step = solved.solve(&right).map(|step| step.clamp(-0.4, 0.4));
            let delays = state.delays.iter().zip(&sums).map(|(delay, tap)| {
                let own =
                    tap.own.cholesky().map(|own| own.solve(&(tap.own_right - tap.mixed * step)));
                (delay + own.map_or(0.0, |own| own[DELAY].clamp(-0.5, 0.5))).clamp(-4.0, 4.0)
            });
            let next = State { shared: state.shared + step, delays: delays.collect() };
            let after = self.cost(&next);
            if after < cost {
                let is_done = cost - after < 1e-4 && step.amax() < 1e-3;
                (state, cost) = (next, after);
                caution = (caution * 0.2).max(1e-9);
                if is_done {
                    break;
                }
            } else if caution > 1e3 {
                break;
            } else {
                caution *= 10.0;
            }
        }
        (cost, state)
    }

    fn result(&self, (cost, state): (f64, State)) -> Fitted {
        let joint = self.joint(&state.shared);
        let (_, matrix, _) = self.reduced(&state);
        let readings: usize = self.taps.iter().map(|tap| tap.samples.len()).sum();
        let free = (readings as f64 - (OWN * self.taps.len() + SHARED) as f64).max(1.0);
        let variance = cost / free;
        let inverse = matrix.try_inverse();
        let error = |at: usize| {
            inverse.map_or(f64::INFINITY, |inverse| (variance * inverse[(at, at)]).max(0.0).sqrt())
        };
        let full_nm = self.full_nm * state.shared[3].exp();
        let part =
            self.taps.iter().map(|tap| tap.step).sum::<f64>() / self.taps.len().max(1) as f64;
        Fitted {
            joint,
            full_nm,
            errors: [error(0), error(1)],
            ring_counts: full_nm * part * joint.ring_rad_nm() / self.count_rad,
            noise_counts: NOISE_COUNTS * variance.sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNT_RAD: f64 = 1.533_98e-3;

    /// Simulates taps of a joint as an encoder measures them. All taps differ.
    fn taps(joint: &Joint, full_nm: f64) -> Vec<Tap> {
        let curves = joint.curves(0.2);
        let tap = |index: u32| {
            let [place, speed, late] =
                [0.618_034, 0.754_878, 0.819_173].map(|step| (f64::from(index) * step).fract());
            let samples = (-20..53).map(|ms| {
                let time_s = 1e-3 * f64::from(ms);
                let [creep, preload, step] =
                    [0.04, 0.039, -1e-3 * late].map(|more_s| curves.at(time_s + more_s));
                let torque_nm = |part: f64, point: &Point| part * full_nm * point.free[3];
                let position_rad = 10.0 * place * COUNT_RAD
                    + (0.1 + 0.05 * speed) * creep.free[0]
                    + torque_nm(0.1, &preload)
                    + torque_nm(0.5, &step);
                [time_s, (position_rad / COUNT_RAD).round() * COUNT_RAD]
            });
            Tap { samples: samples.collect(), step: 0.5, meet_s: 0.1 }
        };
        (0..100).map(tap).collect()
    }

    #[test]
    fn what_taps_were_made_of_is_found_within_three_standard_errors() {
        for (stiffness, damping) in [(286.0, 0.36), (143.0, 0.12), (71.0, 0.36)] {
            let joint = Joint {
                rotor_kg_m2: 5e-3,
                load_kg_m2: 5e-3,
                stiffness_nm_rad: stiffness,
                damping_nm_s: damping,
                drag_nm_s: 0.43,
                load_frictions: [0.06, 0.03],
            };
            let believed =
                Joint { stiffness_nm_rad: 143.0, damping_nm_s: 0.36, drag_nm_s: 0.45, ..joint };
            let fitted = fit(&believed, 2.85, &taps(&joint, 2.6), COUNT_RAD);
            let off = [
                fitted.joint.stiffness_nm_rad / stiffness - 1.0,
                fitted.joint.damping_nm_s / damping - 1.0,
            ];
            for (off, error) in off.iter().zip(fitted.errors) {
                assert!(off.abs() < 3.0 * error && error < 0.08, "{off} {fitted:?}");
            }
            assert!((fitted.full_nm / 2.6 - 1.0).abs() < 0.05, "{fitted:?}");
            // Evenly spread encoder steps have a deviation of 1/sqrt(12) of a count.
            assert!((fitted.noise_counts - 0.29).abs() < 0.02, "{fitted:?}");
        }
    }
}
