//! Inputs as makers and users write them (`field/`), each with its command and the right result.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{sinew_in, text};

/// Creates a temporary folder with a copy of each of these files.
fn folder_with(names: &[&str]) -> tempfile::TempDir {
    let field: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/field");
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in names {
        fs::copy(field.join(name), folder.path().join(name)).expect("a copy");
    }
    folder
}

/// Runs a command that must succeed, and returns its standard error.
#[track_caller]
fn done(folder: &Path, words: &[&str]) -> String {
    let output = sinew_in(folder, words);
    let said = text(&output.stderr);
    assert!(output.status.success(), "{words:?}: {said}");
    said
}

/// Returns the header and the numbers of a table.
fn table(path: &Path) -> (Vec<String>, Vec<Vec<f64>>) {
    let text = fs::read_to_string(path).expect("a table");
    let mut lines = text.lines();
    let header = lines.next().expect("a header").split(',').map(str::to_owned).collect();
    let row = |line: &str| line.split(',').map(|field| field.parse().expect("a number")).collect();
    (header, lines.map(row).collect())
}

#[test]
fn a_turn_past_half_a_turn_is_followed() {
    let folder = folder_with(&["turn_past_180.bvh", "turn_past_180.map.toml", "lever.toml"]);
    let folder = folder.path();
    done(
        folder,
        &[
            "clip",
            "export",
            "turn_past_180.bvh",
            "--rig",
            "lever.toml",
            "--mapping",
            "turn_past_180.map.toml",
            "--metres-per-unit",
            "0.01",
            "-o",
            "o.csv",
        ],
    );
    let (header, rows) = table(&folder.join("o.csv"));
    let lever = header.iter().position(|name| name == "lever").expect("the lever");
    for (k, row) in rows.iter().enumerate() {
        let clip_deg = 150.0 + 0.5 * k as f64;
        let expected = (-60.0 + 120.0 * (clip_deg - 100.0) / 140.0).to_radians();
        assert!((row[lever] - expected).abs() < 1e-4, "{k}: {} {expected}", row[lever]);
    }
}

#[test]
fn an_angle_that_jumps_by_more_than_half_a_turn_is_told() {
    let folder = folder_with(&["lever.toml"]);
    let folder = folder.path();
    let wrapped = "time,dial\n0,3.0\n0.02,3.1\n0.04,-3.1\n0.06,-3.0\n";
    fs::write(folder.join("wrapped.csv"), wrapped).expect("a table");
    let export = ["clip", "export", "wrapped.csv", "--rig", "lever.toml", "-o", "o.csv"];
    let said = done(folder, &export);
    assert!(said.contains("first `dial`, by -355 deg before 0.040 s"), "{said}");
}
