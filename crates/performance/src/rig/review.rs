//! Reviews a rig, and compares its two sides.

use anyhow::Context as _;
use sinew_retarget::rig::{RigMatch, mirror_faults};
use sinew_rig::description::Doubt;
use sinew_rig::review::{Finding, Loop, Review, Servos, Severity};

use super::LoadedRig;
use crate::play::closes_loop;

/// Reviews a rig, and compares its left side with its right one, if it has limbs.
///
/// # Errors
/// If a servo or a drive is invalid, or the rig does not fit `sinew-core`.
pub fn review(rig: &LoadedRig, control: Loop) -> anyhow::Result<Review> {
    let name = || rig.description.name.clone();
    let is_corrected = |name: &str| {
        let named = rig.description.servos.iter().find(|servo| servo.name == name);
        named.is_some_and(|servo| closes_loop(&servo.model))
    };
    let servos = Servos::of(&rig.description, &rig.mechanism)
        .with_context(name)?
        .with_loops_of(is_corrected);
    let mut review = Review::of(&rig.mechanism, &servos, control).with_context(name)?;
    for doubt in &rig.doubts {
        let Doubt { about, text } = doubt.clone();
        warn(&mut review, Finding { severity: Severity::Warning, about, text });
    }
    let faults = RigMatch::of(&rig.mechanism)
        .map(|sides| mirror_faults(&rig.mechanism, &sides))
        .unwrap_or_default();
    for fault in faults {
        let joint = &rig.mechanism.bodies[fault.joint].joint_name;
        let mend = if fault.is_axis_turned {
            format!(
                ". With the axis turned round it would be: give `{joint}` in rig.toml the axis with the other sign, or \
                 import with `--turn-axis {joint}`"
            )
        } else {
            String::new()
        };
        let finding = Finding {
            severity: Severity::Warning,
            about: format!("joint {joint}"),
            text: format!("{}{mend}", fault.text),
        };
        warn(&mut review, finding);
    }
    Ok(review)
}

/// Adds a warning after the findings that are at least as severe.
fn warn(review: &mut Review, finding: Finding) {
    let place = review.findings.partition_point(|other| other.severity <= Severity::Warning);
    review.findings.insert(place, finding);
}
