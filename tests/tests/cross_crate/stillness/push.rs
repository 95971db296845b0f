//! The starter arm is pushed, and comes to rest again.

use sinew_retarget::feasibility::RigMotion;
use sinew_servo_sim::variation::Variation;

use super::limits::SPLIT;
use super::measure::{POSES_DEG, peak_to_peak};
use super::run::Rig;

/// Time of the first joint's push, s; interval to the next joint's push, s; and duration of a push, s.
const FIRST_S: f64 = 3.0;
const EVERY_S: f64 = 2.0;
const PUSH_S: f64 = 0.2;
/// Time from the end of a push until the joint must be at rest, s.
const SETTLED_S: f64 = 0.5;
/// Allowed offset beyond half the play and a step of the encoder, rad.
const OFFSET_RAD: f64 = 0.3 * std::f64::consts::PI / 180.0;

#[test]
fn a_pushed_arm_stands_again_without_ringing() {
    let rig = Rig::new_arm();
    let pose: Vec<f64> = POSES_DEG[0].iter().map(|deg| deg.to_radians()).collect();
    let motion = RigMotion { dt_s: 0.1, rows: vec![pose; 161] };
    let begin_s = |dof: usize| FIRST_S + EVERY_S * dof as f64;
    let mut pushed_nm = [0.0; 6];
    let run = rig.play(&motion, Variation::default(), |sim, time_s| {
        for (dof, pushed_nm) in pushed_nm.iter_mut().enumerate() {
            let since_s = time_s - begin_s(dof);
            if since_s >= 0.0 && *pushed_nm == 0.0 {
                let asked_nm = f64::from(sim.report().dofs[dof].effort);
                let most_nm = rig.model(dof).continuous_torque_nm.value;
                *pushed_nm = 0.5 * (most_nm - asked_nm.abs());
                assert!(*pushed_nm > 0.0);
                // The push acts in the direction of the load that the joint already carries.
                sim.push(dof, -pushed_nm.abs() * asked_nm.signum());
            } else if since_s >= PUSH_S {
                sim.push(dof, 0.0);
            }
        }
    });
    let mut bad = Vec::new();
    for (dof, name) in run.names.iter().enumerate() {
        let end_s = begin_s(dof) + PUSH_S;
        let off = |window: [f64; 2]| -> Vec<f64> {
            let samples = run.window(dof, window);
            samples.iter().map(|sample| sample.measured - sample.commanded).collect()
        };
        let away = off([begin_s(dof), end_s]).into_iter().map(f64::abs).fold(0.0, f64::max);
        let allowed = run.blind_rad[dof] + OFFSET_RAD;
        let after = off([end_s + SETTLED_S, end_s + EVERY_S - PUSH_S]);
        // The joint must stand as still as in a held pose: by its mean offset, and by its peak-to-peak motion.
        let left = (after.iter().sum::<f64>() / after.len() as f64).abs();
        let swing_deg =
            peak_to_peak(run.window(dof, [end_s + SETTLED_S, end_s + EVERY_S - PUSH_S]))
                .to_degrees();
        // A reversal is a change of side, with an offset beyond the allowed one.
        let mut sides: Vec<f64> = off([end_s, end_s + EVERY_S - PUSH_S])
            .into_iter()
            .filter(|off| off.abs() > allowed)
            .map(f64::signum)
            .collect();
        sides.dedup();
        let turns = sides.len().saturating_sub(1);
        assert!(away > rig.model(dof).resolution_rad.value, "{name}: no push moved it");
        let [away, left, allowed] = [away, left, allowed].map(f64::to_degrees);
        println!(
            "{name}: {:.4} N m, {away:.2} deg away, {left:.3} left of {allowed:.3} allowed, {swing_deg:.3} to \
             and fro, {turns} turns back",
            pushed_nm[dof]
        );
        if left > allowed || swing_deg > SPLIT.peak_to_peak_deg || turns > 1 {
            bad.push(name);
        }
    }
    assert!(bad.is_empty(), "{bad:?}");
}
