//! A desk arm with six servos: their drives, and their bus.

use serde::{Deserialize, Serialize};
use sinew_core::tracker::{MethodName, Settings as TrackerSettings};
use sinew_firmware::controller::{ControllerSettings, ServoSetup};
use sinew_firmware::drives::{
    CurrentSettings, CutOff, DriveSettings, Encoder, PositionSettings, VoltageSettings,
};
use sinew_firmware::supervisor::detect::{HeatSettings, SupplySettings, WindingSettings};
use sinew_servo_bus::dynamixel::{self, table::MODELS};
use sinew_servo_bus::feetech::{self, Family};
use sinew_servo_bus::{Schedule, Timing};

use crate::limits::CAPACITY;

const COUNT: u32 = 6;

/// Number of servos of the arm, and of its joints.
pub const SERVOS: usize = COUNT as usize;

/// Drive of the arm's servos.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kind {
    /// XL330 driven by current, 400 Hz at 4 Mbit/s.
    Current,
    /// STS3215 driven by position, 100 Hz at 1 Mbit/s.
    Position,
    /// XL430 driven by voltage, 400 Hz at 4 Mbit/s.
    Voltage,
}

impl Kind {
    /// Returns the tick rate, Hz.
    pub fn rate_hz(self) -> u32 {
        match self {
            Self::Current | Self::Voltage => 400,
            Self::Position => 100,
        }
    }

    /// Returns the model of its servos.
    pub fn model(self) -> &'static str {
        match self {
            Self::Current => "XL330-M288-T",
            Self::Position => "STS3215-7.4V",
            Self::Voltage => "XL430-W250-T",
        }
    }
}

/// Parts of a controller of the arm, besides the rig.
pub struct Parts {
    /// Settings of the controller.
    pub settings: ControllerSettings,
    /// Settings of each servo.
    pub servos: [ServoSetup; SERVOS],
    /// Schedule of the bus.
    pub schedule: Schedule,
    /// Timing of the bus.
    pub timing: Timing,
    /// The bus of the arm.
    pub bus: Bus,
}

/// Type of the arm's bus, which is that of a rig's lines in an image.
pub type Bus = sinew_wiring::Bus<CAPACITY>;

/// Returns the parts of an arm.
///
/// # Panics
/// Never: all numbers are constants.
pub fn parts(kind: Kind) -> Parts {
    let baud = if kind == Kind::Position { 1_000_000 } else { 4_000_000 };
    let timing = Timing { baud, return_delay_us: 2, turnaround_us: 5 };
    let (traffic, recommended_v, bounds_v, stall_a, stall_nm) = match kind {
        // The makers' voltages, each with the range outside of which the servo switches off: 5 V (3.5 to 7 V), 7.4
        // V (4 to 9 V), 11.1 V (6 to 14 V).
        Kind::Current => (dynamixel::traffic(COUNT, 2, true), 5.0, [3.5, 7.0], 1.47, 0.52),
        Kind::Position => {
            let traffic = feetech::traffic(Family::Sts, COUNT).with_goal(6);
            (traffic, 7.4, [4.0, 9.0], 2.4, 1.91)
        }
        Kind::Voltage => (dynamixel::traffic(COUNT, 2, true), 11.1, [6.0, 14.0], 1.3, 1.4),
    };
    let schedule = Schedule::new(timing, &traffic, kind.rate_hz()).expect("the bus is fast enough");
    let current = CurrentSettings {
        encoder: Encoder::default(),
        blind_rad: 0.0059,
        current_a: 1.2,
        // Above the first threshold of the heat detector.
        cut_off: CutOff { warm_c: 65.0, hot_c: 69.0, ..CutOff::default() },
    };
    let setup = ServoSetup {
        drive: match kind {
            Kind::Current => DriveSettings::Current(current),
            Kind::Position => DriveSettings::Position(PositionSettings::default()),
            Kind::Voltage => DriveSettings::Voltage(VoltageSettings {
                current: CurrentSettings { current_a: 1.0, ..current },
                resistance_ohm: recommended_v / stall_a,
                // Supply voltage divided by no-load speed, minus the part for friction.
                back_emf_v_s: 1.44,
                supply_v: recommended_v,
            }),
        },
        // The gear of an XL330 with a light load: half its play and a step of its encoder.
        bandwidth_rad_s: 40.0,
        rest_rad: 0.0059,
        heat: HeatSettings::default(),
        supply: SupplySettings::of(recommended_v, bounds_v[0], bounds_v[1]),
        winding: WindingSettings::of_stall(stall_a),
        stall_a,
        stall_nm,
        shutdown_c: 70.0,
    };
    let tracker = match kind {
        Kind::Current | Kind::Voltage => TrackerSettings::recommended(),
        // A tick of 10 ms with a latency of equal length is too long for the recommended settings, whose feedback a
        // position servo cannot use.
        Kind::Position => {
            TrackerSettings { method: MethodName::Local, ..TrackerSettings::default() }
        }
    };
    let settings = ControllerSettings { tracker, ..ControllerSettings::default() };
    let bus = bus(kind, schedule);
    Parts { settings, servos: [setup; SERVOS], schedule, timing, bus }
}

fn bus(kind: Kind, schedule: Schedule) -> Bus {
    let ids: [u8; SERVOS] = [1, 2, 3, 4, 5, 6];
    match kind {
        Kind::Current | Kind::Voltage => {
            let (name, mode) = match kind {
                Kind::Voltage => ("XL430-W250", dynamixel::Mode::Pwm),
                _ => ("XL330-M288", dynamixel::Mode::Current),
            };
            let model = MODELS.iter().find(|model| model.name == name);
            let setups = ids.map(|id| dynamixel::ServoSetup {
                id,
                model: model.expect("the table has it"),
                mode,
                range_rad: [0.0, 6.2],
                current_a: 1.2,
                pwm: 1.0,
                speed_rad_s: 15.0,
            });
            let settings = dynamixel::Settings { fast: true, retries: 1 };
            let bus = dynamixel::Bus::new(&setups, schedule, settings);
            Bus::Dynamixel(bus.expect("six servos, each with its id"))
        }
        Kind::Position => {
            let setups = ids.map(|id| feetech::ServoSetup {
                id,
                mode: feetech::Mode::Position,
                range_rad: [0.0, 6.2],
                pwm: 1.0,
                speed_rad_s: 10.0,
            });
            let family = Family::Sts;
            let settings = feetech::Settings { family, echo: false, retries: 1, speed_counts: 1 };
            let bus = feetech::Bus::new(&setups, schedule, settings);
            Bus::Feetech(bus.expect("six servos, each with its id"))
        }
    }
}
