//! Refusals of `sinew servo`, and their messages.

use crate::common::sinew;

#[track_caller]
fn refused(args: &[&str], code: i32) -> String {
    let output = sinew(&[&["servo"], args].concat());
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{args:?}: {text}");
    assert!(output.stdout.is_empty());
    text
}

#[test]
fn a_port_that_is_not_named_or_not_there_says_so() {
    let none = refused(&["scan"], 2);
    assert!(none.contains("--port PORT") && none.contains("/dev/ttyUSB0"), "{none}");
    let missing = refused(&["ping", "1", "--port", "/dev/no-such-port"], 2);
    assert!(missing.contains("/dev/no-such-port: there is no such port"), "{missing}");
    // Options of the port may be before or after the command.
    let missing = refused(&["--port", "/dev/no-such-port", "--baud", "57600", "watch", "1"], 2);
    assert!(missing.contains("no such port"), "{missing}");
    let file = tempfile::NamedTempFile::new().unwrap();
    let text = refused(&["scan", "--port", file.path().to_str().unwrap()], 2);
    assert!(text.contains("it is no serial port"), "{text}");
}

#[test]
fn numbers_that_cannot_be_are_refused_before_the_port_is_opened() {
    for args in [
        &["ping", "253"][..],
        &["set-id", "1", "254"],
        &["scan", "--baud", "0"],
        &["scan", "--timeout-ms", "0"],
        &["watch", "1", "--samples", "0"],
        &["calibrate", "--rig", "rig.toml", "--margin-deg", "nan"],
        &["diff", "--rig", "rig.toml", "--mode", "torque"],
    ] {
        let text = refused(args, 2);
        assert!(text.contains("invalid value"), "{args:?}: {text}");
    }
    for value in ["fast", "1e"] {
        let text = refused(&["write", "1", "led", value], 2);
        assert!(text.contains("expected a number"), "{text}");
    }
    let text = refused(&["write", "1", "led", "1.5", "--raw"], 2);
    assert!(text.contains("expected a whole number"), "{text}");
}

#[test]
fn a_rig_that_has_no_servos_on_the_bus_is_refused_before_the_port_is_opened() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rig.toml");
    std::fs::write(&path, "name = \"stone\"\n[[body]]\nname = \"base\"\n").unwrap();
    let path = path.to_str().unwrap();
    for command in ["diff", "apply", "calibrate", "watch"] {
        let text = refused(&[command, "--rig", path, "--port", "/dev/no-such-port"], 2);
        assert!(text.contains("stone: none of its servos has an id"), "{command}: {text}");
    }
}
