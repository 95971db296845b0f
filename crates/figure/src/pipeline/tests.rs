use glam::DQuat;
use sinew_mocap::JointSample;

use super::*;
use crate::builtin;

/// Returns a built-in clip without gaps, of `frame_count` identical frames.
fn still(frame_count: usize) -> Recording {
    let mut clip = builtin::clips().swap_remove(0);
    let pose = clip.frames.iter().find(|frame| frame.iter().all(Option::is_some)).unwrap().clone();
    clip.frames = vec![pose; frame_count];
    clip
}

fn rest(clip: &Recording) -> Vec<Option<JointSample>> {
    let joints = clip.skeleton.joints.iter();
    joints
        .map(|joint| Some(JointSample { rotation: DQuat::IDENTITY, position_m: joint.offset_m }))
        .collect()
}

#[test]
fn prepares_the_built_in_clips_and_says_what_it_did() {
    let mut frames = 0;
    for clip in builtin::clips() {
        let missing = clip.frames[12..].iter().flatten().filter(|s| s.is_none()).count();
        let seconds = (clip.frames.len() - 1 - 12) as f64 / 120.0;
        let (motion, notices) = prepare(clip, &Settings::default()).unwrap();
        let [
            Notice::Measured(_),
            Notice::LeadInSkipped { frames: 12, .. },
            Notice::GapsFilled(filled),
        ] = &notices[..]
        else {
            panic!("{notices:?}");
        };
        assert_eq!(filled.samples(), missing);
        let last_s = (motion.rotation.len() - 1) as f64 * motion.dt_s;
        assert!((0.0..0.01).contains(&(seconds - last_s + 1e-9)), "{seconds} {last_s}");
        assert_eq!(motion.root_position_m.len(), motion.rotation.len());
        assert!(motion.rotation.iter().flatten().all(|rotation| rotation.is_normalized()));
        frames += motion.rotation.len();
    }
    assert!(frames >= 22_560, "{frames}");
}

#[test]
fn skips_an_inserted_t_pose_but_no_clip_that_starts_in_one() {
    let mut clip = still(40);
    clip.frames[0] = rest(&clip);
    let (motion, notices) = prepare(clip.clone(), &Settings::default()).unwrap();
    assert_eq!(notices[1], Notice::TPoseSkipped);
    assert_eq!(notices[2].to_string(), "skipped the first 0.1 s (12 frames)");
    // 27 frames at 120 Hz are left, the last 0.2167 s after the first.
    assert_eq!(motion.rotation.len(), 22);

    clip.frames = vec![rest(&clip); 40];
    let (_, notices) = prepare(clip, &Settings::default()).unwrap();
    assert!(!notices.contains(&Notice::TPoseSkipped));
}

#[test]
fn leaves_the_low_pass_out_where_the_rate_is_too_low() {
    let mut clip = still(40);
    clip.frame_time_s = Some(1.0 / 12.0);
    let (motion, notices) = prepare(clip, &Settings::default()).unwrap();
    assert_eq!(
        notices[2].to_string(),
        "not low-passed: a rate of 12 Hz contains nothing above the cutoff of 6 Hz"
    );
    // 0.1 s is 1.2 frames; therefore 38 frames are left: 37 / 12 s.
    assert_eq!(motion.rotation.len(), 309);
}

#[test]
fn refuses_what_is_too_short() {
    for frame_count in [0, 1, 12, 13] {
        let error = prepare(still(frame_count), &Settings::default()).unwrap_err();
        assert!(matches!(error, Error::TooShort { .. }), "{frame_count}: {error}");
    }
    assert!(prepare(still(15), &Settings::default()).is_ok());
}

#[test]
fn says_what_is_too_short_and_why() {
    let mut clip = still(2);
    clip.name = "two".to_owned();
    assert_eq!(
        prepare(clip, &Settings::default()).unwrap_err().to_string(),
        "two: too short: expected at least 2 frames at 100 Hz after the 2 frames skipped at its start, \
         found 0 of the recording's 2 frames"
    );
}

#[test]
fn refuses_a_wrong_unit_of_length() {
    for (factor, height) in [(100.0, "1"), (0.01, "0.0")] {
        let mut clip = still(40);
        clip.name = "take".to_owned();
        for joint in &mut clip.skeleton.joints {
            joint.offset_m *= factor;
            for end in &mut joint.end_sites_m {
                *end *= factor;
            }
        }
        let error = prepare(clip, &Settings::default()).unwrap_err().to_string();
        assert!(
            error.starts_with(&format!("take: expected a figure 0.3 to 3 m tall, found {height}"))
                && error.contains("check metres_per_unit in the mapping"),
            "{error}"
        );
    }
}

#[test]
fn fills_frames_that_are_missing_and_reports_a_flip() {
    let mut clip = still(200);
    for frame in &mut clip.frames[50..53] {
        frame.fill(None);
    }
    let forearm = clip.skeleton.find("forearm_l").unwrap();
    for frame in &mut clip.frames[120..] {
        if let Some(sample) = &mut frame[forearm] {
            sample.rotation *= DQuat::from_rotation_x(0.5);
        }
    }
    let (_, notices) = prepare(clip, &Settings::default()).unwrap();
    let texts: Vec<String> = notices.iter().map(ToString::to_string).collect();
    assert_eq!(
        texts[2..],
        [
            "filled 1 gap (54 samples; slerp, positions linear): all joints frames 50-52 (0.03 s)",
            "joint flips, above 2500 deg/s and left as they are: forearm_l 3438 deg/s at frame 120 (1.00 s)",
        ]
    );
}

#[test]
fn names_the_clip_and_the_joint_of_a_long_gap() {
    let mut clip = still(200);
    clip.name = "take".to_owned();
    for frame in &mut clip.frames[20..100] {
        frame[5] = None;
    }
    assert_eq!(
        prepare(clip, &Settings::default()).unwrap_err().to_string(),
        "take: joint `upper_arm_l`: no sample in frames 20-99 (0.67 s); expected gaps of at most 0.5 s \
         (60 frames)"
    );
}

#[test]
fn refuses_settings_that_make_no_sense() {
    let settings = Settings { cutoff_hz: f64::NAN, ..Settings::default() };
    assert_eq!(
        settings.check().unwrap_err().to_string(),
        "cutoff_hz: expected a finite number above 0, found NaN"
    );
    let settings = Settings { lead_in_s: -0.1, ..Settings::default() };
    assert_eq!(
        settings.check().unwrap_err().to_string(),
        "lead_in_s: expected a finite number from 0, found -0.1"
    );
}

#[test]
fn names_the_place_in_a_file_that_cannot_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("b.bvh");
    std::fs::write(&file, "").unwrap();
    let error = load_paths(&[file], &Settings::default()).unwrap_err().to_string();
    assert!(
        error.ends_with("b.bvh:1:1: expected `HIERARCHY`, found the end of the file"),
        "{error}"
    );
}
