//! A clip on a rig, through the commands map, bake, export and evaluate.

mod emulated;
mod face;
#[cfg(unix)]
mod following;
mod humanoid;
mod independent;
mod keys;
mod loops;
#[cfg(unix)]
mod play;
#[cfg(unix)]
mod report;
mod servos;
mod talk;

use crate::common::sinew;

/// Runs a command that must succeed. Returns standard output and standard error.
#[track_caller]
fn done(arguments: &[&str]) -> [String; 2] {
    let output = sinew(arguments);
    let [out, err] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    assert!(output.status.success(), "{arguments:?}: {err}");
    [out, err]
}

#[track_caller]
fn refused(arguments: &[&str], part: &str) -> String {
    let output = sinew(arguments);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
    assert!(told.contains(part), "{arguments:?}: {told}");
    told
}

/// Reads the bodies of a rig's file.
fn mechanism(rig: &str) -> sinew_rig::Mechanism {
    let options = sinew_rig::import::Options::default();
    sinew_performance::rig::load(rig.as_ref(), &options).unwrap().mechanism
}

/// Converts a time of a show to microseconds.
fn whole_us(time_s: f64) -> u64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative")]
    let us = (time_s * 1e6).round() as u64;
    us
}

/// Returns whether a report of `bake` has no limit that is exceeded. The motion may still differ much from the clip.
fn within_limits(report: &str) -> bool {
    !report.contains("EXCEEDED")
        && (report.contains("No limit is exceeded") || report.contains("is within all limits"))
}
