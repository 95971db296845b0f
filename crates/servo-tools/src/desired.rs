//! Computes the register values that a rig file requires of its servos, with the list of `sinew-servo-bus`.

use std::f64::consts::PI;

use sinew_rig::description::ServoModel;
use sinew_servo_bus::settings::{self, ServoRequirements};
pub use sinew_servo_bus::settings::{Mode, Setting};
use sinew_servo_bus::table::Range;

use crate::lerobot::homing_register;
use crate::rig_servo::RigServo;
use crate::{ServiceError, Table};

/// Returns the required registers of a rig's servo, by address: mode, return delay, status level, limits, shutdown,
/// gains.
///
/// The position limits are the rig's range. The limits of current, PWM or torque follow from the rig's torque, the
/// temperature limit from the kind. A register that neither the rig nor the kind specifies must hold its factory value.
/// Id and baud rate are not included, and a homing offset only if the rig file has one.
///
/// # Errors
/// [`ServiceError::Rig`] if the servo does not support the rig's range or `mode`.
pub fn desired(rig: &RigServo, table: &Table, mode: Mode) -> Result<Vec<Setting>, ServiceError> {
    if matches!(mode, Mode::CurrentPosition | Mode::Current) && !table.has_current() {
        let model = ServoModel::with_article(table.model());
        let what = format!("{model} does not control current; it has position and pwm");
        return Err(ServiceError::Rig { name: rig.name.clone(), what });
    }
    if let Some(range_rad) = rig.range_rad {
        check_seam(rig, table, range_rad)?;
    }
    let model = &rig.model;
    let half_rad = 0.5 * model.range_rad.value;
    let middle_rad = single(f64::from(table.counts() / 2) * table.rad_per_count());
    let requirements = ServoRequirements {
        mode,
        range_rad: rig
            .range_rad
            .unwrap_or([-half_rad, half_rad])
            // Added in f32, as on a board.
            .map(|own| single(own) + middle_rad),
        torque_nm: single(rig.torque_nm.unwrap_or(model.stall_torque_nm.value)),
        stall_nm: single(model.stall_torque_nm.value),
        // Added in f32, as on a board.
        friction_nm: single(model.friction_nm.value) + rig.joint_friction_nm,
        torque_constant_nm_a: single(model.torque_constant_nm_a.value),
        shutdown_c: single(model.shutdown_c.value),
        gain_ratio: match (mode, &rig.position_gain) {
            (Mode::Position, Some(gain)) => gain.ratio(),
            _ => 1.0,
        },
    };
    let mut settings: Vec<Setting> = match table {
        Table::Dynamixel(table) => settings::dynamixel(*table, requirements).collect(),
        Table::Feetech(table) => settings::feetech(table.model.family, requirements).collect(),
    };
    if let Some(offset_rad) = rig.homing_offset_rad {
        let homing = homing(rig, table, offset_rad)?;
        let place = settings.partition_point(|other| other.item.address < homing.item.address);
        settings.insert(place, homing);
    }
    Ok(settings)
}

/// Returns the required homing offset.
fn homing(rig: &RigServo, table: &Table, offset_rad: f64) -> Result<Setting, ServiceError> {
    let refused = |what: String| ServiceError::Rig { name: rig.name.clone(), what };
    let item = homing_register(table).ok_or_else(|| {
        let model = ServoModel::with_article(table.model());
        refused(format!("{model} has no homing offset: leave homing_offset_deg out"))
    })?;
    #[expect(clippy::cast_possible_truncation, reason = "saturates")]
    let raw = (offset_rad / f64::from(item.unit.scale)).round() as i32;
    match item.range {
        Range::Between(least, most) if !(least..=most).contains(&raw) => Err(refused(format!(
            "its homing_offset_deg is {raw} counts; its register takes {least} to {most}"
        ))),
        _ => Ok(Setting { item, raw, mask: !0 }),
    }
}

/// Refuses a range that crosses the seam of the encoder, or has no width.
fn check_seam(rig: &RigServo, table: &Table, [least, most]: [f64; 2]) -> Result<(), ServiceError> {
    let unit = table.rad_per_count();
    let half = f64::from(table.counts() / 2) * unit;
    // A range up to half a turn ends at the last count, which is one count less than half a turn.
    if least > -half - unit && most <= half + unit && most - least > unit {
        return Ok(());
    }
    let [least, most, half] = [least, most, half].map(|rad| rad * 180.0 / PI);
    let what = format!(
        "its range_deg is [{least:.2}, {most:.2}]; its encoder goes from {:.2} to {half:.2} deg round its middle. \
         Turn the horn on the shaft so that the seam is outside of the range",
        -half
    );
    Err(ServiceError::Rig { name: rig.name.clone(), what })
}

/// Rounds to f32: a board computes in f32, and both must get the same counts.
fn single(number: f64) -> f32 {
    #[expect(clippy::cast_possible_truncation, reason = "it rounds; all that comes here is small")]
    let number = number as f32;
    number
}
