//! What a rig's servos should have in their registers.

use std::f64::consts::PI;

use sinew_bus::feetech::Family;
use sinew_bus::table::{Item, Range};

use crate::quantity::Scale;
use crate::rig_servo::RigServo;
use crate::table::Role;
use crate::{ServiceError, Table};

/// What a servo controls.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// Position within a turn.
    #[default]
    Position,
    /// Position with a limit of current.
    CurrentPosition,
    /// Current.
    Current,
    /// PWM.
    Pwm,
}

/// A register, and what it should hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// The register.
    pub item: Item,
    /// What it should hold.
    pub raw: i32,
}

/// Dynamixel: the servo answers after 2 us. The factory's 500 us make a bus of 6 a third as fast.
const RETURN_DELAY: i32 = 1;
/// Pings and reads are answered, writes are not.
const STATUS_LEVEL: i32 = 1;
/// Feetech: heat, current and overload make it let go, as dumps of new STS3215 have it.
const UNLOADING: i32 = 44;
const FULL_PWM: f64 = 885.0;

/// What a servo of a rig should have: mode, return delay, status level, limits, shutdown, gains. By address.
///
/// Limits of position are the rig's range; those of current, PWM or torque follow from its torque, heat from its kind.
/// What neither rig nor kind says is as the factory sets it. Id, baud and homing offset are left alone.
///
/// # Errors
/// [`ServiceError::Rig`] if the servo cannot do what the rig or `mode` asks.
pub fn desired(rig: &RigServo, table: &Table, mode: Mode) -> Result<Vec<Setting>, ServiceError> {
    let refused = |what: String| ServiceError::Rig { name: rig.name.clone(), what };
    let mut settings = Settings { table, all: Vec::new() };
    let heat = (rig.model.shutdown_c.value).min(100.0);
    let share = rig
        .torque_nm
        .map_or(1.0, |torque| torque / rig.model.stall_torque_nm.value)
        .clamp(0.0, 1.0);
    match table {
        Table::Dynamixel(_) => {
            let number = match mode {
                Mode::Position => 3,
                Mode::Pwm => 16,
                Mode::CurrentPosition if table.has_current() => 5,
                Mode::Current if table.has_current() => 0,
                Mode::CurrentPosition | Mode::Current => {
                    let model = table.model();
                    return Err(refused(format!(
                        "a {model} does not control current; it has position and pwm"
                    )));
                }
            };
            settings.set("Return Delay Time", RETURN_DELAY);
            // Neither turned round (the rig's `direction` does that), nor timed, nor on by a goal.
            settings.set("Drive Mode", 0);
            settings.set("Operating Mode", number);
            settings.set_value("Temperature Limit", heat);
            settings.factory(&["Max Voltage Limit", "Min Voltage Limit"]);
            // A servo that measures current is limited there.
            let pwm = if table.has_current() { 1.0 } else { share };
            settings.set("PWM Limit", whole(FULL_PWM * pwm));
            match rig.torque_nm {
                Some(torque) => {
                    let current = (torque + rig.model.friction_nm.value)
                        / rig.model.torque_constant_nm_a.value;
                    settings.set_value("Current Limit", current);
                }
                None => settings.factory(&["Current Limit"]),
            }
            // Limp at power-up, until somebody arms it.
            settings.set("Startup Configuration", 0);
            settings.factory(&["Shutdown"]);
            settings.set("Status Return Level", STATUS_LEVEL);
            settings.factory(&[
                "Position D Gain",
                "Position I Gain",
                "Position P Gain",
                "Feedforward 2nd Gain",
                "Feedforward 1st Gain",
            ]);
        }
        Table::Feetech(feetech) => {
            let number = match mode {
                Mode::Position => 0,
                Mode::Pwm => 2,
                Mode::CurrentPosition | Mode::Current => {
                    let model = table.model();
                    return Err(refused(format!(
                        "a {model} does not control current; it has position and pwm"
                    )));
                }
            };
            settings.set("Return Delay Time", 0);
            settings.set("Operating Mode", number);
            settings.set_value("Max Temperature Limit", heat);
            settings.set("Max Torque Limit", whole(1000.0 * share));
            settings.set("Torque Limit", whole(1000.0 * share));
            // What the factory sets in an SCS is not known, nor the highest voltage of an STS, which differs by type.
            if feetech.model.family == Family::Sts {
                settings.factory(&[
                    "Min Voltage Limit",
                    "P Coefficient",
                    "D Coefficient",
                    "I Coefficient",
                ]);
                settings.set("Unloading Condition", UNLOADING);
            }
        }
    }
    let [least, most] = position_limits(rig, table)?;
    settings.all.push(Setting { item: table.role(Role::MinPosition)?, raw: least });
    settings.all.push(Setting { item: table.role(Role::MaxPosition)?, raw: most });
    settings.all.sort_by_key(|setting| setting.item.address);
    Ok(settings.all)
}

struct Settings<'t> {
    table: &'t Table,
    all: Vec<Setting>,
}

impl Settings<'_> {
    /// A register that a model does not have is left out; a number beyond its range is held at the end.
    fn set(&mut self, name: &str, raw: i32) {
        if let Ok(item) = self.table.register(name) {
            let raw = match item.range {
                Range::Between(least, most) => raw.clamp(least, most),
                _ => raw,
            };
            self.all.push(Setting { item, raw });
        }
    }

    fn set_value(&mut self, name: &str, value: f64) {
        if let Ok(item) = self.table.register(name) {
            self.set(name, Scale::of(&item).raw(value).unwrap_or(i32::MAX));
        }
    }

    fn factory(&mut self, names: &[&str]) {
        for name in names {
            if let Ok(item) = self.table.register(name) {
                self.all.push(Setting { item, raw: item.initial });
            }
        }
    }
}

/// The rig's range in counts, rounded inwards.
fn position_limits(rig: &RigServo, table: &Table) -> Result<[i32; 2], ServiceError> {
    let last = table.counts() - 1;
    let Some([least, most]) = rig.range_rad else { return Ok([0, last]) };
    let middle = f64::from(table.counts() / 2);
    let unit = table.rad_per_count();
    // A range to half a turn ends with the last count, which is one short of it.
    let end = f64::from(last);
    let [from, to] = [(middle + least / unit).ceil(), (middle + most / unit).floor().min(end)];
    let half = middle * unit;
    if from < 0.0 || most > half + unit || from >= to {
        let [least, most, half] = [least, most, half].map(|rad| rad * 180.0 / PI);
        let what = format!(
            "its range_deg is [{least:.2}, {most:.2}]; its encoder goes from {:.2} to {half:.2} deg round its middle. \
             Turn the horn on the shaft so that the seam is outside of the range",
            -half
        );
        return Err(ServiceError::Rig { name: rig.name.clone(), what });
    }
    Ok([from, to].map(whole))
}

/// A number of counts; all that come here are between 0 and 4095.
fn whole(value: f64) -> i32 {
    #[expect(clippy::cast_possible_truncation, reason = "the cast saturates, and NaN becomes 0")]
    let whole = value.round() as i32;
    whole
}
