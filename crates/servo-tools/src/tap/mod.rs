//! Tap tests: how stiff a servo's gear is and how it damps, by the ring of its joint after a step of torque.
//!
//! The servo creeps in its own mode of position, so weakly that friction hardly lets it move, then speeds up a little:
//! its teeth touch, and all friction has one sign. Then the limit of its torque goes up at once. The goal is far away,
//! so the motor gives all that the limit lets it give: a step of torque, which winds the gear up, and the shaft rings on
//! top of its way. After a few swings it brakes, and goes back to where it was. Two masses, a spring and a damper are
//! fitted to many such taps.
//!
//! The rotor does not stand while the shaft rings: a ring that an encoder can see takes more torque than friction holds.
//! So inertias of rotor and load must be known. Play is not found: the encoder is at the shaft, and does not see the
//! rotor cross it.

mod act;
mod clock;
mod fit;
mod joint;

use sinew_rig::description::ServoModel;

use crate::{Client, Exchange, ServiceError, Servo};
use act::{Direction, Plan};
use joint::Push;
pub use fit::{Fitted, Tap};
pub use joint::Joint;

/// A ring whose first swing is smaller cannot be seen, counts of the encoder.
pub const LEAST_COUNTS: f64 = 0.2;
/// A ring that is damped by more than this part of what is critical is none.
pub const MOST_DAMPING_RATIO: f64 = 0.8;
/// Largest standard error of a result that is one.
pub const MOST_ERROR: f64 = 0.1;
/// Readings that a period of the ring needs.
const LEAST_READINGS: f64 = 4.0;
/// Parts of the taps that are fitted each by itself, to see whether they agree.
pub const PARTS: usize = 5;
/// A joint whose gravity is more than this many times its servo's friction is tapped against gravity only: the other
/// way gravity would take its teeth apart.
const GRAVITY_FRICTIONS: f64 = 2.0;

/// What a tap test is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Number of taps.
    pub taps: u32,
    /// Part of its full torque by which the servo steps, 0 to 0.5.
    pub strength: f64,
    /// Inertia of what hangs on the shaft, kg m².
    pub load_kg_m2: f64,
    /// What gravity pulls at the shaft with where it stands, N m, positive towards larger positions.
    pub gravity_nm: f64,
}

/// What a tap test came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Tapped {
    /// Stiffness, damping, and how sure they are.
    pub fitted: Fitted,
    /// The same of each of [`PARTS`] parts of the taps.
    pub parts: Vec<Fitted>,
    /// Number of taps.
    pub taps: usize,
    /// Mean time between readings, s.
    pub reading_s: f64,
    /// How far it was from where it stood, rad.
    pub farthest_rad: f64,
    /// Torque at standstill with all of its supply by what is known of its kind, N m.
    pub believed_full_nm: f64,
}

/// What is believed of a joint before it is tapped, and the motor's torque at standstill, N m.
pub fn believed(model: &ServoModel, load_kg_m2: f64) -> (Joint, f64) {
    // At no-load speed w the supply gives back-EMF k w and the current that friction f takes, f / k.
    let [volts, speed] = [model.voltage_v.value, model.no_load_speed_rad_s.value];
    let resistance_ohm = volts / model.stall_current_a.value;
    let friction_nm = model.friction_nm.value + model.damping_nm_s.value * speed;
    let square = (volts * volts - 4.0 * speed * resistance_ohm * friction_nm).max(0.0);
    let back_emf = 0.5 * (volts + square.sqrt()) / speed;
    let joint = Joint {
        rotor_kg_m2: model.rotor_inertia_kg_m2.value,
        load_kg_m2,
        stiffness_nm_rad: model.gear_stiffness(),
        damping_nm_s: model.gear_damping(),
        drag_nm_s: model.damping_nm_s.value + back_emf * back_emf / resistance_ohm,
    };
    (joint, back_emf * model.stall_current_a.value)
}

/// Part of its full torque with which a servo speeds up before the step.
const PRELOAD: f64 = 0.1;
/// Periods of the believed ring that it does so for, within these times, s.
const PRELOAD_PERIODS: f64 = 1.5;
const PRELOAD_S: [f64; 2] = [0.03, 0.15];
/// Part of a period that is read before the step, within these times, s.
const BEFORE_PERIODS: f64 = 0.8;
const BEFORE_S: [f64; 2] = [0.02, 0.06];
/// Periods of the believed ring that are read after it, within these times, s.
const WINDOW_PERIODS: f64 = 2.0;
const WINDOW_S: [f64; 2] = [0.03, 0.15];
/// Error of position at which a servo gives all it has, rad; its gain is raised for it where it can be.
const FULL_RAD: f64 = 0.12;

