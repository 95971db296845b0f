//! A Unix socket, which only this user can open, by which commands of this user reach a running hub: a console, or
//! another command that uses the board.
//!
//! A request and its answer are each one line of JSON. A motion is answered at its end. If the command ends earlier,
//! the rig holds. A command that watches gets a line for each view of the rig until it ends.

mod client;

use std::path::{Path, PathBuf};
use std::{env, fs};

use serde::{Deserialize, Serialize};
use sinew_link::message::{FaultRecord, Servo, Summary};

pub use client::{Watching, ask, consoles, watch};

/// A command for a running hub.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "command", rename_all = "lowercase")]
pub enum Request {
    /// The rig goes to its rest pose and is lowered; then torque is off.
    Stop,
    /// Torque goes off at once.
    EStop,
    /// The armed rig goes to its home pose.
    Home,
    /// A joint of the armed rig moves by an angle or a distance.
    Jog {
        /// Name of the joint.
        joint: String,
        /// Angle in deg, or distance in mm.
        by: f64,
    },
    /// Views of the rig, until the command leaves.
    Watch,
    /// A hub that only watches closes its port, so that this command can open it.
    Yield,
}

/// View of a rig, for a command that watches.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct View {
    /// The newest summary.
    pub summary: Summary,
    /// The newest data of servos.
    pub servos: Vec<Servo>,
    /// Faults since the last view.
    pub faults: Vec<FaultRecord>,
}

/// An answer of a hub.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reply {
    /// Whether the command was executed.
    pub ok: bool,
    /// Result, or reason for the refusal, in words.
    pub text: String,
}

/// Returns the name of the hub that uses a port.
pub fn name_of_port(port: &Path) -> String {
    let port = fs::canonicalize(port).unwrap_or_else(|_| port.to_owned());
    let name = port.to_string_lossy();
    name.chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
        .collect::<String>()
        .trim_matches('-')
        .to_owned()
}

/// Returns the folder with the sockets of this user's hubs.
pub fn folder() -> PathBuf {
    if let Some(runtime) = env::var_os("XDG_RUNTIME_DIR").filter(|path| !path.is_empty()) {
        return PathBuf::from(runtime).join("sinew");
    }
    let user = env::var("USER").unwrap_or_default();
    let user: String = user.chars().filter(char::is_ascii_alphanumeric).collect();
    env::temp_dir().join(format!("sinew-{user}"))
}
