//! What servos move.

use crate::model::Parameters;

/// Where an output shaft is, and how fast.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Shaft {
    /// rad.
    pub position_rad: f64,
    /// rad/s.
    pub velocity_rad_s: f64,
}

/// Push of a servo on its shaft in a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Push {
    /// Mean torque at the speed that the servo foresaw for its shaft, N m.
    pub torque_nm: f64,
    /// Torque that is lost for each rad/s that the shaft is faster, N m s/rad: that of the gear's spring and damping.
    pub slope_nm_s: f64,
}

/// What hangs on one shaft.
pub trait Load {
    /// Inertia at the shaft, kg m²: more than 0.
    fn inertia_kg_m2(&self) -> f64;

    /// Torque on the shaft, N m: gravity, stops, hands. Asked several times in a millisecond.
    fn torque_nm(&self, shaft: Shaft) -> f64;
}

/// What hangs on all shafts.
///
/// For [`Self::servo_steps`] steps of the servos each shaft moves by [`Self::load`] alone. Then [`Self::step`] says
/// where the shafts really are: for loads that do not know of each other, where they came to.
pub trait Plant {
    /// What hangs on one shaft.
    type Load: Load;

    /// What shaft `servo` works against until then.
    fn load(&self, servo: usize) -> Self::Load;

    /// Steps of the servos ([`STEP_S`](crate::device::STEP_S)) in one of this.
    fn servo_steps(&self) -> u32 {
        4
    }

    /// Time passes. `pushes` are those of the servos on their shafts, `shafts` where they came to.
    fn step(&mut self, dt_s: f64, pushes: &[Push], shafts: &mut [Shaft]);
}

/// An arm with a mass, between stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arm {
    /// Inertia, kg m².
    pub inertia_kg_m2: f64,
    /// Mass times g times lever arm, N m: it pulls with `-gravity_nm * cos(position - level_rad)`.
    pub gravity_nm: f64,
    /// Where the arm is level, rad.
    pub level_rad: f64,
    /// A constant torque, N m.
    pub torque_nm: f64,
    /// Hard stops, rad.
    pub stops_rad: [f64; 2],
}

/// Of a hard stop: stiff, and stable at steps of 0.25 ms for inertias from 1e-4 kg m² on.
pub(crate) const STOP_NM_RAD: f64 = 200.0;
/// Stiffness of the stops of slides, N/m: that of turns, 30 mm from the axis.
pub(crate) const STOP_N_M: f64 = STOP_NM_RAD / (0.03 * 0.03);
/// Time that a stop's damping is behind its stiffness, s.
pub(crate) const STOP_DAMPING_S: f64 = 0.002;

/// Of a small arm, m.
const SMALL_M: f64 = 0.1;
/// Part of its stall torque that a servo holds a small arm level with.
const SMALL_PART: f64 = 0.1;
const GRAVITY_M_S2: f64 = 9.81;

impl Arm {
    /// A small arm that hangs where a servo is at the middle of its range: a weight on 10 cm that takes a tenth of its
    /// stall torque when it is level (of an XL330: 53 g).
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
    /// A bare horn.
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
        // A stop pushes; it does not pull back what leaves it.
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
