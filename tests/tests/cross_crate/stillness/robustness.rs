//! The starter arm stands on gears that are worse than its file says.

use rayon::prelude::*;
use sinew_servo_sim::variation::Variation;

use super::measure::{Poses, peak_to_peak};
use super::run::Rig;

/// The largest peak to peak, deg.
const SWING_DEG: f64 = 0.6;

/// The same of all three differences at once.
const TRIPLE_DEG: f64 = 1.0;

/// Each difference alone, in pairs, and all at once; what else may be off; and a tick of delay.
fn plants() -> Vec<(String, Variation, f64)> {
    let mut plants = Vec::new();
    for mask in 0..8_u32 {
        let has = |bit: u32| mask & (1 << bit) != 0;
        let variation = Variation {
            stiffness: if has(0) { 0.5 } else { 1.0 },
            play: if has(1) { 2.0 } else { 1.0 },
            damping: if has(2) { 0.33 } else { 1.0 },
            ..Variation::default()
        };
        let name = format!(
            "stiffness {}, play {}, damping {}",
            variation.stiffness, variation.play, variation.damping
        );
        plants.push((name, variation, if mask == 7 { TRIPLE_DEG } else { SWING_DEG }));
    }
    let own = Variation::default();
    for (name, variation) in [
        ("masses 0.8", Variation { masses: 0.8, ..own }),
        ("masses 1.2", Variation { masses: 1.2, ..own }),
        ("rotor 0.8", Variation { rotor: 0.8, ..own }),
        ("rotor 1.2", Variation { rotor: 1.2, ..own }),
        ("a tick of delay", Variation { delay_ticks: 1, ..own }),
    ] {
        plants.push((name.to_owned(), variation, SWING_DEG));
    }
    plants
}

#[test]
fn no_swing_grows_on_a_worse_plant() {
    let (rig, poses) = (Rig::new_arm(), Poses::of_arm());
    let rows: Vec<_> = plants()
        .into_par_iter()
        .map(|(name, variation, most_deg)| {
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
                    // Between encoder steps numbers are rounded.
                    if second > first + 1.01 * step || all > most_deg {
                        bad.push(format!(
                            "pose {number}, {joint}: {first:.3}, then {second:.3}, {all:.3} in all"
                        ));
                    }
                }
            }
            (name, worst_deg, growth_deg, most_deg, bad)
        })
        .collect();
    println!("| plant | peak to peak, deg | largest growth, deg | allowed, deg |");
    println!("|---|---:|---:|---:|");
    for (name, worst, growth, most, _) in &rows {
        println!("| {name} | {worst:.3} | {growth:.3} | {most} |");
    }
    for (name, _, _, _, bad) in &rows {
        assert!(bad.is_empty(), "{name}:\n{}", bad.join("\n"));
    }
}
