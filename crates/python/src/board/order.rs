//! Orders to a board, and their replies.

use std::time::Duration;

use super::FaultRow;

/// An order that Python gives to a board.
#[derive(Debug)]
pub(super) enum Order {
    Arm,
    Goto {
        q: Vec<f32>,
        least: Duration,
    },
    Live {
        q: Vec<f32>,
    },
    /// Stores a show on the board, and selects it.
    Load {
        bytes: Vec<u8>,
    },
    Play {
        bytes: Vec<u8>,
        rounds: u32,
    },
    Hold,
    Stop,
    EStop,
    Clear,
    State,
    Faults,
    /// Stops the rig, and ends the session.
    Close,
}

/// Reply to an order.
#[derive(Debug)]
pub(super) enum Reply {
    Done,
    State(Box<RigState>),
    Faults(Vec<FaultRow>),
}

/// State of a rig according to the newest telemetry.
#[derive(Debug)]
pub(super) struct RigState {
    pub(super) name: String,
    pub(super) q: Vec<f32>,
    pub(super) effort: Vec<f32>,
    pub(super) supply_v: f32,
    pub(super) show_ms: u32,
    /// Largest angle between pose and target, rad; NaN without a target.
    pub(super) error_rad: f32,
    /// Temperature in degC, and heat in percent of its maximum, for each servo.
    pub(super) servos: Vec<(Option<i8>, u8)>,
}
