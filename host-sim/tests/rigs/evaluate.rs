//! `--rig`: a user's rig tracks motions of its own joints.

use std::path::{Path, PathBuf};

use crate::common::{printed, sinew};

/// Writes a new arm whose mount has this rotation.
fn arm(folder: &Path, mount: &str) -> String {
    let path = folder.join("arm.toml");
    let text = printed(&["rig", "new", "--arm", "6"]);
    let (name, rest) = text.split_once("\n\n").expect("its name stands apart");
    std::fs::write(&path, format!("{name}\n\n[mount]\nrotation_xyzw = {mount}\n\n{rest}")).unwrap();
    path.to_str().unwrap().to_owned()
}

/// Returns the mean angular error of all bodies over the first 40 s of all motions, deg.
fn mean_deg(rig: &str, masses: &str) -> f64 {
    let set = format!("disturbance.masses={masses}");
    let methods = ["--methods", "recommended", "--seconds", "40", "--format", "csv"];
    let table = printed(&[&["evaluate", "--rig", rig, "--set", &set][..], &methods].concat());
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    let mut rows = rows.records().map(Result::unwrap);
    rows.find(|row| &row[2] == "all").expect("a row of all bodies")[4].parse().unwrap()
}

/// Largest mean error that the rigs may have, deg.
const GOAL_DEG: f64 = 0.1;

#[test]
fn an_arm_follows_however_it_is_mounted() {
    let folder = tempfile::tempdir().unwrap();
    // On the floor, on a wall, upside down.
    for mount in ["[0, 0, 0, 1]", "[0, 0, 0.7071067811865476, 0.7071067811865476]", "[1, 0, 0, 0]"]
    {
        let rig = arm(folder.path(), mount);
        for masses in ["0", "0.15"] {
            let mean = mean_deg(&rig, masses);
            assert!(mean > 0.0 && mean < GOAL_DEG, "{mount}, masses {masses}: {mean}");
        }
    }
}

#[test]
fn all_commands_take_a_rig_and_say_so() {
    let folder = tempfile::tempdir().unwrap();
    let rig = arm(folder.path(), "[0, 0, 0, 1]");
    let table = printed(&["evaluate", "--rig", &rig, "--seconds", "2"]);
    assert!(table.contains("base of the rig: held by a stand"), "{table}");
    assert!(table.contains("Rig arm") && table.contains("Recommended"), "{table}");
    assert!(!table.contains("paper"), "{table}");
    let accumulated =
        printed(&["evaluate", "--rig", &rig, "--seconds", "2", "--methods", "accumulated"]);
    assert!(accumulated.contains("Accumulated"), "its reference is the base by default");
    let robust =
        printed(&["evaluate", "robustness", "--rig", &rig, "--seconds", "1", "--rigs", "2"]);
    assert!(robust.starts_with("rig arm") && !robust.contains("times the dim"), "{robust}");
    let late = ["--seconds", "1", "--rates-hz", "500", "--methods", "world"];
    let late = printed(&[&["evaluate", "latency", "--rig", &rig][..], &late].concat());
    assert!(late.starts_with("rig arm"), "{late}");

    let sweep = folder.path().join("sweep.toml");
    std::fs::write(&sweep, "[[grid]]\ncontroller.method = ['local', 'recommended']\n").unwrap();
    let out = folder.path().join("out");
    let [file, out] = [&sweep, &out].map(|path| path.to_str().unwrap());
    let again = ["evaluate", "sweep", file, "--rig", &rig, "--seconds", "1", "--output", out];
    assert!(printed(&again).contains("2 cells; 4 runs made"));
    assert!(printed(&again).contains("0 runs made, 4 taken over"));
}

