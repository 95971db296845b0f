//! The starter arm stands still for ten minutes.

use sinew_retarget::feasibility::RigMotion;
use sinew_servo_sim::variation::Variation;

use super::measure::POSES_DEG;
use super::run::Rig;

const HOLD_S: f64 = 600.0;
/// The last part of the time, s, and the largest rise of the case temperatures in it, K.
const LAST_S: f64 = 60.0;
const RISE_K: f64 = 0.2;

#[test]
fn an_arm_held_for_ten_minutes_gets_no_warmer() {
    let rig = Rig::new_arm();
    let pose: Vec<f64> = POSES_DEG[0].iter().map(|deg| deg.to_radians()).collect();
    let motion = RigMotion { dt_s: 1.0, rows: vec![pose; 601] };
    let (mut before_c, mut last_c) = (Vec::new(), Vec::new());
    let run = rig.play(&motion, Variation::default(), |sim, time_s| {
        let servos = 0..rig.description.servos.len();
        last_c = servos.map(|servo| sim.case_c(servo)).collect();
        if time_s <= HOLD_S - LAST_S {
            before_c.clone_from(&last_c);
        }
    });
    let limited = run.samples.iter().flatten().filter(|sample| sample.is_limited).count();
    let rises_k: Vec<f64> =
        last_c.iter().zip(&before_c).map(|(last, before)| last - before).collect();
    println!("at the end {last_c:.2?} C, in the last minute {rises_k:.4?} K; limited {limited}");
    assert_eq!(limited, 0);
    assert!(rises_k.iter().all(|rise| *rise < RISE_K));
}
