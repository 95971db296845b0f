//! Following errors of servos by position, predicted by `bake` and met in `play`.

use super::{done, within_limits};
use crate::common::{path, sinew};

/// A show within all limits of the arm ended in a following error before errors were predicted: the servos have their
/// torque at rest and their speed without load, but not both at once.
#[test]
fn a_show_that_would_end_in_a_following_error_is_named_or_fitted() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, show] = ["arm.toml", "kick.show"].map(|name| path(folder.path(), name));
    done(&["rig", "new", "--arm", "6", "-o", &rig]);
    // STS3215 have no current mode. Without its own limits the arm has those of its servos.
    let text = std::fs::read_to_string(&rig).unwrap().replace("XL330-M288-T", "STS3215-7.4V");
    let is_limit =
        |line: &&str| line.starts_with("speed_deg_s") || line.starts_with("acceleration");
    let text: Vec<&str> = text.lines().filter(|line| !is_limit(line)).collect();
    std::fs::write(&rig, text.join("\n")).unwrap();

    let checked = done(&["rig", "check", &rig])[0].clone();
    assert!(checked.contains("Joints by position: the largest speed"), "{checked}");

    let bake = ["bake", "kicks_01", "--rig", &rig, "--seconds", "6", "-o", &show];
    let play = ["play", &show, "--rig", &rig, "--fast"];
    let [report, _] = done(&bake);
    assert!(report.contains("EXCEEDED: bend6: following error "), "{report}");
    let output = sinew(&play);
    let told = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("faults: fault 9 (following error) of joint bend6"), "{told}");

    for fit in ["--fit", "--keep-time"] {
        let [report, _] = done(&[&bake[..], &[fit]].concat());
        assert!(within_limits(&report), "{report}");
        let line = report.lines().find(|line| line.starts_with("Following error")).expect(&report);
        let predicted = line.split("at most ").nth(1).and_then(|rest| rest.split('°').next());
        let predicted: f64 = predicted.and_then(|number| number.parse().ok()).expect(line);
        // 80 % of 15 deg.
        assert!(predicted <= 12.0, "{line}");
        let [table, _] = done(&play);
        assert!(table.contains("faults: none"), "{fit}: {table}");
        let [_, largest] = super::play::errors(&table, "position");
        // The play prints two decimals, the prediction three digits; a bound is above the play.
        assert!(largest <= predicted + 0.06, "{fit}: {largest} {predicted}");
    }
}
