//! The hub's end of the socket by which other commands of this user reach it. Their end is
//! [`sinew_board_client::console`].

mod server;

use std::fs::{self, DirBuilder};
use std::io;
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _};
use std::path::Path;

pub use sinew_board_client::console::{Reply, Request, ask, consoles, folder, name_of_port};

pub(crate) use server::Door;

/// Creates the folder, for this user alone. A folder that others may enter is refused.
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
