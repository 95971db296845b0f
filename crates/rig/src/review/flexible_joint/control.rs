//! The control loop of a joint, tick by tick, and as matrices of the whole loop.

use super::complex::{Complex, solve};
use super::matrix::Matrix;
use super::plant::{FlexibleJoint, Step};

/// The sampled loop of the tracker on one joint. It has the gains of stable PD in implicit form, critically damped
/// ([`Gains::implicit`](sinew_core::control::Gains::implicit)), and an extended state observer that cancels the
/// estimated disturbance and predicts over the latency ([`sinew_core::observer`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlLoop {
    /// Control period, s.
    pub dt_s: f64,
    /// Delay until a torque acts, in ticks; the observer predicts over it.
    pub latency_ticks: usize,
    /// Additional delay that the observer does not know, s.
    pub late_s: f64,
    /// Bandwidth of the observer, rad/s.
    pub bandwidth_rad_s: f64,
    /// Stiffness per inertia, 1/s².
    pub kp_per_s2: f64,
    /// Share of the commanded torque that the servo gives. Differs from 1 for a wrong torque constant or inertia.
    pub torque_share: f64,
}

/// Constants of a loop's computation in a tick.
#[derive(Debug, Clone, Copy)]
struct Controller {
    dt_s: f64,
    kp: f64,
    kd: f64,
    pose_gain: f64,
    velocity_gain: f64,
    disturbance_gain: f64,
}

impl Controller {
    fn of(control: &ControlLoop) -> Self {
        let ControlLoop { dt_s, bandwidth_rad_s, kp_per_s2, .. } = *control;
        let kd = 2.0 * libm::sqrt(kp_per_s2);
        let soft = 1.0 + dt_s * (kd + dt_s * kp_per_s2);
        let beta = libm::exp(-bandwidth_rad_s * dt_s);
        let rest = 1.0 - beta;
        Self {
            dt_s,
            kp: kp_per_s2 / soft,
            kd: (kd + dt_s * kp_per_s2) / soft,
            pose_gain: 1.0 - beta * beta * beta,
            velocity_gain: rest * rest * (1.0 + 2.0 * beta) / dt_s,
            disturbance_gain: rest * rest * rest / (dt_s * dt_s),
        }
    }

    /// Processes a reading. `sent` contains the `latency_ticks + 1` latest requested accelerations, the latest
    /// first. Returns the estimate and the requested acceleration.
    fn tick(
        &self,
        [angle, speed, disturbance]: [f64; 3],
        sent: &[f64],
        read: f64,
    ) -> ([f64; 3], f64) {
        let dt_s = self.dt_s;
        let (made, on_their_way) = sent.split_last().unwrap_or((&0.0, &[]));
        let expected_speed = speed + (made + disturbance) * dt_s;
        let expected = angle + expected_speed * dt_s;
        let off = read - expected;
        let angle = expected + self.pose_gain * off;
        let speed = expected_speed + self.velocity_gain * off;
        let disturbance = disturbance + self.disturbance_gain * off;
        let (mut angle_then, mut speed_then) = (angle, speed);
        for asked in on_their_way.iter().rev() {
            speed_then += (asked + disturbance) * dt_s;
            angle_then += speed_then * dt_s;
        }
        let asked = -self.kp * angle_then - self.kd * speed_then - disturbance;
        ([angle, speed, disturbance], asked)
    }
}

/// A loop of a joint, opened where the torque acts. The input is the acting torque and the output is the requested
/// torque, both as accelerations of the whole inertia.
///
/// Its state contains four numbers of the joint, three of the estimate, then the requested and the acting
/// accelerations, the latest first. Units are based on ticks, so that all numbers have similar size.
#[derive(Debug, Clone)]
pub(super) struct OpenLoop {
    /// Matrix from the state to the next state.
    state: Matrix,
    /// Row from the state to the requested acceleration.
    asked: Vec<f64>,
    /// Effect of the input on the next state. A reading precedes the torque that is computed from it, therefore the
    /// input has no direct effect on the output.
    acting: Vec<f64>,
}

/// Number of values in the joint's state, and in the estimate's state.
const JOINT: usize = 4;
const ESTIMATE: usize = 3;

