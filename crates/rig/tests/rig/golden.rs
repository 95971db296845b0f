//! Compares torques of imported robots with those of Pinocchio and MuJoCo (`tests/golden/rigs/make.py`).

#![expect(clippy::cast_possible_truncation, reason = "the core computes in f32")]

use std::path::{Path, PathBuf};

use serde_json::Value;
use sinew_core::dynamics::{BodyMotion, inverse_dynamics};
use sinew_core::glam::Vec3;
use sinew_core::{JointStates, JointTargets, Tree, Wrench};
use sinew_rig::Mechanism;
use sinew_rig::import::{self, Options};

const CAPACITY: usize = 64;

/// Tolerance of f32 against f64: a plain recursive Newton-Euler algorithm in f32 is within 1.4e-6 of the largest
/// torque (tests/oracles); angles, inertias and axes that are rounded to f32 first add further errors.
const TOLERANCE: f64 = 2e-5;

fn numbers(value: &Value) -> Vec<f64> {
    let numbers = value.as_array().expect("a list");
    numbers.iter().map(|number| number.as_f64().expect("a number")).collect()
}

/// Folder of the golden files.
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/rigs");

fn is_mjcf(file: &str) -> bool {
    Path::new(file).extension().is_some_and(|extension| extension == "xml")
}

/// Imports the rig of a file, from `SINEW_DATA` or from the golden files' folder.
fn imported(file: &str, repair_inertia: bool) -> import::Imported {
    let folder = if file.contains('/') {
        std::env::var_os("SINEW_DATA").expect("SINEW_DATA names the folder of the data").into()
    } else {
        PathBuf::from(FOLDER)
    };
    let text = std::fs::read_to_string(folder.join(file)).expect("the file");
    let options = Options { repair_inertia, ..Options::default() };
    let read = if is_mjcf(file) { import::mjcf } else { import::urdf };
    read(&text, &options).unwrap_or_else(|error| panic!("{file}:{error}"))
}

/// Returns the efforts along the dofs that a motion needs. Gravity points along the world's -y.
fn efforts(tree: &Tree<CAPACITY>, q: &[f32], qd: &[f32], qdd: &[f32]) -> Vec<f64> {
    let mut targets = JointTargets::rest(tree);
    targets.set_coordinates(tree, q, qd, qdd).expect("a motion");
    let mut states = JointStates::rest(tree);
    states.set_coordinates(tree, q, qd).expect("a state");
    let gravity = Vec3::new(0.0, -9.81, 0.0);
    let mut scratch = vec![BodyMotion::default(); tree.len()];
    let mut wrenches = vec![Wrench::ZERO; tree.len()];
    inverse_dynamics(
        tree.bodies(),
        states.as_slice(),
        targets.accelerations(),
        gravity,
        &[],
        &mut scratch,
        &mut wrenches,
    );
    let mut efforts = vec![0.0; tree.dof_count()];
    tree.efforts(states.as_slice(), &wrenches, &mut efforts).expect("slices that fit");
    efforts.into_iter().map(f64::from).collect()
}

/// Sorts numbers of a golden file into the order of the rig's dofs.
fn in_order(names: &[String], golden: &[&str], numbers: &[f64]) -> Vec<f32> {
    let number = |name: &String| {
        let at = golden.iter().position(|golden| golden == name);
        numbers[at.unwrap_or_else(|| panic!("no joint `{name}`"))] as f32
    };
    names.iter().map(number).collect()
}

/// Returns the largest error of all states, as a share of the largest effort.
fn largest_error(golden: &Value) -> f64 {
    let file = golden["file"].as_str().expect("a file");
    let repair = golden["repair_inertia"].as_bool().expect("a word");
    let mut mechanism: Mechanism =
        imported(file, repair).description.mechanism().expect("a mechanism");
    let names = mechanism.dof_names();
    let joints: Vec<&str> = golden["joints"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|joint| joint.as_str().expect("a name"))
        .collect();
    assert_eq!(names.len(), joints.len(), "{file}: as many degrees of freedom");
    let rotors = in_order(&names, &joints, &numbers(&golden["rotor_inertia"]));
    if is_mjcf(file) {
        let links = mechanism.bodies.iter().filter(|link| link.parent.is_some());
        let ours: Vec<f32> = links.map(|link| link.rotor_inertia as f32).collect();
        assert_eq!(ours, rotors, "{file}: armature");
    }
    // A URDF has no rotor inertias, therefore those of the golden file are set.
    let moved = mechanism.bodies.iter_mut().filter(|link| link.parent.is_some());
    for (link, rotor) in moved.zip(&rotors) {
        link.rotor_inertia = f64::from(*rotor);
    }
    let tree = mechanism.tree::<CAPACITY>().expect("a tree");
    let (mut error, mut largest) = (0.0_f64, 0.0_f64);
    for state in golden["states"].as_array().expect("a list") {
        let column = |name: &str| in_order(&names, &joints, &numbers(&state[name]));
        let (q, qd, qdd, tau) = (column("q"), column("qd"), column("qdd"), column("tau"));
        let ours = efforts(&tree, &q, &qd, &qdd);
        for (ours, tau) in ours.iter().zip(&tau) {
            error = error.max((ours - f64::from(*tau)).abs());
            largest = largest.max(f64::from(tau.abs()));
        }
    }
    println!("{file}: {:.1e} of {largest:.3}", error / largest);
    error / largest
}

fn assert_golden(name: &str) {
    let path = PathBuf::from(FOLDER).join(name).with_extension("json");
    let text = std::fs::read_to_string(&path).expect("a golden file");
    let error = largest_error(&serde_json::from_str(&text).expect("JSON"));
    assert!(error < TOLERANCE, "{name}: {error:e}");
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn torques_are_those_of_other_programs() {
    for name in [
        "poppy",
        "op3",
        "open_duck_urdf",
        "open_duck_mjcf",
        "panda",
        "so100",
        "h1",
        "allegro",
        "anymal",
        "talos",
    ] {
        assert_golden(name);
    }
}

#[test]
fn every_way_to_say_it_in_mjcf_gives_the_torques_of_mujoco() {
    assert_golden("quirks");
}
