//! `sinew evaluate verify` as a command: its output, and its exit codes.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use crate::common::{command, text};

fn oracles() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/oracles")
}

fn verify(folder: &Path, more: &[&str]) -> Output {
    command()
        .args(["evaluate", "verify"])
        .arg(folder)
        .args(more)
        .output()
        .expect("the command runs")
}

#[test]
fn a_line_for_each_quantity_and_success() {
    let output = verify(&oracles(), &[]);
    let printed = text(&output.stdout);
    assert!(output.status.success(), "{printed}{}", text(&output.stderr));
    for quantity in
        ["tau", "H", "world position", "local e_rot", "forward omega_world", "volume", "mesh raw"]
    {
        let line = printed.lines().find(|line| line.contains(&format!(" {quantity} ")));
        let line = line.unwrap_or_else(|| panic!("no line for {quantity}: {printed}"));
        assert!(line.trim_end().ends_with("ok"), "{line}");
    }
    assert!(!printed.contains("FAIL"));
}

#[test]
fn failure_over_a_limit_names_the_worst_case() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let good = fs::read_to_string(oracles().join("rnea_05.json")).expect("the oracles are there");
    let bad = good.replacen("\"gravity_term\":[[", "\"gravity_term\":[[0.0,0.0,0.0],[", 1);
    fs::write(folder.path().join("a.json"), bad).expect("the folder can be written");
    let output = verify(folder.path(), &[]);
    assert_eq!(output.status.code(), Some(2), "one entry too many: it cannot be computed");
    let wrong = good.replacen("\"mass\":", "\"mass\":1", 1);
    fs::write(folder.path().join("a.json"), wrong).expect("the folder can be written");
    let output = verify(folder.path(), &[]);
    let printed = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "computed, and bad: {printed}");
    assert!(
        printed.contains("FAIL a.json, tau: worst at case 0 (s05_free_random_g0)"),
        "{printed}"
    );
    assert!(text(&output.stderr).contains("over their limits"));
}

