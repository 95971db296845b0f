use std::f64::consts::FRAC_PI_2;

use proptest::prelude::*;

use super::*;

/// A file with two joints, 9 channels, and 2 frames of one line each.
const VALID: &str = "\
HIERARCHY
ROOT Hips
{
  OFFSET 1 2 3
  CHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation
  JOINT Left Knee:1
  {
    OFFSET 0 -4 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 -5 1
    }
  }
}
MOTION
Frames: 2
Frame Time: .0083333
10 11 12 0 0 90 90 90 0
10 11 13 0 0 0 0 0 0
";

fn read_text(text: &str) -> Result<Recording, Error> {
    parse(text.as_bytes(), Path::new("folder/clip.bvh"))
}

fn recording(text: &str) -> Recording {
    read_text(text).expect("a valid file")
}

fn rate_of(recording: &Recording) -> f64 {
    recording.frame_time_s.expect("a rate").recip()
}

/// Returns the error's text for `VALID` after replacing `what` once, without the file's name.
fn error(what: &str, with: &str) -> String {
    assert!(VALID.contains(what));
    error_of(&VALID.replacen(what, with, 1))
}

fn error_of(text: &str) -> String {
    let error = read_text(text).expect_err("an invalid file").to_string();
    error.strip_prefix("folder/clip.bvh:").expect("the file's name").to_owned()
}

fn assert_rotation(found: DQuat, expected: DQuat) {
    assert!(found.dot(expected).abs() > 1.0 - 1e-15, "{found} {expected}");
}

