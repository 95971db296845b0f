//! A servo of a rig that plays: its drive, and the controller's settings for it.

use sinew_firmware::controller::ServoSetup;
use sinew_firmware::drives::{
    CurrentSettings, CutOff, DriveSettings, Encoder, PositionSettings, TargetSettings,
    VoltageSettings,
};
use sinew_firmware::supervisor::detect::{HeatSettings, SupplySettings, WindingSettings};
use sinew_rig::Description;
use sinew_rig::tracking::ServoTracking;
use sinew_servo_bus::dynamixel;
use sinew_servo_sim::registers::RegisterTable;
use sinew_servo_sim::rig::RigServo;
use sinew_servo_tools::position_gain::PositionGain;

use super::CompactRig;
use super::error::PartsError;

/// Largest current as a share of the stall current. A guess that leaves room for the voltage drop of a supply.
const CURRENT_SHARE: f64 = 0.8;
/// Voltage range of a Feetech servo, V: the minimum by its table, and a factor on the recommended voltage for the
/// maximum (1.2 is a guess).
const FEETECH_V: (f32, f32) = (4.0, 1.2);
/// A current drive reduces its current to zero over this many °C, beginning at the temperature at which the heat
/// detector finds a fault.
const HOT_ROOM_C: f32 = 4.0;

/// Quantity by which a servo is driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drive {
    /// Current: the tracker closes the loop.
    Current,
    /// Voltage: the tracker closes the loop, and the winding damps.
    Voltage,
    /// Position: the servo closes the loop.
    Position,
    /// Length of pulses: the servo closes the loop, and reports nothing.
    Pulses,
}

impl Drive {
    /// All drives, in the order of tables.
    pub const ALL: [Self; 4] = [Self::Current, Self::Voltage, Self::Position, Self::Pulses];

    /// Returns the name of the drive in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Current => "current",
            Self::Voltage => "voltage",
            Self::Position => "position",
            Self::Pulses => "pulses",
        }
    }

    /// Returns whether the tracker closes the loop.
    pub fn closes_loop(self) -> bool {
        matches!(self, Self::Current | Self::Voltage)
    }
}

/// A servo of a rig that plays.
#[derive(Debug, Clone)]
pub struct ServoPart {
    /// Data for the simulation.
    pub own: RigServo,
    /// Quantity by which the servo is driven.
    pub drive: Drive,
    /// Index of the servo's line, and the servo's place on this line.
    pub place: (usize, usize),
}

/// Returns the operating mode of a Dynamixel for a drive.
pub(super) fn mode(drive: Drive) -> dynamixel::Mode {
    match drive {
        Drive::Current => dynamixel::Mode::Current,
        Drive::Voltage => dynamixel::Mode::Pwm,
        Drive::Position | Drive::Pulses => dynamixel::Mode::Position,
    }
}

pub(super) fn table(servo: &RigServo) -> Option<RegisterTable> {
    RegisterTable::of(&servo.kind.name)
}

/// Returns the no-load speed, at which the back-EMF equals the supply voltage, rad/s.
pub(super) fn no_load_rad_s(servo: &RigServo) -> f64 {
    servo.kind.voltage_v / servo.kind.torque_constant_nm_a
}

fn stall_a(servo: &RigServo) -> f64 {
    servo.kind.voltage_v / servo.kind.resistance_ohm
}

pub(super) fn current_a(stall_a: f32) -> f32 {
    single(CURRENT_SHARE) * stall_a
}

#[expect(clippy::cast_possible_truncation, reason = "a board computes in f32")]
pub(super) fn single(number: f64) -> f32 {
    number as f32
}

pub(super) fn encoder(part: &ServoPart) -> Encoder {
    let turn_rad = single(part.own.kind.range_rad);
    Encoder { zero_rad: 0.5 * turn_rad, turn_rad }
}

/// Returns whether servos of a model support a drive.
fn takes(drive: Drive, model: &str) -> bool {
    match (drive, RegisterTable::of(model)) {
        (Drive::Current, Some(RegisterTable::Dynamixel(table))) => table.model.current.is_some(),
        (Drive::Voltage, table) => matches!(table, Some(RegisterTable::Dynamixel(_))),
        (Drive::Position, table) => table.is_some(),
        (Drive::Pulses, table) => table.is_none(),
        (Drive::Current, _) => false,
    }
}

/// Returns the default drive of a model: see `docs/drives.md`.
fn usual(model: &str) -> Drive {
    let known = [Drive::Current, Drive::Position];
    known.into_iter().find(|drive| takes(*drive, model)).unwrap_or(Drive::Pulses)
}