/// How far it creeps at most until it is seen, and what it goes further meanwhile by the speed that it has then, rad.
const CREEP_RAD: f64 = 0.05;
const WAY_MARGIN: f64 = 1.15;

fn plan(model: &ServoModel, settings: &Settings) -> Plan {
    let (joint, full_nm) = believed(model, settings.load_kg_m2);
    let is_loaded = settings.gravity_nm.abs() > GRAVITY_FRICTIONS * model.friction_nm.value;
    let direction = match (is_loaded, settings.gravity_nm > 0.0) {
        (false, _) => Direction::Both,
        (true, true) => Direction::Down,
        (true, false) => Direction::Up,
    };
    let periods = |count: f64, [least, most]: [f64; 2]| (count * joint.period_s()).clamp(least, most);
    let mut plan = Plan {
        taps: settings.taps,
        direction,
        strength: settings.strength,
        preload: PRELOAD,
        gravity_part: settings.gravity_nm.abs() / model.stall_torque_nm.value,
        preload_s: periods(PRELOAD_PERIODS, PRELOAD_S),
        before_s: periods(BEFORE_PERIODS, BEFORE_S),
        window_s: periods(WINDOW_PERIODS, WINDOW_S),
        gain: (model.stall_torque_nm.value / FULL_RAD / model.position_gain_nm_rad.value.max(1e-3))
            .max(1.0),
        way_rad: 0.0,
        full_rad: FULL_RAD,
        full_a: model.stall_current_a.value,
    };
    plan.way_rad = WAY_MARGIN * way_rad(&joint, full_nm, &plan)
        + CREEP_RAD
        + FULL_RAD * plan.most_part().min(1.0);
    plan
}

/// Returns how far a rigid joint without friction would go until the readings end, rad.
fn way_rad(joint: &Joint, full_nm: f64, plan: &Plan) -> f64 {
    const STEP_S: f64 = 1e-3;
    let inertia_kg_m2 = joint.rotor_kg_m2 + joint.load_kg_m2;
    let [mut time_s, mut speed, mut way] = [0.0; 3];
    while time_s < plan.preload_s + plan.window_s {
        let part = if time_s < plan.preload_s { plan.preload } else { plan.preload + plan.strength };
        // Implicit: stable whatever the drag.
        speed = (speed + STEP_S * part * full_nm / inertia_kg_m2)
            / (1.0 + STEP_S * joint.drag_nm_s / inertia_kg_m2);
        way += STEP_S * speed;
        time_s += STEP_S;
    }
    way
}

/// Returns how far a servo goes at most from where it stands, rad: its goal is there while it is tapped.
pub fn reach_rad(model: &ServoModel, settings: &Settings) -> f64 {
    plan(model, settings).way_rad
}

/// Taps a servo, and fits. Afterwards it stands where it stood, limp if it was limp, with all registers as before, also
/// where something fails or `goes_on`, which is asked before each tap, says no.
///
/// # Errors
/// Those of [`identify`](crate::identify::identify), and [`ServiceError::State`] if its limits leave no room for a tap
/// or the ring tells too little.
pub fn tap<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    model: &ServoModel,
    settings: &Settings,
    goes_on: &mut dyn FnMut(u32) -> bool,
) -> Result<Tapped, ServiceError> {
    let (believed, believed_full_nm) = believed(model, settings.load_kg_m2);
    let plan = plan(model, settings);
    let recorded = act::record(client, servo, &plan, goes_on)?;
    let count_rad = servo.table.rad_per_count();
    let push = Push {
        preload_nm: plan.preload * believed_full_nm,
        preload_s: plan.preload_s,
        step_nm: plan.strength * believed_full_nm,
        held_nm: 0.5 * model.output_friction_share() * model.friction_nm.value
            + settings.gravity_nm.abs(),
    };
    let (fitted, taps) =
        while_it_pushes(&believed, believed_full_nm, &push, &recorded.taps, count_rad);
    let of_part = |part: usize| {
        // Both directions are in each: taps go up and down in turn.
        let own: Vec<Tap> = taps.iter().skip(part).step_by(PARTS).cloned().collect();
        fit::refit(&believed, &fitted, &own, count_rad)
    };
    let parts = (0..PARTS.min(taps.len())).map(of_part).collect();
    let [mut gaps, mut time_s] = [0.0; 2];
    for tap in &taps {
        gaps += tap.samples.len().saturating_sub(1) as f64;
        let ends = tap.samples.first().zip(tap.samples.last());
        time_s += ends.map_or(0.0, |(first, last)| last[0] - first[0]);
    }
    let tapped = Tapped {
        fitted,
        parts,
        taps: taps.len(),
        reading_s: time_s / gaps.max(1.0),
        farthest_rad: recorded.farthest_rad,
        believed_full_nm,
    };
    if std::env::var("TAP_DEBUG").is_ok() { println!("{tapped}"); }
    tapped.check().map_err(|what| ServiceError::State { id: servo.id, what })?;
    Ok(tapped)
}

