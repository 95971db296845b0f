//! `sinew servo` at the port of `sinew servo simulate`, both as processes.

use std::path::{Path, PathBuf};
use std::process::Child;

use serde_json::Value;

use super::process::{end, start};
use crate::common::{printed, sinew};

/// Simulated servos on a port.
pub(super) struct Bus {
    folder: tempfile::TempDir,
    child: Option<Child>,
}

impl Bus {
    fn link(folder: &Path) -> String {
        folder.join("bus").to_str().unwrap().to_owned()
    }

    pub(super) fn of_kind(kind: &str, ids: &str) -> Self {
        Self::of_kind_with(kind, ids, &[])
    }

    pub(super) fn of_kind_with(kind: &str, ids: &str, more: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let link = Self::link(folder.path());
        let args = ["--kind", kind, "--ids", ids, "--pty", &link];
        let child = Some(start(&[&args, more].concat()));
        Self { folder, child }
    }

    pub(super) fn port(&self) -> String {
        Self::link(self.folder.path())
    }

    /// Simulates the servos of a rig of `sinew rig new`.
    pub(super) fn of_new_arm(joints: &str, more: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (rig, link) = (folder.path().join("rig.toml"), Self::link(folder.path()));
        let rig = rig.to_str().unwrap();
        printed(&["rig", "new", "--arm", joints, "-o", rig]);
        let args: Vec<&str> = ["--rig", rig, "--pty", &link].iter().chain(more).copied().collect();
        let child = Some(start(&args));
        Self { folder, child }
    }

    pub(super) fn rig(&self) -> PathBuf {
        self.folder.path().join("rig.toml")
    }

