//! `sinew verify` as a command: what it prints, and its exit codes.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn oracles() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/oracles")
}

fn verify(folder: &Path, more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sinew"))
        .arg("verify")
        .arg(folder)
        .args(more)
        .output()
        .expect("the command runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
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
