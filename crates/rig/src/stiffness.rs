//! How stiffly a servo may hold its joint by the loop of its own: what its P gain is chosen by.

use crate::description::ServoModel;
use crate::review::{FlexibleJoint, with_worst_gear};

/// How late a servo's own loop is: a tick of 1 ms, and half of one for which its torque is held, s. Guess: no maker
/// states the rate of the loop.
pub const DELAY_S: f64 = 1.5e-3;

/// The least damping of a push that swings out, as a part of the critical one: it swings back by less than half.
pub const DAMPING_RATIO: f64 = 0.25;

/// How stiffly a servo may hold, and the reason that it is no stiffer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stiffness {
    /// Torque per position error at the servo's own shaft, N m/rad.
    pub nm_rad: f64,
    /// The limit that it has reached.
    pub reason: StiffnessReason,
}

/// The limit of a stiffness.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StiffnessReason {
    /// Beyond it a swing grows through the worst gear that is judged: half as stiff, with twice the play.
    Gear,
    /// Beyond it a push swings out with less than [`DAMPING_RATIO`].
    Damping,
    /// A push swings out with less than that already as the servo left the factory: it is made no stiffer.
    Factory,
}

impl Stiffness {
    /// Returns how stiffly a kind of servo may hold a load, kg m² at its shaft; none of a kind without a loop or a
    /// rotor of its own. The greatest load that it has in any pose is the one to give; a lighter one than its rotor
    /// counts as the rotor. O(1).
    pub fn of(model: &ServoModel, load_kg_m2: f64) -> Option<Self> {
        let factory = model.position_gain_nm_rad.value;
        let rotor = model.rotor_inertia_kg_m2.value;
        let back_emf = model.stall_torque_nm.value / model.no_load_speed_rad_s.value;
        let joint = FlexibleJoint {
            rotor_inertia: rotor,
            load_inertia: load_kg_m2.max(rotor),
            stiffness: model.gear_stiffness(),
            gear_damping: model.gear_damping(),
            damping: model.damping_nm_s.value + back_emf,
        };
        let numbers = [factory, rotor, joint.load_inertia, joint.stiffness, joint.damping];
        if !numbers.iter().all(|number| *number > 0.0 && number.is_finite()) {
            return None;
        }
        let by_gear = where_swings_grow(&with_worst_gear(joint, model.backlash_rad.value));
        let by_damping = (0.5 * joint.damping / DAMPING_RATIO).powi(2) / joint.inertia();
        Some(if by_gear <= factory.max(by_damping) {
            Self { nm_rad: by_gear, reason: StiffnessReason::Gear }
        } else if by_damping > factory {
            Self { nm_rad: by_damping, reason: StiffnessReason::Damping }
        } else {
            Self { nm_rad: factory, reason: StiffnessReason::Factory }
        })
    }
}

/// The stiffness at which a swing neither grows nor decays, N m/rad.
///
/// The servo turns its rotor by `kp` for each radian that its output is off, [`DELAY_S`] late, which takes `kp` times
/// that from the damping. With rotor `J`, load `L`, gear `K` and `c`, damping `b` (viscous friction and back-EMF) and
/// delay `T` the polynomial is
///
/// ```text
/// J L s⁴ + (b L + c (J + L)) s³ + (K (J + L) + c (b - kp T)) s² + (K (b - kp T) + c kp) s + K kp
/// ```
///
/// and Routh's criterion a quadratic in `kp`, whose first root this is.
fn where_swings_grow(joint: &FlexibleJoint) -> f64 {
    let FlexibleJoint { rotor_inertia, load_inertia, stiffness, gear_damping, damping } = *joint;
    let fourth = rotor_inertia * load_inertia;
    let third = damping * load_inertia + gear_damping * joint.inertia();
    // What stands without kp, and with it.
    let second = [stiffness * joint.inertia() + gear_damping * damping, -gear_damping * DELAY_S];
    let first = [stiffness * damping, gear_damping - stiffness * DELAY_S];
    let constant = stiffness;
    // third second first - fourth first² - third² constant
    let c = third * second[0] * first[0] - fourth * first[0] * first[0];
    let b = third * (second[0] * first[1] + second[1] * first[0])
        - 2.0 * fourth * first[0] * first[1]
        - third * third * constant;
    let a = third * second[1] * first[1] - fourth * first[1] * first[1];
    let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
    // Without kp all decays: c is positive. Written so that a small `a` divides nothing.
    let least = 2.0 * c / (root - b);
    let none = f64::INFINITY;
    // With a positive b and no root all decays, whatever kp.
    if least > 0.0 { least } else { none }
}
