//! Socket through which other commands of this user reach the hub: the hub's end. The commands' end is
//! [`sinew_board_client::console`].

mod bell;
mod server;

use std::fs::{self, DirBuilder};
use std::io;
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _};
use std::path::{Path, PathBuf};

pub use sinew_board_client::console::{
    Reply, Request, Role, View, Watching, ask, ask_all, consoles, folder, name_of_port, roles,
    watch,
};

pub use bell::Bell;
pub(crate) use server::Door;

/// Answers to a stop and to an e-stop.
pub(crate) const STOPS: &str = "the rig goes to its rest pose, then torque is off";
pub(crate) const CUTS: &str = "torque is off";

/// Returns the folder of this user's sockets. Creates it if necessary.
///
/// # Errors
/// An I/O error, also if the folder exists and other users may open it.
pub fn private_folder() -> io::Result<PathBuf> {
    let folder = folder()?;
    create_folder(&folder)?;
    Ok(folder)
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
