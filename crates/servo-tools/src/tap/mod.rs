//! Tap tests: how stiff a servo's gear is and how it damps, by the ring of its joint after a step of torque.
//!
//! The servo creeps in its own mode of position, so weakly that friction hardly lets it move, then speeds up a little:
//! its teeth touch, and all friction has one sign. Then the limit of its torque goes up at once. The goal is far away,
//! so the motor gives all that the limit lets it give: a step of torque, which winds the gear up, and the shaft rings
//! on top of its way. After a few swings it brakes, and goes back to where it was. Two masses, a spring and a damper
//! are fitted to many such taps.
//!
//! The rotor does not stand while the shaft rings: a ring that an encoder can see takes more torque than friction
//! holds. So inertias of rotor and load must be known. Play is not found: the encoder is at the shaft, and does not see
//! the rotor cross it.

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

/// The load that hangs on a servo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// Inertia at the shaft, kg m².
    pub inertia_kg_m2: f64,
    /// Torque of gravity at the shaft where it holds, N m, positive towards larger positions.
    pub gravity_nm: f64,
}

/// Settings of a tap test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Number of taps.
    pub taps: u32,
    /// Part of its full torque by which the servo steps, 0 to 0.6.
    pub strength: f64,
    /// The load that hangs on it.
    pub load: Load,
}

/// Least inertia of what hangs on a servo, in inertias of its rotor.
const LEAST_LOAD: f64 = 0.3;
/// Parts of the taps that are fitted each by itself, to see whether they agree.
pub const PARTS: usize = 5;

/// A tap test of a servo, which has not moved yet.
#[derive(Debug, Clone)]
pub struct TapTest {
    servo: Servo,
    plan: Plan,
}

impl TapTest {
    /// Plans a test, by what is known of the servo's kind and of what hangs on it. It only reads.
    ///
    /// # Errors
    /// Those of [`Client::read_bytes`], and [`ServiceError::State`] if so little hangs on it that it cannot ring.
    pub fn new<E: Exchange>(
        client: &mut Client<E>,
        servo: &Servo,
        model: &ServoModel,
        settings: &Settings,
    ) -> Result<Self, ServiceError> {
        let [rotor, load] = [model.rotor_inertia_kg_m2.value, settings.load.inertia_kg_m2];
        if load < LEAST_LOAD * rotor {
            let what = format!(
                "what hangs on it has an inertia of {load:.5} kg m2, and its rotor {rotor:.5}: with less than \
                 {LEAST_LOAD} of that its ring is damped too soon. Fix a weight to it, and tell the inertia of both"
            );
            return Err(ServiceError::State { id: servo.id, what });
        }
        let was_on = torque_is_on(client, servo)?;
        let plan = Plan::new(model, settings, was_on);
        Ok(Self { servo: servo.clone(), plan })
    }

    /// Returns how far the servo goes at most, rad.
    pub fn reach_rad(&self) -> f64 {
        self.plan.reach_rad()
    }

    /// Returns the most of its torque at standstill that it takes, 0 to 1.
    pub fn most_torque(&self) -> f64 {
        self.plan.most_part().min(1.0)
    }

    /// Taps, and fits. Afterwards the servo stands where it stood, limp if it was limp, with all registers as before,
    /// also where something fails or a signal ends it.
    ///
    /// # Errors
    /// Those of [`identify`](crate::identify::identify), and [`ServiceError::State`] if its limits leave no room for a
    /// tap, or the ring tells too little.
    pub fn run<E: Exchange>(&self, client: &mut Client<E>) -> Result<Tapped, ServiceError> {
        let Self { servo, plan } = self;
        let recorded = act::record(client, servo, plan)?;
        let tapped = Tapped::of(plan, &recorded, servo.table.rad_per_count());
        tapped.check().map_err(|what| ServiceError::State { id: servo.id, what })?;
        Ok(tapped)
    }
}