    /// Returns exit code, standard output and standard error of `sinew servo ARGS --port LINK`.
    pub(super) fn servo(&self, args: &[&str]) -> (i32, String, String) {
        let port = self.port();
        let output = sinew(&[&["servo"], args, &["--port", &port]].concat());
        let text = |bytes| String::from_utf8(bytes).unwrap();
        (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
    }

    /// Runs `sinew servo ARGS` at the rate of the port. The command must succeed. It waits longer for answers, because
    /// a busy machine may delay the simulator.
    #[track_caller]
    pub(super) fn done(&self, args: &[&str]) -> String {
        let args: Vec<&str> =
            args.iter().chain(&["--baud", "1000000", "--timeout-ms", "300"]).copied().collect();
        let (code, said, errors) = self.servo(&args);
        assert_eq!(code, 0, "{args:?}: {said}{errors}");
        said
    }

    /// Runs `sinew servo ARGS` at the rate of the port. The command must end with code `expected`. Returns all its
    /// output.
    #[track_caller]
    pub(super) fn not_done(&self, args: &[&str], expected: i32) -> String {
        let args: Vec<&str> =
            args.iter().chain(&["--baud", "1000000", "--timeout-ms", "300"]).copied().collect();
        let (code, said, errors) = self.servo(&args);
        assert_eq!(code, expected, "{args:?}: {said}{errors}");
        said + &errors
    }

    /// Returns the raw number in a register.
    pub(super) fn raw(&self, id: &str, register: &str) -> i64 {
        let read = self.done(&["read", id, register, "--format", "json"]);
        let object: Value = serde_json::from_str(&read).unwrap();
        assert_eq!(object["schema"], "sinew-servo-read/1");
        object["registers"][0]["raw"].as_i64().unwrap()
    }
}

impl Drop for Bus {
    fn drop(&mut self) {
        if let Some(child) = self.child.take() {
            let ended = end(child, "-TERM");
            assert!(std::thread::panicking() || ended.success());
        }
    }
}

#[test]
fn servos_are_found_asked_and_given_another_id() {
    let bus = Bus::of_kind("xl330", "1,2,3");
    let found = bus.done(&["scan", "--max-id", "4", "--format", "json"]);
    let found: Value = serde_json::from_str(&found).unwrap();
    let servos: Vec<_> = found["servos"]
        .as_array()
        .unwrap()
        .iter()
        .map(|servo| (servo["id"].as_u64().unwrap(), servo["model"].as_str().unwrap()))
        .collect();
    assert_eq!(servos, [(1, "XL330-M288"), (2, "XL330-M288"), (3, "XL330-M288")]);
    assert!(bus.done(&["scan", "--max-id", "4"]).lines().nth(1).unwrap().contains("XL330-M288"));
    // Without protocol and rate the command searches for both, and prints them.
    let (code, said, errors) = bus.servo(&["ping", "2"]);
    assert_eq!((code, said.as_str()), (0, "servo 2: XL330-M288, firmware 52, at 1000000 baud\n"));
    assert!(errors.contains("Dynamixel at 1000000 baud"), "{errors}");
    assert!(bus.not_done(&["ping", "9"], 2).contains('9'));

    assert_eq!(bus.done(&["set-id", "3", "7"]), "servo 3 is servo 7 now\n");
    assert!(bus.done(&["ping", "7"]).starts_with("servo 7: XL330-M288"));
    bus.not_done(&["ping", "3"], 2);
    // Another servo has that id.
    assert!(bus.not_done(&["set-id", "1", "2"], 2).contains('2'));
    assert!(bus.done(&["ping", "1"]).starts_with("servo 1:"));
}

#[test]
fn registers_are_read_and_written_by_name() {
    let bus = Bus::of_kind("sts3215", "4");
    assert!(bus.done(&["ping", "4"]).starts_with("servo 4: STS3215"));
    // The middle of its turn.
    let position = bus.raw("4", "present-position");
    assert!((position - 2048).abs() <= 2, "{position}");
    assert!(bus.done(&["read", "4"]).lines().count() > 30);
    let unknown = bus.not_done(&["read", "4", "goal-colour"], 2);
    assert!(unknown.to_lowercase().contains("goal"), "{unknown}");

    let written = bus.done(&["write", "4", "max-position-limit", "3000", "--raw"]);
    assert!(written.contains("(raw 3000)"), "{written}");
    assert_eq!(bus.raw("4", "max-position-limit"), 3000);
    // The EEPROM is locked again.
    assert_eq!(bus.raw("4", "lock"), 1);
    bus.not_done(&["write", "4", "max-position-limit", "70000", "--raw"], 2);
    bus.not_done(&["write", "4", "present-position", "1", "--raw"], 2);
    assert_eq!(bus.raw("4", "max-position-limit"), 3000);
}

#[test]
fn a_rig_s_settings_are_compared_written_and_compared_again() {
    let bus = Bus::of_new_arm("3", &["--supply", "4.6"]);
    let rig = bus.rig();
    let rig = rig.to_str().unwrap();
    let differs = bus.not_done(&["diff", "--rig", rig], 1);
    assert!(differs.contains("Return Delay Time") && differs.contains("in 3 servos"), "{differs}");
    let applied = bus.done(&["apply", "--rig", rig]);
    assert_eq!(applied.lines().count(), 3);
    assert!(applied.lines().all(|line| line.contains("wrote ")), "{applied}");
    assert_eq!(bus.done(&["diff", "--rig", rig]), "no difference in 3 servos\n");
    assert!(
        bus.done(&["apply", "--rig", rig]).lines().all(|line| line.ends_with("as it should be"))
    );
    // One supply for all servos, as the option says.
    assert_eq!(bus.raw("3", "present-input-voltage"), 46);

    // A changed servo that holds a load is left alone, and the others are still checked.
    bus.done(&["write", "2", "return-delay-time", "100", "--raw"]);
    bus.done(&["write", "2", "torque-enable", "1", "--raw"]);
    let left = bus.not_done(&["apply", "--rig", rig], 2);
    assert!(left.contains("`apply --torque-off`"), "{left}");
    assert_eq!(bus.raw("2", "torque-enable"), 1);
    let released = bus.done(&["apply", "--rig", rig, "--torque-off"]);
    assert!(released.contains("its torque is off now"), "{released}");
    assert_eq!((bus.raw("2", "torque-enable"), bus.raw("2", "return-delay-time")), (0, 1));
    bus.done(&["diff", "--rig", rig]);
}

#[test]
fn help_says_that_a_servo_with_torque_is_left_alone() {
    let help = printed(&["servo", "apply", "--help"]);
    let words = help.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        words.contains("a servo whose torque is on is skipped, unless --torque-off is given"),
        "{words}"
    );
}
