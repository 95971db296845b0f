//! Opens the page in a browser, if a person uses the desktop of this machine.

use std::env;
use std::fs::{self, OpenOptions};
use std::io::{IsTerminal as _, Write as _, stdout};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use sinew_console::local::private_folder;

/// Program that opens a file with the user's default program.
const OPENER: &str = if cfg!(target_os = "macos") { "open" } else { "xdg-open" };

/// File that redirects a browser to the page. The file is removed on drop.
///
/// The address contains the token. Only this user can read this file, but all users of the machine can read the
/// arguments of a program.
pub(super) struct Redirect(PathBuf);

impl Drop for Redirect {
    fn drop(&mut self) {
        // The user may have removed it.
        let _ = fs::remove_file(&self.0);
    }
}

/// Opens an address in a browser. Returns the file that redirects the browser; it must exist until the browser has read
/// it. Returns `None` without a desktop or a browser; the address is printed in any case.
pub(super) fn open(address: &str) -> Option<Redirect> {
    if !stdout().is_terminal() || !is_desktop(|name| env::var_os(name).is_some()) {
        return None;
    }
    let path = private_folder().ok()?.join(format!("console-{}.html", std::process::id()));
    let redirect = Redirect(path);
    let mut file = OpenOptions::new()
        .write(true)
        .create(true)
        .truncate(true)
        .mode(0o600)
        .open(&redirect.0)
        .ok()?;
    file.write_all(page(address).as_bytes()).ok()?;
    let mut opener = Command::new(OPENER);
    opener.arg(&redirect.0).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    opener.spawn().ok()?;
    Some(redirect)
}

/// Returns whether the program was started on a desktop of this machine. `has`: whether an environment variable is set.
fn is_desktop(has: impl Fn(&str) -> bool) -> bool {
    let is_remote = ["CI", "SSH_CONNECTION", "SSH_TTY"].into_iter().any(&has);
    let has_screen =
        cfg!(target_os = "macos") || ["DISPLAY", "WAYLAND_DISPLAY"].into_iter().any(&has);
    has_screen && !is_remote
}

fn page(address: &str) -> String {
    format!(
        "<!doctype html><meta charset=\"utf-8\"><meta http-equiv=\"refresh\" content=\"0; url={address}\">\
         <a href=\"{address}\">Sinew console</a>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_browser_is_opened_on_a_desktop_alone() {
        let with = |set: &[&str]| is_desktop(|name| set.contains(&name));
        assert!(with(&["DISPLAY"]) && with(&["WAYLAND_DISPLAY"]));
        assert_eq!(with(&[]), cfg!(target_os = "macos"));
        for remote in ["CI", "SSH_CONNECTION", "SSH_TTY"] {
            assert!(!with(&["DISPLAY", remote]), "{remote}");
        }
        assert!(page("http://127.0.0.1:1/#0f").contains("url=http://127.0.0.1:1/#0f\""));
    }
}
