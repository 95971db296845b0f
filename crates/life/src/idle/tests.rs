use sinew_retarget::feasibility::looped as blended;
use sinew_rig::new::{arm, face};

use super::*;

fn settings(seconds: f64, seed: u64) -> IdleSettings {
    IdleSettings { seconds, seed, uses: Vec::new() }
}

#[test]
fn a_face_lives_within_its_limits() {
    let mechanism = face().mechanism().unwrap();
    for seed in 0..3 {
        let made = idle(&mechanism, &settings(120.0, seed)).unwrap();
        assert!(
            made.alike <= ALIKE_MAX && made.fastest.1 <= 1.0,
            "{:?} {}",
            made.fastest,
            made.alike
        );
        let of = |role: Role| {
            made.used.iter().find(|(used, _)| *used == role).map_or(0, |(_, all)| all.len())
        };
        assert_eq!((of(Role::Blink), of(Role::EyeTurn), of(Role::HeadTurn)), (4, 2, 1));
        assert_eq!(made.still, ["jaw"]);
        // A check that shares no code with that of the loop.
        for (link, range) in mechanism.bodies.iter().zip(mechanism.coordinate_ranges()) {
            let Some([least, most]) = link.ranges.first().copied() else { continue };
            let values = || made.motion.rows.iter().map(|q| q[range.start]);
            assert!(values().all(|q| (least..=most).contains(&q)), "{}", link.joint_name);
            let fast = values().zip(values().skip(1)).map(|(a, b)| (a - b).abs() * 100.0);
            assert!(fast.fold(0.0, f64::max) <= link.speed, "{}", link.joint_name);
        }
        // Lids close, and eyes look around.
        let swing = |name: &str| {
            let body = mechanism.bodies.iter().position(|link| link.joint_name == name).unwrap();
            let place = mechanism.coordinate_ranges()[body].start;
            let values = made.motion.rows.iter().map(|q| q[place]);
            let (least, most) = values.fold((f64::MAX, f64::MIN), |(a, b), q| (a.min(q), b.max(q)));
            (most - least).to_degrees()
        };
        assert!(swing("lid_upper_left") > 20.0 && swing("eye_turn_right") > 15.0);
        assert!(swing("neck_turn") > 8.0);
    }
}

/// In an hour of idle life, no limit is exceeded, and no two windows of 10 s are alike.
#[test]
fn an_hour_is_never_the_same() {
    let mechanism = face().mechanism().unwrap();
    let motion = idle(&mechanism, &settings(3600.0, 1)).unwrap().motion;
    assert_eq!(motion.rows.len(), 360_001);
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for (link, range) in mechanism.bodies.iter().zip(mechanism.coordinate_ranges()) {
        let Some([least, most]) = link.ranges.first().copied() else { continue };
        let values: Vec<f64> = motion.rows.iter().map(|q| q[range.start]).collect();
        assert!(values.iter().all(|q| (least..=most).contains(q)), "{}", link.joint_name);
        let fast = values.windows(2).map(|pair| (pair[1] - pair[0]).abs() * 100.0);
        assert!(fast.fold(0.0, f64::max) <= link.speed, "{}", link.joint_name);
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let square = values.iter().map(|q| (q - mean).powi(2)).sum::<f64>() / values.len() as f64;
        // Four rows per second suffice to compare windows.
        let scaled = values.iter().step_by(25).map(|q| (q - mean) / square.sqrt());
        columns.extend((square > 1e-9).then(|| scaled.collect()));
    }
    // Consecutive windows of 40 rows.
    let windows: Vec<Vec<f64>> = (0..360)
        .map(|window| {
            let mut all = Vec::new();
            for column in &columns {
                let part = &column[40 * window..40 * (window + 1)];
                let mean = part.iter().sum::<f64>() / 40.0;
                all.extend(part.iter().map(|q| q - mean));
            }
            let length = all.iter().map(|q| q * q).sum::<f64>().sqrt();
            all.iter().map(|q| q / length).collect()
        })
        .collect();
    for (index, one) in windows.iter().enumerate() {
        for other in &windows[index + 1..] {
            let product: f64 = one.iter().zip(other).map(|(a, b)| a * b).sum();
            assert!(product <= 0.95, "{product}");
        }
    }
}

#[test]
fn a_loop_has_no_seam() {
    let mechanism = face().mechanism().unwrap();
    let motion = idle(&mechanism, &settings(60.0, 7)).unwrap().motion;
    assert_eq!(motion.rows.first(), motion.rows.last());
    assert_eq!(motion.rows.len(), 6001);
    // A blend of the end into the beginning has almost nothing to do.
    let (_, change) = blended(&mechanism, &motion, 1.0).unwrap().most;
    assert!(change.to_degrees() < 0.3, "{}", change.to_degrees());
}

#[test]
fn a_seed_is_a_loop() {
    let mechanism = arm(4).unwrap().mechanism().unwrap();
    let loops = [3, 3, 4].map(|seed| idle(&mechanism, &settings(30.0, seed)).unwrap().motion);
    assert_eq!(loops[0], loops[1]);
    assert_ne!(loops[0], loops[2]);
}

#[test]
fn joints_are_known_by_words_and_may_be_named() {
    for (name, role) in [
        ("lid_upper_left", Some(Role::Blink)),
        ("leftEyeYaw", Some(Role::EyeTurn)),
        ("eye_pitch", Some(Role::EyeNod)),
        ("head_z", Some(Role::HeadTurn)),
        ("head_pan", Some(Role::HeadTurn)),
        ("neck_pitch_joint", Some(Role::HeadNod)),
        ("head", Some(Role::HeadTilt)),
        ("l_hip_x", Some(Role::Weight)),
        ("l_hip_y", None),
        ("bust_y", Some(Role::Breath)),
        ("r_shoulder_x", Some(Role::Sway)),
        ("jaw", None),
        ("slide7", None),
    ] {
        assert_eq!(Role::of(name), role, "{name}");
    }
    let mechanism = face().mechanism().unwrap();
    let uses = vec![(Role::Sway, "jaw".to_owned()), (Role::Still, "head".to_owned())];
    let made = idle(&mechanism, &IdleSettings { uses, ..settings(30.0, 1) }).unwrap();
    assert_eq!(made.still, ["head"]);
    assert!(made.used.contains(&(Role::Sway, vec!["jaw".to_owned()])));
    let wrong = IdleSettings { uses: vec![(Role::Sway, "tail".to_owned())], ..settings(30.0, 1) };
    assert!(idle(&mechanism, &wrong).unwrap_err().to_string().contains("`tail`"));
    assert!(idle(&mechanism, &settings(5.0, 1)).unwrap_err().to_string().contains("20 to 3600"));
}
