//! What a board has built in: how its servos are driven, and its lines.

use heapless::Vec;
use serde::{Deserialize, Serialize};
use sinew_bus::dynamixel::table::MODELS;
use sinew_bus::{Schedule, Timing, Traffic, dynamixel, feetech};
use sinew_core::tracker::Settings as TrackerSettings;
use sinew_firmware::controller::{ControllerSettings, ServoSetup};

use crate::arm::{self, Kind};
use crate::lines::{Line as BusLine, Lines};
use crate::node::{CAPACITY, LINES};
use crate::remote::{
    DynamixelModeOf, DynamixelOf, FeetechOf, FeetechServoOf, ServoSetupOf, TimingOf, TrafficOf,
};

/// What the node drives.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum BuiltIn {
    /// The desk arm of the tests.
    Arm(Kind),
    /// A rig of a host, whose lines and servos follow.
    Rig(Rig),
}

/// A rig's loop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Rig {
    /// How many lines follow, each as [`ToNode::Line`](crate::message::ToNode::Line).
    pub lines: usize,
    /// How many servos follow, in the rig's order, each as [`ToNode::Servo`](crate::message::ToNode::Servo).
    pub servos: usize,
    /// Ticks a second.
    pub rate_hz: u32,
    /// The line whose schedule the controller goes by.
    pub latest: usize,
    /// Method and gains.
    pub tracker: TrackerSettings,
}

/// A line of servos.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// What is spoken on it.
    pub protocol: Protocol,
    /// How fast it is.
    #[serde(with = "TimingOf")]
    pub timing: Timing,
    /// What goes over it in a tick.
    #[serde(with = "TrafficOf")]
    pub traffic: Traffic,
}

/// What is spoken on a line, and how.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Protocol {
    /// Dynamixel 2.0.
    Dynamixel(#[serde(with = "DynamixelOf")] dynamixel::Settings),
    /// Feetech's.
    Feetech(#[serde(with = "FeetechOf")] feetech::Settings),
}

/// A servo.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Servo {
    /// Its line.
    pub line: usize,
    /// What it is there.
    pub on_line: OnLine,
    /// What the controller knows of it.
    #[serde(with = "ServoSetupOf")]
    pub setup: ServoSetup,
}

/// What a servo is on its line.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum OnLine {
    /// A Dynamixel.
    Dynamixel(Dynamixel),
    /// A Feetech.
    Feetech(#[serde(with = "FeetechServoOf")] feetech::ServoSetup),
}

/// A [`dynamixel::ServoSetup`], its model by number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Dynamixel {
    id: u8,
    model: u16,
    #[serde(with = "DynamixelModeOf")]
    mode: dynamixel::Mode,
    range_rad: [f32; 2],
    current_a: f32,
    pwm: f32,
    speed_rad_s: f32,
}

impl From<dynamixel::ServoSetup> for Dynamixel {
    fn from(setup: dynamixel::ServoSetup) -> Self {
        let dynamixel::ServoSetup { id, model, mode, range_rad, current_a, pwm, speed_rad_s } =
            setup;
        Self { id, model: model.number, mode, range_rad, current_a, pwm, speed_rad_s }
    }
}

impl Dynamixel {
    fn setup(self) -> dynamixel::ServoSetup {
        let Self { id, model, mode, range_rad, current_a, pwm, speed_rad_s } = self;
        let model = MODELS.iter().find(|known| known.number == model);
        let model = model.expect("the host's table is this one");
        dynamixel::ServoSetup { id, model, mode, range_rad, current_a, pwm, speed_rad_s }
    }
}

/// All that was said of it.
#[expect(clippy::large_enum_variant, reason = "an image has no heap, and there is one")]
pub(crate) enum Said {
    Arm(Kind),
    Rig { rig: Rig, lines: Vec<Line, LINES>, servos: Vec<Servo, CAPACITY> },
}

/// What a controller is made of, beside the rig.
pub(crate) struct Parts {
    pub(crate) settings: ControllerSettings,
    pub(crate) servos: Vec<ServoSetup, CAPACITY>,
    pub(crate) schedule: Schedule,
    pub(crate) lines: Lines,
}

impl Said {
    pub(crate) fn parts(&self) -> Parts {
        match self {
            Self::Arm(kind) => {
                let arm::Parts { settings, servos, schedule, bus, .. } = arm::parts(*kind);
                let lines = Lines::new([BusLine::Arm(bus)], [0; arm::SERVOS]);
                let servos = Vec::from_slice(&servos).expect("the arm is small");
                Parts { settings, servos, schedule, lines }
            }
            Self::Rig { rig, lines, servos } => {
                let schedule = |line: &Line| {
                    Schedule::new(line.timing, &line.traffic, rig.rate_hz).expect("the host has it")
                };
                let buses = (0..).zip(lines).map(|(index, line)| {
                    let own = servos.iter().filter(|servo| servo.line == index);
                    line.bus(own.map(|servo| servo.on_line), schedule(line))
                });
                Parts {
                    settings: ControllerSettings {
                        tracker: rig.tracker,
                        ..ControllerSettings::default()
                    },
                    servos: servos.iter().map(|servo| servo.setup).collect(),
                    schedule: schedule(&lines[rig.latest]),
                    lines: Lines::new(buses, servos.iter().map(|servo| servo.line)),
                }
            }
        }
    }
}

impl Line {
    fn bus(&self, servos: impl Iterator<Item = OnLine>, schedule: Schedule) -> BusLine {
        const RIGHT: &str = "the host has a bus of these servos";
        match self.protocol {
            Protocol::Dynamixel(settings) => {
                let setups: Vec<_, CAPACITY> = servos
                    .map(|servo| match servo {
                        OnLine::Dynamixel(own) => own.setup(),
                        OnLine::Feetech(_) => panic!("{RIGHT}"),
                    })
                    .collect();
                let bus = dynamixel::Bus::new(&setups, schedule, settings);
                BusLine::Dynamixel(bus.expect(RIGHT))
            }
            Protocol::Feetech(settings) => {
                let setups: Vec<_, CAPACITY> = servos
                    .map(|servo| match servo {
                        OnLine::Feetech(own) => own,
                        OnLine::Dynamixel(_) => panic!("{RIGHT}"),
                    })
                    .collect();
                let bus = feetech::Bus::new(&setups, schedule, settings);
                BusLine::Feetech(bus.expect(RIGHT))
            }
        }
    }
}