impl OpenLoop {
    pub(super) fn new(joint: &FlexibleJoint, control: &ControlLoop) -> Self {
        let ControlLoop { dt_s, latency_ticks, late_s, torque_share, .. } = *control;
        let controller = Controller::of(control);
        // The delay is split into whole ticks and the rest of a tick, during which the previous torque still acts.
        let delay_s = latency_ticks as f64 * dt_s + late_s;
        let mut ticks = 0;
        while (ticks + 1) as f64 * dt_s <= delay_s * (1.0 + 1e-12) {
            ticks += 1;
        }
        let rest_s = (delay_s - ticks as f64 * dt_s).max(0.0);
        let [before, after] = [rest_s, dt_s - rest_s].map(|time_s| joint.step(time_s));
        let plant = Plant { before, after, torque: joint.inertia() * torque_share };
        let sent = latency_ticks + 1;
        let held = ticks + 1;
        let estimate_end = JOINT + ESTIMATE;
        let sent_end = estimate_end + sent;
        let size = sent_end + held;
        // Units based on ticks: a speed is an angle per tick.
        let (speed, acceleration) = (1.0 / dt_s, 1.0 / (dt_s * dt_s));
        let units: Vec<f64> = [1.0, speed, 1.0, speed, 1.0, speed, acceleration]
            .into_iter()
            .chain(std::iter::repeat_n(acceleration, sent + held))
            .collect();
        let step = |x: &[f64], acting: f64| -> (Vec<f64>, f64) {
            let x: Vec<f64> = x.iter().zip(&units).map(|(x, unit)| x * unit).collect();
            let joint = [x[0], x[1], x[2], x[3]];
            let estimate = [x[4], x[5], x[6]];
            let (sent, held) = (&x[estimate_end..sent_end], &x[sent_end..]);
            let (estimate, asked) = controller.tick(estimate, sent, joint[0]);
            let acting = acting * acceleration;
            let mut all = vec![acting];
            all.extend_from_slice(held);
            let joint = plant.tick(joint, all[ticks], all[ticks + 1]);
            let mut next = [&joint[..], &estimate[..], &[asked]].concat();
            next.extend_from_slice(&sent[..sent.len() - 1]);
            next.extend_from_slice(&all[..held.len()]);
            (next.iter().zip(&units).map(|(x, unit)| x / unit).collect(), asked / acceleration)
        };
        let unit = |place: usize| {
            let mut unit = vec![0.0; size];
            unit[place] = 1.0;
            unit
        };
        Self {
            state: Matrix::of_map(size, |x| step(x, 0.0).0),
            asked: (0..size).map(|place| step(&unit(place), 0.0).1).collect(),
            acting: step(&vec![0.0; size], 1.0).0,
        }
    }

    /// Returns the matrix of the closed loop, with the torque multiplied by `gain`.
    pub(super) fn closed(&self, gain: f64) -> Matrix {
        let size = self.asked.len();
        Matrix::of_map(size, |x| {
            let asked: f64 = self.asked.iter().zip(x).map(|(a, b)| a * b).sum();
            let moved = self.state.apply(x);
            moved.iter().zip(&self.acting).map(|(x, b)| x + b * gain * asked).collect()
        })
    }

    /// Returns the return ratio of the loop at a frequency of `angle_rad` per tick. If the ratio is -1 at some
    /// frequency, the closed loop oscillates forever.
    pub(super) fn response(&self, angle_rad: f64) -> Complex {
        let z = Complex::turn(angle_rad);
        let rows = self.state.rows().zip(&self.acting).enumerate().map(|(place, (row, acting))| {
            let mut row: Vec<Complex> = row.iter().map(|item| Complex::real(-item)).collect();
            row[place] = row[place] + z;
            row.push(Complex::real(*acting));
            row
        });
        let state = solve(rows.collect());
        let asked = self.asked.iter().zip(&state);
        asked.fold(Complex::default(), |sum, (c, x)| sum - Complex::real(*c) * *x)
    }
}

/// The joint over a tick in which the torque changes once.
struct Plant {
    before: Step,
    after: Step,
    /// Torque per acceleration.
    torque: f64,
}

impl Plant {
    fn tick(&self, state: [f64; 4], now: f64, until_then: f64) -> [f64; 4] {
        let state = self.before.of(state, self.torque * until_then);
        self.after.of(state, self.torque * now)
    }
}
