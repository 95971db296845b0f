//! A Unix socket, which only this user can open, by which other commands of this user reach a hub.
//!
//! A request and its answer are each one line of JSON. A motion is answered at its end. If the command ends earlier,
//! the rig holds.

mod client;
mod server;

use std::env;
use std::fs::{self, DirBuilder};
use std::io;
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

pub use client::{ask, consoles};
pub(crate) use server::Door;

/// A command for a running console.
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
}

/// An answer of a console.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reply {
    /// Whether the command was executed.
    pub ok: bool,
    /// Result, or reason for the refusal, in words.
    pub text: String,
}

/// Returns the name of the console that uses a port.
pub fn name_of_port(port: &Path) -> String {
    let port = fs::canonicalize(port).unwrap_or_else(|_| port.to_owned());
    let name = port.to_string_lossy();
    name.chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
        .collect::<String>()
        .trim_matches('-')
        .to_owned()
}

/// Returns the folder with the sockets of this user's consoles.
fn folder() -> PathBuf {
    if let Some(runtime) = env::var_os("XDG_RUNTIME_DIR").filter(|path| !path.is_empty()) {
        return PathBuf::from(runtime).join("sinew");
    }
    let user = env::var("USER").unwrap_or_default();
    let user: String = user.chars().filter(char::is_ascii_alphanumeric).collect();
    env::temp_dir().join(format!("sinew-{user}"))
}

/// Creates the folder, accessible only to this user. Fails if other users can enter an existing folder.
fn create_folder(folder: &Path) -> io::Result<()> {
    match DirBuilder::new().mode(0o700).create(folder) {
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(error),
        _ => {}
    }
    let found = fs::symlink_metadata(folder)?;
    let of_others = 0o077;
    if found.is_dir() && found.mode() & of_others == 0 {
        return Ok(());
    }
    let text = format!("{}: is not a folder of this user alone", folder.display());
    Err(io::Error::new(io::ErrorKind::PermissionDenied, text))
}
