//! The console's page while the link between the hub and its board is interrupted.

use std::path::Path;
use std::process::{Child, Stdio};
use std::time::Duration;

use crate::common::{command, sinew_in};
use crate::console::{Served, arm, text, wait_for_state, wait_until};

/// A simulated board on a pseudo-terminal.
struct OnPty(Child);

impl OnPty {
    /// Starts a board with a rig of `folder`, and waits for its link.
    fn start(folder: &Path) -> Self {
        let simulate = ["board", "simulate", "--rig", "arm.toml", "--pty", "board"];
        let mut board = command();
        let board = board.current_dir(folder).args(simulate).stdin(Stdio::null());
        let board = Self(board.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap());
        while folder.join("board").symlink_metadata().is_err() {
            std::thread::sleep(Duration::from_millis(20));
        }
        board
    }
}

impl Drop for OnPty {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The console stands still for 4 s while the rig holds. The board lowers the rig; afterwards the page reports the
/// fault with its remedy, and clears it.
#[test]
#[ignore = "needs SINEW_CHROMIUM"]
fn a_lost_link_is_told_and_cleared() {
    let folder = tempfile::tempdir().unwrap();
    let new = ["rig", "new", "--arm", "3", "--output", "arm.toml"];
    assert!(sinew_in(folder.path(), &new).status.success());
    let board = OnPty::start(folder.path());
    let console =
        Served::start_in(folder.path(), &["--rig", "arm.toml", "--target", "board", "--no-open"]);
    console.with_page(|page| {
        arm(page);
        console.signal("-STOP");
        wait_until(page, "document.getElementById('lost-title').textContent === 'No news'");
        assert_eq!(page.ask("document.getElementById('lost').hidden"), false);
        assert_eq!(page.ask("document.querySelectorAll('#sliders input:enabled').length"), 0);
        page.wait_ms(3000);
        console.signal("-CONT");
        wait_until(page, "document.getElementById('faults').textContent.includes('link lost')");
        let panel = text(page, "faults");
        assert!(panel.contains("To do: "), "{panel}");
        let is_clear = "document.getElementById('faults').hidden";
        let clear = "document.querySelector('#faults .clear')?.click()";
        wait_until(page, &format!("({clear}, {is_clear})"));
        wait_for_state(page, "limp");
        wait_until(page, "document.getElementById('lost').hidden");
        arm(page);
    });
    drop((console, board));
}