#[test]
fn what_is_skipped_is_said_and_unknown_names_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::copy(oracles().join("control.json"), folder.path().join("control.json")).expect("a copy");
    fs::write(folder.path().join("h.json"), r#"{"schema": "hauberg/2", "cases": [{}]}"#)
        .expect("the folder can be written");

    let output = verify(folder.path(), &[]);
    assert_eq!(output.status.code(), Some(2), "there is no second version of it");
    let error = text(&output.stderr);
    assert!(error.contains("h.json") && error.contains("hauberg/2"), "{error}");

    for (name, schema) in [("w.json", "weights/2"), ("r.json", "rnea/2"), ("x.json", "songs/1")] {
        let golden = format!(r#"{{"schema": "{schema}", "cases": [{{}}]}}"#);
        fs::write(folder.path().join(name), golden).expect("the folder can be written");
    }
    let error = text(&verify(folder.path(), &["--skip", "solids"]).stderr);
    for told in ["w.json: `weights/2`", "r.json: `rnea/2`", "x.json: `songs/1` (of no known kind"] {
        assert!(error.contains(told), "all are told at once: {error}");
    }
    assert!(error.contains("--skip solids,hauberg,rnea,weights"), "{error}");
    for name in ["w.json", "r.json", "x.json"] {
        fs::remove_file(folder.path().join(name)).expect("it is there");
    }

    let output = verify(folder.path(), &["--skip", "hauberg,solids"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("skipped h.json: kind hauberg"));

    let output = verify(folder.path(), &["--skip", "weight"]);
    assert!(!output.status.success());
    let error = text(&output.stderr);
    for known in ["rnea", "control", "errors", "finite_difference", "weights", "hauberg", "solids"]
    {
        assert!(error.contains(known), "{known}: {error}");
    }

    let output = verify(folder.path(), &["--skip", "hauberg,control"]);
    assert!(!output.status.success(), "nothing is left");
    assert!(text(&output.stderr).contains("2 were skipped"));
}

/// Returns, from a quantity's line, the smallest error that the check would notice.
fn noticed(printed: &str, quantity: &str) -> f64 {
    let line = printed.lines().find(|line| line.contains(&format!(" {quantity} ")));
    let line = line.unwrap_or_else(|| panic!("no line for {quantity}: {printed}"));
    let numbers = line.split(quantity).nth(1).expect("behind its name").split_whitespace();
    numbers.skip(3).find_map(|word| word.parse().ok()).expect("what it notices")
}

/// Returns whether a quantity of a file exceeds its limit when `mistake` is added to one of its numbers.
fn is_found(file: &str, path: &str, quantity: &str, mistake: f64) -> bool {
    let good = fs::read_to_string(oracles().join(file)).expect("the oracles are there");
    let mut golden: serde_json::Value = serde_json::from_str(&good).expect("a golden file");
    let number = golden.pointer_mut(path).unwrap_or_else(|| panic!("{path} is there"));
    let planted = number.as_f64().expect("a number") + mistake;
    *number = planted.into();
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join(file), golden.to_string()).expect("the folder can be written");
    let printed = text(&verify(folder.path(), &[]).stdout);
    printed.contains(&format!("FAIL {file}, {quantity}: "))
}

#[test]
fn mistakes_just_above_what_is_noticed_are_found_and_small_ones_are_not() {
    let printed = text(&verify(&oracles(), &[]).stdout);
    for (file, path, quantity) in [
        ("rnea_05.json", "/cases/0/states/0/tau/1/0", "tau"),
        ("rnea_05.json", "/cases/0/states/0/bias/1/1", "bias"),
        ("rnea_05.json", "/cases/0/states/0/gravity_term/1/2", "gravity_term"),
        ("rnea_05.json", "/cases/0/states/0/root_wrench/force_world/0", "root force, world axes"),
        ("rnea_05.json", "/cases/0/states/0/H_lower/0", "H"),
        ("rnea_05.json", "/cases/0/states/0/world/1/pos/0", "world position"),
        ("rnea_05.json", "/cases/0/states/0/world/1/vel/0", "world linear velocity"),
        ("control.json", "/cases/0/expected/world/tau/1/0", "world, tau"),
        ("control.json", "/cases/0/expected/local/joint_acc_child/1/0", "local, acceleration"),
        ("errors.json", "/cases/0/expected/local/1/e_rot/0", "local e_rot"),
        ("errors.json", "/cases/0/expected/world/1/e_lin/0", "world e_lin"),
        ("errors.json", "/cases/0/expected/egocentric/1/ed_rot/0", "egocentric ed_rot"),
        ("errors.json", "/cases/0/expected/metrics/angular_deg/mean_all", "metric, angle"),
        ("finite_difference.json", "/cases/0/forward/omega_world/0/0", "forward omega_world"),
        ("finite_difference.json", "/cases/0/forward/lin_acc/0/0", "targets lin_acc"),
        ("hauberg.json", "/cases/0/chord", "chord"),
        ("hauberg.json", "/cases/0/line/energy", "line energy"),
        ("weights.json", "/cases/0/mesh/raw/0", "mesh raw"),
        ("weights.json", "/cases/0/cylinder_exact/raw/0", "cylinder_exact raw"),
        ("solids.json", "/cases/0/volume", "volume"),
    ] {
        // Only lines of that file: the others may have a quantity of the same name.
        let of_file: String =
            printed.lines().filter(|line| line.contains(file)).collect::<Vec<_>>().join("\n");
        // The number is printed with two digits.
        let noticed = noticed(&of_file, quantity) * 1.06;
        assert!(is_found(file, path, quantity, noticed), "{file} {path}: {noticed:e}");
        assert!(is_found(file, path, quantity, -noticed), "{file} {path}: -{noticed:e}");
        // A mistake this small is within the tolerance by theory. A test that reports every change would show
        // nothing.
        let excused = noticed * 1e-5;
        assert!(!is_found(file, path, quantity, excused), "{file} {path}: {excused:e}");
    }
}
