//! The starter arm, in its present and its old form, holds six poses.

use rayon::prelude::*;
use sinew_performance::play::Drive;
use sinew_servo_sim::variation::Variation;

use super::limits::{Limits, ON_ROTOR, SPLIT};
use super::measure::Poses;
use super::run::Rig;

/// Checks that an arm stays within the limits of each plant. The plants differ from the arm's file.
fn holds(rig: &Rig, plants: &[(String, Variation, Limits)]) {
    let poses = Poses::of_arm();
    let runs: Vec<_> = plants
        .par_iter()
        .map(|(name, variation, limits)| {
            let run = rig.play(&poses.motion, *variation, |_, _| {});
            (name, run.beyond(&poses.windows_s, *limits))
        })
        .collect();
    for (name, (_, worst)) in &runs {
        println!("{name}: {worst:.3?}");
    }
    for (name, (beyond, _)) in &runs {
        assert!(beyond.is_empty(), "{name}:\n{}", beyond.join("\n"));
    }
}

/// Returns plants: with the servos' own values, heavier and lighter, and with the lowest known damping of a gear.
fn plants(friction: &str, own: Variation, limits: Limits) -> [(String, Variation, Limits); 4] {
    [
        ("as it is", own),
        ("masses 0.8", Variation { masses: 0.8, ..own }),
        ("masses 1.2", Variation { masses: 1.2, ..own }),
        ("a third of the damping", Variation { damping: 0.33, ..own }),
    ]
    .map(|(name, variation)| (format!("{friction}, {name}"), variation, limits))
}

fn split() -> [(String, Variation, Limits); 4] {
    plants("split friction", Variation::default(), SPLIT)
}

/// With all friction on the rotor, nothing holds a shaft within the play. If the damping is also low, the shaft
/// oscillates for longer than a pose is held, so that plant is left out.
fn on_rotor() -> Vec<(String, Variation, Limits)> {
    let own = Variation { output_friction: Some(0.0), ..Variation::default() };
    plants("friction on the rotor", own, ON_ROTOR).into_iter().take(3).collect()
}

#[test]
fn the_starter_arm_stands_still() {
    holds(&Rig::new_arm(), &[split().to_vec(), on_rotor()].concat());
}

#[test]
fn the_starter_arm_stands_still_by_voltage() {
    holds(&Rig { drive: Some(Drive::Voltage), ..Rig::new_arm() }, &split());
}

#[test]
fn the_old_starter_arm_stands_still() {
    holds(&Rig::old_arm(), &[split().to_vec(), on_rotor()].concat());
}
