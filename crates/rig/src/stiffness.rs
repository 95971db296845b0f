//! Maximum stiffness of a servo's own position loop, from which its P gain is chosen.

use crate::description::ServoModel;
use crate::review::{FlexibleJoint, with_worst_gear};

/// Delay of a servo's own loop, s: a tick of 1 ms, plus half a tick because the torque is held during a tick. It is
/// a guess, because makers do not state the rate of the loop.
pub const DELAY_S: f64 = 1.5e-3;

/// Minimum damping of the oscillation after a disturbance, as a share of the critical damping. The oscillation then
/// overshoots by less than half.
pub const DAMPING_RATIO: f64 = 0.25;

/// Share of the limit stiffness (at which oscillations through the worst gear grow) that a servo may have, unless
/// its dry friction holds the rotor within the play. It is the largest share at which Poppy's MX-64 servos remain
/// at rest with half the gear stiffness, twice the play and a third of the damping.
pub const GEAR_SHARE: f64 = 0.75;

/// Share of the damping that remains in the worst gear.
const DAMPING_LEFT: f64 = 1.0 / 3.0;

/// Permitted stiffness of a servo, with the limit that determined it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stiffness {
    /// Torque per position error at the servo's own shaft, N m/rad.
    pub nm_rad: f64,
    /// Limit that determined the stiffness.
    pub reason: StiffnessReason,
}

/// Reason that limits a stiffness.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StiffnessReason {
    /// At a higher stiffness, an oscillation may grow through the worst gear that is judged: half the stiffness, twice
    /// the play and a third of the damping. See [`GEAR_SHARE`].
    Gear,
    /// At a higher stiffness, the oscillation after a disturbance has less damping than [`DAMPING_RATIO`].
    Damping,
    /// The limit by damping is below the factory setting, at which no oscillation grows: the factory setting is
    /// kept.
    Factory,
}

impl Stiffness {
    /// Returns the permitted stiffness of a kind of servo with a load (kg m² at its shaft); `None` for a kind
    /// without its own loop or without rotor data. Pass the maximum load of all poses. A load below the rotor's
    /// inertia counts as the rotor's inertia. O(1).
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
        let play_rad = model.backlash_rad.value;
        let worst = with_worst_gear(joint, play_rad);
        let worst = FlexibleJoint { gear_damping: DAMPING_LEFT * worst.gear_damping, ..worst };
        let grows = where_swings_grow(&worst);
        // Twice the play allows this angle in each direction.
        let held = model.friction_nm.value / play_rad.max(f64::MIN_POSITIVE);
        let by_gear = grows.min(held.max(GEAR_SHARE * grows));
        let by_damping = (0.5 * joint.damping / DAMPING_RATIO).powi(2) / joint.inertia();
        let (nm_rad, reason) = if by_gear <= by_damping {
            (by_gear, StiffnessReason::Gear)
        } else {
            (by_damping, StiffnessReason::Damping)
        };
        Some(if nm_rad > factory {
            Self { nm_rad, reason }
        } else if by_gear < factory {
            Self { nm_rad: by_gear, reason: StiffnessReason::Gear }
        } else {
            Self { nm_rad: factory, reason: StiffnessReason::Factory }
        })
    }
}