#[test]
fn what_a_rig_has_by_itself_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let rig = arm(folder.path(), "[0, 0, 0, 1]");
    let face = folder.path().join("face.toml");
    printed(&["rig", "new", "--face", "-o", face.to_str().unwrap()]);
    let face = face.to_str().unwrap();
    for (arguments, part) in [
        (&["evaluate", "--rig", &rig, "--scale", "1.1"][..], "cannot be used with"),
        (&["evaluate", "--rig", &rig, "--clips", "a.bvh"], "a.bvh"),
        (&["evaluate", "--rig", &rig, "--set", "root=fixed"], "the rig has its own"),
        (&["evaluate", "--rig", &rig, "--set", "controller.reference=pelvi"], "a body of the rig"),
        (
            &["evaluate", "--rig", &rig, "--speed-shares", "0"],
            "shares: expected shares from 0.01 to 1",
        ),
        (
            &["evaluate", "--rig", &rig, "--speed-shares", "0.5,0.5"],
            "shares: expected each share once",
        ),
        (&["evaluate", "--speed-shares", "0.5"], "--rig"),
        // Rigs that this plant cannot simulate are refused; they are not lost.
        (&["evaluate", "--rig", &rig, "--plant", "rapier"], "a rotor has inertia"),
        (
            &["evaluate", "robustness", "--rig", &rig, "--plant", "rapier", "--seconds", "1"],
            "a rotor has inertia",
        ),
        (&["evaluate", "--rig", face], "sinew rig view"),
        (&["evaluate", "--rig", "none.toml"], "none.toml"),
    ] {
        let output = sinew(arguments);
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        assert!(told.contains(part), "{arguments:?}: {told}");
    }
}

#[test]
fn a_rig_that_is_too_weak_is_told_and_fails() {
    let folder = tempfile::tempdir().unwrap();
    let path = arm(folder.path(), "[0, 0, 0, 1]");
    let text = std::fs::read_to_string(&path).unwrap();
    let tip = text.rfind("mass_kg = ").unwrap();
    let end = tip + text[tip..].find('\n').unwrap();
    std::fs::write(&path, format!("{}mass_kg = 2.5{}", &text[..tip], &text[end..])).unwrap();
    let methods = ["--methods", "recommended", "--seconds", "10"];
    let output = sinew(&[&["evaluate", "--rig", &path][..], &methods].concat());
    assert_eq!(output.status.code(), Some(1));
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(told.contains("FAULT: joint bend2: gravity asks for"), "{told}");
    assert!(told.contains("method recommended: not followed"), "{told}");
    let table = String::from_utf8_lossy(&output.stdout);
    assert!(table.contains("torques cut by the drives' limits: Recommended"), "{table}");
}

#[test]
fn a_setup_in_a_file_keeps_the_exact_plant() {
    let folder = tempfile::tempdir().unwrap();
    let rig = arm(folder.path(), "[0, 0, 0, 1]");
    let setup = folder.path().join("setup.toml");
    std::fs::write(&setup, "plant.substeps = 2\n").unwrap();
    let file = ["--setup", setup.to_str().unwrap(), "--seconds", "1", "--methods", "world"];
    let table = printed(&[&["evaluate", "--rig", &rig][..], &file].concat());
    assert!(table.contains("articulated-body algorithm in f64, 2 substep(s)"), "{table}");
}

/// The robots of `SINEW_DATA` that can become a rig without changes.
#[test]
#[ignore = "needs SINEW_DATA"]
fn robots_follow_within_a_tenth_of_a_degree() {
    let data: PathBuf = std::env::var_os("SINEW_DATA").expect("SINEW_DATA").into();
    for file in [
        "urdf/poppy-humanoid/Poppy_Humanoid.urdf",
        "urdf/robotis-op3/robotis_op3.urdf",
        "urdf/open-duck-mini/open_duck_mini_v2.urdf",
        "urdf/open-duck-mini/open_duck_mini_v2.mjcf.xml",
        "foreign/urdf/so100.urdf",
        "foreign/urdf/panda.urdf",
    ] {
        let rig = data.join(file);
        for masses in ["0", "0.15"] {
            let mean = mean_deg(rig.to_str().unwrap(), masses);
            assert!(mean > 0.0 && mean < GOAL_DEG, "{file}, masses {masses}: {mean}");
        }
    }
    let reachy = data.join("urdf/reachy-mini/reachy_mini.urdf");
    let output = sinew(&["evaluate", "--rig", reachy.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("5 closed loops"));
}
