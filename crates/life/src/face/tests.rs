use std::fmt::Write as _;

use sinew_rig::description::{Description, FaceShape};
use sinew_rig::mechanism::Mechanism;
use sinew_rig::new;

use super::*;

/// Mouth cues in the form of the README of Rhubarb 1.13, with other times.
const JSON: &str = r#"{
  "metadata": { "soundFile": "talk.wav", "duration": 1.20 },
  "mouthCues": [
    { "start": 0.00, "end": 0.20, "value": "X" },
    { "start": 0.20, "end": 0.45, "value": "D" },
    { "start": 0.45, "end": 0.60, "value": "A" },
    { "start": 0.60, "end": 1.00, "value": "E" },
    { "start": 1.00, "end": 1.20, "value": "X" }
  ]
}"#;
const TSV: &str = "0.00\tX\n0.20\tD\n0.45\tA\n0.60\tE\n1.00\tX\n";
/// Cues in frames at 20 Hz.
const LETTERS: &str = "MohoSwitch1\n1 X\n5 D\n10 A\n13 E\n21 X\n";
const PAPAGAYO: &str = "MohoSwitch1\n1 rest\n5 AI\n10 MBP\n13 O\n21 rest\n";

fn face() -> (Description, Mechanism) {
    let rig = new::face();
    let mechanism = rig.mechanism().unwrap();
    (rig, mechanism)
}

fn weights(text: &str, fps: Option<f64>, rig: &Description) -> Result<Weights, FaceError> {
    match read(text.as_bytes(), fps)? {
        FaceTrack::Weights(weights) => Ok(weights),
        FaceTrack::Cues(cues, end_s) => {
            let names: Vec<&str> =
                rig.face_shapes.iter().map(|shape| shape.name.as_str()).collect();
            Weights::of_cues(&cues, end_s, &names)
        }
    }
}

/// Returns the angle of the jaw in each row, deg.
fn jaw(motion: &FaceMotion) -> Vec<f64> {
    let at = motion.joints.iter().position(|joint| joint.name == "jaw").unwrap();
    motion.rows.iter().map(|row| row[at].to_degrees()).collect()
}

#[test]
fn all_files_of_mouth_cues_move_the_jaw_alike() {
    let (rig, mechanism) = face();
    let motions = [JSON, TSV, LETTERS, PAPAGAYO].map(|text| {
        let weights = weights(text, Some(20.0), &rig).unwrap();
        assert!(weights.rows.iter().all(|row| (row.iter().sum::<f64>() - 1.0).abs() < 1e-9));
        jaw(&perform(&mechanism, &rig.face_shapes, &weights).unwrap())
    });
    for motion in &motions {
        assert!(motion.len() >= 105, "{}", motion.len());
        for (row, deg) in motion.iter().enumerate().take(95) {
            assert!((deg - motions[0][row]).abs() < 1.5, "row {row}: {deg} {}", motions[0][row]);
        }
        // Silence is closed; the vowel is open in the middle of 0.2 to 0.45 s; the lips close between the vowels.
        assert!(motion[5] > -1.0 && motion[32] < -10.0, "{} {}", motion[5], motion[32]);
        assert!(motion[52] > -7.0 && motion[80] < -8.0, "{} {}", motion[52], motion[80]);
    }
}

/// Rhubarb 1.14.0 has made these files from the sentence of `tests/golden/voice`, spoken at 22 kHz.
#[test]
fn files_that_rhubarb_made_move_the_jaw_alike() {
    const FILES: [&str; 3] = [
        include_str!("../../../../tests/golden/voice/rhubarb.json"),
        include_str!("../../../../tests/golden/voice/rhubarb.tsv"),
        include_str!("../../../../tests/golden/voice/rhubarb.dat"),
    ];
    let (rig, mechanism) = face();
    let motions = FILES.map(|text| {
        jaw(&perform(&mechanism, &rig.face_shapes, &weights(text, None, &rig).unwrap()).unwrap())
    });
    for motion in &motions {
        assert!((485..=500).contains(&motion.len()), "{}", motion.len());
        // Silence at the beginning, between the sentences at 0.65 s, and at the end; vowels at 1.77 s and 2.79 s.
        assert!(motion[0] > -1.0 && motion[65] > -1.0 && motion[470] > -1.0);
        assert!(motion[177] < -5.0 && motion[279] < -10.0, "{} {}", motion[177], motion[279]);
    }
    // A frame of the `.dat` is 42 ms, so its cues begin up to 42 ms early.
    let off = |other: &[f64]| {
        let pairs = motions[0].iter().zip(other).take(480);
        pairs.map(|(a, b)| (a - b).abs()).sum::<f64>() / 480.0
    };
    assert!(
        off(&motions[1]) < 1e-9 && off(&motions[2]) < 2.0,
        "{} {}",
        off(&motions[1]),
        off(&motions[2])
    );
    let refused = read(include_bytes!("../../../../tests/golden/voice/rhubarb.xml"), None);
    assert!(refused.unwrap_err().to_string().contains("`rhubarb -f json`"));
}

