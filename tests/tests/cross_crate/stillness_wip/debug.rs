use super::measure::{Poses, Stillness};
use super::run::Rig;
use sinew_servo_sim::variation::Variation;

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "ticks")]
#[test]
fn debug_one() {
    let rig = if std::env::var("OLD").is_ok() { Rig::old_arm() } else { Rig::new_arm() };
    let dof: usize = std::env::var("DOF").unwrap().parse().unwrap();
    let pose: usize = std::env::var("POSE").unwrap().parse().unwrap();
    let poses = Poses::of_arm();
    let v = Variation { output_friction: Some(0.0), ..Variation::default() };
    let mut truth = Vec::new();
    let run = rig.play(&poses.motion, v, |sim, _| truth.push(sim.q()[dof]));
    let w = poses.windows_s[pose];
    let from = w[0] - 1.5;
    for n in 0..16 {
        let a = from + 0.3 * f64::from(n);
        let s = run.window(dof, [a, a + 0.3]);
        let st = Stillness::of(s, run.rate_hz);
        let m = s.iter().map(|s| s.current_a).sum::<f64>() / s.len() as f64;
        println!("{:.1} {:.3?} mean A {m:.4}", a - from, st);
    }
    let s = run.window(dof, [w[0] + 0.5, w[0] + 1.5]);
    let i0 = ((w[0] + 0.5) * run.rate_hz).round() as usize;
    for (i, s) in s.iter().enumerate().step_by(5) {
        println!(
            "{:.3} cmd {:.3} meas {:.3} true {:.3} A {:.4}",
            i as f64 / run.rate_hz,
            s.commanded.to_degrees(),
            s.measured.to_degrees(),
            truth[i0 + i].to_degrees(),
            s.current_a
        );
    }
}
