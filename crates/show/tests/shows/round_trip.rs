//! A played show equals the written motion within the bound, with its exact derivatives, in any order of positions.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "small positive numbers"
)]

use crate::examples::{self, Example, angle_between, any_example, example};
use proptest::prelude::*;
use sinew_show::write::Settings;
use sinew_show::{Joint, Player, Position, Rate, Show};

const COORDS: usize = 32;

struct Played {
    q: [f32; COORDS],
    qd: [f32; COORDS],
    qdd: [f32; COORDS],
}

fn play(player: &mut Player<'_, COORDS>, position: Position) -> Played {
    let (mut q, mut qd, mut qdd) = ([0.0; COORDS], [0.0; COORDS], [0.0; COORDS]);
    player.state_at(position, &mut q, &mut qd, &mut qdd).expect("a whole show");
    Played { q, qd, qdd }
}

fn bits(played: &Played) -> Vec<u32> {
    [played.q, played.qd, played.qdd].iter().flatten().map(|x| x.to_bits()).collect()
}

/// Measures the largest errors at all samples independently: rad, m.
fn errors(example: &Example, show: Show<'_>) -> (f64, f64) {
    let mut player = Player::new(show).expect("room");
    let (mut angle, mut length) = (0.0f64, 0.0f64);
    for (sample, wanted) in (0u32..).zip(example.q.chunks_exact(example.nq())) {
        let Played { q, .. } = play(&mut player, Position::from_samples(sample));
        let mut at = 0;
        for joint in &example.joints {
            let numbers = |k: usize| (f64::from(q[at + k]) - wanted[at + k]).abs();
            match joint {
                Joint::Fixed => {}
                Joint::Revolute => angle = angle.max(numbers(0)),
                Joint::Universal => angle = angle.max(numbers(0)).max(numbers(1)),
                Joint::Prismatic => length = length.max(numbers(0)),
                Joint::Spherical | Joint::Free => {
                    angle = angle.max(angle_between(&q[at..at + 4], &wanted[at..at + 4]));
                    let rest = 4..joint.coordinate_count();
                    length = rest.map(numbers).fold(length, f64::max);
                }
            }
            at += joint.coordinate_count();
        }
    }
    (angle, length)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn every_sample_is_within_the_bound(example in any_example(COORDS), angle_deg in 0.02f64..1.0) {
        let settings = Settings { angle_rad: angle_deg.to_radians(), ..Settings::default() };
        let written = example.write(&settings);
        let show = Show::open(&written.bytes).expect("a show");
        show.check_blocks().expect("whole blocks");
        let (angle, length) = errors(&example, show);
        prop_assert!(angle <= settings.angle_rad, "{angle}");
        prop_assert!(length <= settings.length_m, "{length}");
        // The errors in the show itself: equal within f32 rounding.
        let (stated_rad, stated_m) = show.largest_error();
        prop_assert!((f64::from(stated_rad) - angle).abs() < 1e-6, "{stated_rad} {angle}");
        prop_assert!((f64::from(stated_m) - length).abs() < 1e-6, "{stated_m} {length}");
        prop_assert_eq!(show.rig(), 0x1234_abcd);
        prop_assert_eq!(show.joints().collect::<Vec<_>>(), example.joints);
    }

    #[test]
    fn any_order_gives_the_same_bits(example in any_example(COORDS), places in prop::collection::vec(0.0f64..1.2, 60)) {
        let written = example.write(&Settings { block_s: 0.5, ..Settings::default() });
        let show = Show::open(&written.bytes).expect("a show");
        let mut wandering = Player::<COORDS>::new(show).expect("room");
        let mut forwards = wandering.clone();
        let mut ordered = places.clone();
        ordered.sort_by(f64::total_cmp);
        let position = |place: f64| {
            show.position_at_us((place * f64::from(show.duration_s()) * 1e6) as u64)
        };
        let in_order: Vec<_> =
            ordered.iter().map(|place| bits(&play(&mut forwards, position(*place)))).collect();
        for place in places {
            let index = ordered.iter().position(|other| other.total_cmp(&place).is_eq()).expect("the same places");
            prop_assert_eq!(&bits(&play(&mut wandering, position(place))), &in_order[index]);
        }
    }

    #[test]
    fn speeds_and_accelerations_are_the_curve_s_own(example in any_example(COORDS), place in 0.05f64..0.95) {
        let written = example.write(&Settings::default());
        let show = Show::open(&written.bytes).expect("a show");
        let mut player = Player::<COORDS>::new(show).expect("room");
        let middle_us = (place * f64::from(show.duration_s()) * 1e6) as u64;
        let step_us = 200;
        let [before, now, after] = [middle_us - step_us, middle_us, middle_us + step_us]
            .map(|at| play(&mut player, show.position_at_us(at)));
        let twice_s = 2.0 * step_us as f64 * 1e-6;
        let rate = f64::from(show.rate().hz());
        let (mut at, mut v_at) = (0, 0);
        for joint in &example.joints {
            let (nq, nv) = (joint.coordinate_count(), joint.dof_count());
            // The rate of speeds is the acceleration; a knot in between changes it by a jerk times the step.
            let angular = if joint.turns_freely() { 3 } else { nv };
            for k in v_at..v_at + angular {
                let found = (f64::from(after.qd[k]) - f64::from(before.qd[k])) / twice_s;
                let around = [&before, &now, &after].map(|p| f64::from(p.qdd[k]));
                let (least, most) = around.iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
                // Tolerance: f32 speeds of a few rad/s, differences over 0.4 ms, and the curvature of the
                // acceleration.
                let rounding = 4e-7 * rate.max(60.0) / 60.0 * (1.0 + f64::from(now.qd[k].abs())) / twice_s;
                let tolerance = rounding + 1e-3 * most.abs().max(least.abs()) + 0.02;
                prop_assert!(found >= least - tolerance && found <= most + tolerance, "{joint} {found} {around:?}");
            }
            // A chord over both steps differs from the tangent by third derivatives, of the curve and of the arc.
            let norm = |qd: &[f32]| qd.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
            let numbers = v_at..v_at + nv;
            let spread = after.qdd[numbers.clone()].iter().zip(&before.qdd[numbers.clone()]);
            let spread = spread.fold(0.0f64, |most, (a, b)| most.max(f64::from((a - b).abs())));
            let (step_s, turning, speeding) = (twice_s / 2.0, norm(&now.qd[numbers.clone()]), norm(&now.qdd[numbers]));
            let chord = step_s * spread + step_s.powi(2) * turning * (turning.powi(2) + speeding);
            // Tolerance: f32 positions over both steps.
            let tolerance = chord + 4e-7 * 2.0 / twice_s + 1e-6 * turning;
            if joint.turns_freely() {
                let q = |p: &Played| [0, 1, 2, 3].map(|k| f64::from(p.q[at + k]));
                let (a, b) = (q(&before), q(&after));
                let turned = [
                    a[3] * b[0] - a[0] * b[3] - a[1] * b[2] + a[2] * b[1],
                    a[3] * b[1] + a[0] * b[2] - a[1] * b[3] - a[2] * b[0],
                    a[3] * b[2] - a[0] * b[1] + a[1] * b[0] - a[2] * b[3],
                ];
                for (k, half) in turned.iter().enumerate() {
                    let found = 2.0 * half / twice_s;
                    let speed = f64::from(now.qd[v_at + k]);
                    prop_assert!((found - speed).abs() < tolerance, "{joint} {found} {speed} {tolerance}");
                }
            } else {
                for k in 0..nq {
                    let found = (f64::from(after.q[at + k]) - f64::from(before.q[at + k])) / twice_s;
                    let speed = f64::from(now.qd[v_at + k]);
                    prop_assert!((found - speed).abs() < tolerance, "{joint} {found} {speed}");
                }
            }
            at += nq;
            v_at += nv;
        }
    }

    #[test]
    fn a_loop_has_no_seam(mut example in any_example(COORDS)) {
        if !example.is_loop {
            let Example { joints, samples, rate, .. } = example;
            example = examples::example(joints, samples.max(20), rate, true, 5);
        }
        let written = example.write(&Settings::default());
        let show = Show::open(&written.bytes).expect("a show");
        prop_assert!(show.is_loop());
        let mut player = Player::<COORDS>::new(show).expect("room");
        let Rate { samples, seconds } = show.rate();
        let end_s = f64::from(show.length()) / f64::from(samples) * f64::from(seconds);
        let end_us = (end_s * 1e6) as u64;
        let [end, begin] = [end_us - 1, end_us + 1].map(|at| play(&mut player, show.position_at_us(at)));
        // At most 3 µs apart: the change is the derivative times this, plus f32 rounding of the largest number.
        let most = |numbers: &[f32]| numbers.iter().fold(1.0f32, |most, x| most.max(x.abs()));
        let [speed, acceleration] = [most(&end.qd), most(&end.qdd)];
        let moved = 3e-6 * speed + 1e-6;
        let mut at = 0;
        for joint in &example.joints {
            let mut numbers = at..at + joint.coordinate_count();
            if joint.turns_freely() {
                let wanted: Vec<f64> = begin.q[at..at + 4].iter().map(|x| f64::from(*x)).collect();
                prop_assert!(angle_between(&end.q[at..at + 4], &wanted) < 2.0 * f64::from(moved));
                numbers.start += 4;
            }
            for k in numbers {
                prop_assert!((end.q[k] - begin.q[k]).abs() < moved);
            }
            at += joint.coordinate_count();
        }
        for k in 0..show.dof_count() {
            let (a, b) = (end.qd[k], begin.qd[k]);
            prop_assert!((a - b).abs() < 6e-6 * acceleration + 4e-6 * speed, "{a} {b}");
            // A jerk is at most an acceleration per sample; a rotation also has the acceleration towards its centre.
            let acceleration = acceleration + speed * speed;
            let jerk = acceleration * show.rate().hz();
            let (a, b) = (end.qdd[k], begin.qdd[k]);
            prop_assert!((a - b).abs() < 6e-6 * jerk + 1e-4 * acceleration, "{a} {b}");
        }
    }
}

