//! `sinew servo tap`: with a simulated servo in simulated time, and at the port of `sinew servo simulate`.

use std::path::{Path, PathBuf};

use sinew_rig::description::ServoModel;
use sinew_rig::toml_file;

use crate::common::{printed, sinew};

/// Writes an arm with XL330 servos into a folder.
fn arm(folder: &Path) -> PathBuf {
    let rig = folder.join("rig.toml");
    printed(&["rig", "new", "--arm", "3", "-o", rig.to_str().unwrap()]);
    rig
}

/// Returns exit code, standard output and standard error of `sinew servo tap turn1 --rig RIG ARGS`.
fn tap(rig: &Path, args: &[&str]) -> (i32, String, String) {
    let start = ["servo", "tap", "turn1", "--rig", rig.to_str().unwrap()];
    let output = sinew(&[&start, args].concat());
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

/// A weight with the inertia of the servo's rotor, so that the arm rings.
const WEIGHT: [&str; 4] = ["--target", "sim", "--inertia-kg-m2", "0.0018"];

#[test]
fn a_gear_that_is_softer_than_the_file_says_comes_into_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let rig = arm(folder.path());
    let before = std::fs::read_to_string(&rig).unwrap();
    let (code, said, errors) =
        tap(&rig, &[&WEIGHT as &[&str], &["--plant", "stiffness=0.5"]].concat());
    assert_eq!(code, 0, "{said}{errors}");
    for words in
        ["turn1, an XL330-M288-T: it rings with", "stiffness, N m/rad", "29.7", "damping, N m s"]
    {
        assert!(said.contains(words), "{said}");
    }
    assert!(errors.contains("wrote XL330-M288-T into"), "{errors}");
    let after = std::fs::read_to_string(&rig).unwrap();
    assert!(after.starts_with(&before), "{after}");
    let read = toml_file::read(&after).unwrap();
    let model = &read.servo_models[0];
    let built_in = ServoModel::built_in("XL330-M288-T").unwrap();
    let off = [
        model.gear_stiffness() / (0.5 * built_in.gear_stiffness()) - 1.0,
        model.gear_damping() / built_in.gear_damping() - 1.0,
    ];
    assert!(off.iter().all(|off| off.abs() < 0.2), "{off:?}");
    let source = &model.gear_stiffness_nm_rad.as_ref().unwrap().source;
    assert!(
        source.starts_with("tap test of a simulated servo of turn1, 150 taps: +- "),
        "{source}"
    );
    // All other values are those of its kind.
    let with_its_gear = ServoModel {
        gear_stiffness_nm_rad: built_in.gear_stiffness_nm_rad.clone(),
        gear_damping_nm_s: built_in.gear_damping_nm_s.clone(),
        ..model.clone()
    };
    assert_eq!(with_its_gear, built_in);
    // Writes to another file, and with --dry-run to none.
    let other = folder.path().join("other.toml");
    let (code, ..) = tap(&rig, &[&WEIGHT as &[&str], &["-o", other.to_str().unwrap()]].concat());
    assert_eq!(code, 0);
    let (code, ..) = tap(&rig, &[&WEIGHT as &[&str], &["--dry-run"]].concat());
    assert_eq!(code, 0);
    assert_eq!(std::fs::read_to_string(&rig).unwrap(), after);
    let read = toml_file::read(&std::fs::read_to_string(&other).unwrap()).unwrap();
    // The simulated servo now matches the file.
    let off = read.servo_models[0].gear_stiffness() / model.gear_stiffness() - 1.0;
    assert!(off.abs() < 0.2, "{off}");
}

#[test]
fn what_tells_too_little_is_refused_and_leaves_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let rig = arm(folder.path());
    let before = std::fs::read_to_string(&rig).unwrap();
    let start = ["--target", "sim"];
    for (args, words) in [
        // Three light links without a weight.
        (&[] as &[&str], "Fix a weight to it"),
        (&["--inertia-kg-m2", "0.05"], "has 0.05000"),
        (
            &["--inertia-kg-m2", "0.0018", "--taps", "20", "--strength", "5"],
            "the shaft rings by 0.",
        ),
        (&["-o", rig.to_str().unwrap()], "is the rig, which would be lost"),
        (&["--plant", "stiffnes=2"], "stiffness (of gears)"),
    ] {
        let (code, said, errors) = tap(&rig, &[&start as &[&str], args].concat());
        assert_eq!((code, said.as_str()), (2, ""), "{args:?}: {errors}");
        assert!(errors.contains(words), "{args:?}: {errors}");
    }
    let output =
        sinew(&["servo", "tap", "nobody", "--rig", rig.to_str().unwrap(), "--target", "sim"]);
    let errors = String::from_utf8(output.stderr).unwrap();
    assert!(errors.contains("the rig has no servo \"nobody\"; there are: turn1"), "{errors}");
    assert_eq!(std::fs::read_to_string(&rig).unwrap(), before);
}

#[cfg(unix)]
mod at_a_port {
    use std::io::{BufRead as _, BufReader, Read as _};
    use std::process::Stdio;
    use std::time::Duration;

    use super::super::process::{end, start};
    use super::{arm, sinew};
    use crate::common::command;

    const LINE: [&str; 4] = ["--baud", "1000000", "--timeout-ms", "300"];

    #[test]
    fn ctrl_c_ends_a_test_and_leaves_the_servo_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let rig = arm(folder.path());
        let (rig, link) = (rig.to_str().unwrap(), folder.path().join("bus"));
        let link = link.to_str().unwrap();
        let servos = start(&["--rig", rig, "--pty", link]);
        let read = |register: &str| {
            let args = ["servo", "read", "1", register, "--port", link];
            let output = sinew(&[&args as &[&str], &LINE].concat());
            String::from_utf8(output.stdout).unwrap()
        };
        let registers = ["torque-enable", "position-p-gain", "goal-pwm", "profile-velocity"];
        let before = registers.map(read);
        assert!(before.iter().all(|register| !register.is_empty()));
        let mut tap = command()
            .args(["servo", "tap", "turn1", "--rig", rig, "--port", link, "--yes"])
            .args(["--inertia-kg-m2", "0.0018"])
            .args(LINE)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut said = BufReader::new(tap.stderr.take().unwrap());
        let mut line = String::new();
        said.read_line(&mut line).unwrap();
        assert!(line.contains("turn1 (id 1): 150 taps move it by up to"), "{line}");
        // Long enough for some taps.
        std::thread::sleep(Duration::from_secs(3));
        let status = end(tap, "-INT");
        let mut rest = String::new();
        said.read_to_string(&mut rest).unwrap();
        assert_eq!(status.code(), Some(2), "{rest}");
        assert!(rest.contains("ended by a signal"), "{rest}");
        assert_eq!(registers.map(read), before);
        end(servos, "-TERM");
    }
}
