//! Unix socket through which commands reach a running hub of the same user. A hub is a console, or another command that
//! uses a board. Only this user can open the socket.
//!
//! A request is one line of JSON, and so is its answer. A motion is answered at its end; if the asking command ends
//! earlier, the rig holds. A command that watches receives a line for each view of the rig, until it ends. A program
//! that drives sends and receives the messages of a page, a line each.

mod client;
mod folder;

use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};
use sinew_link::message::{FaultRecord, Servo, Summary};

pub use client::{Watching, ask, ask_all, connect, consoles, roles, watch};
pub use folder::folder;

/// A command for a running hub.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "command", rename_all = "lowercase")]
pub enum Request {
    /// The hub moves the rig to its rest pose, lowers it, and switches torque off.
    Stop,
    /// The hub switches torque off at once.
    EStop,
    /// The hub moves the armed rig to its home pose.
    Home,
    /// The hub moves a joint of the armed rig by an angle or a distance.
    Jog {
        /// Name of the joint.
        joint: String,
        /// Angle in deg, or distance in mm.
        by: f64,
    },
    /// The hub sends views of the rig until the asking command ends.
    Watch,
    /// A hub that only watches closes its port, so that the asking command can open it.
    Yield,
    /// The hub tells its [`Role`].
    Who,
    /// A console accepts the connection as a page: messages in both directions, each a line of JSON.
    Drive,
}

/// Kind of a hub.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// A console, or a command that drives a board.
    Drives,
    /// A command that watches a board.
    Watches,
    /// A command that simulates a rig without a board.
    Simulates,
}

impl Role {
    /// Returns the word by which a hub tells its role.
    pub fn name(self) -> &'static str {
        match self {
            Self::Drives => "drives",
            Self::Watches => "watches",
            Self::Simulates => "simulates",
        }
    }
}

/// State of a rig for a command that watches.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct View {
    /// Newest summary of the board.
    pub summary: Summary,
    /// Newest data of all servos.
    pub servos: Vec<Servo>,
    /// Faults that are new since the previous view.
    pub faults: Vec<FaultRecord>,
}

/// State of a rig for a program that drives it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// CRC of the rig.
    pub rig: u32,
    /// Newest summary of the board.
    pub summary: Summary,
    /// Number of summaries that the hub has received.
    pub summaries: u32,
    /// Measured coordinates.
    pub q: Vec<f32>,
    /// Commanded efforts of all dofs, N m or N.
    pub efforts: Vec<f32>,
    /// Newest data of all servos.
    pub servos: Vec<Servo>,
}

/// Answer of a hub to a request.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reply {
    /// Whether the command was executed.
    pub ok: bool,
    /// Result, or reason for the refusal, in words.
    pub text: String,
}

/// Returns the name of the hub that uses a port. The name depends only on the port's path.
pub fn name_of_port(port: &Path) -> String {
    let port = fs::canonicalize(port).unwrap_or_else(|_| port.to_owned());
    let name = port.to_string_lossy();
    name.chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
        .collect::<String>()
        .trim_matches('-')
        .to_owned()
}
