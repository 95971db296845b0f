//! Other commands of this user reach a running console by a Unix socket that only this user can open.
//!
//! A request and its answer are each one line of JSON. A motion is answered when it is over; if the command ends
//! before, the rig holds.

mod client;

use std::path::{Path, PathBuf};
use std::{env, fs};

use serde::{Deserialize, Serialize};

pub use client::{ask, consoles};

/// A command for a running console.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "command", rename_all = "lowercase")]
pub enum Request {
    /// The rig goes to its rest pose, is lowered, then limp.
    Stop,
    /// Torque off at once.
    EStop,
    /// The armed rig goes to its home pose.
    Home,
    /// A joint of the armed rig moves by an angle.
    Jog {
        /// Name of the joint.
        joint: String,
        /// Angle in deg, or distance in mm.
        by: f64,
    },
}

/// An answer of a console.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reply {
    /// Whether the command was executed.
    pub ok: bool,
    /// Result, or reason, in words.
    pub text: String,
}

/// Returns the name of the console that owns a port.
pub fn name_of_port(port: &Path) -> String {
    let port = fs::canonicalize(port).unwrap_or_else(|_| port.to_owned());
    let name = port.to_string_lossy();
    name.chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
        .collect::<String>()
        .trim_matches('-')
        .to_owned()
}

/// Returns the folder of this user's sockets.
pub fn folder() -> PathBuf {
    if let Some(runtime) = env::var_os("XDG_RUNTIME_DIR").filter(|path| !path.is_empty()) {
        return PathBuf::from(runtime).join("sinew");
    }
    let user = env::var("USER").unwrap_or_default();
    let user: String = user.chars().filter(char::is_ascii_alphanumeric).collect();
    env::temp_dir().join(format!("sinew-{user}"))
}
