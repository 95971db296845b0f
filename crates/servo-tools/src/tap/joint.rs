//! A rotor, a gear and a load, and their oscillation.

use nalgebra::{SMatrix, SVector};

/// Torques that push a joint.
#[derive(Debug, Clone, Copy)]
pub(super) struct Push {
    /// Torque of the motor before the step, N m.
    pub(super) preload_nm: f64,
    /// Duration of the torque before the step, s.
    pub(super) preload_s: f64,
    /// Step of torque, N m.
    pub(super) step_nm: f64,
    /// Constant torque by which friction and gravity resist at the shaft, N m.
    pub(super) held_nm: f64,
}

/// Two masses with a spring and a damper between them, with all values at the output shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint {
    /// Inertia of the rotor at the output shaft, kg m².
    pub rotor_kg_m2: f64,
    /// Inertia of the load on the shaft, kg m².
    pub load_kg_m2: f64,
    /// Stiffness of the gear, N m/rad.
    pub stiffness_nm_rad: f64,
    /// Damping between the two ends of the gear, N m s.
    pub damping_nm_s: f64,
    /// Viscous friction and back-EMF of the rotor, N m s.
    pub drag_nm_s: f64,
    /// Friction per torque of motor and gear, at the rotor and at the shaft.
    pub load_frictions: [f64; 2],
}

/// Torque of the gear, relative to its maximum, below which its teeth may lose contact.
const LEAST_PUSH: f64 = -0.1;

impl Joint {
    /// Returns the undamped frequency of the oscillation, rad/s.
    pub fn ring_rad_s(&self) -> f64 {
        (self.stiffness_nm_rad * self.mobility()).sqrt()
    }

    /// Returns the undamped period of the oscillation, s.
    pub fn period_s(&self) -> f64 {
        2.0 * std::f64::consts::PI / self.ring_rad_s()
    }

    /// Returns the damping ratio of the oscillation: 1 is critical.
    pub fn damping_ratio(&self) -> f64 {
        0.5 * self.damping_nm_s * self.mobility() / self.ring_rad_s()
    }

    /// Returns the shaft's amplitude after a step of torque, rad per N m.
    pub fn ring_rad_nm(&self) -> f64 {
        self.rotor_part() * (1.0 - self.rotor_part()) / self.stiffness_nm_rad
    }

    /// Returns the rotor's share of the total inertia.
    pub fn rotor_part(&self) -> f64 {
        self.rotor_kg_m2 / (self.rotor_kg_m2 + self.load_kg_m2)
    }

    fn mobility(&self) -> f64 {
        1.0 / self.rotor_kg_m2 + 1.0 / self.load_kg_m2
    }

    /// Computes the motion of the shaft from 0 to `until_s`, free and under a torque.
    pub(super) fn curves(&self, until_s: f64) -> Curves {
        let [stiffness, damping] = [self.stiffness_nm_rad, self.damping_nm_s];
        let [rotor, load] = [self.rotor_kg_m2, self.load_kg_m2];
        // The state is position and speed of rotor and shaft, and a constant torque of the motor. All torques and
        // speeds have one sign, so friction that grows with torque is a fixed share of each torque.
        let [at_rotor, at_shaft] = self.load_frictions;
        let [pushed, pulled] = [(1.0 - at_rotor) / rotor, (1.0 + at_rotor) / rotor];
        let [carried, rubbed] = [(1.0 - at_shaft) / load, -at_shaft / load];
        let drag = self.drag_nm_s;
        #[rustfmt::skip]
        let rates = SMatrix::<f64, 5, 5>::from_row_slice(&[
            0.0, 1.0, 0.0, 0.0, 0.0,
            -stiffness * pulled, -damping * pulled - drag * pushed, stiffness * pulled, damping * pulled, pushed,
            0.0, 0.0, 0.0, 1.0, 0.0,
            stiffness * carried, damping * carried - drag * rubbed, -stiffness * carried, -damping * carried, rubbed,
            0.0, 0.0, 0.0, 0.0, 0.0,
        ]);
        let step = (rates * Curves::STEP_S).exp();
        // The two ends turn in opposite directions, so that the total momentum is zero.
        let [ahead, behind] = [1.0 - self.rotor_part(), -self.rotor_part()];
        let starts: [SVector<f64, 5>; 4] = [
            [0.0, 1.0, 0.0, 1.0, 0.0],
            [ahead, 0.0, behind, 0.0, 0.0],
            [0.0, ahead, 0.0, behind, 0.0],
            [0.0, 0.0, 0.0, 0.0, 1.0],
        ]
        .map(SVector::from);
        let mut states = starts;
        let mut points = Vec::new();
        while points.len() as f64 * Curves::STEP_S < until_s + 2.0 * Curves::STEP_S {
            let [coast, windup, unwinding, pushed] = states;
            points.push(Point {
                free: [coast[2], windup[2], unwinding[2], pushed[2]],
                pushed_rad_s: pushed[3],
                gear_nm: stiffness * (pushed[0] - pushed[2]) + damping * (pushed[1] - pushed[3]),
            });
            states = states.map(|state| step * state);
        }
        Curves { points }
    }

    /// Returns the time for which the gear pushes after the step, s, at most `until_s`. Later the teeth may separate,
    /// because the motor no longer accelerates.
    pub(super) fn contact_s(&self, push: &Push, until_s: f64) -> f64 {
        let curves = self.curves(until_s + push.preload_s);
        let [mut most_nm, mut time_s]: [f64; 2] = [0.0; 2];
        while time_s < until_s {
            let gear_nm = push.preload_nm * curves.at(time_s + push.preload_s).gear_nm
                + push.step_nm * curves.at(time_s).gear_nm
                + push.held_nm;
            most_nm = most_nm.max(gear_nm);
            if gear_nm < LEAST_PUSH * most_nm {
                break;
            }
            time_s += Curves::STEP_S;
        }
        time_s
    }
}

/// Motions of the shaft from time 0 on, as a table.
pub(super) struct Curves {
    points: Vec<Point>,
}

/// Motion of the shaft at a time.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Point {
    /// Position, rad, for four unit starts: rotor and shaft at 1 rad/s; windup of 1 rad; windup speed of 1 rad/s; a
    /// torque of 1 N m from time 0 on.
    pub(super) free: [f64; 4],
    /// Speed for the last of these starts, rad/s.
    pub(super) pushed_rad_s: f64,
    /// Torque of the gear for the last of these starts, N m.
    gear_nm: f64,
}

impl Curves {
    const STEP_S: f64 = 1e-4;

    /// Returns the motion at a time, interpolated; at rest before 0.
    pub(super) fn at(&self, time_s: f64) -> Point {
        if time_s <= 0.0 {
            return Point::default();
        }
        let place = time_s / Self::STEP_S;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a number of steps, above 0"
        )]
        let index = (place as usize).min(self.points.len().saturating_sub(2));
        let [Some(before), Some(after)] = [self.points.get(index), self.points.get(index + 1)]
        else {
            return Point::default();
        };
        let part = place - index as f64;
        let between = |before: f64, after: f64| before + part * (after - before);
        Point {
            free: std::array::from_fn(|at| between(before.free[at], after.free[at])),
            pushed_rad_s: between(before.pushed_rad_s, after.pushed_rad_s),
            gear_nm: between(before.gear_nm, after.gear_nm),
        }
    }
}
