//! Compares the efforts of imported joints with forces of MuJoCo's `mj_forward` (`tests/golden/actuators.py`).

use std::path::Path;

use serde_json::Value;
use sinew_rig::import::{Options, mjcf};

/// Tolerance, as a share of the effort: both programs compute in f64, from texts of the same digits.
const TOLERANCE: f64 = 1e-9;

/// Imports all models of a golden file, and compares the effort of each driven joint with the larger of both forces.
fn compare(file: &Path) -> usize {
    let text = std::fs::read_to_string(file).expect("the golden file");
    let golden: Value = serde_json::from_str(&text).expect("JSON");
    let cases = golden["cases"].as_array().expect("cases");
    for (index, case) in cases.iter().enumerate() {
        let text = case["mjcf"].as_str().expect("a model");
        let imported = mjcf(text, &Options::default())
            .unwrap_or_else(|error| panic!("model {index}: {error}\n{text}"));
        for (name, ends) in case["forces"].as_object().expect("forces") {
            let joint = imported.description.joints.iter().find(|joint| joint.name == *name);
            let found = joint.expect("a joint").effort;
            let ends: Option<Vec<f64>> =
                ends.as_array().expect("two ends").iter().map(Value::as_f64).collect();
            // A force of zero is no effort, but no limit.
            let expected = ends
                .map(|ends| ends.iter().map(|end| end.abs()).fold(0.0, f64::max))
                .filter(|force| *force > 0.0);
            let is_near = match (found, expected) {
                (Some(found), Some(expected)) => (found - expected).abs() <= TOLERANCE * expected,
                (found, expected) => found.is_none() && expected.is_none(),
            };
            assert!(is_near, "model {index}, `{name}`: {found:?}, MuJoCo {expected:?}\n{text}");
        }
    }
    cases.len()
}

#[test]
fn efforts_are_the_forces_of_mujoco() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/actuators.json");
    assert_eq!(compare(Path::new(file)), 40);
}

#[test]
#[ignore = "needs SINEW_ACTUATORS, a file that tests/golden/actuators.py writes"]
fn efforts_of_many_models_are_the_forces_of_mujoco() {
    let file = std::env::var_os("SINEW_ACTUATORS").expect("SINEW_ACTUATORS names the file");
    println!("{} models", compare(Path::new(&file)));
}
