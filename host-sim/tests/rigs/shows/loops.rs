//! Tests of looping shows.

use sinew_show::Show;

use super::{done, humanoid, independent, refused};
use crate::common::path;

#[test]
fn a_fitted_loop_keeps_all_limits_over_its_seam() {
    let folder = tempfile::tempdir().unwrap();
    let rig = humanoid::toy(folder.path(), 5.0, 1.2);
    let file = path(folder.path(), "punches.show");
    let bake = ["bake", "punches_01", "--rig", &rig, "--seconds", "4", "--fit", "--loop"];
    let [report, _] = done(&[&bake[..], &["--cue", "end@4", "-o", &file]].concat());
    assert!(super::within_limits(&report), "{report}");
    assert!(
        report.contains("loop: the last 1.00 s of the clip are led to where it begins"),
        "{report}"
    );
    let bytes = std::fs::read(&file).unwrap();
    let show = Show::open(&bytes).unwrap();
    assert!(show.is_loop());
    // A cue at the end is still within the round.
    assert!(show.cues().next().unwrap().sample < show.length(), "{report}");
    // This check also looks past the end.
    independent::exceeds_nothing(&super::mechanism(&rig), &bytes);
}

#[test]
fn what_cannot_go_round_is_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let rig = humanoid::toy(folder.path(), 5.0, 1.2);
    let out = path(folder.path(), "x.show");
    let bake = ["bake", "punches_01", "--rig", &rig, "--seconds", "4", "-o", &out];
    for (arguments, part) in [
        (&["--loop", "--loop-blend-s", "5"][..], "that the motion lasts, found 5.000 s"),
        (&["--loop", "--loop-blend-s", "0.05"], "to return to its start within 0.05 s"),
        (&["--loop-blend-s", "1"], "--loop"),
    ] {
        refused(&[&bake[..], arguments].concat(), part);
    }
    refused(&["bake", "punches_01", "--loop", "-o", &out], "--rig");
    assert!(!std::path::Path::new(&out).exists());
}
