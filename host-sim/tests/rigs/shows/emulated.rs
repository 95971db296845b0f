//! `sinew play --target nucleo`: the NUCLEO's own image plays a show with one command.

use super::done;
use crate::common::{command, path};

/// Writes an arm with three joints, and two seconds of punches.
fn arguments(folder: &std::path::Path) -> [String; 10] {
    let [rig, map] = ["arm.toml", "map.toml"].map(|name| path(folder, name));
    done(&["rig", "new", "--arm", "3", "-o", &rig]);
    let joint = &super::mechanism(&rig).bodies[2].joint_name;
    let curve = format!(
        "rig = \"arm\"\nclip = \"punches_01\"\n\n[[curve]]\nclip = \"forearm_l\"\naxis = [0, 0, 1]\nrig = \"{joint}\"\n\
         points_deg = [[-180, -60], [180, 60]]\n"
    );
    std::fs::write(&map, curve).unwrap();
    let seconds = ["--seconds", "2", "--target", "nucleo"].map(str::to_owned);
    let [seconds, two, target, nucleo] = seconds;
    let [play, clip] = ["play", "punches_01"].map(str::to_owned);
    let [of_rig, of_map] = ["--rig", "--mapping"].map(str::to_owned);
    [play, clip, of_rig, rig, of_map, map, seconds, two, target, nucleo]
}

#[test]
#[ignore = "needs the emulator: `cargo xtask emulate`"]
fn emulated_nucleo_performs_by_one_command() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = arguments(folder.path());
    let [table, told] = done(&arguments.each_ref().map(String::as_str));
    let mut rest = told.as_str();
    for state in ["limp", "arming", "holding", "playing", "holding", "stopping", "lowering", "limp"]
    {
        let at = rest.find(&format!("s  {state}\n"));
        rest = &rest[at.unwrap_or_else(|| panic!("{state} is not told: {told}"))..];
    }
    assert!(table.starts_with("the emulated NUCLEO-F446RE ran "), "{table}");
    println!("{table}{told}");
}

#[test]
fn what_is_missing_for_nucleo_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let output = command()
        .args(arguments(folder.path()))
        .env("SINEW_EMULATOR", "no/such/tool")
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("no/such/tool: not there. `cargo xtask emulate` builds it"), "{told}");
}
