//! Converts `LeRobot`'s calibration of motors to changes of a rig file, and a rig file to such a calibration.
//!
//! `LeRobot` (0.4.4, `motors/motors_bus.py`) stores a JSON object. For each motor it contains the id, the drive mode,
//! the homing offset and the range, in counts of the motor's registers. A Feetech subtracts its homing offset from the
//! encoder, a Dynamixel adds it.

use serde::ser::{Serialize, Serializer};
use serde::{Deserialize, Serialize as SerializeDerive};
use sinew_rig::Description;
use sinew_rig::description::{Address, Servo};

use crate::rig_file::ServoChange;
use crate::{Protocol, ServiceError, Table};

/// Calibration of one motor, as in `LeRobot`'s file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, SerializeDerive)]
pub struct MotorCalibration {
    /// Id on the bus.
    pub id: u8,
    /// 1 if the motor is reversed: by its own Drive Mode (Dynamixel), or by `LeRobot` (Feetech).
    pub drive_mode: u8,
    /// Value of the register Homing Offset, counts.
    pub homing_offset: i32,
    /// Minimum position, counts.
    pub range_min: i32,
    /// Maximum position, counts.
    pub range_max: i32,
}

/// Calibrations of motors with their names, in the order of the file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Calibrations(pub Vec<(String, MotorCalibration)>);

impl Serialize for Calibrations {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, motor)| (name, motor)))
    }
}

/// The changes that a calibration makes to a rig file, and notes about them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Taken {
    /// New values of servos.
    pub changes: Vec<ServoChange>,
    /// Notes for a person: values that the rig file cannot contain, and values to check.
    pub notes: Vec<String>,
}

fn refused(name: &str, what: String) -> ServiceError {
    ServiceError::Rig { name: name.to_owned(), what }
}

/// Returns the register table of a rig's servo. Refuses a kind without a table.
fn table_of(servo: &Servo) -> Result<Table, ServiceError> {
    Table::named_model(&servo.model, u8::MAX).ok_or_else(|| {
        refused(&servo.name, format!("its kind {} has no register of its position", servo.model))
    })
}

/// Finds the servo of a motor by its name, otherwise by its id. A servo with this name must have the same id.
fn servo_of<'r>(
    rig: &'r Description,
    name: &str,
    motor: &MotorCalibration,
) -> Result<&'r Servo, ServiceError> {
    let has_id = |servo: &&Servo| servo.address == Address::Id(motor.id);
    let named = rig.servos.iter().find(|servo| servo.name == name);
    match named {
        Some(servo) if has_id(&servo) => Ok(servo),
        Some(servo) => {
            let found = format!("{:?}", servo.address);
            Err(refused(name, format!("the calibration has id {}, the rig file {found}", motor.id)))
        }
        None => rig.servos.iter().find(has_id).ok_or_else(|| {
            refused(name, format!("the rig file has no servo of this name or of id {}", motor.id))
        }),
    }
}