#[test]
fn reads_a_motion() {
    let clip = recording(VALID);
    assert_eq!(clip.name, "clip");
    assert!((rate_of(&clip) - 120.0).abs() < 1e-12);
    let [hips, knee] = &clip.skeleton.joints[..] else { panic!("two joints") };
    assert_eq!((hips.name.as_str(), hips.parent), ("Hips", None));
    assert_eq!((knee.name.as_str(), knee.parent), ("Left Knee:1", Some(0)));
    assert_eq!(hips.offset_m, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(knee.end_sites_m, [DVec3::new(0.0, -5.0, 1.0)]);
    assert_eq!(clip.frames.len(), 2);
    let [hips, knee] = clip.frames[0][..] else { panic!("two joints") };
    let (hips, knee) = (hips.unwrap(), knee.unwrap());
    assert_eq!(hips.position_m, DVec3::new(10.0, 11.0, 12.0));
    assert_rotation(hips.rotation, DQuat::from_rotation_x(FRAC_PI_2));
    assert_eq!(knee.position_m, DVec3::new(0.0, -4.0, 0.0));
    // Z first, then X in the rotated frame.
    let z_then_x = DQuat::from_rotation_z(FRAC_PI_2) * DQuat::from_rotation_x(FRAC_PI_2);
    assert_rotation(knee.rotation, z_then_x);
}

#[test]
fn scales_lengths_to_metres() {
    let clip = recording(VALID).in_metres(0.01);
    assert_eq!(clip.skeleton.joints[1].offset_m, DVec3::new(0.0, -0.04, 0.0));
    assert_eq!(clip.skeleton.joints[1].end_sites_m, [DVec3::new(0.0, -0.05, 0.01)]);
    assert_eq!(clip.frames[1][0].unwrap().position_m, DVec3::new(0.1, 0.11, 0.13));
}

#[test]
fn takes_any_white_space_line_end_and_case() {
    let expected = recording(VALID);
    for text in [
        VALID.replace('\n', "\r\n"),
        VALID.replace('\n', "\r"),
        VALID.replace('\n', " \t \r\n\r\n"),
        VALID.replace("  ", "\t"),
        VALID.replace("Frames: ", "Frames:\t").replace("Time: ", "Time:"),
        VALID.replace("Knee:1\n", "Knee:1 "),
        VALID.replace("End Site", "End site").replace("position", "POSITION"),
        VALID.replace("10 11 12 0", "10 11\n12\n0").replace("90 0\n10", "90 0 10"),
        VALID.trim_end().to_owned(),
        format!("\u{feff}{VALID}\n\n"),
    ] {
        assert_eq!(recording(&text), expected, "{text}");
    }
}

#[test]
fn takes_utf16_and_says_of_other_bytes_that_they_are_no_text() {
    for unit in [u16::to_le_bytes, u16::to_be_bytes] {
        let bytes: Vec<u8> = format!("\u{feff}{VALID}").encode_utf16().flat_map(unit).collect();
        assert_eq!(parse(&bytes, Path::new("clip.bvh")).unwrap(), recording(VALID));
    }
    let error = parse(b"\x1f\x8b\x08\x99", Path::new("clip.bvh")).unwrap_err().to_string();
    assert_eq!(error, "clip.bvh:1:1: expected `HIERARCHY`, found bytes that are not text");
}

#[test]
fn a_position_channel_takes_the_place_of_that_component_only() {
    let text = VALID
        .replace("CHANNELS 3 Zrotation Xrotation Yrotation", "CHANNELS 2 yrotation Zposition")
        .replace("90 90 0\n", "90 7\n")
        .replace("0 0 0\n", "0 8\n");
    let knee = recording(&text).frames[0][1].unwrap();
    assert_eq!(knee.position_m, DVec3::new(0.0, -4.0, 7.0));
    assert_rotation(knee.rotation, DQuat::from_rotation_y(FRAC_PI_2));
}

#[test]
fn takes_joints_without_channels_bones_or_end_sites() {
    let text = VALID
        .replace("CHANNELS 3 Zrotation Xrotation Yrotation", "CHANNELS 0")
        .replace("90 90 90 0\n", "90\n")
        .replace("0 0 0 0 0 0\n", "0 0 0\n")
        .replace("0 -4 0", "0 0 0")
        .replace("    End Site\n    {\n      OFFSET 0 -5 1\n    }\n", "");
    let clip = recording(&text);
    assert_eq!(clip.skeleton.joints[1].end_sites_m, []);
    let still = JointSample { rotation: DQuat::IDENTITY, position_m: DVec3::ZERO };
    assert_eq!(clip.frames[0][1], Some(still));
}

#[test]
fn takes_rounded_frame_times_for_the_whole_rate() {
    for (written, rate_hz) in [
        (".0083333", 120.0),
        ("0.00833333", 120.0),
        ("0.00833", 120.0),
        ("0.016667", 60.0),
        ("0.0333333", 30.0),
        ("0.083333333", 12.0),
        ("0.01", 100.0),
        ("0.0333667", 1.0 / 0.033_366_7),
        ("0.4", 2.5),
    ] {
        let found_hz = rate_of(&recording(&VALID.replace(".0083333", written)));
        assert!((found_hz - rate_hz).abs() < 1e-9, "{written}: {found_hz} Hz");
    }
}

#[test]
fn takes_names_that_are_not_utf_8() {
    let mut bytes = VALID.as_bytes().to_vec();
    let at = VALID.find("Knee").unwrap();
    bytes[at] = 0xe9;
    let clip = parse(&bytes, Path::new("clip.bvh")).unwrap();
    assert_eq!(clip.skeleton.joints[1].name, "Left \u{e9}nee:1");
}

#[test]
fn refuses_what_is_no_bvh() {
    assert_eq!(error_of(""), "1:1: expected `HIERARCHY`, found the end of the file");
    assert_eq!(
        error_of("\n\n  PK\u{3}\u{4}"),
        "3:3: expected `HIERARCHY`, found bytes that are not text"
    );
    assert_eq!(error("ROOT", "JOINT"), "2:1: expected `ROOT`, found `JOINT`");
    assert_eq!(
        error("ROOT Hips\n", "ROOT\n"),
        "3:1: expected the joint's name on the same line, found `{`"
    );
    assert_eq!(
        error("MOTION", "ROOT Second"),
        "16:1: expected `MOTION`, found a second `ROOT`: a clip holds one skeleton"
    );
}

#[test]
fn refuses_open_and_stray_braces() {
    assert_eq!(
        error("  }\n}\nMOTION", "  }\nMOTION"),
        "15:1: expected `JOINT`, `End Site` or the `}` of joint `Hips`, found `MOTION`"
    );
    assert_eq!(error("}\nMOTION", "}\n}\nMOTION"), "16:1: expected `MOTION`, found `}`");
    // One closing brace is missing, therefore the others close the joints further inside, and the root's is
    // missing.
    assert_eq!(
        error("0 -5 1\n    }", "0 -5 1\n"),
        "16:1: expected `JOINT`, `End Site` or the `}` of joint `Hips`, found `MOTION`"
    );
}

#[test]
fn refuses_a_wrong_hierarchy() {
    assert_eq!(error("    OFFSET 0 -4 0\n", ""), "8:5: expected `OFFSET`, found `CHANNELS`");
    assert_eq!(error("0 -4 0", "0 -4"), "9:5: expected a finite number, found `CHANNELS`");
    assert_eq!(error("0 -4 0", "0 nan 0"), "8:14: expected a finite number, found `nan`");
    assert_eq!(error("0 -4 0", "0 1e999 0"), "8:14: expected a finite number, found `1e999`");
    assert_eq!(error("0 -4 0", "0 -4,5 0"), "8:14: expected a finite number, found `-4,5`");
    assert_eq!(
        error("CHANNELS 3", "CHANNELS 7"),
        "9:14: expected a number of channels from 0 to 6, found `7`"
    );
    assert_eq!(
        error("Zrotation Xrotation", "Wrotation Xrotation"),
        "9:16: expected a channel (`Xposition` to `Zrotation`), found `Wrotation`"
    );
    assert_eq!(
        error("Zrotation Xrotation", "Zrotation zrotation"),
        "9:26: expected another channel, found a second `zrotation` in joint `Left Knee:1`"
    );
    assert_eq!(
        error("Left Knee:1", "Hips"),
        "6:9: expected a new joint name, found `Hips`, which line 2 names already"
    );
    assert_eq!(error("End Site", "End Joint"), "10:9: expected `Site`, found `Joint`");
}

#[test]
fn refuses_a_wrong_header() {
    assert_eq!(error("Frames:", "Frames"), "17:8: expected `:`, found `2`");
    for count in ["-2", "2.5", "two", "99999999999999999999999999"] {
        let expected = format!("17:9: expected a whole number of frames, found `{count}`");
        assert_eq!(error("Frames: 2", &format!("Frames: {count}")), expected);
    }
    for time in ["0", "-0.01", "inf", "NaN", "1e-300", "33.3", "fast"] {
        let expected =
            format!("18:13: expected a frame time from 0.00001 to 1 second, found `{time}`");
        assert_eq!(error(".0083333", time), expected);
    }
}

#[test]
fn refuses_values_that_do_not_fill_the_frames() {
    assert_eq!(
        error("10 11 13 0 0 0 0 0 0", "10 11 13 0 0 0 0 0"),
        "21:1: the file ends after 1 frame of 2: expected 9 values in each, found 8 of the next; \
         line 20 is the first that is not one frame: it has 8 values"
    );
    assert_eq!(
        error("10 11 12 0 0 90", "10 11 12 0 0 90 1"),
        "20:20: expected the end of the file after 2 frames of 9 values, found 1 more; line 19 is \
         the first that is not one frame: it has 10 values"
    );
    assert_eq!(
        error("Frames: 2", "Frames: 4"),
        "21:1: the file ends after 2 frames of 4: expected 9 values in each, found 0 of the next"
    );
    assert_eq!(
        error_of(&(VALID.to_owned() + &"0 ".repeat(18))),
        "21:1: expected the end of the file after 2 frames of 9 values, found 18 more; line 21 is \
         the first that is not one frame: it has 18 values"
    );
    assert_eq!(error("10 11 13", "10 inf 13"), "20:4: expected a finite number, found `inf`");
    assert_eq!(error("10 11 13", "10 1e10 13"), "20:4: expected a finite number, found `1e10`");
    assert_eq!(error("10 11 13", "10 ? 13"), "20:4: expected a finite number, found `?`");
}

#[test]
fn rows_that_were_miscounted_by_one_are_noted() {
    let few = recording(&VALID.replace("Frames: 2", "Frames: 3"));
    assert_eq!(few.frames.len(), 2);
    assert_eq!(few.notes, ["has 2 frames, one fewer than it says"]);
    let many = recording(&(VALID.to_owned() + "1 2 3 4 5 6 7 8 9\n"));
    assert_eq!(many.frames, recording(VALID).frames);
    assert_eq!(many.notes, ["has a frame more than the 2 that it says: left out"]);
    assert!(recording(VALID).notes.is_empty());
    assert!(read_text(&(VALID.to_owned() + "1 2 3 4 5 6 7 8 nine\n")).is_err());
}

#[test]
fn comments_and_named_end_sites_are_read_over() {
    let expected = recording(VALID);
    for text in [
        VALID.replace("End Site", "End Site tip # of the foot"),
        VALID.replace("Left Knee:1", "Left Knee:1 // below"),
        VALID.replace("OFFSET 0 -4 0\n", "# where it is\nOFFSET 0 -4 0 # cm\n"),
    ] {
        assert_eq!(recording(&text), expected, "{text}");
    }
    assert_eq!(
        recording(&VALID.replace("Knee:1", "Knee#1")).skeleton.joints[1].name,
        "Left Knee#1"
    );
}

#[test]
fn refuses_what_would_not_fit_the_memory() {
    // A header that announces 2^64 frames allocates none: the error is about missing values.
    assert_eq!(
        error("Frames: 2", "Frames: 18446744073709551615"),
        "21:1: the file ends after 2 frames of 18446744073709551615: expected 9 values in each, \
         found 0 of the next"
    );
    let joints: Vec<String> =
        (0..1024).map(|k| format!("JOINT j{k} {{ OFFSET 0 0 0 CHANNELS 0\n")).collect();
    let text = format!("HIERARCHY ROOT r {{ OFFSET 0 0 0 CHANNELS 0\n{}", joints.concat());
    assert_eq!(error_of(&text), "1025:7: expected at most 1024 joints, found more");
    let text = "HIERARCHY\nROOT r { OFFSET 0 0 0 CHANNELS 0 }\nMOTION\nFrames: 9\nFrame Time: 1\n";
    assert_eq!(error_of(text), "6:1: expected at least one channel in the hierarchy, found none");
}

#[test]
fn cuts_long_words_short() {
    let error = error("HIERARCHY", &"x".repeat(100_000));
    assert_eq!(error, format!("1:1: expected `HIERARCHY`, found `{}…`", "x".repeat(40)));
}

#[test]
fn names_a_file_that_is_not_there() {
    let error = read(Path::new("no/such.bvh")).unwrap_err().to_string();
    assert!(error.starts_with("no/such.bvh: cannot be read: "), "{error}");
}

/// Generates words and marks of a BVH file in any order.
fn words() -> impl Strategy<Value = Vec<&'static str>> {
    let words = VALID.split_inclusive(char::is_whitespace).collect::<Vec<_>>();
    prop::collection::vec(prop::sample::select(words), 0..80)
}

