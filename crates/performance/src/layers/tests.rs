use std::fs;
use std::path::Path;

use sinew_rig::{new, toml_file};

use super::*;
use crate::rig::load;

fn face(folder: &Path) -> LoadedRig {
    let path = folder.join("face.toml");
    fs::write(&path, toml_file::write(&new::face())).unwrap();
    load(&path, &sinew_rig::import::Options::default()).unwrap()
}

fn put(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

/// Returns the positions of one joint in a motion, deg.
fn joint(rig: &LoadedRig, motion: &RigMotion, name: &str) -> Vec<f64> {
    let body = rig.mechanism.bodies.iter().position(|link| link.joint_name == name).unwrap();
    let at = rig.mechanism.coordinate_ranges()[body].start;
    motion.rows.iter().map(|row| row[at].to_degrees()).collect()
}

#[test]
fn a_layer_replaces_or_adds_to_its_joints_only() {
    let folder = tempfile::tempdir().unwrap();
    let rig = face(folder.path());
    let below = put(
        folder.path(),
        "below.csv",
        "time,jaw_deg,neck_turn_deg,easing\n0,-4,0,linear\n2,-4,20,linear\n",
    );
    let talk = put(folder.path(), "talk.csv", "time,jaw_deg\n0,-10\n2,-10\n");
    let read = OwnMotion::Coordinates.read(&rig, below.as_ref(), None).unwrap();
    let with = |layer: &str| {
        let below =
            LayeredMotion { motion: read.motion.clone(), start_s: read.start_s, is_loop: false };
        below.with(&rig, &[layer.parse().unwrap()], None)
    };
    let near = |rows: &[f64], wanted: f64| rows.iter().all(|x| (x - wanted).abs() < 1e-6);
    let (over, lines) = with(&talk).unwrap();
    assert!(lines[0].ends_with("0.00 to 2.00 s: jaw"), "{lines:?}");
    assert!(near(&joint(&rig, &over.motion, "jaw"), -10.0));
    assert!((joint(&rig, &over.motion, "neck_turn")[100] - 10.0).abs() < 1e-6);
    let home = rig.mechanism.home();
    let home = joint(&rig, &RigMotion { dt_s: 0.01, rows: vec![home] }, "jaw")[0];
    let (added, _) = with(&format!("{talk}:add:0.5")).unwrap();
    assert!(near(&joint(&rig, &added.motion, "jaw"), -4.0 + 0.5 * (-10.0 - home)));
    let (half, _) = with(&format!("{talk}:over:0.5:j*w")).unwrap();
    assert!(near(&joint(&rig, &half.motion, "jaw"), -7.0));
    let told = with(&format!("{talk}:over:tail")).unwrap_err();
    assert!(format!("{told:#}").contains("no joint `tail`"), "{told:#}");
    let told = format!("{:#}", with(&format!("{talk}:over:neck_turn")).unwrap_err());
    assert!(told.starts_with("--layer") && told.contains("none of these joints"), "{told}");
    put(folder.path(), "talk.csv", "time,jaw_deg\n0,-10\n1,x\n");
    let told = format!("{:#}", with(&talk).unwrap_err());
    for part in ["--layer", "talk.csv", "line 3", "jaw"] {
        assert!(told.contains(part), "{told}");
    }
}

#[test]
fn a_late_layer_comes_smoothly_and_a_loop_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let rig = face(folder.path());
    let below = put(folder.path(), "below.csv", "time,neck_turn_deg\n0,0\n0.5,10\n1,0\n");
    let late = put(folder.path(), "late.csv", "time,jaw_deg\n2,-10\n3,-10\n");
    let read = OwnMotion::Coordinates.read(&rig, below.as_ref(), None).unwrap();
    let below = |is_loop| LayeredMotion { motion: read.motion.clone(), start_s: 0.0, is_loop };
    let (looped, _) = below(true).with(&rig, &[late.parse().unwrap()], None).unwrap();
    assert!(!looped.is_loop && (looped.motion.duration_s() - 3.0).abs() < 1e-9);
    let neck = joint(&rig, &looped.motion, "neck_turn");
    assert!((neck[250] - neck[50]).abs() < 1e-6 && neck[50] > 9.0);
    let jaw = joint(&rig, &looped.motion, "jaw");
    let steepest = jaw.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
    assert!(steepest < 1.0 && (jaw[240] + 10.0).abs() < 1e-6, "{steepest}");
    let (once, _) = below(false).with(&rig, &[late.parse().unwrap()], None).unwrap();
    assert!(joint(&rig, &once.motion, "neck_turn")[150..].iter().all(|x| x.abs() < 1e-6));
}

#[test]
fn names_may_have_stars() {
    for (name, pattern, is) in [
        ("lid_left", "lid_*", true),
        ("lid_left", "*left", true),
        ("lid_left", "l*_l*t", true),
        ("lid_left", "lid", false),
        ("lid", "*", true),
        ("jaw", "*aw?", false),
    ] {
        assert_eq!(is_named(name, pattern), is, "{name} {pattern}");
    }
}