/// Papagayo-NG has written this file: at the end of a word it repeats `rest` in the frame before.
#[test]
fn a_file_that_papagayo_made_moves_the_jaw() {
    let (rig, mechanism) = face();
    let text = include_str!("../../../../tests/golden/voice/papagayo.dat");
    let weights = weights(text, None, &rig).unwrap();
    let motion = jaw(&perform(&mechanism, &rig.face_shapes, &weights).unwrap());
    // AI from frame 15 to 22 and from 31 to 37, MBP from 22 to 27; 24 frames per second.
    assert!(motion[75] < -10.0 && motion[137] < -10.0, "{} {}", motion[75], motion[137]);
    assert!(motion[93] > -7.0 && motion[170] > -1.0, "{} {}", motion[93], motion[170]);
}

/// Lips close even within 60 ms, and no weight jumps.
#[test]
fn neighbours_colour_a_mouth_and_lips_still_close() {
    let (rig, _) = face();
    let weights = weights("0\tD\n0.30\tA\n0.36\tD\n0.70\tX\n", None, &rig).unwrap();
    let of = |name: &str| weights.names.iter().position(|own| own == name).unwrap();
    let (closed, open) = (of("PP"), of("aa"));
    assert!(weights.rows[33][closed] > 0.9, "{:?}", weights.rows[33]);
    assert!(weights.rows[28][closed] > 0.2 && weights.rows[15][open] > 0.99);
    for pair in weights.rows.windows(2) {
        assert!(pair[0].iter().zip(&pair[1]).all(|(a, b)| (a - b).abs() < 0.5), "{pair:?}");
    }
}

fn live_link(codes: &[&str], is_long: bool) -> String {
    let mut text = "Timecode,BlendShapeCount,EyeBlinkLeft,EyeBlinkRight,JawOpen".to_owned();
    let rest = if is_long { ",HeadYaw,LeftEyeRoll" } else { "" };
    text.push_str(rest);
    text.push('\n');
    for (row, code) in codes.iter().enumerate() {
        let count = if is_long { 5 } else { 3 };
        let tail = if is_long { ",0.3,-1.2" } else { "" };
        writeln!(text, "{code},{count},0.0,0.5,{}{tail}", 0.1 * row as f64).unwrap();
    }
    text
}

#[test]
fn the_three_forms_of_time_codes_are_times() {
    let times = |codes: &[&str], fps| match read(live_link(codes, true).as_bytes(), fps).unwrap() {
        FaceTrack::Weights(weights) => {
            assert_eq!(weights.names, ["EyeBlinkLeft", "EyeBlinkRight", "JawOpen"]);
            weights.times_s
        }
        FaceTrack::Cues(..) => panic!("weights"),
    };
    let near = |found: Vec<f64>, expected: &[f64]| {
        assert_eq!(found.len(), expected.len());
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
    };
    near(
        times(&["10:00:00:58.500", "10:00:00:59.500", "10:00:01:00.500"], None),
        &[0.0, 1.0 / 60.0, 2.0 / 60.0],
    );
    near(
        times(&["23:59:59:29", "00:00:00:00", "00:00:00:15"], None),
        &[0.0, 1.0 / 30.0, 16.0 / 30.0],
    );
    near(times(&["01:02:03.250", "01:02:03.283", "01:02:04.000"], None), &[0.0, 0.033, 0.75]);
    // Two rows with the same frame are spread over the frame; `--fps` has priority over the frame numbers.
    near(times(&["10:00:00:00", "10:00:00:00", "10:00:00:01"], Some(50.0)), &[0.0, 0.01, 0.02]);
}

#[test]
fn blend_shapes_move_lids_and_jaw() {
    let (rig, mechanism) = face();
    let codes: Vec<String> = (0..10).map(|frame| format!("00:00:00:{frame:02}")).collect();
    let codes: Vec<&str> = codes.iter().map(String::as_str).collect();
    let weights = weights(&live_link(&codes, false), Some(10.0), &rig).unwrap();
    let motion = perform(&mechanism, &rig.face_shapes, &weights).unwrap();
    assert_eq!(motion.used, ["EyeBlinkRight", "JawOpen"]);
    let column = |name: &str| motion.joints.iter().position(|joint| joint.name == name).unwrap();
    let last = &motion.rows[motion.rows.len() - 1];
    // The jaw has 0.9 of 22 deg, and the lid half of the way from 30 to -8 deg.
    assert!((last[column("jaw")].to_degrees() + 19.8).abs() < 0.3, "{last:?}");
    assert!((last[column("lid_upper_right")].to_degrees() - 11.0).abs() < 0.3, "{last:?}");
    assert!((last[column("lid_upper_left")].to_degrees() - 30.0).abs() < 0.01, "{last:?}");
    let text = motion.csv();
    let read = sinew_retarget::exchange::keys::read(&mechanism, &text, None).unwrap();
    assert!((read.motion.duration_s() - 0.9).abs() < 1e-9 && read.jumps.is_empty());
    for joint in &motion.joints {
        assert!(joint.correlation > 0.99 && joint.jerk.is_finite(), "{joint:?}");
    }
}