/// Asserts that the reader returns only finite numbers and unit rotations.
fn check(read: Result<Recording, Error>) {
    let Ok(recording) = read else { return };
    let clip = recording.in_metres(1.0);
    let frame_time_s = clip.frame_time_s.unwrap();
    assert!(frame_time_s > 0.0 && frame_time_s.is_finite());
    for sample in clip.frames.iter().flatten().flatten() {
        assert!(sample.position_m.is_finite() && sample.rotation.is_normalized());
    }
}

proptest! {
    #[test]
    fn never_panics_on_bytes(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        check(parse(&bytes, Path::new("x")));
    }

    #[test]
    fn never_panics_on_words(words in words()) {
        check(parse(words.concat().as_bytes(), Path::new("x")));
    }

    #[test]
    fn never_panics_on_damaged_files(
        damage in prop::collection::vec((0..VALID.len(), 0..4_usize, any::<u8>()), 1..6),
    ) {
        let mut bytes = VALID.as_bytes().to_vec();
        for (at, kind, byte) in damage {
            let last = bytes.len() - 1;
            let (at, other) = (at.min(last), usize::from(byte).min(last));
            match kind {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                2 => drop(bytes.drain(at.min(other)..at.max(other))),
                _ => bytes.swap(at, other),
            }
        }
        check(parse(&bytes, Path::new("x")));
    }
}

/// Tests positions as `MakeHuman` writes them in files of a face.
#[test]
fn positions_near_zero_are_displacements() {
    let text = VALID
        .replace("CHANNELS 3", "CHANNELS 6 Xposition Yposition Zposition")
        .replace("90 90 0\n", "0.01 0 0 90 90 0\n")
        .replace("\n10 11 13 0 0 0 0 0 0", "\n10 11 13 0 0 0 0 -0.02 0 0 0 0");
    let displaced = recording(&text);
    let at = |frame: usize| displaced.frames[frame][1].unwrap().position_m;
    assert_eq!([at(0), at(1)], [DVec3::new(0.01, -4.0, 0.0), DVec3::new(0.0, -4.02, 0.0)]);
    assert_eq!(displaced.notes.len(), 1, "{:?}", displaced.notes);
    // A single pose away from zero shows that they are positions.
    let placed = recording(&text.replace("-0.02", "-4.02"));
    assert_eq!(placed.frames[0][1].unwrap().position_m, DVec3::new(0.01, 0.0, 0.0));
    assert_eq!(placed.notes.len(), 0);
}