/// Returns the stiffness at which an oscillation neither grows nor decays, N m/rad.
///
/// The servo's torque on its rotor is `kp` per radian of output error, with a delay of [`DELAY_S`]. The delay
/// subtracts `kp` times [`DELAY_S`] from the damping. With rotor `J`, load `L`, gear `K` and `c`, damping `b`
/// (viscous friction and back-EMF) and delay `T`, the characteristic polynomial is
///
/// ```text
/// J L s⁴ + (b L + c (J + L)) s³ + (K (J + L) + c (b - kp T)) s² + (K (b - kp T) + c kp) s + K kp
/// ```
///
/// Routh's criterion gives a quadratic equation in `kp`; the result is its smallest positive root.
fn where_swings_grow(joint: &FlexibleJoint) -> f64 {
    let FlexibleJoint { rotor_inertia, load_inertia, stiffness, gear_damping, damping } = *joint;
    let fourth = rotor_inertia * load_inertia;
    let third = damping * load_inertia + gear_damping * joint.inertia();
    // Part without kp, and factor of kp.
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
    // Without kp all oscillations decay, therefore c is positive. This form avoids a division by a small `a`.
    let least = 2.0 * c / (root - b);
    let none = f64::INFINITY;
    // With a positive b and no root, oscillations decay for any kp.
    if least > 0.0 { least } else { none }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(name: &str) -> ServoModel {
        ServoModel::built_in(name).unwrap_or_default()
    }

    /// Returns whether an oscillation grows, from a simulation of the loop in steps of 20 µs.
    fn grows(joint: &FlexibleJoint, stiffness: f64) -> bool {
        let FlexibleJoint { rotor_inertia, load_inertia, .. } = *joint;
        let (step_s, delay) = (2e-5, 75);
        let mut late = std::collections::VecDeque::from(vec![1.0; delay]);
        let (mut load, mut rotor, mut speeds) = (1.0_f64, 1.0_f64, [0.0_f64; 2]);
        let mut largest = [0.0_f64; 2];
        let steps = 200_000;
        for at in 0..steps {
            late.push_back(load);
            let seen = late.pop_front().unwrap_or_default();
            let gear =
                joint.stiffness * (rotor - load) + joint.gear_damping * (speeds[1] - speeds[0]);
            speeds[0] += step_s * gear / load_inertia;
            let motor = -stiffness * seen - joint.damping * speeds[1] - gear;
            speeds[1] += step_s * motor / rotor_inertia;
            load += step_s * speeds[0];
            rotor += step_s * speeds[1];
            let half = usize::from(at >= steps / 2);
            largest[half] = largest[half].max(load.abs());
        }
        largest[1] > 0.5 * largest[0]
    }

    #[test]
    fn a_swing_grows_beyond_the_limit_and_decays_below() {
        for name in ["XL330-M288-T", "XL430-W250-T", "MX-64", "STS3215-12V"] {
            let model = kind(name);
            let rotor = model.rotor_inertia_kg_m2.value;
            let back_emf = model.stall_torque_nm.value / model.no_load_speed_rad_s.value;
            let joint = FlexibleJoint {
                rotor_inertia: rotor,
                load_inertia: rotor,
                stiffness: 0.2 * model.gear_stiffness(),
                gear_damping: 0.1 * model.gear_damping(),
                damping: model.damping_nm_s.value + back_emf,
            };
            let limit = where_swings_grow(&joint);
            // The delay is a first-order approximation.
            assert!(grows(&joint, 1.07 * limit), "{name}: {limit}");
            assert!(!grows(&joint, 0.93 * limit), "{name}: {limit}");
        }
    }

    #[test]
    fn each_limit_holds_where_it_is_the_least() {
        let of = |name: &str, load| Stiffness::of(&kind(name), load).map(|stiff| stiff.reason);
        assert_eq!(of("XL430-W250-T", 1e-3), Some(StiffnessReason::Gear));
        assert_eq!(of("XL330-M288-T", 1.5e-3), Some(StiffnessReason::Damping));
        assert_eq!(of("XL330-M288-T", 0.1), Some(StiffnessReason::Factory));
        // A gear that oscillates with the factory gain.
        let mut soft = kind("XM430-W350-T");
        if let Some(stiffness) = &mut soft.gear_stiffness_nm_rad {
            stiffness.value = 10.0;
        }
        let stiff = Stiffness::of(&soft, 0.1);
        assert!(stiff.is_some_and(|stiff| stiff.nm_rad < 18.9));
        assert_eq!(stiff.map(|stiff| stiff.reason), Some(StiffnessReason::Gear));
        assert_eq!(Stiffness::of(&ServoModel::default(), 1.0), None);
    }

    #[test]
    fn a_lighter_load_than_the_rotor_counts_as_the_rotor() {
        let of = |load| Stiffness::of(&kind("MX-28"), load).map(|stiff| stiff.nm_rad);
        assert_eq!(of(0.0), of(0.005));
        assert!(of(0.05) < of(0.005));
    }
}