/// If shapes together exceed a range, they keep their form: their other joints move less, too.
#[test]
fn shapes_that_overlap_are_fitted() {
    let (mut rig, mechanism) = face();
    let shape = |name: &str, pose: &[(&str, f64)]| FaceShape {
        name: name.to_owned(),
        pose: pose.iter().map(|(joint, deg)| ((*joint).to_owned(), deg.to_radians())).collect(),
    };
    rig.face_shapes = vec![
        shape("cry", &[("jaw", -20.0), ("brow_left", 10.0)]),
        shape("yell", &[("jaw", -20.0), ("brow_left", 10.0)]),
    ];
    let weights = Weights {
        names: vec!["cry".to_owned(), "yell".to_owned()],
        times_s: vec![0.0, 1.0, 2.0],
        rows: vec![vec![0.0, 0.0], vec![1.0, 1.0], vec![1.0, 1.0]],
    };
    let motion = perform(&mechanism, &rig.face_shapes, &weights).unwrap();
    assert!(motion.fitted > 0.4, "{}", motion.fitted);
    let last = &motion.rows[motion.rows.len() - 1];
    // The two shapes ask for 40 deg of the jaw, and 24.7 are in its range. The brow must be near the nearest pose that
    // both shapes can make.
    let [jaw, brow] = [0, 1].map(|joint| last[joint].to_degrees());
    assert!((-24.8..-24.0).contains(&jaw) && (12.0..17.0).contains(&brow), "{jaw} {brow}");
    for row in &motion.rows {
        assert!(row[0].to_degrees() >= -25.0 && row[0] <= 0.0);
    }
}

/// Lids never cross, for all combinations of the weights.
#[test]
fn lids_keep_the_limit_that_joins_them() {
    let (rig, mechanism) = face();
    let names = ["eyeBlinkLeft", "eyeLookDownLeft", "eyeSquintLeft", "eyeWideLeft"];
    let rows = (0..40)
        .map(|row| (0..4).map(|column| f64::from(u8::from((row >> column) & 1 == 1))).collect());
    let weights = Weights {
        names: names.map(str::to_owned).to_vec(),
        times_s: (0..40).map(|row| 0.5 * f64::from(row)).collect(),
        rows: rows.collect(),
    };
    let motion = perform(&mechanism, &rig.face_shapes, &weights).unwrap();
    let column = |name: &str| motion.joints.iter().position(|joint| joint.name == name).unwrap();
    let (upper, lower) = (column("lid_upper_left"), column("lid_lower_left"));
    assert!(motion.rows.iter().all(|row| row[upper] >= row[lower]));
}

#[test]
fn files_of_other_kinds_are_refused_with_the_right_form() {
    let (rig, _) = face();
    for (text, words) in [
        ("", "an empty file"),
        ("RIFF....WAVEfmt ", "a sound: `sinew clip jaw`"),
        ("<?xml version=\"1.0\"?><rhubarbResult>", "XML: `rhubarb -f json`"),
        (
            "lipsync version 1\ntalk.wav\n24\n",
            "project of Papagayo: export the voice as a Moho switch",
        ),
        ("HIERARCHY\nROOT Hips", "BVH clip: `sinew bake`"),
        ("Kaydara FBX Binary", "an FBX: open it in Blender"),
        ("time,jaw_deg\n0,1\n", "keys of joints: `sinew bake` reads it"),
        ("frame,jawOpen\n0,1\n", "must be that of Live Link Face"),
        ("{\"frames\": []}", "JSON without `mouthCues`: `rhubarb -f json`"),
        ("{\"mouthCues\": [{\"start\": 0.0}]}", "line 1, column 29: missing field `end`"),
        (
            "{\"mouthCues\": [{\"start\": 1.0, \"end\": 0.5, \"value\": \"A\"}]}",
            "mouthCues[0], `end`: expected a time from 1 s",
        ),
        ("{\"mouthCues\": []}", "at least one mouth cue, found 0"),
        ("0.0\tX\n0.2 s\tA\n", "line 2, the mouth cue: expected a time in s, a tab"),
        ("0.3\tX\n0.2\tA\n", "line 2, the beginning: expected a time from 0.3 s on"),
        (
            "0.0\tX\n0.2\tQ\n0.4\tX\n",
            "line 2, the mouth: expected one of A, B, C, D, E, F, G, H, X, found `Q`",
        ),
        ("MohoSwitch2\n1 rest\n", "of another version: its first line must be `MohoSwitch1`"),
        ("NaN\tX\n0.2\tA\n", "something else"),
        ("0.0\tX\nNaN\tA\n", "line 2, the mouth cue: expected a time in s, a tab"),
        ("MohoSwitch1\n0 rest\n", "line 2, the mouth cue: expected a frame from 1 on"),
        ("MohoSwitch1\n1 rest\n5 AAH\n9 rest\n", "line 3, the mouth: expected one of AI, E, etc"),
    ] {
        let refused = weights(text, None, &rig).unwrap_err().to_string();
        assert!(refused.contains(words), "{text:?}: {refused}");
    }
}

