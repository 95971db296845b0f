//! Built-in parts of a board: the drives of its servos, and its bus lines.

use heapless::Vec;
use serde::{Deserialize, Serialize};
use sinew_core::tracker::Settings as TrackerSettings;
use sinew_firmware::controller::{ControllerSettings, ServoSetup};
use sinew_servo_bus::Schedule;
use sinew_wiring::{Bus, Lines as AnyLines, Wiring};

pub use sinew_wiring::{BusLine, Dynamixel, LineServo, Protocol, Servo};

use crate::arm::{self, Kind};
use crate::limits::{CAPACITY, LINES};

/// The rig that the node drives.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum BuiltIn {
    /// The desk arm of the tests.
    Arm(Kind),
    /// A rig from the host. Messages with its lines and servos follow.
    Rig(Rig),
}

/// The loop of a rig.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Rig {
    /// Number of lines that follow, each as [`ToNode::Line`](crate::message::ToNode::Line).
    pub lines: usize,
    /// Number of servos that follow, in the rig's order, each as [`ToNode::Servo`](crate::message::ToNode::Servo).
    pub servos: usize,
    /// Tick rate, Hz.
    pub rate_hz: u32,
    /// Index of the line whose schedule the controller uses.
    pub latest: usize,
    /// Method and gains.
    pub tracker: TrackerSettings,
}

/// All received messages about the built-in parts.
#[expect(clippy::large_enum_variant, reason = "an image has no heap, and there is one")]
pub(crate) enum Received {
    Arm(Kind),
    Rig { rig: Rig, lines: Vec<BusLine, LINES>, servos: Vec<Servo, CAPACITY> },
}

/// All bus lines of the node.
pub(crate) type Lines = AnyLines<Bus<CAPACITY>, LINES, CAPACITY>;

/// Parts of a controller, besides the rig.
pub(crate) struct Parts {
    pub(crate) settings: ControllerSettings,
    pub(crate) servos: Vec<ServoSetup, CAPACITY>,
    pub(crate) schedule: Schedule,
    pub(crate) lines: Lines,
}

impl Received {
    pub(crate) fn parts(&self) -> Parts {
        match self {
            Self::Arm(kind) => {
                let arm::Parts { settings, servos, schedule, bus, .. } = arm::parts(*kind);
                let lines = Lines::new([bus], [0; arm::SERVOS]);
                let servos = Vec::from_slice(&servos).expect("the arm is small");
                Parts { settings, servos, schedule, lines }
            }
            Self::Rig { rig, lines, servos } => {
                let Rig { rate_hz, latest, tracker, .. } = *rig;
                let (lines, servos) = (lines.clone(), servos.clone());
                let wiring = Wiring { rate_hz, latest, tracker, lines, servos };
                let mut lines = Lines::new([], []);
                wiring.connect(&mut lines).expect("the host has it");
                let schedule = wiring.schedule().expect("the host has it");
                Parts { settings: wiring.settings(), servos: wiring.setups(), schedule, lines }
            }
        }
    }
}
