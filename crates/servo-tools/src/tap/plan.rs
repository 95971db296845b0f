//! Plans the taps of a servo, from the expected values of its kind.

use sinew_rig::description::{MotorFigures, ServoModel};

use super::joint::{Joint, Push};
use super::{Load, Settings};

/// Direction of the taps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Direction {
    /// Towards larger positions.
    Up,
    /// Towards smaller positions.
    Down,
    /// Both directions in turn.
    Both,
}

/// Parameters of the taps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plan {
    /// Joint with its expected values.
    pub(super) joint: Joint,
    /// Full torque: stall torque of the motor at full supply, N m.
    pub(super) full_nm: f64,
    /// Current for the full torque, A.
    pub(super) full_a: f64,
    pub(super) taps: u32,
    pub(super) direction: Direction,
    /// Step of torque, as a part of the full torque.
    pub(super) strength: f64,
    /// Torque of the acceleration before the step, as a part of the full torque.
    pub(super) preload: f64,
    /// Torque of gravity, as a part of the full torque.
    pub(super) gravity_part: f64,
    /// Minimum friction at the shaft, N m.
    friction_nm: f64,
    /// Time from the first motion of creeping to the acceleration, in which the teeth come to rest on each other, s; up
    /// to twice as long in a tap.
    pub(super) meet_s: f64,
    /// Time of the acceleration before the step, s.
    pub(super) preload_s: f64,
    /// Time of reading before the step, s.
    pub(super) before_s: f64,
    /// Time of reading after the step, s.
    pub(super) window_s: f64,
    /// Factor on the position gain during a tap.
    pub(super) gain: f64,
    /// Distance of the goal during a tap, rad. The servo does not reach it.
    pub(super) way_rad: f64,
}

/// Torque of the acceleration before the step, as a part of the full torque.
const PRELOAD: f64 = 0.1;
/// Minimum time for the teeth to come to rest: this many expected periods, within the bounds [`MEET_S`], s.
const MEET_PERIODS: f64 = 2.0;
const MEET_S: [f64; 2] = [0.04, 0.15];
/// Duration of the acceleration: this many expected periods, within the bounds [`PRELOAD_S`], s.
const PRELOAD_PERIODS: f64 = 1.5;
const PRELOAD_S: [f64; 2] = [0.03, 0.15];
/// Duration of reading before the step: this many expected periods, within the bounds [`BEFORE_S`], s.
const BEFORE_PERIODS: f64 = 0.8;
const BEFORE_S: [f64; 2] = [0.02, 0.06];
/// Duration of reading after the step: this many expected periods, within the bounds [`WINDOW_S`], s.
const WINDOW_PERIODS: f64 = 2.7;
const WINDOW_S: [f64; 2] = [0.03, 0.2];
/// Position error at which a servo gives its full torque, rad. Its gain is raised for this if possible.
const FULL_RAD: f64 = 0.12;
/// Maximum motion before the creeping is detected, plus the motion at that speed until the step, rad.
const CREEP_RAD: f64 = 0.08;
const WAY_MARGIN: f64 = 1.15;
/// Factor on the motion of a tap, for the distance of braking.
const BRAKE_MARGIN: f64 = 1.3;
/// Torque of the way back, in addition to gravity, as a part of the full torque.
const BACK_PART: f64 = 0.3;
/// Torque at rest, in addition to twice the torque of gravity, as a part of the full torque: less than friction.
const CALM_PART: f64 = 0.02;
/// Usual friction, as a part of the full torque.
const FRICTION_PART: f64 = 0.1;
/// Part of the expected shaft friction that is certain.
const SURE_FRICTION: f64 = 0.5;
/// Relative variation between taps.
const VARIES: f64 = 0.2;

impl Plan {
    /// Creates a plan. The torque of gravity on a servo that rests with torque off is limited to its friction, which
    /// holds the load.
    pub(super) fn new(model: &ServoModel, settings: &Settings, was_on: bool) -> Self {
        let (joint, full_nm) = believed(model, &settings.load);
        let friction_nm = model.friction_nm.value;
        let most_nm = if was_on { f64::INFINITY } else { friction_nm };
        let gravity_nm = settings.load.gravity_nm.clamp(-most_nm, most_nm);
        let at_shaft_nm = SURE_FRICTION * model.output_friction_share() * friction_nm;
        // A tap in the direction of gravity would separate the teeth, unless friction at the shaft keeps them together.
        let direction = match (gravity_nm.abs() > at_shaft_nm, gravity_nm > 0.0) {
            (false, _) => Direction::Both,
            (true, true) => Direction::Down,
            (true, false) => Direction::Up,
        };
        let periods =
            |count: f64, [least, most]: [f64; 2]| (count * joint.period_s()).clamp(least, most);
        let gain =
            model.stall_torque_nm.value / FULL_RAD / model.position_gain_nm_rad.value.max(1e-3);
        let mut plan = Self {
            joint,
            full_nm,
            full_a: model.stall_current_a.value,
            taps: settings.taps,
            direction,
            strength: settings.strength,
            preload: PRELOAD,
            gravity_part: gravity_nm.abs() / full_nm,
            friction_nm: at_shaft_nm,
            meet_s: periods(MEET_PERIODS, MEET_S),
            preload_s: periods(PRELOAD_PERIODS, PRELOAD_S),
            before_s: periods(BEFORE_PERIODS, BEFORE_S),
            window_s: periods(WINDOW_PERIODS, WINDOW_S),
            gain: gain.max(1.0),
            way_rad: 0.0,
        };
        plan.way_rad = WAY_MARGIN * plan.rigid_way_rad()
            + CREEP_RAD
            + Self::lead_rad(plan.most_part().min(1.0));
        plan
    }

