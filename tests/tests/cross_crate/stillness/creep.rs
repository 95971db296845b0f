//! Joints with slowly moving targets.

use rayon::prelude::*;
use sinew_retarget::feasibility::RigMotion;
use sinew_servo_sim::variation::Variation;

use super::measure::POSES_DEG;
use super::run::Rig;

/// Time between rows of the motion, s. The target stands still, moves slowly, and stands still again.
const DT_S: f64 = 0.01;
const STANDS_S: f64 = 2.0;
const CREEPS_S: f64 = 6.0;
/// Longest duration of a stick-slip step, s.
const STEP_S: f64 = 0.1;

/// Speeds far below, slightly below, slightly above and far above the one from which a target counts as moving: 1.146
/// deg/s.
const SPEEDS_DEG_S: [f64; 5] = [0.1, 0.5, 1.1, 1.2, 2.0];

#[test]
fn a_creeping_joint_does_not_slip_by_more_than_its_play() {
    let rig = Rig::new_arm();
    let rows: Vec<_> = SPEEDS_DEG_S
        .par_iter()
        .map(|speed_deg_s| {
            let rows = (0..1000).map(|row| {
                let crept_s = (f64::from(row) * DT_S - STANDS_S).clamp(0.0, CREEPS_S);
                let way = f64::to_radians(speed_deg_s * crept_s);
                POSES_DEG[0].iter().map(|deg| deg.to_radians() + way).collect()
            });
            let motion = RigMotion { dt_s: DT_S, rows: rows.collect() };
            let run = rig.play(&motion, Variation::default(), |_, _| {});
            let mut found = Vec::new();
            for (dof, name) in run.names.iter().enumerate() {
                let samples = run.window(dof, [1.0, 9.5]);
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "ticks"
                )]
                let apart = (STEP_S * run.rate_hz).round() as usize;
                let steps = samples.iter().zip(&samples[apart..]);
                // The motion of the target meanwhile does not count as a step.
                let slip = |(a, b): (&super::run::Sample, &super::run::Sample)| {
                    ((b.measured - a.measured) - (b.commanded - a.commanded)).abs()
                };
                let most_deg = steps.map(slip).fold(0.0, f64::max).to_degrees();
                let ticks = samples.iter().zip(&samples[1..]);
                let jump = ticks.map(|(a, b)| (b.current_a - a.current_a).abs());
                let jump_a = jump.fold(0.0, f64::max);
                let model = rig.model(dof);
                let play = 2.0 * model.half_play_rad();
                let friction_a = model.friction_nm.value * model.stall_current_a.value
                    / model.stall_torque_nm.value;
                found.push((name.clone(), most_deg, play.to_degrees(), jump_a, friction_a));
            }
            (speed_deg_s, found)
        })
        .collect();
    for (speed, found) in &rows {
        for (name, slip, play, jump, friction) in found {
            println!(
                "{speed} deg/s, {name}: slips {slip:.3} deg of {play:.3}, current steps {jump:.4} A (friction {friction:.4})"
            );
        }
    }
    for (speed, found) in rows {
        for (name, slip, play, jump, friction) in found {
            assert!(slip <= play, "{speed} deg/s, {name}");
            // A transition zone that ended at once would add the whole friction as feedforward in one tick.
            assert!(jump < 0.75 * friction, "{speed} deg/s, {name}");
        }
    }
}
