//! Rigs whose servos are driven by position stand still, with P gains by the rule.

use rayon::prelude::*;
use sinew_performance::play::Drive;
use sinew_servo_sim::variation::Variation;

use super::limits::{Limits, SPLIT};
use super::measure::{Poses, peak_to_peak};
use super::robots::{MIXED, OP3, POPPY, poses, robot};
use super::run::{Rig, Run};

/// The largest peak-to-peak motion on a worse gear, deg.
const SWING_DEG: f64 = 0.6;
/// The starter arm's XL330 are simulated a quarter stiffer than their model: they lift the arm too far. This is the
/// largest excess besides the effect of friction and play, deg.
const LIFTED_DEG: f64 = 0.3;
/// Because of the damping of its load, Poppy's trunk is less stiff than its gear would allow: it rests farther from its
/// target, at most by this, deg.
const TRUNK_DEG: f64 = 0.05;

/// Returns worse gears: half the stiffness, twice the play and a third of the damping, alone and together.
fn worse() -> Vec<(&'static str, Variation)> {
    let own = Variation::default();
    let soft = Variation { stiffness: 0.5, ..own };
    vec![
        ("stiffness 0.5", soft),
        ("play 2", Variation { play: 2.0, ..own }),
        ("damping 0.33", Variation { damping: 0.33, ..own }),
        ("all three", Variation { play: 2.0, damping: 0.33, ..soft }),
    ]
}

fn by_position(rig: Rig) -> Rig {
    Rig { drive: Some(Drive::Position), ..rig }
}

/// Describes the dofs that are farther from their target or move more than allowed; `is_asked` selects dofs.
fn beyond(
    run: &Run,
    poses: &Poses,
    lifted_deg: f64,
    is_asked: impl Fn(&str) -> bool,
) -> Vec<String> {
    // At rest, the current of a servo driven by position depends on its own loop.
    let limits = Limits { alternating_a: f64::INFINITY, ..SPLIT };
    let mut beyond = Vec::new();
    for (window, dofs) in run.stillness(&poses.windows_s).into_iter().enumerate() {
        for (dof, still) in
            dofs.into_iter().enumerate().filter(|(dof, _)| is_asked(&run.names[*dof]))
        {
            let offset_deg = run.blind_rad[dof].to_degrees() + 0.3 + lifted_deg;
            if still.peak_to_peak_deg > limits.peak_to_peak_deg
                || still.speed_deg_s > limits.speed_deg_s
                || still.offset_deg > offset_deg
            {
                let name = &run.names[dof];
                beyond.push(format!("pose {window}, {name}: {still:.3?}, up to {offset_deg:.3}"));
            }
        }
    }
    beyond
}

/// Returns the largest peak-to-peak motion of any window, deg, and the dofs that swing more than allowed, or with
/// growing amplitude.
fn swings(
    rig: &Rig,
    run: &Run,
    poses: &Poses,
    is_asked: impl Fn(&str) -> bool,
) -> (f64, Vec<String>) {
    let (mut most_deg, mut bad) = (0.0_f64, Vec::new());
    for window in &poses.windows_s {
        for (dof, name) in run.names.iter().enumerate().filter(|(_, name)| is_asked(name)) {
            let samples = run.window(dof, *window);
            let (first, second) = samples.split_at(samples.len() / 2);
            let [first, second, all] =
                [first, second, samples].map(|part| peak_to_peak(part).to_degrees());
            let step_deg = rig.model(dof).resolution_rad.value.to_degrees();
            most_deg = most_deg.max(all);
            if all > SWING_DEG || second > first + 2.01 * step_deg {
                bad.push(format!("{name}: {first:.3}, then {second:.3}, {all:.3} in all"));
            }
        }
    }
    (most_deg, bad)
}

/// Checks that a rig stands still, and that no swing grows on a worse gear.
fn stands(
    name: &str,
    rig: &Rig,
    poses: &Poses,
    lifted_deg: f64,
    is_asked: impl Fn(&str) -> bool + Sync,
) {
    let run = rig.play(&poses.motion, Variation::default(), |_, _| {});
    let worst = run.stillness(&poses.windows_s).into_iter().flatten().zip(run.names.iter().cycle());
    let worst = worst.filter(|(_, name)| is_asked(name));
    let worst = worst.map(|(still, _)| still).reduce(super::measure::Stillness::max);
    println!("{name}: {worst:.3?}");
    let found = beyond(&run, poses, lifted_deg, &is_asked);
    let rows: Vec<_> = worse()
        .into_par_iter()
        .map(|(plant, variation)| {
            let run = rig.play(&poses.motion, variation, |_, _| {});
            (plant, swings(rig, &run, poses, &is_asked))
        })
        .collect();
    for (plant, (most_deg, _)) in &rows {
        println!("{name}, {plant}: {most_deg:.3} deg peak to peak");
    }
    assert!(found.is_empty(), "{name}:\n{}", found.join("\n"));
    for (plant, (_, bad)) in rows {
        assert!(bad.is_empty(), "{name}, {plant}:\n{}", bad.join("\n"));
    }
}

#[test]
fn the_starter_arm_stands_by_position() {
    stands("arm", &by_position(Rig::new_arm()), &Poses::of_arm(), LIFTED_DEG, |_| true);
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn robots_stand_by_position() {
    for (name, rig, more_deg) in [
        ("OP3", robot(OP3, None, &["xm430"]), 0.0),
        ("Poppy, MX-64", robot(POPPY, Some("l_knee_y"), &["mx-64"]), TRUNK_DEG),
    ] {
        let rig = by_position(rig);
        stands(name, &rig, &poses(&rig), more_deg, |_| true);
    }
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn an_op3_with_weak_arms_stands() {
    let rig = robot(OP3, None, MIXED);
    // Servos driven by current have tests of their own.
    let is_weak = |name: &str| {
        ["head_", "l_sho_", "r_sho_", "l_el", "r_el"].iter().any(|own| name.starts_with(own))
    };
    stands("OP3, mixed", &rig, &poses(&rig), 0.0, is_weak);
}
