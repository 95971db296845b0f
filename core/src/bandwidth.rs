//! The bandwidth of an observer whose encoder measures through a soft gear.

use core::fmt;

use crate::math;

/// Maximum ratio of a loop's bandwidth to the gear's resonance.
///
/// The loop treats a joint as rigid. Above the gear's resonance, rotor and load turn against each other, so the
/// loop's torque must be small there. The value was chosen from 0.2, 0.3, 0.4 and 0.5: it is the largest for which
/// joints with the softest gears (XL330, MX-64), with a load as heavy as the rotor, stay stable when the gear is half
/// as stiff as modelled and has twice the play. For heavier loads, `sinew rig check` reviews the rig.
pub const RESONANCE_SHARE: f32 = 0.3;

/// Maximum bandwidth of any joint, rad/s. Above it, the noise of a 12-bit encoder exceeds the joint's motion.
pub const WIDEST_RAD_S: f32 = 150.0;

/// The bandwidth of a joint's observer, and the limit that set it.
///
/// ```
/// use sinew_core::bandwidth::{Bandwidth, BandwidthReason};
/// // An XL330 whose shaft is held: 29.7 N m/rad on a rotor of 0.00181 kg m², at 500 Hz.
/// let held = Bandwidth::of_gear(29.7, 0.00181, 0.002)?;
/// assert_eq!(held.reason, BandwidthReason::Gear);
/// assert!((held.rad_s - 38.4).abs() < 0.1);
/// // With a load as light as the rotor, the resonance is higher.
/// let light = Bandwidth::of_loaded_gear(29.7, 0.00181, 0.00181, 0.002)?;
/// assert!((light.rad_s - 54.3).abs() < 0.1);
/// # Ok::<(), sinew_core::bandwidth::BandwidthError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Bandwidth {
    /// Bandwidth, rad/s.
    pub rad_s: f32,
    /// The limit that set the bandwidth.
    pub reason: BandwidthReason,
}

/// A limit of the bandwidth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BandwidthReason {
    /// Gear: [`RESONANCE_SHARE`] of the resonance of gear, rotor and load.
    Gear,
    /// The constant maximum, [`WIDEST_RAD_S`].
    Widest,
    /// The control tick: `1 / dt`.
    Tick,
}

impl Bandwidth {
    /// Returns the bandwidth of a joint whose load is far heavier than the rotor: `0.3 √(K / J)`, at most
    /// [`WIDEST_RAD_S`] and `1 / dt`. Both values refer to the same shaft: stiffness of the gear in N m/rad, inertia
    /// of the rotor in kg m². The tick is in s. O(1).
    ///
    /// # Errors
    /// [`BandwidthError`] if a value is not a finite number above 0.
    pub fn of_gear(
        stiffness_nm_rad: f32,
        rotor_inertia_kg_m2: f32,
        dt_s: f32,
    ) -> Result<Self, BandwidthError> {
        Self::of_loaded_gear(stiffness_nm_rad, rotor_inertia_kg_m2, f32::MAX, dt_s)
    }

    /// Returns the bandwidth of a joint whose load has a known inertia (kg m²): `0.3 √(K (1 / J_rotor + 1 / J_load))`,
    /// with the limits of [`Self::of_gear`].
    ///
    /// A load that is lighter than the rotor counts as the rotor's inertia: while the rotor crosses the gear's play,
    /// the joint's friction holds such a load. Pass the largest load inertia that the joint has in any pose. O(1).
    ///
    /// # Errors
    /// [`BandwidthError`] if a value is not a finite number above 0.
    pub fn of_loaded_gear(
        stiffness_nm_rad: f32,
        rotor_inertia_kg_m2: f32,
        load_inertia_kg_m2: f32,
        dt_s: f32,
    ) -> Result<Self, BandwidthError> {
        for (what, value) in [
            ("gear stiffness", stiffness_nm_rad),
            ("rotor inertia", rotor_inertia_kg_m2),
            ("load inertia", load_inertia_kg_m2),
            ("tick", dt_s),
        ] {
            // Written so that NaN fails.
            if !(value > 0.0 && value.is_finite()) {
                return Err(BandwidthError { what, value });
            }
        }
        let load_kg_m2 = load_inertia_kg_m2.max(rotor_inertia_kg_m2);
        let share = 1.0 + rotor_inertia_kg_m2 / load_kg_m2;
        let rad_s = RESONANCE_SHARE * math::sqrt(stiffness_nm_rad / rotor_inertia_kg_m2 * share);
        let tick = 1.0 / dt_s;
        Ok(if tick <= rad_s.min(WIDEST_RAD_S) {
            Self { rad_s: tick, reason: BandwidthReason::Tick }
        } else if WIDEST_RAD_S <= rad_s {
            Self { rad_s: WIDEST_RAD_S, reason: BandwidthReason::Widest }
        } else {
            Self { rad_s, reason: BandwidthReason::Gear }
        })
    }
}

/// A value of a gear, a load or a tick that is not a finite number above 0.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BandwidthError {
    /// Name of the value.
    pub what: &'static str,
    /// The value, in the unit of the argument.
    pub value: f32,
}

impl fmt::Display for BandwidthError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the {} is {}; it must be a finite number above 0", self.what, self.value)
    }
}

impl core::error::Error for BandwidthError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_of_gear_widest_and_tick_is_the_bandwidth() {
        let of = |stiffness, dt_s| Bandwidth::of_gear(stiffness, 0.002, dt_s).unwrap();
        assert_eq!(of(20.0, 0.002).reason, BandwidthReason::Gear);
        assert_eq!(of(2000.0, 0.002).reason, BandwidthReason::Widest);
        assert_eq!(of(20.0, 0.1), Bandwidth { rad_s: 10.0, reason: BandwidthReason::Tick });
    }

    #[test]
    fn a_lighter_load_than_the_rotor_counts_as_the_rotor() {
        let of = |load| Bandwidth::of_loaded_gear(20.0, 0.002, load, 0.002).unwrap().rad_s;
        assert!((of(1e-6) - of(0.002)).abs() < 1e-6);
        assert!(of(0.004) < of(0.002) && of(1.0) < of(0.004));
    }

    #[test]
    fn values_that_cannot_be_are_refused_by_name() {
        for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            let error = Bandwidth::of_gear(bad, 0.002, 0.002).unwrap_err();
            assert_eq!(error.what, "gear stiffness");
            assert_eq!(Bandwidth::of_gear(20.0, bad, 0.002).unwrap_err().what, "rotor inertia");
            assert_eq!(Bandwidth::of_gear(20.0, 0.002, bad).unwrap_err().what, "tick");
            let error = Bandwidth::of_loaded_gear(20.0, 0.002, bad, 0.002).unwrap_err();
            assert_eq!(error.what, "load inertia");
        }
    }
}
