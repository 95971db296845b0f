//! The studies of spatial measures of poses, on small seeded subsets: their printed tables as committed snapshots.
//!
//! Run these tests with `INSTA_UPDATE=always` to accept a change.

use std::path::PathBuf;

use sinew_pose_metrics::spatial::{Measure, SpatialRig};
use sinew_studies::recordings::{Recordings, broad};
use sinew_studies::spatial::classes::TwoClasses;
use sinew_studies::spatial::{classify, cluster, components, geodesic_ratio};

/// Number of frames of every recording: enough to detect changes, few enough for a debug build.
const FRAMES: usize = 60;

fn data() -> PathBuf {
    PathBuf::from(std::env::var_os("SINEW_DATA").expect("SINEW_DATA names the folder of the data"))
}

/// Returns some of the recordings, cut to their first frames.
fn some(mut recordings: Recordings, each: usize) -> Recordings {
    let mut number = 0..;
    recordings.sequences.retain(|_| number.next().is_some_and(|number| number % each == 0));
    for sequence in &mut recordings.sequences {
        sequence.frames.truncate(FRAMES);
    }
    recordings
}

fn ratios(recordings: &Recordings) -> String {
    let plan = geodesic_ratio::Plan { recordings, root: None, pairs: 11, seed: 1, steps: 10 };
    let outcomes = geodesic_ratio::run(&plan, &plan.conditions(), &|_| ()).expect("it is a rig");
    geodesic_ratio::tables(&plan, &outcomes)
}

fn shares(walking: &Recordings, walks: [&str; 2], broad: &[Recordings]) -> String {
    let walks = walks.map(|file| {
        let found = walking.sequences.iter().find(|sequence| sequence.file == file);
        found.expect("the walk is there")
    });
    let skeleton = &walking.skeleton;
    let plan = components::Plan { skeleton, walks, broad, roots: &[], steps: 10, neighbours: 7 };
    let study = components::run(&plan, &|_| ()).expect("they are rigs");
    components::tables(&plan, &study)
}

/// Returns some sequences of both classes, cut to their first poses.
fn two_classes(recordings: &Recordings, each: usize) -> TwoClasses {
    let mut classes = TwoClasses::of(recordings).expect("no sequence is empty");
    classes.sequences = classes.sequences.into_iter().step_by(each).collect();
    for sequence in &mut classes.sequences {
        sequence.frames.truncate(FRAMES / 2);
    }
    classes
}

fn told_by_the_nearest_pose(classes: &TwoClasses) -> String {
    let rig = SpatialRig::new(&classes.skeleton, None).expect("it is a rig");
    let measures = Measure::all().collect();
    let plan = classify::Plan { classes, rig: &rig, measures, each: 3, draws: 5, seed: 1 };
    let study = classify::run(&plan, &|_| ()).expect("there are enough of either class");
    classify::tables(&plan, &study, &[])
}

fn told_by_clusters(classes: &TwoClasses) -> String {
    let rig = SpatialRig::new(&classes.skeleton, None).expect("it is a rig");
    let measures = Measure::all().collect();
    let plan = cluster::Plan { classes, rig: &rig, measures, pairs: 8, seed: 1 };
    let study = cluster::run(&plan, &|_| ()).expect("there are some of either class");
    cluster::tables(&plan, &study, &[])
}

#[test]
fn geodesics_over_lines_on_built_in_clips() {
    insta::assert_snapshot!("geodesic_ratio_built_in", ratios(&some(Recordings::built_in(), 3)));
}

#[test]
fn first_components_on_built_in_clips() {
    let clips = some(Recordings::built_in(), 3);
    let walks = [0, 1].map(|index: usize| clips.sequences[index].file.as_str());
    let broad = std::slice::from_ref(&clips);
    insta::assert_snapshot!("mds_built_in", shares(&clips, walks, broad));
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn geodesics_over_lines_on_cmu() {
    let cmu = Recordings::cmu(&data().join("cmu")).expect("the data of CMU");
    insta::assert_snapshot!("geodesic_ratio_cmu", ratios(&cmu));
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn first_components_on_cmu_and_bandai() {
    let cmu = Recordings::cmu(&data().join("cmu")).expect("the data of CMU");
    let all = broad(&data()).expect("the data of CMU and Bandai");
    let broad: Vec<Recordings> = all.into_iter().step_by(40).map(|one| some(one, 1)).collect();
    let walks = ["broad-12hz/07_01.bvh", "broad-12hz/35_01.bvh"];
    insta::assert_snapshot!("mds_cmu", shares(&cmu, walks, &broad));
}

#[test]
fn classes_by_the_nearest_pose_on_built_in_clips() {
    let classes = two_classes(&Recordings::built_in(), 1);
    insta::assert_snapshot!("classify_built_in", told_by_the_nearest_pose(&classes));
}

#[test]
fn classes_by_clusters_on_built_in_clips() {
    let classes = two_classes(&Recordings::built_in(), 1);
    insta::assert_snapshot!("cluster_built_in", told_by_clusters(&classes));
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn classes_by_the_nearest_pose_on_cmu() {
    let cmu = Recordings::cmu(&data().join("cmu")).expect("the data of CMU");
    insta::assert_snapshot!("classify_cmu", told_by_the_nearest_pose(&two_classes(&cmu, 4)));
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn classes_by_clusters_on_cmu() {
    let cmu = Recordings::cmu(&data().join("cmu")).expect("the data of CMU");
    insta::assert_snapshot!("cluster_cmu", told_by_clusters(&two_classes(&cmu, 4)));
}