/// Checks every sample, and therefore every knot and every block border.
#[test]
fn accelerations_have_no_steps() {
    let joints = vec![Joint::Revolute, Joint::Spherical, Joint::Prismatic];
    let example = example(joints, 600, Rate { samples: 100, seconds: 1 }, false, 11);
    let written = example.write(&Settings { block_s: 0.5, ..Settings::default() });
    let show = Show::open(&written.bytes).expect("a show");
    assert_eq!(show.block_count(), 12);
    let mut player = Player::<COORDS>::new(show).expect("room");
    for sample in 1..show.length() {
        let middle_us = u64::from(sample) * 10_000;
        let mut at = |us: u64| play(&mut player, show.position_at_us(us));
        let [long_before, before, after, long_after] =
            [middle_us - 5000, middle_us - 1, middle_us + 1, middle_us + 5000].map(&mut at);
        for k in 0..show.dof_count() {
            let (a, b) = (before.qdd[k], after.qdd[k]);
            // Tolerance: the change within 5 ms on each side, in proportion, and f32 rounding.
            let around = (long_before.qdd[k] - a).abs() + (long_after.qdd[k] - b).abs();
            let rounding = 2e-5 * (1.0 + a.abs());
            assert!((a - b).abs() <= around * 1e-3 + rounding, "{a} {b} at {sample}");
        }
    }
}

