//! The loads that servos move.

use crate::model::Parameters;

/// Position and speed of an output shaft.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Shaft {
    /// Position, rad.
    pub position_rad: f64,
    /// Speed, rad/s.
    pub velocity_rad_s: f64,
}

/// Push of a servo on its shaft in a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Push {
    /// Mean torque at the speed that the servo predicted for its shaft, N m.
    pub torque_nm: f64,
    /// Decrease of the torque for each rad/s by which the shaft is faster than predicted, N m s/rad. The gear's
    /// spring and damping cause it.
    pub slope_nm_s: f64,
}

/// The load on one shaft.
pub trait Load {
    /// Returns the inertia at the shaft, kg m²: more than 0.
    fn inertia_kg_m2(&self) -> f64;

    /// Returns the torque on the shaft, N m: gravity, stops, hands. Called several times in a millisecond.
    fn torque_nm(&self, shaft: Shaft) -> f64;
}

/// The mechanics on all shafts.
///
/// For [`Self::servo_steps`] steps of the servos, each shaft moves with its [`Self::load`] alone. Then [`Self::step`]
/// sets the real positions of the shafts. Independent loads leave the positions unchanged.
pub trait Plant {
    /// Type of the load on one shaft.
    type Load: Load;

    /// Returns the load of shaft `servo` until the next [`Self::step`].
    fn load(&self, servo: usize) -> Self::Load;

    /// Returns the number of servo steps ([`STEP_S`](crate::device::STEP_S)) in one step of the plant.
    fn servo_steps(&self) -> u32 {
        4
    }

    /// Advances by `dt_s`. `pushes` are the pushes of the servos on their shafts; `shafts` are the shafts after the
    /// servos' steps.
    fn step(&mut self, dt_s: f64, pushes: &[Push], shafts: &mut [Shaft]);
}

/// An arm with a mass, between stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arm {
    /// Inertia at the shaft, kg m².
    pub inertia_kg_m2: f64,
    /// Mass times g times lever arm, N m. Gravity pulls with `-gravity_nm * cos(position - level_rad)`.
    pub gravity_nm: f64,
    /// Position at which the arm is level, rad.
    pub level_rad: f64,
    /// Additional constant torque, N m.
    pub torque_nm: f64,
    /// Positions of the hard stops, rad.
    pub stops_rad: [f64; 2],
}

/// Stiffness of a hard stop, N m/rad: stiff, and stable at steps of 0.25 ms for inertias from 1e-4 kg m² on.
pub(crate) const STOP_NM_RAD: f64 = 200.0;
/// Stiffness of the stops of slides, N/m: equal to that of a hinge's stop at 30 mm from the axis.
pub(crate) const STOP_N_M: f64 = STOP_NM_RAD / (0.03 * 0.03);
/// Ratio of a stop's damping to its stiffness, s.
pub(crate) const STOP_DAMPING_S: f64 = 0.002;

/// Length of a small arm, m.
const SMALL_M: f64 = 0.1;
/// Torque that holds a small arm level, as a part of the stall torque.
const SMALL_PART: f64 = 0.1;
const GRAVITY_M_S2: f64 = 9.81;

impl Arm {
    /// Creates a small arm that hangs down while the servo is at the middle of its range: a weight at 10 cm that needs
    /// a tenth of the stall torque to be level (53 g for an XL330).
    pub fn small(kind: &Parameters) -> Self {
        let stall_nm = kind.torque_constant_nm_a * kind.voltage_v / kind.resistance_ohm;
        let gravity_nm = SMALL_PART * stall_nm;
        Self {
            inertia_kg_m2: gravity_nm / GRAVITY_M_S2 * SMALL_M,
            gravity_nm,
            level_rad: 0.5 * kind.range_rad + core::f64::consts::FRAC_PI_2,
            ..Self::default()
        }
    }
}

impl Default for Arm {
    /// Returns a servo horn without a load.
    fn default() -> Self {
        Self {
            inertia_kg_m2: 1e-4,
            gravity_nm: 0.0,
            level_rad: 0.0,
            torque_nm: 0.0,
            stops_rad: [f64::NEG_INFINITY, f64::INFINITY],
        }
    }
}

impl Load for Arm {
    fn inertia_kg_m2(&self) -> f64 {
        self.inertia_kg_m2
    }

    fn torque_nm(&self, shaft: Shaft) -> f64 {
        let [least, most] = self.stops_rad;
        let beyond = shaft.position_rad - shaft.position_rad.clamp(least, most);
        // A stop pushes, but does not pull back.
        let push = if beyond == 0.0 {
            0.0
        } else {
            let push = -STOP_NM_RAD * (beyond + STOP_DAMPING_S * shaft.velocity_rad_s);
            if push * beyond < 0.0 { push } else { 0.0 }
        };
        self.torque_nm - self.gravity_nm * libm::cos(shaft.position_rad - self.level_rad) + push
    }
}

impl Plant for Vec<Arm> {
    type Load = Arm;

    fn load(&self, servo: usize) -> Arm {
        self.get(servo).copied().unwrap_or_default()
    }

    fn step(&mut self, _dt_s: f64, _pushes: &[Push], _shafts: &mut [Shaft]) {}
}
