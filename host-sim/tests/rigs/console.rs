//! The console without a page: recordings of its session, and recordings instead of a board.

use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Stdio};
use std::thread::sleep;
use std::time::Duration;

use super::board::says;
use crate::common::{command, end_by, path, text};

/// Starts a console, and waits until it serves its page.
fn start(folder: &Path, args: &[&str]) -> Child {
    let mut console = command();
    console.env("SINEW_SOCKETS", folder.join("sinew")).arg("console").args(args);
    let mut console = console.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut address = String::new();
    BufReader::new(console.stdout.take().unwrap()).read_line(&mut address).unwrap();
    assert!(address.starts_with("http://127.0.0.1:"), "{address}");
    console
}

/// The page's commands act by the same hub; this test gives those of other terminals.
#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_nucleo_is_the_board_of_a_console() {
    let folder = tempfile::tempdir().unwrap();
    let rig = path(folder.path(), "arm.toml");
    says(&["rig", "new", "--arm", "3", "-o", &rig], 0);
    let mut console = start(folder.path(), &["--rig", &rig, "--target", "nucleo"]);
    let own = |args: &[&str]| {
        let output = command()
            .env("SINEW_SOCKETS", folder.path().join("sinew"))
            .args(args)
            .output()
            .unwrap();
        text(&output.stdout) + &text(&output.stderr)
    };
    let watched = own(&["board", "monitor", "--samples", "2", "--interval-ms", "50"]);
    assert!(watched.contains("watching nucleo-") && watched.contains("tick "), "{watched}");
    let stopped = own(&["estop"]);
    assert!(stopped.contains("torque is off"), "{stopped}");
    let watched = own(&["board", "monitor", "--samples", "1"]);
    assert!(watched.contains("faulted, fault 16"), "{watched}");
    end_by(&mut console, "-INT");
    assert_eq!(console.wait().unwrap().code(), Some(0));
}

#[test]
fn a_session_is_recorded_reported_and_shown() {
    let folder = tempfile::tempdir().unwrap();
    let [recording, page] = ["session.parquet", "page.html"].map(|name| path(folder.path(), name));
    let mut console = start(folder.path(), &["--record", &recording]);
    sleep(Duration::from_secs(4));
    end_by(&mut console, "-INT");
    assert_eq!(console.wait().unwrap().code(), Some(0));
    says(&["report", &recording, "-o", &page], 0);
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.contains("a session of the console") && page.contains("limp"));

    let mut console = start(folder.path(), &[&recording]);
    end_by(&mut console, "-TERM");
    assert_eq!(console.wait().unwrap().code(), Some(0));
    for option in [&["--servo", "xm430"][..], &["--unattended"], &["kicks_01"]] {
        let refused = says(&[&["console", &recording][..], option].concat(), 2);
        assert!(refused.contains("has no effect on a recording"), "{refused}");
    }
    let no_recording = path(folder.path(), "none.parquet");
    std::fs::write(&no_recording, "PAR1").unwrap();
    let refused = says(&["console", &no_recording], 2);
    assert!(refused.contains("none.parquet"), "{refused}");
}
