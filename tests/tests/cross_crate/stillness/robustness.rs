//! The starter arm stands still on gears that are worse than its file says.

use rayon::prelude::*;
use sinew_servo_sim::variation::Variation;

use super::measure::{Poses, peak_to_peak};
use super::run::Rig;

/// The largest peak-to-peak motion, deg.
const SWING_DEG: f64 = 0.6;

/// The largest peak-to-peak motion with all three changes of the gear at once, deg.
const TRIPLE_DEG: f64 = 1.0;

/// Returns gears with other stiffness, play, damping, or several of these.
fn gears() -> Vec<(String, Variation)> {
    let of_mask = |mask: u32| {
        let has = |bit: u32| mask & (1 << bit) != 0;
        let variation = Variation {
            stiffness: if has(0) { 0.5 } else { 1.0 },
            play: if has(1) { 2.0 } else { 1.0 },
            damping: if has(2) { 0.33 } else { 1.0 },
            ..Variation::default()
        };
        let Variation { stiffness, play, damping, .. } = variation;
        (format!("stiffness {stiffness}, play {play}, damping {damping}"), variation)
    };
    (0..8).map(of_mask).collect()
}

/// Returns each gear except the worst; the arm's own gear and each gear with one change, combined with another error;
/// and servos with other friction and torque.
fn plants() -> Vec<(String, Variation)> {
    let mut plants = gears();
    plants.pop();
    let single: Vec<_> = plants.iter().filter(|(_, own)| is_single(own)).cloned().collect();
    for (gear, own) in single {
        let others = [
            ("masses 0.8", Variation { masses: 0.8, ..own }),
            ("masses 1.2", Variation { masses: 1.2, ..own }),
            ("rotor 0.8", Variation { rotor: 0.8, ..own }),
            ("rotor 1.2", Variation { rotor: 1.2, ..own }),
            ("a tick of delay", Variation { delay_ticks: 1, ..own }),
        ];
        plants.extend(others.map(|(name, plant)| (format!("{gear}, {name}"), plant)));
    }
    let own = Variation::default();
    let servos = [
        ("friction 0.5", Variation { friction: 0.5, ..own }),
        ("friction 0.7", Variation { friction: 0.7, ..own }),
        ("friction 1.5", Variation { friction: 1.5, ..own }),
        ("torque 0.8", Variation { torque: 0.8, ..own }),
        ("torque 1.2", Variation { torque: 1.2, ..own }),
    ];
    plants.extend(servos.map(|(name, plant)| (name.to_owned(), plant)));
    plants
}

fn is_single(own: &Variation) -> bool {
    [own.stiffness, own.play, own.damping].iter().filter(|part| (**part - 1.0).abs() > 0.0).count()
        < 2
}

#[test]
fn no_swing_grows_on_a_worse_plant() {
    for (name, rig) in [("starter arm", Rig::new_arm()), ("old starter arm", Rig::old_arm())] {
        none_grows(name, &rig, plants(), SWING_DEG);
    }
}

#[test]
fn no_swing_grows_on_the_worst_gear() {
    let worst = gears().pop().unwrap();
    none_grows("starter arm", &Rig::new_arm(), vec![worst], TRIPLE_DEG);
}

/// Prints a table of plants, and checks the largest motion of each.
fn none_grows(arm: &str, rig: &Rig, plants: Vec<(String, Variation)>, most_deg: f64) {
    let poses = Poses::of_arm();
    let rows: Vec<_> = plants
        .into_par_iter()
        .map(|(name, variation)| {
            let run = rig.play(&poses.motion, variation, |_, _| {});
            let (mut bad, mut worst_deg, mut growth_deg) = (Vec::new(), 0.0_f64, 0.0_f64);
            for (number, window) in poses.windows_s.iter().enumerate() {
                for (dof, joint) in run.names.iter().enumerate() {
                    let samples = run.window(dof, *window);
                    let halves = samples.split_at(samples.len() / 2);
                    let [first, second] =
                        [halves.0, halves.1].map(|half| peak_to_peak(half).to_degrees());
                    let all = peak_to_peak(samples).to_degrees();
                    let step = rig.model(dof).resolution_rad.value.to_degrees();
                    worst_deg = worst_deg.max(all);
                    growth_deg = growth_deg.max(second - first);
                    // Numbers are rounded to encoder steps.
                    if second > first + 1.01 * step || all > most_deg {
                        bad.push(format!(
                            "pose {number}, {joint}: {first:.3}, then {second:.3}, {all:.3} in all"
                        ));
                    }
                }
            }
            (name, worst_deg, growth_deg, bad)
        })
        .collect();
    println!("| {arm}, at most {most_deg} deg | peak to peak, deg | largest growth, deg |");
    println!("|---|---:|---:|");
    for (name, worst, growth, _) in &rows {
        println!("| {name} | {worst:.3} | {growth:.3} |");
    }
    let bad: Vec<_> = rows
        .iter()
        .filter(|(_, _, _, bad)| !bad.is_empty())
        .map(|(name, _, _, bad)| format!("{name}:\n{}", bad.join("\n")))
        .collect();
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}
