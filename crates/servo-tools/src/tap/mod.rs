//! Tap tests: how stiff a servo's gear is and how it damps, by the ring of its joint after a step of torque.
//!
//! The servo creeps in its own mode of position, so weakly that friction hardly lets it move: its teeth touch, and all
//! friction has one sign. Then the limit of its torque goes up at once. The goal is far away, so the motor gives all
//! that the limit lets it give: a step of torque, which winds the gear up, and the shaft rings on top of its way. After
//! a few swings the goal is where it was. Two masses, a spring and a damper are fitted to many such taps.
//!
//! The rotor does not stand while the shaft rings: a ring that an encoder can see takes more torque than friction holds.
//! So inertias of rotor and load must be known.

mod act;
mod fit;
mod response;

use std::f64::consts::PI;

use sinew_rig::description::ServoModel;

use crate::{Client, Exchange, ServiceError, Servo};
pub use act::Direction;
use act::Plan;
pub use fit::{Fitted, Tap};
pub use response::Joint;

/// A ring whose first swing is smaller cannot be seen, counts of the encoder.
pub const LEAST_COUNTS: f64 = 0.2;
/// A ring that is damped by more than this part of what is critical is none.
pub const MOST_DAMPING_RATIO: f64 = 0.8;
/// Largest standard error of a result that is one.
pub const MOST_ERROR: f64 = 0.1;
/// Readings that a period of the ring needs.
const LEAST_READINGS: f64 = 10.0;
/// A joint whose gravity is less than this many times its servo's friction is tapped both ways.
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
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tapped {
    /// Stiffness, damping, and how sure they are.
    pub fitted: Fitted,
    /// Number of taps.
    pub taps: usize,
    /// Mean time between readings, s.
    pub reading_s: f64,
    /// Whether gravity loads the gear, so that its teeth touch on one side.
    pub is_loaded: bool,
}

/// What is believed of a joint before it is tapped.
pub fn believed(model: &ServoModel, load_kg_m2: f64) -> Joint {
    // At no-load speed w the supply gives back-EMF k w and the current that friction f takes, f / k.
    let [volts, speed] = [model.voltage_v.value, model.no_load_speed_rad_s.value];
    let resistance_ohm = volts / model.stall_current_a.value;
    let friction_nm = model.friction_nm.value + model.damping_nm_s.value * speed;
    let square = (volts * volts - 4.0 * speed * resistance_ohm * friction_nm).max(0.0);
    let back_emf = 0.5 * (volts + square.sqrt()) / speed;
    Joint {
        rotor_kg_m2: model.rotor_inertia_kg_m2.value,
        load_kg_m2,
        stiffness_nm_rad: model.gear_stiffness(),
        damping_nm_s: model.gear_damping(),
        drag_nm_s: model.damping_nm_s.value + back_emf * back_emf / resistance_ohm,
    }
}

/// Taps a servo, and fits. Afterwards it stands where it stood, limp if it was limp, with all registers as before, also
/// where something fails or `goes_on` says no.
///
/// # Errors
/// Those of [`identify`](crate::identify::identify), and [`ServiceError::State`] if the ring tells too little.
pub fn tap<E: Exchange>(
    client: &mut Client<E>,
    servo: &Servo,
    model: &ServoModel,
    settings: &Settings,
    goes_on: &mut dyn FnMut(u32) -> bool,
) -> Result<Tapped, ServiceError> {
    let believed = believed(model, settings.load_kg_m2);
    let is_loaded = settings.gravity_nm.abs() > GRAVITY_FRICTIONS * model.friction_nm.value;
    let direction = match (is_loaded, settings.gravity_nm > 0.0) {
        (false, _) => Direction::Both,
        (true, true) => Direction::Down,
        (true, false) => Direction::Up,
    };
    let stall_nm = model.stall_torque_nm.value;
    let plan = Plan {
        taps: settings.taps,
        direction,
        strength: settings.strength,
        gravity_part: settings.gravity_nm.abs() / stall_nm,
        preload_s: (1.2 * 2.0 * PI / believed.ring_rad_s()).clamp(0.07, 0.15),
        // With the gain as shipped, so many times more to give all within a few degrees.
        window_s: (PERIODS * 2.0 * PI / believed.ring_rad_s()).clamp(0.03, 0.15),
        gain: (stall_nm / FULL_RAD / model.position_gain_nm_rad.value.max(1e-3)).max(1.0),
    };
    let taps = act::record(client, servo, &plan, goes_on)?;
    let count_rad = servo.table.rad_per_count();
    let fitted = fit::fit(&believed, &taps, count_rad);
    let [mut gaps, mut time_s] = [0.0; 2];
    for tap in &taps {
        gaps += tap.samples.len().saturating_sub(1) as f64;
        let ends = tap.samples.first().zip(tap.samples.last());
        time_s += ends.map_or(0.0, |(first, last)| last[0] - first[0]);
    }
    let reading_s = time_s / gaps.max(1.0);
    let tapped = Tapped { fitted, taps: taps.len(), reading_s, is_loaded };
    tapped.check().map_err(|what| ServiceError::State { id: servo.id, what })?;
    Ok(tapped)
}

/// Periods of the believed ring that a tap lasts.
const PERIODS: f64 = 2.0;
/// Error of position at which a servo gives all it has, rad.
const FULL_RAD: f64 = 0.12;

impl Tapped {
    /// Says why the ring tells nothing, if it does not.
    fn check(&self) -> Result<(), String> {
        let Fitted { joint, errors, ring_counts, .. } = self.fitted;
        let period_s = 2.0 * PI / joint.ring_rad_s();
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
        let Fitted { joint, errors, ring_counts, noise_counts } = self.fitted;
        let percent = errors.map(|error| 100.0 * error);
        write!(
            f,
            "stiffness {:.1} N m/rad (+- {:.1} %), damping {:.4} N m s (+- {:.1} %), drag {:.4}\n\
             it rings with {:.1} Hz, at {:.2} of the critical damping; {} taps, {:.0} readings a second; \
             the ring is {ring_counts:.2} counts of the encoder, the noise {noise_counts:.2}",
            joint.stiffness_nm_rad,
            percent[0],
            joint.damping_nm_s,
            percent[1],
            joint.drag_nm_s,
            joint.ring_rad_s() / (2.0 * PI),
            joint.damping_ratio(),
            self.taps,
            1.0 / self.reading_s,
        )
    }
}