/// Returns the changes that a calibration makes to a rig file: it sets `range_deg`, `homing_offset_deg`, and the
/// `direction` of a reversed motor. `offset_deg` stays unchanged, because `LeRobot`'s zero is the middle of the range,
/// and the rig has its own zero.
///
/// # Errors
/// [`ServiceError::Rig`] if a motor has no servo, or its numbers are not those of its registers.
pub fn taken(rig: &Description, calibrations: &Calibrations) -> Result<Taken, ServiceError> {
    let mut taken = Taken::default();
    for (name, motor) in &calibrations.0 {
        let servo = servo_of(rig, name, motor)?;
        let table = table_of(servo)?;
        let turn = table.counts();
        let MotorCalibration { drive_mode, homing_offset, range_min, range_max, .. } = *motor;
        let is_range = (0..turn).contains(&range_min) && range_min < range_max && range_max < turn;
        if !is_range {
            let what = format!(
                "range_min {range_min}, range_max {range_max}: expected counts from 0 to {}, growing",
                turn - 1
            );
            return Err(refused(name, what));
        }
        if drive_mode > 1 {
            return Err(refused(name, format!("drive_mode {drive_mode}: expected 0 or 1")));
        }
        let is_reversed = drive_mode == 1;
        // A reversed Dynamixel counts in the other direction around its middle. The rig file has the values of the
        // servo without its reversal.
        let mirrors = is_reversed && table.protocol() == Protocol::Dynamixel;
        let (least, most, homing) = if mirrors {
            (turn - range_max, (turn - range_min).min(turn - 1), -homing_offset)
        } else {
            (range_min, range_max, homing_offset)
        };
        let degrees = |counts: i32| (f64::from(counts) * table.rad_per_count()).to_degrees();
        let has_homing = homing_register(&table).is_some();
        if !has_homing && homing != 0 {
            taken.notes.push(format!("{name}: a {} keeps no homing offset", table.model()));
        }
        if mirrors {
            taken.notes.push(format!(
                "{name}: `direction = -1` in place of its Drive Mode: `sinew servo apply` sets the mode to 0"
            ));
        }
        if servo.offset_rad.is_none() {
            taken.notes.push(format!(
                "{name}: no `offset_deg`: where its drive is at zero is not in the calibration; `sinew servo calibrate` finds it"
            ));
        }
        taken.changes.push(ServoChange {
            name: servo.name.clone(),
            range_deg: Some([least, most].map(|end| degrees(end - turn / 2))),
            homing_offset_deg: has_homing.then(|| degrees(homing)),
            direction: is_reversed.then_some(-1),
            offset_deg: None,
        });
    }
    Ok(taken)
}

/// Returns `LeRobot`'s calibration of those servos of a rig that have an id, in the order of the rig file. Without
/// `range_deg` the range is the whole turn; without `homing_offset_deg` the offset is 0. A Feetech with `direction =
/// -1` gets drive mode 1, which makes `LeRobot` reverse it.
///
/// # Errors
/// [`ServiceError::Rig`] if a kind is unknown, or a range is not within a turn.
pub fn calibrations(rig: &Description) -> Result<Calibrations, ServiceError> {
    let mut all = Vec::new();
    for servo in &rig.servos {
        let Address::Id(id) = servo.address else { continue };
        let table = table_of(servo)?;
        let turn = table.counts();
        let counts = |rad: f64| {
            #[expect(clippy::cast_possible_truncation, reason = "saturates")]
            let counts = (rad / table.rad_per_count()).round() as i32;
            counts
        };
        let [range_min, range_max] = match servo.range_rad.first() {
            Some(range) => range.map(|end| counts(end) + turn / 2),
            None => [0, turn - 1],
        };
        if range_min < 0 || range_max >= turn {
            let what = format!(
                "its range is {range_min} to {range_max} counts: expected 0 to {}",
                turn - 1
            );
            return Err(refused(&servo.name, what));
        }
        let is_feetech = table.protocol() == Protocol::Feetech;
        let motor = MotorCalibration {
            id,
            drive_mode: (is_feetech && servo.direction < 0).into(),
            homing_offset: servo.homing_offset_rad.map_or(0, counts),
            range_min,
            range_max,
        };
        all.push((servo.name.clone(), motor));
    }
    Ok(Calibrations(all))
}

