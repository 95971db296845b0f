//! The position P gain of each servo of a rig in a position mode.

use sinew_rig::description::{Servo, ServoModel};
use sinew_rig::stiffness::{Stiffness, StiffnessReason};
use sinew_rig::tracking::{ServoTracking, tracking};
use sinew_rig::{Description, Mechanism};
use sinew_servo_bus::table::{Item, Range};

use crate::table::Role;
use crate::{ServiceError, Table};

/// Tick of the tracker, s. Any value works: the gains of the servos' own loops do not depend on it.
const TICK_S: f64 = 0.002;

/// Value of a servo's position P gain register, and its reason.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct PositionGain {
    /// The maker's name for the register.
    pub register: &'static str,
    /// Value of the register.
    pub raw: i32,
    /// Factory value.
    pub factory: i32,
    /// Torque per position error with this gain, N m/rad.
    pub stiffness_nm_rad: f64,
    /// The rule that decided the value.
    pub reason: GainReason,
}

/// The rule that decided a P gain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum GainReason {
    /// The rig file states the gain.
    File,
    /// See [`StiffnessReason::Gear`].
    Gear,
    /// See [`StiffnessReason::Damping`].
    Damping,
    /// See [`StiffnessReason::Factory`]; also used if gear and load are unknown.
    Factory,
    /// The gain is limited by the register's maximum.
    Register,
}

impl GainReason {
    /// Returns the reason in a few words.
    pub fn text(self) -> &'static str {
        match self {
            Self::File => "the rig file",
            Self::Gear => "its gear",
            Self::Damping => "damping of its load",
            Self::Factory => "as shipped",
            Self::Register => "its register",
        }
    }
}

impl PositionGain {
    /// Returns the gain of a servo: the value in the rig file, otherwise the value by the rule, otherwise the factory
    /// value. Returns `None` for a kind without this register, or with an unknown factory gain.
    ///
    /// # Errors
    /// [`ServiceError::Rig`] if the servo does not support the gain in the file.
    pub fn of(
        servo: &Servo,
        model: &ServoModel,
        rule: Option<Stiffness>,
    ) -> Result<Option<Self>, ServiceError> {
        let table = Table::named_model(&model.name, u8::MAX);
        let item = table.and_then(|table| table.at(table.address(Role::PositionP)));
        let item = item.filter(|item| item.initial > 0);
        let Some(Item { name: register, initial: factory, range: Range::Between(_, most), .. }) =
            item
        else {
            return match servo.p_gain {
                None => Ok(None),
                Some(_) => Err(refused(
                    servo,
                    format!("{} has no known P gain", ServoModel::with_article(&model.name)),
                )),
            };
        };
        let known = model.position_gain_nm_rad.value;
        let (raw, reason) = match (servo.p_gain.map(i32::from), rule) {
            (Some(raw), _) if raw > most => {
                let what = format!("its p_gain is {raw}; {register} takes 1 to {most}");
                return Err(refused(servo, what));
            }
            (Some(raw), _) => (raw, GainReason::File),
            (None, Some(rule)) => by_rule(rule, f64::from(factory) / known, most),
            (None, None) => (factory, GainReason::Factory),
        };
        let stiffness_nm_rad = known * f64::from(raw) / f64::from(factory);
        Ok(Some(Self { register, raw, factory, stiffness_nm_rad, reason }))
    }

    /// Returns the ratio of the gain to the factory's gain.
    pub fn ratio(&self) -> f32 {
        self.raw as f32 / self.factory as f32
    }
}

fn by_rule(rule: Stiffness, per_stiffness: f64, most: i32) -> (i32, GainReason) {
    let reason = match rule.reason {
        StiffnessReason::Gear => GainReason::Gear,
        StiffnessReason::Damping => GainReason::Damping,
        StiffnessReason::Factory => GainReason::Factory,
    };
    // Tolerance of a millionth for rounding, so that the factory's gain stays unchanged.
    let raw = (rule.nm_rad * per_stiffness * (1.0 + 1e-6)).floor().max(1.0);
    if raw > f64::from(most) {
        return (most, GainReason::Register);
    }
    #[expect(clippy::cast_possible_truncation, reason = "from 1 to the register's most")]
    let raw = raw as i32;
    (raw, reason)
}

fn refused(servo: &Servo, what: String) -> ServiceError {
    ServiceError::Rig { name: servo.name.clone(), what }
}

/// Returns the gain of each servo of a rig, in the rig's order. Without a mechanism, the loads are unknown: then a gain
/// that the file does not state is the factory's.
///
/// # Errors
/// [`ServiceError::Rig`] if a servo does not support the gain in the file.
pub fn position_gains(
    rig: &Description,
    mechanism: Option<&Mechanism>,
) -> Result<Vec<Option<PositionGain>>, ServiceError> {
    let loads = mechanism.and_then(|mechanism| tracking(rig, mechanism, TICK_S).ok());
    let loads: Vec<Option<Stiffness>> = match loads {
        Some(loads) => loads.into_iter().map(|ServoTracking { stiffness, .. }| stiffness).collect(),
        None => vec![None; rig.servos.len()],
    };
    let each = rig.servos.iter().zip(loads);
    each.map(|(servo, rule)| match rig.servo_model(&servo.model) {
        Some(model) => PositionGain::of(servo, &model, rule),
        None => Ok(None),
    })
    .collect()
}
