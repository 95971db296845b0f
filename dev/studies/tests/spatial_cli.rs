//! The studies of spatial measures as commands: their short forms need no data.

use std::process::{Command, Output};

use serde_json::Value;

fn study(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sinew-studies"));
    let output = command.args(arguments).env_remove("SINEW_DATA").output();
    output.expect("the command starts")
}

fn printed(arguments: &[&str]) -> String {
    let output = study(arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

#[test]
fn a_study_is_the_same_at_any_number_of_threads_and_can_be_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let arguments = ["geodesic-ratio", "--quick", "--pairs", "3", "--steps", "4"];
    let with = |more: &[&str]| printed(&[&arguments, more].concat());
    let json = with(&["--format", "json", "--threads", "1", "--out", out]);
    assert_eq!(json, with(&["--format", "json", "--threads", "3"]));
    let first = &serde_json::from_str::<Value>(&json).expect("JSON")["conditions"][0];
    assert_eq!(first["pairs"].as_array().expect("a list").len(), 3);
    let written = std::fs::read_to_string(folder.path().join("geodesic-ratio.txt")).unwrap();
    assert_eq!(written, with(&[]));
    for name in ["geodesic-ratio.json", "geodesic-ratio.svg", "geodesic-ratio.png"] {
        assert!(folder.path().join(name).metadata().unwrap().len() > 500, "{name}");
    }
}

#[test]
fn what_cannot_be_is_refused_with_what_could() {
    for (arguments, part) in [
        (&["mds"][..], "expected --data DIR, or SINEW_DATA, or --quick"),
        (&["mds", "--data", "nowhere"], "nowhere: expected a folder"),
        (&["mds", "--quick", "--neighbours", "0"], "--neighbours"),
        (&["mds", "--quick", "--root", "tail,fin"], "root tail: expected a joint of the skeleton"),
        (&["mds", "--walks", "a.bvh"], "2 values required"),
        (&["geodesic-ratio", "--quick", "--root", "tail"], "root tail: expected a joint"),
        (&["geodesic-ratio", "--quick", "--steps", "1"], "--steps"),
        (&["geodesic-ratio", "--quick", "--pairs", "0"], "--pairs"),
    ] {
        let output = study(arguments);
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        assert!(told.contains(part), "{arguments:?}: {told}");
    }
}

#[test]
fn distances_are_written_for_numpy_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let out = |name: &str| path(name).to_str().unwrap().to_owned();
    let told = printed(&["distances", "--quick", "--metric", "positions", "--out", &out("a.npy")]);
    let bytes = std::fs::read(path("a.npy")).unwrap();
    let rows = std::fs::read_to_string(path("a.csv")).unwrap();
    let poses = rows.lines().count() - 1;
    assert!(rows.starts_with("pose,file,frame,seconds\n0,") && told.contains(" Hz, 18 joints"));
    let pairs = poses * (poses - 1) / 2;
    // NumPy's magic, and a header whose length is a multiple of 64 bytes.
    assert!(bytes.starts_with(b"\x93NUMPY") && poses > 100);
    assert!((bytes.len() - 4 * pairs).is_multiple_of(64) && bytes.len() < 4 * pairs + 256);
    assert!(!path(".sinew-part").exists());
    let with_threads = ["distances", "--quick", "--metric", "positions", "--threads", "3"];
    printed(&[&with_threads[..], &["--out", &out("b.npy")]].concat());
    assert_eq!(std::fs::read(path("b.npy")).unwrap(), bytes);

    for (more, part) in [
        (&["--out", "a.txt"][..], "--out a.txt: expected a file named *.npy"),
        (&["--out", "a.npy", "--metric", "angles", "--steps", "5"], "--steps: expected only with"),
        (&["--out", "/nowhere/a.npy"], "/nowhere: expected an existing folder"),
    ] {
        let output = study(&[&["distances", "--quick"], more].concat());
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && told.contains(part), "{more:?}: {told}");
    }
}
