//! `sinew servo simulate` as a command.

use std::fs::{File, OpenOptions};
use std::io::{Read as _, Write as _};
use std::path::Path;
use std::sync::mpsc;
use std::time::Duration;

use super::process::{end, simulate, start};
use crate::common::printed;

/// A ping of servo 3: ROBOTIS e-manual, protocol 2.0.
const PING: [u8; 10] = [0xFF, 0xFF, 0xFD, 0x00, 0x03, 0x03, 0x00, 0x01, 0x1A, 0xE6];

/// Sends a ping, and returns the answer within a second; empty if there is none.
fn ping(link: &Path) -> Vec<u8> {
    let mut port = OpenOptions::new().read(true).write(true).open(link).unwrap();
    port.write_all(&PING).unwrap();
    let (send, receive) = mpsc::channel();
    let mut reader: File = port.try_clone().unwrap();
    // Without an answer, the thread ends with the terminal.
    std::thread::spawn(move || {
        let mut reply = [0; 14];
        if reader.read_exact(&mut reply).is_ok() {
            let _ = send.send(reply.to_vec());
        }
    });
    receive.recv_timeout(Duration::from_secs(1)).unwrap_or_default()
}

#[test]
fn it_serves_a_port_until_it_is_told_to_end() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("bus");
    for signal in ["-TERM", "-INT"] {
        let child = start(&["--kind", "xl330", "--ids", "1,3", "--pty", link.to_str().unwrap()]);
        for _ in 0..2 {
            let reply = ping(&link);
            // Id 3, a status without an error; model 1200, firmware 52.
            assert_eq!(reply[..12], [0xFF, 0xFF, 0xFD, 0, 3, 7, 0, 0x55, 0, 0xB0, 0x04, 52]);
        }
        assert!(end(child, signal).success());
        assert!(link.symlink_metadata().is_err(), "the link is still there");
    }
}

#[test]
fn each_bus_of_a_rig_has_a_link_and_a_fault_has_its_servo() {
    let folder = tempfile::tempdir().unwrap();
    let rig = folder.path().join("rig.toml");
    printed(&["rig", "new", "--arm", "3", "-o", rig.to_str().unwrap()]);
    let text = std::fs::read_to_string(&rig).unwrap();
    let link = folder.path().join("bus");
    let args = |fault: &'static str| {
        let [rig, link] = [&rig, &link].map(|path| path.to_str().unwrap().to_owned());
        vec!["--rig".to_owned(), rig, "--pty".to_owned(), link, "--fault".to_owned(), fault.into()]
    };
    let started = |args: &[String]| start(&args.iter().map(String::as_str).collect::<Vec<_>>());

    let child = started(&args("bend3:silent"));
    assert!(ping(&link).is_empty());
    assert!(end(child, "-TERM").success());

    // The first servo is alone on another bus.
    let at = text.find("[[servo]]").unwrap() + "[[servo]]".len();
    let [before, behind] = [&text[..at], &text[at..]];
    std::fs::write(&rig, format!("{before}\nbus = \"neck\"{behind}")).unwrap();
    let child = started(&args("turn1:silent"));
    assert_eq!(ping(&folder.path().join("bus.main")).len(), 14);
    assert!(folder.path().join("bus.neck").exists());
    assert!(end(child, "-TERM").success());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn what_cannot_be_is_refused_with_what_could() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "mine").unwrap();
    let [link, taken] = [folder.path().join("bus"), file.clone()];
    let [link, taken] = [link.to_str().unwrap(), taken.to_str().unwrap()];
    for (args, words) in [
        (&["--pty", link][..], "--rig <RIG>|--kind <KIND>"),
        (&["--kind", "xl999", "--pty", link], "there are XL330-M288-T, "),
        (&["--kind", "xl330"], "--pty <LINK>"),
        (&["--kind", "xl330", "--ids", "1,1", "--pty", link], "two servos have id 1"),
        (&["--kind", "xl330", "--ids", "253", "--pty", link], "0 to 252"),
        (&["--kind", "xl330", "--baud", "9601", "--pty", link], "only to [9600, 57600"),
        (&["--kind", "xl330", "--supply", "5,0", "--pty", link], "`V,OHM,A`"),
        (&["--kind", "xl330", "--fault", "1:mute", "--pty", link], "one of: silent"),
        (&["--kind", "xl330", "--fault", "2:silent", "--pty", link], "expected one of 1"),
        (&["--kind", "xl330", "--pty", taken], "is not a link"),
        (&["--rig", "none.toml", "--pty", link], "none.toml"),
    ] {
        let output = simulate(args).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && said.contains(words), "{args:?}: {said}");
        assert!(output.stdout.is_empty(), "{args:?}");
    }
    assert_eq!(std::fs::read_to_string(file).unwrap(), "mine");
}