#[test]
fn ten_minutes_lose_no_time() {
    let rate = Rate { samples: 120, seconds: 1 };
    let example = example(vec![Joint::Revolute], 2, rate, false, 1);
    let written = example.write(&Settings::default());
    let show = Show::open(&written.bytes).expect("a show");
    // 300 000 ticks of 2 ms: 72 000 samples, up to the rounding of 0.002 to f32.
    let dt_s = 0.002f32;
    let wanted = f64::from(dt_s) * 300_000.0 * 120.0;
    let found = show.pace(dt_s).position(300_000).sample();
    assert!((f64::from(found) - wanted).abs() < 1.0, "{found} {wanted}");
    assert_eq!(show.position_at_us(600_000_000), Position::from_samples(72_000));
}

#[test]
fn a_half_turn_in_a_loop_is_held_at_the_seam() {
    let mut joints = vec![Joint::Fixed; 4];
    joints.push(Joint::Spherical);
    let rate = Rate { samples: 120, seconds: 1 };
    let example = example(joints, 619, rate, true, 3_857_804_649);
    let written = example.write(&Settings::default());
    let (angle, _) = errors(&example, Show::open(&written.bytes).expect("a show"));
    assert!(angle <= Settings::default().angle_rad);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Tests the end of a motion that was not low-passed. No sample follows the end, so the fit's smoothing term
    /// determines the curve there; this term must be smooth in time.
    #[test]
    fn no_speed_is_beyond_that_of_the_samples(
        steps in prop::collection::vec(-0.03f64..0.03, 40..200),
        bound_deg in 0.05f64..1.0,
    ) {
        let mut angle = 0.0;
        let walk = |step: &f64| {
            angle = 0.9 * angle + step;
            angle
        };
        let q: Vec<f64> = steps.iter().map(walk).collect();
        let rate = Rate { samples: 120, seconds: 1 };
        let example = Example { q, ..example(vec![Joint::Revolute], steps.len(), rate, false, 0) };
        let settings = Settings { angle_rad: bound_deg.to_radians(), ..Settings::default() };
        let written = example.write(&settings);
        let mut player = Player::new(Show::open(&written.bytes).expect("a show")).expect("room");
        let widest = example.q.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        // Between two samples, each off by the whole bound, a cubic through noise is up to four times as steep as its
        // chord. It was a hundred times as steep at the ends, when third differences of control values were
        // minimised.
        let most = 6.0 * 120.0 * (widest + 2.0 * settings.angle_rad);
        for quarter in 0..=4 * (example.q.len() - 1) as u64 {
            let position = player.show().position_at_us(quarter * 1_000_000 / 480);
            let Played { qd, .. } = play(&mut player, position);
            prop_assert!(f64::from(qd[0].abs()) <= most, "{} of {most} at {quarter}", qd[0]);
        }
    }
}
