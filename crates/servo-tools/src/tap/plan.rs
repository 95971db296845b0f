//! How to tap a servo of a kind, by what is believed of it.

use sinew_rig::description::{MotorFigures, ServoModel};

use super::joint::{Joint, Push};
use super::{Load, Settings};

/// Which way to tap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Direction {
    /// Towards larger positions.
    Up,
    /// Towards smaller ones.
    Down,
    /// In turn.
    Both,
}

/// How to tap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plan {
    /// The joint as it is believed to be.
    pub(super) joint: Joint,
    /// Torque of the motor at standstill with all of its supply, N m: the full torque.
    pub(super) full_nm: f64,
    /// Current for it, A.
    pub(super) full_a: f64,
    pub(super) taps: u32,
    pub(super) direction: Direction,
    /// Step, of the full torque.
    pub(super) strength: f64,
    /// It speeds up by so much of its full torque before.
    pub(super) preload: f64,
    /// Part of the full torque that gravity takes.
    pub(super) gravity_part: f64,
    /// Least friction at the shaft, N m.
    friction_nm: f64,
    /// How long it creeps before, s: at least.
    pub(super) meet_s: f64,
    /// How long it speeds up before the step, s.
    pub(super) preload_s: f64,
    /// How long to read before the step, s.
    pub(super) before_s: f64,
    /// How long to read after the step, s.
    pub(super) window_s: f64,
    /// Factor on the gain of position.
    pub(super) gain: f64,
    /// How far away its goal is meanwhile, rad: it does not get there.
    pub(super) way_rad: f64,
}

/// Part of its full torque with which a servo speeds up before the step.
const PRELOAD: f64 = 0.1;
/// Periods of the believed ring that it creeps for before, within these times, s.
const MEET_PERIODS: f64 = 2.0;
const MEET_S: [f64; 2] = [0.04, 0.15];
/// Periods of the believed ring that it speeds up for, within these times, s.
const PRELOAD_PERIODS: f64 = 1.5;
const PRELOAD_S: [f64; 2] = [0.03, 0.15];
/// Part of a period that is read before the step, within these times, s.
const BEFORE_PERIODS: f64 = 0.8;
const BEFORE_S: [f64; 2] = [0.02, 0.06];
/// Periods of the believed ring that are read after it, within these times, s.
const WINDOW_PERIODS: f64 = 2.7;
const WINDOW_S: [f64; 2] = [0.03, 0.2];
/// Error of position at which a servo gives all it has, rad; its gain is raised for it where it can be.
const FULL_RAD: f64 = 0.12;
/// How far it creeps at most until it is seen, and what it goes further meanwhile by the speed that it has then, rad.
const CREEP_RAD: f64 = 0.08;
const WAY_MARGIN: f64 = 1.15;
/// Factor of its way by which it goes further while it brakes.
const BRAKE_MARGIN: f64 = 1.3;
/// It goes back with so much more than gravity takes, of its full torque.
const BACK_PART: f64 = 0.3;
/// It stands with so much more than twice what gravity takes: less than friction.
const CALM_PART: f64 = 0.02;
/// Part of the full torque that friction takes as a rule.
const FRICTION_PART: f64 = 0.1;
/// Part of what is believed of the friction at the shaft that is there for sure.
const SURE_FRICTION: f64 = 0.5;
/// Part by which taps differ from each other.
const VARIES: f64 = 0.2;

impl Plan {
    /// Plans. A servo that stands without torque has no more gravity than its friction holds.
    pub(super) fn new(model: &ServoModel, settings: &Settings, was_on: bool) -> Self {
        let (joint, full_nm) = believed(model, &settings.load);
        let friction_nm = model.friction_nm.value;
        let most_nm = if was_on { f64::INFINITY } else { friction_nm };
        let gravity_nm = settings.load.gravity_nm.clamp(-most_nm, most_nm);
        let at_shaft_nm = SURE_FRICTION * model.output_friction_share() * friction_nm;
        // With gravity, it would take the teeth apart that friction at the shaft keeps together.
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

    /// Returns how far a rigid joint without friction would go until the readings end, rad.
    fn rigid_way_rad(&self) -> f64 {
        const STEP_S: f64 = 5e-4;
        let inertia_kg_m2 = self.joint.rotor_kg_m2 + self.joint.load_kg_m2;
        let [mut time_s, mut speed_rad_s, mut way_rad] = [-self.preload_s, 0.0, 0.0];
        while time_s < self.window_s {
            let step = if time_s < 0.0 { 0.0 } else { self.strength };
            // Implicit: stable whatever the drag.
            speed_rad_s += STEP_S * (self.preload + step) * self.full_nm / inertia_kg_m2;
            speed_rad_s /= 1.0 + STEP_S * self.joint.drag_nm_s / inertia_kg_m2;
            way_rad += STEP_S * speed_rad_s;
            time_s += STEP_S;
        }
        way_rad
    }

    /// Returns the plan of a tap: none is as another, so that steps of the encoder are averaged out.
    pub(super) fn of_tap(&self, index: u32) -> Self {
        // Parts of 1 that are spread evenly, whatever their number: those of irrational numbers.
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

    /// Returns how far it goes at most, rad: past its goal, if it takes long to brake.
    pub(super) fn reach_rad(&self) -> f64 {
        BRAKE_MARGIN * self.way_rad
    }

    /// Returns how far ahead its goal must be for a part of the full torque, rad.
    pub(super) fn lead_rad(part: f64) -> f64 {
        FULL_RAD * part
    }

    /// Returns the most of the full torque that it takes, as a rule.
    pub(super) fn most_part(&self) -> f64 {
        self.gravity_part + self.preload + self.strength + FRICTION_PART
    }

    /// Returns the part of the full torque with which it goes back.
    pub(super) fn back_part(&self) -> f64 {
        (self.gravity_part + BACK_PART).min(1.0)
    }

    /// Returns the part of the full torque with which it stands.
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

/// Friction per torque where the maker's figures say nothing of it.
const LOAD_FRICTION: f64 = 0.1;
/// The most that figures of a motor come to. More means that the servo's own program caps the speed.
const MOST_LOAD_FRICTION: f64 = 0.25;

/// Returns what is believed of a joint before it is tapped, and its motor's torque at standstill, N m.
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
