//! Orders to a board, and their replies.

use std::f32::consts::PI;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::time::Duration;

use sinew_link::message::{Servo, Summary};

use super::FaultRow;

/// An order of Python, and the way of its reply.
#[derive(Debug)]
pub(super) struct Asked {
    pub(super) order: Order,
    pub(super) cancel: Cancel,
    pub(super) reply: SyncSender<Result<Reply, String>>,
}

/// The wish of Python that one order ends early. It is never taken back.
#[derive(Debug, Clone, Default)]
pub(super) struct Cancel(Arc<AtomicBool>);

impl Cancel {
    pub(super) fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    pub(super) fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// An order of Python.
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
    Play {
        bytes: Vec<u8>,
        rounds: u32,
    },
    Upload {
        bytes: Vec<u8>,
    },
    Hold,
    Stop,
    EStop,
    Clear,
    /// Takes or releases the wheel of a console.
    Wheel {
        take: bool,
    },
    State,
    Faults,
    /// Stops the rig, and ends the session.
    Close,
}

/// Urgency of an order. An order ends the running one if it is more urgent.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Urgency {
    #[default]
    Waits,
    Holds,
    Stops,
    Cuts,
}

impl Order {
    pub(super) fn urgency(&self) -> Urgency {
        match self {
            Self::Hold => Urgency::Holds,
            Self::Stop | Self::Close => Urgency::Stops,
            Self::EStop => Urgency::Cuts,
            _ => Urgency::Waits,
        }
    }

    /// Returns whether the order needs torque: it is not executed after a stop.
    pub(super) fn moves(&self) -> bool {
        matches!(
            self,
            Self::Arm | Self::Goto { .. } | Self::Live { .. } | Self::Play { .. } | Self::Hold
        )
    }

    /// Returns the name of an urgent order in Python.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::Hold => "hold",
            Self::Stop => "stop",
            Self::EStop => "estop",
            Self::Close => "close",
            _ => "an order",
        }
    }
}

/// The result of an order.
#[derive(Debug)]
pub(super) enum Reply {
    Done,
    /// The pose that was sent.
    Sent(Vec<f32>),
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

impl RigState {
    pub(super) fn new(summary: &Summary, q: Vec<f32>, effort: Vec<f32>, servos: &[Servo]) -> Self {
        let error = summary.errors.map_or(f32::NAN, |errors| errors.largest_deg * PI / 180.0);
        Self {
            name: summary.state.to_string(),
            q,
            effort,
            supply_v: summary.supply_v,
            show_ms: summary.show_ms,
            error_rad: error,
            servos: servos.iter().map(|of| (of.temperature_c, of.heat_percent)).collect(),
        }
    }
}