/// Returns the register of the homing offset, or `None` if the servo has none.
pub(crate) fn homing_register(table: &Table) -> Option<sinew_servo_bus::table::Item> {
    table.named("Homing Offset")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::desired::{Mode, desired};
    use crate::rig_file::edited;
    use crate::rig_servo::of_bus;

    const MODEL: &str = "STS3215-12V";

    /// Returns the text of a rig file with two servos, as a person writes it before the calibration.
    fn text(model: &str) -> String {
        let mut text = "name = \"arm\"\n[[body]]\nname = \"base\"\n".to_owned();
        for (index, name) in ["shoulder_pan", "shoulder_lift"].into_iter().enumerate() {
            let parent = ["base", "shoulder_pan"][index];
            text.extend([format!(
                "[[body]]\nname = \"{name}\"\n[[joint]]\nname = \"{name}\"\nparent = \"{parent}\"\nchild = \"{name}\"\n\
                 axis = [0, 1, 0]\n[[drive]]\njoints = [\"{name}\"]\nservos = [\"{name}\"]\n[[servo]]\nname = \"{name}\"\n\
                 model = \"{model}\"\nid = {}\n",
                index + 1
            )]);
        }
        text
    }

    fn rig(text: &str) -> Description {
        sinew_rig::toml_file::read(text).unwrap()
    }

    fn motor(id: u8, homing_offset: i32, [range_min, range_max]: [i32; 2]) -> MotorCalibration {
        MotorCalibration { id, drive_mode: 0, homing_offset, range_min, range_max }
    }

    fn named(motors: [MotorCalibration; 2]) -> Calibrations {
        let [pan, lift] = motors;
        Calibrations(vec![("shoulder_pan".to_owned(), pan), ("shoulder_lift".to_owned(), lift)])
    }

    #[test]
    fn a_calibration_comes_back_from_the_rig_file_to_the_count() {
        for homing in [-2047, -1, 0, 1, 123, 2047] {
            for range in [[0, 4095], [760, 3401], [2047, 2049], [1, 4094]] {
                let given = named([motor(1, homing, range), motor(2, -homing, [1000, 3000])]);
                let taken = taken(&rig(&text(MODEL)), &given).unwrap();
                let text = edited(&text(MODEL), &taken.changes).unwrap();
                let rig = rig(&text);
                assert_eq!(calibrations(&rig).unwrap(), given, "{text}");
                // `apply` writes the registers as LeRobot does.
                let servo = &of_bus(&rig, None).unwrap()[0];
                let settings = desired(servo, &servo.table().unwrap(), Mode::Position).unwrap();
                let of = |name: &str| {
                    settings.iter().find(|setting| setting.item.name == name).unwrap().raw
                };
                assert_eq!(of("Homing Offset"), homing);
                assert_eq!([of("Min Position Limit"), of("Max Position Limit")], range);
                assert!(settings.is_sorted_by_key(|setting| setting.item.address));
            }
        }
    }

    #[test]
    fn a_reversed_motor_is_the_rigs_direction() {
        let reversed = MotorCalibration { drive_mode: 1, ..motor(1, 100, [1000, 3000]) };
        let calibrations_of = named([reversed, motor(2, 0, [0, 4095])]);
        // LeRobot reverses a Feetech itself: its registers are as they are.
        let feetech = taken(&rig(&text(MODEL)), &calibrations_of).unwrap();
        let rig_of = rig(&edited(&text(MODEL), &feetech.changes).unwrap());
        assert_eq!(rig_of.servos[0].direction, -1);
        assert_eq!(calibrations(&rig_of).unwrap(), calibrations_of);
        // A reversed Dynamixel counts 4096 - 1000 where it counts 1000 in its other mode.
        let dynamixel = taken(&rig(&text("XL330-M288-T")), &calibrations_of).unwrap();
        let rig_of = rig(&edited(&text("XL330-M288-T"), &dynamixel.changes).unwrap());
        assert_eq!(rig_of.servos[0].direction, -1);
        assert_eq!(
            calibrations(&rig_of).unwrap().0[0].1,
            MotorCalibration { drive_mode: 0, ..motor(1, -100, [1096, 3096]) }
        );
        assert!(dynamixel.notes[0].contains("in place of its Drive Mode"), "{dynamixel:?}");
    }

    #[test]
    fn what_does_not_fit_is_refused_by_name() {
        let rig = rig(&text(MODEL));
        let told =
            |motors: [MotorCalibration; 2]| taken(&rig, &named(motors)).unwrap_err().to_string();
        let good = motor(2, 0, [0, 4095]);
        assert!(told([motor(1, 0, [3000, 1000]), good]).contains("shoulder_pan"));
        assert!(told([motor(1, 0, [0, 4096]), good]).contains("0 to 4095"));
        assert!(told([motor(7, 0, [0, 4095]), good]).contains("id 7"));
        let other = Calibrations(vec![("gripper".to_owned(), motor(2, 5, [10, 20]))]);
        // By its id, since no servo has this name.
        assert_eq!(taken(&rig, &other).unwrap().changes[0].name, "shoulder_lift");
        let nobody = Calibrations(vec![("gripper".to_owned(), motor(9, 5, [10, 20]))]);
        assert!(taken(&rig, &nobody).unwrap_err().to_string().contains("id 9"));
    }
}