    /// Returns the distance that a rigid joint without friction would move until the readings end, rad.
    fn rigid_way_rad(&self) -> f64 {
        const STEP_S: f64 = 5e-4;
        let inertia_kg_m2 = self.joint.rotor_kg_m2 + self.joint.load_kg_m2;
        let [mut time_s, mut speed_rad_s, mut way_rad] = [-self.preload_s, 0.0, 0.0];
        while time_s < self.window_s {
            let step = if time_s < 0.0 { 0.0 } else { self.strength };
            // An implicit step, which is stable for any drag.
            speed_rad_s += STEP_S * (self.preload + step) * self.full_nm / inertia_kg_m2;
            speed_rad_s /= 1.0 + STEP_S * self.joint.drag_nm_s / inertia_kg_m2;
            way_rad += STEP_S * speed_rad_s;
            time_s += STEP_S;
        }
        way_rad
    }

    /// Returns the plan of one tap. All taps differ, so that the steps of the encoder are averaged.
    pub(super) fn of_tap(&self, index: u32) -> Self {
        // Multiples of irrational numbers modulo 1: they are spread evenly for any number of taps.
        let [time, torque, meet] =
            [0.618_034, 0.754_878, 0.819_173].map(|step| (f64::from(index) * step).fract());
        Self {
            meet_s: self.meet_s * (1.0 + meet),
            strength: self.strength * (1.0 - VARIES * torque),
            preload: self.preload * (1.0 - VARIES * time),
            preload_s: self.preload_s * (1.0 - VARIES * time),
            ..*self
        }
    }

    /// Returns the maximum distance that the servo moves, rad: beyond its goal, if braking takes long.
    pub(super) fn reach_rad(&self) -> f64 {
        BRAKE_MARGIN * self.way_rad
    }

    /// Returns the distance between goal and position that gives this part of the full torque, rad.
    pub(super) fn lead_rad(part: f64) -> f64 {
        FULL_RAD * part
    }

    /// Returns the usual maximum torque, as a part of the full torque.
    pub(super) fn most_part(&self) -> f64 {
        self.gravity_part + self.preload + self.strength + FRICTION_PART
    }

    /// Returns the torque of the way back, as a part of the full torque.
    pub(super) fn back_part(&self) -> f64 {
        (self.gravity_part + BACK_PART).min(1.0)
    }

    /// Returns the torque at rest, as a part of the full torque.
    pub(super) fn calm_part(&self) -> f64 {
        (2.0 * self.gravity_part + CALM_PART).min(self.back_part())
    }

    /// Returns the torques of the weakest tap.
    pub(super) fn push(&self) -> Push {
        Push {
            preload_nm: self.preload * (1.0 - VARIES) * self.full_nm,
            preload_s: self.preload_s,
            step_nm: self.strength * self.full_nm,
            held_nm: self.friction_nm + self.gravity_part * self.full_nm,
        }
    }
}

/// Friction per torque, used if the maker's figures do not determine it.
const LOAD_FRICTION: f64 = 0.1;
/// Maximum friction per torque that a motor's figures may give. A larger value means that the servo's own program
/// limits the speed.
const MOST_LOAD_FRICTION: f64 = 0.25;

/// Returns the expected values of a joint before the test, and its motor's stall torque, N m.
fn believed(model: &ServoModel, load: &Load) -> (Joint, f64) {
    let [volts, amps] = [model.voltage_v.value, model.stall_current_a.value];
    let stall_nm = model.stall_torque_nm.value;
    let figures = model.motor(model.friction_nm.value);
    let motor = figures
        .filter(|motor| (0.0..MOST_LOAD_FRICTION).contains(&motor.load_friction))
        .unwrap_or(MotorFigures {
            torque_constant_nm_a: stall_nm * (1.0 + LOAD_FRICTION) / (1.0 - LOAD_FRICTION) / amps,
            load_friction: LOAD_FRICTION,
        });
    let constant = motor.torque_constant_nm_a;
    let at_shaft = model.output_friction_share();
    let joint = Joint {
        rotor_kg_m2: model.rotor_inertia_kg_m2.value,
        load_kg_m2: load.inertia_kg_m2,
        stiffness_nm_rad: model.gear_stiffness(),
        damping_nm_s: model.gear_damping(),
        drag_nm_s: model.damping_nm_s.value + constant * constant * amps / volts,
        load_frictions: [1.0 - at_shaft, at_shaft].map(|share| share * motor.load_friction),
    };
    (joint, constant * amps)
}
