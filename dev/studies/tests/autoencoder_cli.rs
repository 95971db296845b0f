//! `sinew-studies autoencoder` as a command: its short form needs no data.

use std::process::{Command, Output};

use serde_json::Value;

/// Runs the short form of the auto-encoder's study; `limit` limits the framework's own threads.
fn quick(arguments: &[&str], limit: &str) -> Output {
    let output = Command::new(env!("CARGO_BIN_EXE_sinew-studies"))
        .args(["autoencoder", "--quick", "--no-times"])
        .args(arguments)
        .env("RAYON_NUM_THREADS", limit)
        .output();
    output.expect("the command starts")
}

fn printed(arguments: &[&str], limit: &str) -> String {
    let output = quick(arguments, limit);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

#[test]
fn the_short_form_has_known_figures_at_any_number_of_threads() {
    let text = printed(&["--format", "json", "--threads", "1"], "1");
    assert_eq!(text, printed(&["--format", "json", "--threads", "3"], "4"));
    let json: Value = serde_json::from_str(&text).expect("JSON");
    let outcomes = json["outcomes"].as_array().expect("a list");
    let found: Vec<(&str, f64)> = outcomes
        .iter()
        .map(|o| (o["loss"].as_str().unwrap(), o["all"]["position_cm"].as_f64().unwrap()))
        .collect();
    let expected =
        [("uniform", 11.8), ("forward_kinematics", 10.8), ("lengths", 11.6), ("cylinders", 11.6)];
    assert_eq!(found.len(), expected.len());
    for ((loss, found), (of, expected)) in found.iter().zip(expected) {
        assert_eq!(*loss, of);
        // The kernels of matrix products differ between processors: rounding grows over 40 steps.
        assert!((found - expected).abs() < 0.15, "{loss}: {found} cm, expected {expected}");
    }
}

#[test]
fn what_was_trained_is_not_trained_again() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let first = printed(&["--out", out], "1");
    let checkpoint = folder.path().join("checkpoints/12-1-lengths.safetensors");
    let trained = std::fs::read(&checkpoint).unwrap();
    let modified = |path: &std::path::Path| path.metadata().unwrap().modified().unwrap();
    let when = modified(&checkpoint);
    assert_eq!(first, printed(&["--out", out], "1"));
    assert_eq!((when, trained), (modified(&checkpoint), std::fs::read(&checkpoint).unwrap()));
    for name in [
        "autoencoder.txt",
        "autoencoder.json",
        "autoencoder-errors-12.svg",
        "autoencoder-poses-12.png",
    ] {
        assert!(folder.path().join(name).metadata().unwrap().len() > 500, "{name}");
    }
    let other = quick(&["--out", out, "--batch", "64"], "1");
    let told = String::from_utf8_lossy(&other.stderr);
    assert_eq!(other.status.code(), Some(2), "{told}");
    assert!(told.contains("is of another training"), "{told}");
}

#[test]
fn what_cannot_be_is_refused_with_what_could() {
    for (arguments, part) in [
        (&["--data", "nowhere"][..], "nowhere: expected a folder"),
        (&["--latent", "0"], "--latent"),
        (&["--latent", "9223372036854775807"], "a whole number from 1 to 100000"),
        (&["--position-per-m", "nan"], "a number from 0 to 1000000"),
        (&["--quick", "--data", "nowhere"], "cannot be used with"),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_sinew-studies"))
            .args(["autoencoder"])
            .args(arguments)
            .output()
            .expect("the command starts");
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        assert!(told.contains(part), "{arguments:?}: {told}");
    }
}
