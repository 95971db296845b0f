//! The arm of a walk and of a wave on small arms: the hand goes along the performer's path.

use std::path::PathBuf;

use crate::field::done;

/// Returns mean and largest distance of the hand from its path, % of the arm, which a command has printed.
#[track_caller]
fn off_path(said: &str) -> [f64; 2] {
    let line = said.lines().find(|line| line.contains("the hand's path is followed"));
    let line = line.unwrap_or_else(|| panic!("{said}"));
    let numbers: Vec<f64> =
        line.split(", ").skip(1).filter_map(|part| part.split(" %").next()?.parse().ok()).collect();
    <[f64; 2]>::try_from(numbers).unwrap_or_else(|_| panic!("{line}"))
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn the_hands_of_small_arms_go_along_a_walk_and_a_wave() {
    let data = std::env::var_os("SINEW_DATA").expect("SINEW_DATA names the folder of the data");
    let data = PathBuf::from(data);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    let urdf = data.join("foreign/urdf/so100.urdf");
    done(folder, &["rig", "import", urdf.to_str().expect("UTF-8"), "-o", "so100.toml"]);
    done(folder, &["rig", "new", "--arm", "6", "-o", "starter.toml"]);
    for rig in ["so100.toml", "starter.toml"] {
        for (clip, [mean_most, most]) in [
            ("cmu/walk/07_01.bvh", [0.5, 1.0]),
            // The wave passes above the arm's own upright axis, about which the arm then turns at its maximum speed.
            ("bandai/broad-12hz/dataset-2_wave-left-hand_active_006.bvh", [3.0, 20.0]),
        ] {
            let clip = data.join(clip);
            let clip = clip.to_str().expect("UTF-8");
            let export = ["clip", "export", clip, "--rig", rig, "--mirror", "-o", "o.csv"];
            let said = done(folder, &export);
            let [mean, largest] = off_path(&said);
            assert!(mean < mean_most && largest < most, "{rig}: {said}");
            // The SO-100's file says 1 rad/s, which is too slow for both.
            assert!(
                rig == "starter.toml" || said.contains("--fit slows the motion down"),
                "{said}"
            );
        }
    }
}
