//! Tap tests: measure stiffness and damping of a servo's gear by the oscillation of its joint after a step of torque.
//!
//! The servo moves slowly in its own position mode, with a torque that is hardly larger than friction; then it
//! accelerates a little. Its teeth now touch, and all friction has one sign. Then the torque limit is raised in one
//! step. The goal is far away, so the motor uses the whole limit: its torque makes a step, too. The step winds the gear
//! up, and the shaft oscillates during its motion. After a few swings the servo brakes, and returns to its start. A
//! model with two masses, a spring and a damper is fitted to many taps.
//!
//! The rotor also turns while the shaft oscillates: an oscillation that an encoder can measure needs more torque than
//! friction can hold. Therefore the inertias of rotor and load must be known. The test cannot measure play: the encoder
//! is at the shaft, and does not measure that the rotor crosses the play.

mod act;
mod clock;
mod fit;
mod joint;
mod plan;
mod tapped;

use sinew_rig::description::ServoModel;

use crate::store::torque_is_on;
use crate::{Client, Exchange, ServiceError, Servo};
pub use fit::Fitted;
use fit::Tap;
pub use joint::Joint;
use plan::Plan;
pub use tapped::Tapped;

/// The load on a servo's shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// Inertia at the shaft, kg m².
    pub inertia_kg_m2: f64,
    /// Torque of gravity at the shaft at the held position, N m, positive towards larger positions.
    pub gravity_nm: f64,
}

/// Settings of a tap test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Number of taps.
    pub taps: u32,
    /// Step of torque, as a part of the full torque, 0 to 0.6.
    pub strength: f64,
    /// Load on the shaft.
    pub load: Load,
}

/// Minimum inertia of the load, relative to the rotor's inertia.
const LEAST_LOAD: f64 = 0.3;
/// Number of groups of taps that are also fitted separately, to check whether they agree.
pub const PARTS: usize = 5;

/// A planned tap test of a servo.
#[derive(Debug, Clone)]
pub struct TapTest {
    servo: Servo,
    plan: Plan,
}

impl TapTest {
    /// Plans a test from the data of the servo's kind and of its load. Only reads, and does not move the servo.
    ///
    /// # Errors
    /// The errors of [`Client::read_bytes`], and [`ServiceError::State`] if the load is too small for an oscillation.
    pub fn new<E: Exchange>(
        client: &mut Client<E>,
        servo: &Servo,
        model: &ServoModel,
        settings: &Settings,
    ) -> Result<Self, ServiceError> {
        let [rotor, load] = [model.rotor_inertia_kg_m2.value, settings.load.inertia_kg_m2];
        if load < LEAST_LOAD * rotor {
            let what = format!(
                "its load has an inertia of {load:.5} kg m2, and its rotor {rotor:.5}: with less than {LEAST_LOAD} of \
                 the rotor's, the oscillation is damped too soon. Fix a weight to it, and give the inertia of load and \
                 weight together"
            );
            return Err(ServiceError::State { id: servo.id, what });
        }
        let was_on = torque_is_on(client, servo)?;
        let plan = Plan::new(model, settings, was_on);
        Ok(Self { servo: servo.clone(), plan })
    }

    /// Returns the maximum distance that the servo moves, rad.
    pub fn reach_rad(&self) -> f64 {
        self.plan.reach_rad()
    }

    /// Returns the maximum torque of the test, as a part of the stall torque, 0 to 1.
    pub fn most_torque(&self) -> f64 {
        self.plan.most_part().min(1.0)
    }

    /// Taps, and fits the model. Afterwards the servo is at its previous position, with torque on or off as before and
    /// all registers as before, even after an error or a signal.
    ///
    /// # Errors
    /// The errors of [`identify`](crate::identify::identify), and [`ServiceError::State`] if the servo's limits leave
    /// no room for a tap, or the oscillation is too weak for a result.
    pub fn run<E: Exchange>(&self, client: &mut Client<E>) -> Result<Tapped, ServiceError> {
        let Self { servo, plan } = self;
        let recorded = act::record(client, servo, plan)?;
        let tapped = Tapped::of(plan, &recorded, servo.table.rad_per_count());
        tapped.check().map_err(|what| ServiceError::State { id: servo.id, what })?;
        Ok(tapped)
    }
}