/// Fits what was read while the gear pushed. How long that is follows from the fit, so it is fitted again.
fn while_it_pushes(
    believed: &Joint,
    full_nm: f64,
    push: &Push,
    taps: &[Tap],
    count_rad: f64,
) -> (Fitted, Vec<Tap>) {
    let longest_s = taps.iter().filter_map(|tap| tap.samples.last()).map(|last| last[0]);
    let longest_s = longest_s.fold(0.0, f64::max);
    let mut contact_s = believed.contact_s(push, longest_s);
    loop {
        let within: Vec<Tap> = taps.iter().map(|tap| tap.until(contact_s)).collect();
        let fitted = fit::fit(believed, full_nm, &within, count_rad);
        let found_s = fitted.joint.contact_s(push, longest_s);
        if std::env::var("TAP_DEBUG").is_ok() { println!("contact {contact_s} {found_s} {:?}", fitted.joint); }
        if found_s >= contact_s {
            return (fitted, within);
        }
        contact_s = found_s;
    }
}

impl Tapped {
    /// Says why the ring tells nothing, if it does not.
    fn check(&self) -> Result<(), String> {
        let Fitted { joint, errors, ring_counts, .. } = self.fitted;
        let period_s = joint.period_s();
        let ratio = joint.damping_ratio();
        if ring_counts < LEAST_COUNTS {
            return Err(format!(
                "the shaft rings by {ring_counts:.2} counts of its encoder, which sees none below {LEAST_COUNTS}. \
                 A load as heavy as its rotor ({:.5} kg m2; it has {:.5}) rings most; a stronger tap helps, too",
                joint.rotor_kg_m2, joint.load_kg_m2
            ));
        }
        if period_s < LEAST_READINGS * self.reading_s {
            return Err(format!(
                "the shaft rings with {:.0} Hz, and is read {:.0} times a second: too seldom. A higher baud rate, a \
                 shorter Return Delay Time (`sinew servo apply`) or an adapter with less latency helps",
                1.0 / period_s,
                1.0 / self.reading_s
            ));
        }
        if ratio > MOST_DAMPING_RATIO {
            return Err(format!(
                "the shaft does not ring: its damping is {ratio:.2} of what is critical, and more than \
                 {MOST_DAMPING_RATIO} cannot be told from a soft gear. A heavier load is damped less"
            ));
        }
        let worst = errors[0].max(errors[1]);
        if worst > MOST_ERROR {
            return Err(format!(
                "the taps are too different: the standard error of the result is {:.0} %, and more than {:.0} % is \
                 none. More taps help, a stronger tap, and a load that nothing else shakes",
                100.0 * worst,
                100.0 * MOST_ERROR
            ));
        }
        Ok(())
    }
}

impl std::fmt::Display for Tapped {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Fitted { joint, errors, ring_counts, noise_counts, full_nm } = self.fitted;
        let percent = errors.map(|error| 100.0 * error);
        let parts = |of: fn(&Fitted) -> f64| self.parts.iter().map(|p| format!("{:.4}", of(p))).collect::<Vec<_>>().join(" ");
        write!(
            f,
            "stiffness {:.1} N m/rad (+- {:.1} %) [{}], damping {:.4} N m s (+- {:.1} %) [{}], drag {:.4}, full {full_nm:.3} of {:.3}\n\
             it rings with {:.1} Hz, at {:.2} of the critical damping; {} taps, {:.0} readings a second; \
             the ring is {ring_counts:.2} counts of the encoder, the noise {noise_counts:.2}; farthest {:.1} deg",
            joint.stiffness_nm_rad,
            percent[0],
            parts(|p| p.joint.stiffness_nm_rad),
            joint.damping_nm_s,
            percent[1],
            parts(|p| p.joint.damping_nm_s),
            joint.drag_nm_s, self.believed_full_nm,
            1.0 / joint.period_s(),
            joint.damping_ratio(),
            self.taps,
            1.0 / self.reading_s,
            self.farthest_rad.to_degrees(),
        )
    }
}
