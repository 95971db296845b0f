//! The folders with the sockets of a user's hubs. They depend on the user alone, so that a stop from `ssh`, `su` or
//! `cron` reaches a hub that was started elsewhere.

use std::fs::{self, File};
use std::io;
use std::os::fd::OwnedFd;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

/// Environment variable with another folder, in which tests have their hubs. The other folders are then not used.
const OWN: &str = "SINEW_SOCKETS";

/// Returns the folder in which a new hub of this user creates its socket.
///
/// # Errors
/// An I/O error if the system does not tell the user.
pub fn folder() -> io::Result<PathBuf> {
    if let Some(own) = own() {
        return Ok(own);
    }
    let uid = uid()?;
    let [session, temporary] = candidates(uid);
    let is_there = session.parent().is_some_and(|parent| is_of(uid, parent));
    Ok(if is_there { session } else { temporary })
}

/// Returns all folders of this user in which hubs may have their sockets.
pub(super) fn folders() -> Vec<PathBuf> {
    if let Some(own) = own() {
        return vec![own];
    }
    let Ok(uid) = uid() else { return Vec::new() };
    candidates(uid).into_iter().filter(|folder| is_of(uid, folder)).collect()
}

fn own() -> Option<PathBuf> {
    Some(PathBuf::from(std::env::var_os(OWN).filter(|path| !path.is_empty())?))
}

/// Returns the folder of a user who is logged in, and that of a user who is not.
fn candidates(uid: u32) -> [PathBuf; 2] {
    [format!("/run/user/{uid}/sinew"), format!("/tmp/sinew-{uid}")].map(PathBuf::from)
}

fn is_of(uid: u32, folder: &Path) -> bool {
    fs::symlink_metadata(folder).is_ok_and(|found| found.is_dir() && found.uid() == uid)
}

/// Returns the number of the user, who owns each pipe of this program.
fn uid() -> io::Result<u32> {
    let (pipe, _) = io::pipe()?;
    Ok(File::from(OwnedFd::from(pipe)).metadata()?.uid())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_hub_is_found() -> io::Result<()> {
        let file = std::env::temp_dir().join(format!("sinew-uid-{}", std::process::id()));
        fs::write(&file, "")?;
        assert_eq!(uid()?, fs::metadata(&file)?.uid());
        fs::remove_file(&file)?;
        if own().is_none() {
            assert!(candidates(uid()?).contains(&folder()?));
        }
        Ok(())
    }
}
