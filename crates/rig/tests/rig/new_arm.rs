//! The starter arm can hold its own worst pose continuously; its old form could not.

use sinew_rig::Description;
use sinew_rig::review::{Loop, Review, Servos, Severity};
use sinew_rig::{new, toml_file};

const OLD: &str = include_str!("../../../../tests/support/rigs/arm_62ff7e0.toml");

/// Returns the texts of faults and warnings of a rig.
fn doubts(rig: &Description) -> Vec<String> {
    let mechanism = rig.mechanism().unwrap();
    let servos = Servos::of(rig, &mechanism).unwrap();
    let control = Loop { rate_hz: 500.0, latency_ticks: 1, bandwidth_rad_s: None };
    let review = Review::of(&mechanism, &servos, control).unwrap();
    let doubtful = review.findings.into_iter().filter(|found| found.severity != Severity::Note);
    doubtful.map(|finding| finding.text).collect()
}

#[test]
fn arms_up_to_six_joints_are_without_warnings() {
    for joints in 1..=6 {
        let doubts = doubts(&new::arm(joints).unwrap());
        assert!(doubts.is_empty(), "{joints}: {doubts:?}");
    }
}

#[test]
fn the_arm_as_it_was_could_not_hold_its_worst_pose() {
    let doubts = doubts(&toml_file::read(OLD).unwrap());
    let [doubt] = doubts.as_slice() else { panic!("{doubts:?}") };
    assert!(doubt.contains("gravity asks for 0.200 N m"), "{doubt}");
}