/// Returns whether the tracker closes the loop of servos of a model by default.
pub(crate) fn closes_loop(model: &str) -> bool {
    usual(model).closes_loop()
}

/// Returns the drive of each servo: the requested drive, or the default of its model. Servos that share a drive train
/// get a drive that all of them support.
pub(super) fn drives(
    board: &CompactRig,
    servos: &[RigServo],
    asked: Option<Drive>,
) -> Result<Vec<Drive>, PartsError> {
    let can = |servo: &RigServo, drive| takes(drive, &servo.kind.name);
    // Beside servos on a bus, servos on pulses keep their drive.
    let all_pulses = servos.iter().all(|servo| table(servo).is_none());
    let is_asked = |servo: &&RigServo| all_pulses || table(servo).is_some();
    if let Some(drive) = asked
        && let Some(servo) = servos.iter().filter(is_asked).find(|servo| !can(servo, drive))
    {
        let takes = Drive::ALL.into_iter().filter(|drive| can(servo, *drive)).collect();
        let (servo, model) = (servo.name.clone(), servo.kind.name.clone());
        return Err(PartsError::NotSo { drive, servo, model, takes });
    }
    let of = |servo: &RigServo| {
        asked.filter(|drive| can(servo, *drive)).unwrap_or_else(|| usual(&servo.kind.name))
    };
    let mut drives: Vec<Drive> = servos.iter().map(of).collect();
    for shared in board.drives() {
        let all = || shared.servos.iter().map(|servo| usize::from(*servo));
        let of_pulses = |servo: &usize| drives[*servo] == Drive::Pulses;
        if let Some(one) = all().find(of_pulses)
            && let Some(other) = all().find(|servo| !of_pulses(servo))
        {
            let [one, other] = [one, other].map(|servo| servos[servo].name.clone());
            return Err(PartsError::Mixed { one, other });
        }
        if all().any(|servo| drives[servo] == Drive::Position) {
            all().for_each(|servo| drives[servo] = Drive::Position);
        }
    }
    Ok(drives)
}

/// Returns the controller's settings for a servo.
pub(super) fn setup(
    rig: &Description,
    part: &ServoPart,
    gear: &ServoTracking,
    gain: Option<PositionGain>,
) -> ServoSetup {
    let kind = &part.own.kind;
    let model = rig.servo_model(&kind.name);
    let stall_a = model.as_ref().map_or(stall_a(&part.own), |model| model.stall_current_a.value);
    let stall_a = single(stall_a);
    let stall_nm = model.map_or(kind.torque_constant_nm_a * f64::from(stall_a), |model| {
        model.stall_torque_nm.value
    });
    let stall_nm = single(stall_nm);
    let heat = HeatSettings::of_limit(single(kind.shutdown_c));
    let cut_off =
        CutOff { warm_c: heat.off_c, hot_c: heat.off_c + HOT_ROOM_C, ..CutOff::default() };
    let encoder = encoder(part);
    let voltage_v = single(kind.voltage_v);
    let [least_v, most_v] = match table(&part.own) {
        Some(RegisterTable::Dynamixel(table)) => {
            table.model.voltage_limits.map(|deci| 0.1 * f32::from(deci))
        }
        _ => [FEETECH_V.0, FEETECH_V.1 * voltage_v],
    };
    let current = CurrentSettings {
        encoder,
        blind_rad: single(gear.blind_rad),
        current_a: current_a(stall_a),
        cut_off,
    };
    ServoSetup {
        drive: match part.drive {
            Drive::Current => DriveSettings::Current(current),
            Drive::Voltage => DriveSettings::Voltage(VoltageSettings {
                current,
                resistance_ohm: voltage_v / stall_a,
                back_emf_v_s: single(kind.voltage_v / no_load_rad_s(&part.own)),
                supply_v: rig.supply.map_or(voltage_v, |supply| single(supply.voltage_v)),
            }),
            Drive::Position => DriveSettings::Position(PositionSettings {
                encoder,
                gain_ratio: gain.map_or(1.0, |gain| gain.ratio()),
                drag_nm_s: stall_nm / single(no_load_rad_s(&part.own)),
                cut_off,
                ..PositionSettings::default()
            }),
            Drive::Pulses => DriveSettings::Target(TargetSettings { encoder: None }),
        },
        bandwidth_rad_s: gear.bandwidth.map_or(0.0, |bandwidth| bandwidth.rad_s),
        rest_rad: single(gear.rest),
        heat,
        supply: SupplySettings::of(voltage_v, least_v, most_v),
        winding: WindingSettings::of_stall(stall_a),
        stall_a,
        stall_nm,
        shutdown_c: single(kind.shutdown_c),
    }
}
