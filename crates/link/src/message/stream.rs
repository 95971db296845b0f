//! What a host sends again and again.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use super::Operator;
use crate::finite;

/// The most numbers of a pose in one message.
pub const POSE_MAX: usize = 64;

/// What counts only while it is fresh. A lost one is not sent again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Stream {
    /// The host is there.
    Heartbeat,
    /// The operator who has the rig for maintenance holds the enabling button.
    HoldToRun(Operator),
    /// Somebody moves one degree of freedom: in maintenance, or playing [`Feed::Jog`](super::Feed::Jog).
    Jog {
        /// Which one.
        dof: u8,
        /// How fast, rad/s or m/s; held to what the state allows.
        #[serde(with = "finite")]
        velocity: f32,
    },
    /// A pose of a live source.
    Live(LiveFrame),
    /// The host is there, and the newest telemetry that it has heard has this number. Since version 1.2: whoever speaks
    /// it says this in place of [`Self::Heartbeat`] as soon as telemetry came.
    Heard(u16),
}

/// A pose of a live source, in rig coordinates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LiveFrame {
    /// When the pose was, by the sender's clock, us; after 2³² it begins at 0 again.
    pub sent_us: u32,
    /// The rig's coordinates, body after body: rad, m, unit quaternions xyzw.
    #[serde(with = "finite::list")]
    pub q: Vec<f32, POSE_MAX>,
}
