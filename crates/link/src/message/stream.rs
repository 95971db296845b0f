//! Periodic messages of a host.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use super::Operator;
use crate::finite;

/// Maximum number of coordinates of a pose in a message.
pub const POSE_MAX: usize = 64;

/// A message that counts only while it is fresh. A lost message is not sent again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Stream {
    /// The host is alive.
    Heartbeat,
    /// The operator who has the rig for maintenance holds the enabling button.
    HoldToRun(Operator),
    /// An operator moves a single dof, in maintenance or while the rig plays [`Feed::Jog`](super::Feed::Jog).
    Jog {
        /// Index of the dof.
        dof: u8,
        /// Speed, rad/s or m/s, limited to the maximum of the state.
        #[serde(with = "finite")]
        velocity: f32,
    },
    /// A pose of a live source.
    Live(LiveFrame),
    /// The host is alive, and has received telemetry up to this number. Since version 1.2: a host of that version
    /// sends this instead of [`Self::Heartbeat`] as soon as telemetry arrives.
    Heard(u16),
}

/// A pose of a live source, in rig coordinates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LiveFrame {
    /// Time of the pose by the sender's clock, us; it wraps to 0 after 2³².
    pub sent_us: u32,
    /// The rig's coordinates, body after body: rad, m, unit quaternions xyzw.
    #[serde(with = "finite::list")]
    pub q: Vec<f32, POSE_MAX>,
}