#[test]
fn wrong_rows_of_live_link_face_are_named() {
    let good = live_link(&["00:00:00:00", "00:00:00:01", "00:00:00:02"], false);
    for (from, to, words) in [
        ("00:00:00:01,3", "1.5,3", "line 3, column `Timecode`: expected HH:MM:SS:FF.fff"),
        ("00:00:00:01,3", "00:00:61:01,3", "line 3, column `Timecode`"),
        ("00:00:00:01,3", "00:00:00:01,52", "line 3, column `BlendShapeCount`: expected 3"),
        (
            "0.0,0.5,0.1",
            "0.0,high,0.1",
            "line 3, column `EyeBlinkRight`: expected a weight from 0 to 1, found `high`",
        ),
        ("0.0,0.5,0.1", "0.0,50,0.1", "found `50`"),
        (
            "0.0,0.5,0.1",
            "0.0,NaN,0.1",
            "line 3, column `EyeBlinkRight`: expected a weight from 0 to 1",
        ),
        ("0.0,0.5,0.1", "0.0,0.1", "with 2 value(s)"),
        (
            "00:00:00:02,3",
            "00:00:00.000,3",
            "line 4, column `Timecode`: expected the form of the first line",
        ),
        ("EyeBlinkRight,Jaw", "EyeBlinkLeft,Jaw", "each shape once, found `EyeBlinkLeft`"),
        (
            "Timecode,BlendShapeCount,",
            "Timecode,",
            "line 1, the header: expected `Timecode,BlendShapeCount",
        ),
    ] {
        let text = good.replace(from, to);
        let refused = read(text.as_bytes(), None).unwrap_err().to_string();
        assert!(refused.contains(words), "{to}: {refused}");
    }
    let refused = read(good.as_bytes(), Some(1.0)).unwrap_err().to_string();
    assert!(refused.contains("expected a frame below 1"), "{refused}");
    let back = live_link(&["00:00:00:05", "00:00:00:01", "00:00:00:02"], false);
    let refused = read(back.as_bytes(), None).unwrap_err().to_string();
    assert!(refused.contains("line 3") && refused.contains("earlier"), "{refused}");
}

#[test]
fn a_rig_without_the_shapes_is_told_what_it_needs() {
    let (mut rig, mechanism) = face();
    let cues = weights(TSV, None, &rig).unwrap();
    let refused = perform(&mechanism, &[], &cues).unwrap_err().to_string();
    assert!(refused.contains("no `[[shape]]`") && refused.contains("rig new --face"), "{refused}");
    let refused = |rig: &Description| weights(TSV, None, rig).unwrap_err().to_string();
    rig.face_shapes.retain(|shape| shape.name != "aa");
    let message = refused(&rig);
    assert!(
        message.starts_with("line 2: the rig has no shape `aa` for the mouth `D`"),
        "{message}"
    );
    // A shape with the name of the mouth shape is used, too.
    rig.face_shapes.push(FaceShape { name: "D".to_owned(), pose: vec![("jaw".to_owned(), -0.3)] });
    assert!(weights(TSV, None, &rig).unwrap().names.contains(&"D".to_owned()));
    let poor = [FaceShape { name: "smile".to_owned(), pose: Vec::new() }];
    let message = perform(&mechanism, &poor, &cues).unwrap_err().to_string();
    assert!(message.contains("The file has sil, aa, PP, oh"), "{message}");
}

#[test]
fn names_of_other_programs_are_the_same_shapes() {
    for (one, other) in [
        ("EyeBlinkLeft", "eyeBlinkLeft"),
        ("eyeBlink_L", "eyeBlinkLeft"),
        ("mouthSmile.R", "mouthSmileRight"),
        ("viseme_PP", "PP"),
        ("viseme_aa", "aa"),
    ] {
        assert!(names::is_same(one, other), "{one} {other}");
    }
    assert!(!names::is_same("jawOpen", "jawLeft"));
}
