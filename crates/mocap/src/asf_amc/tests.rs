use glam::{DQuat, DVec3};

use std::f64::consts::FRAC_PI_2;

use proptest::prelude::*;

use super::*;
use crate::skeleton::JointSample;

/// A file in the style of Vicon: a pelvis, a thigh with oblique axes, a shank with one dof, a foot that does not
/// rotate, and a bone on the other side.
const ASF: &str = "\
# AST/ASF file generated using VICON BodyLanguage
# -----------------------------------------------
:version 1.10
:name VICON
:units
  mass 1.0
  length 0.45
  angle deg
:documentation
   .ast/.asf automatically generated from VICON data using
   VICON BodyBuilder and BodyLanguage model FoxedUp or BRILLIANT.MOD
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name lfemur
     direction 0 -2 0
     length 7
     axis 0 0 90  XYZ
    dof rx ry rz
    limits (-160.0 20.0)
           (-70.0 70.0)
           (-60.0 70.0)
  end
  begin
     id 2
     name ltibia
     direction 0 -1 0
     length 6
     axis 0 0 0  XYZ
    dof rx
    limits (-10.0 170.0)
  end
  begin
     id 3
     bodymass 10
     name lfoot
     direction 0 0 1
     length 2
     axis 0 0 0  XYZ
  end
  begin
     id 4
     name head
     direction 0 0 0
     length 0
     axis 90 0 90  ZYX
    dof rz rx
    limits (-inf inf)
           (-inf inf)
  end
:hierarchy
  begin
    root lfemur head
    lfemur ltibia
    ltibia lfoot
  end
";

const AMC: &str = "\
#!OML:ASF F:\\VICON\\USERDATA\\REAL\\SUBJECT.ASF
:FULLY-SPECIFIED
:DEGREES
1
root 1 2 3 0 0 0
lfemur 0 0 0
ltibia 0
head 0 0
2
root 1 2.5 3 90 0 90
lfemur 90 0 0
ltibia 90
head 90 90
";

fn read_texts(asf: &str, amc: &str) -> Result<Recording, Error> {
    parse((asf.as_bytes(), Path::new("a/s.asf")), (amc.as_bytes(), Path::new("a/s_1.amc")))
}

fn good(asf: &str, amc: &str) -> Recording {
    read_texts(asf, amc).expect("a motion")
}

/// Returns the error after replacing `what` once, in the file that contains it.
fn error(what: &str, with: &str) -> String {
    assert!(ASF.contains(what) != AMC.contains(what), "{what}");
    let texts = [ASF, AMC].map(|text| text.replacen(what, with, 1));
    read_texts(&texts[0], &texts[1]).expect_err("a wrong file").to_string()
}

fn sample(recording: &Recording, frame: usize, joint: &str) -> Option<JointSample> {
    recording.frames[frame][recording.skeleton.find(joint).expect("a joint")]
}

fn assert_rotation(found: Option<JointSample>, expected: DQuat) {
    let found = found.expect("a sample").rotation;
    assert!(found.dot(expected).abs() > 1.0 - 1e-14, "{found} {expected}");
}

#[test]
fn reads_skeleton_and_motion() {
    let recording = good(ASF, AMC);
    assert_eq!(recording.name, "s_1");
    assert_eq!(recording.frame_time_s, None);
    assert!((recording.metres_per_unit.unwrap() - 0.0254 / 0.45).abs() < 1e-15);
    // Endorphin's files are in metres, with this `length`.
    let other = good(&ASF.replace("length 0.45", "length 0.01"), AMC);
    assert_eq!(other.metres_per_unit, None);
    let joints = &recording.skeleton.joints;
    let names: Vec<_> = joints.iter().map(|joint| (joint.name.as_str(), joint.parent)).collect();
    let expected = [
        ("root", None),
        ("lfemur", Some(0)),
        ("head", Some(0)),
        ("ltibia", Some(1)),
        ("lfoot", Some(3)),
    ];
    assert_eq!(names, expected);
    // A joint is at the end of its parent's bone; a direction may have any length.
    assert_eq!(joints[3].offset_m, DVec3::new(0.0, -7.0, 0.0));
    assert_eq!(joints[4].offset_m, DVec3::new(0.0, -6.0, 0.0));
    assert_eq!(joints[4].end_sites_m, [DVec3::new(0.0, 0.0, 2.0)]);
    assert_eq!((joints[1].offset_m, &joints[1].end_sites_m[..]), (DVec3::ZERO, &[][..]));
    assert_eq!(sample(&recording, 1, "root").unwrap().position_m, DVec3::new(1.0, 2.5, 3.0));
    for joint in ["root", "lfemur", "ltibia", "lfoot", "head"] {
        assert_rotation(sample(&recording, 0, joint), DQuat::IDENTITY);
    }
}

#[test]
fn turns_about_the_axes_of_the_bone() {
    let recording = good(ASF, AMC);
    let [x, y, z] = [
        DQuat::from_rotation_x(FRAC_PI_2),
        DQuat::from_rotation_y(FRAC_PI_2),
        DQuat::from_rotation_z(FRAC_PI_2),
    ];
    // RX is applied first, about fixed axes.
    assert_rotation(sample(&recording, 1, "root"), z * x);
    // The rotation by 90 deg about z turns the thigh's x axis to y.
    assert_rotation(sample(&recording, 1, "lfemur"), y);
    assert_rotation(sample(&recording, 1, "ltibia"), x);
    assert_rotation(sample(&recording, 1, "lfoot"), DQuat::IDENTITY);
    // ZYX: z is applied first, x last. The bone's z axis is then -y, and its x axis z. rz precedes rx.
    let (about_z, about_x) = (y.inverse(), z);
    assert_rotation(sample(&recording, 1, "head"), about_x * about_z);
}

#[test]
fn takes_radians_rates_line_ends_and_comments() {
    let expected = good(ASF, AMC);
    for (asf, amc) in [
        (ASF.replace('\n', "\r\n"), AMC.replace('\n', "\r\n")),
        (ASF.replace('\n', "\r"), AMC.replace('\n', "\r")),
        (ASF.replace('\n', " # note\n\n"), AMC.replace('\n', " # note\n\n")),
        (format!("\u{feff}{ASF}"), format!("\u{feff}{AMC}")),
        (ASF.replace("    dof rx\n", "\tDOF RX\n"), AMC.replace(":DEGREES\n", "")),
        (ASF.replace("1 0\n", "1, 0\n"), AMC.trim_end().to_owned()),
        (ASF.replace(":hier", ":skin\nsome.obj 1\n:hier"), AMC.replace("1 2.5", "1.0e0 2.5")),
        (ASF.to_owned(), AMC.replace("\n1\n", "\n101\n").replace("\n2\n", "\n102\n")),
    ] {
        assert_eq!(good(&asf, &amc), expected);
    }
    let rate = good(ASF, &AMC.replace(":DEG", ":SAMPLES-PER-SECOND 60\n:DEG"));
    assert_eq!(rate.frame_time_s, Some(1.0 / 60.0));
    for (asf, amc) in [
        (ASF.to_owned(), AMC.replace(":DEGREES", ":RADIANS").replace("90", "1.57079632679489662")),
        (
            ASF.replace("angle deg", "angle rad").replace(" 90 ", " 1.57079632679489662 "),
            AMC.replace(":DEGREES\n", "").replace("90", "1.57079632679489662"),
        ),
    ] {
        let radians = good(&asf, &amc);
        for joint in ["root", "lfemur", "ltibia", "head"] {
            let expected = sample(&expected, 1, joint).unwrap().rotation;
            assert_rotation(sample(&radians, 1, joint), expected);
        }
    }
}

#[test]
fn left_out_frames_and_bones_are_gaps() {
    let recording = good(ASF, &AMC.replace("\n2\n", "\n4\n").replace("ltibia 90\n", ""));
    assert_eq!(recording.frames.len(), 4);
    for missing in [1, 2] {
        assert!(recording.frames[missing].iter().all(Option::is_none));
    }
    assert!(recording.frames[0].iter().all(Option::is_some));
    let missing: Vec<bool> = recording.frames[3].iter().map(Option::is_none).collect();
    assert_eq!(missing, [false, false, false, true, false]);
}

#[test]
fn refuses_wrong_units_roots_and_bones() {
    for (what, with, expected) in [
        (":root", "root", "a/s.asf:62:1: expected a `:root` section, found the end"),
        (
            "length 0.45",
            "length 0",
            "a/s.asf:7:10: expected a unit of length from 0.001 to 1000, found `0`",
        ),
        ("angle deg", "angle grad", "a/s.asf:8:9: expected `deg` or `rad`, found `grad`"),
        (
            "mass 1.0",
            "force 1.0",
            "a/s.asf:6:3: expected `mass`, `length` or `angle`, found `force`",
        ),
        (
            "TX TY TZ RX",
            "TX TY TX RX",
            "a/s.asf:13:16: expected each of TX, TY, TZ, RX, RY and RZ once, found `TX`",
        ),
        (
            "   axis XYZ",
            "   axis XYX",
            "a/s.asf:14:9: expected a sequence of the three axes, such as `XYZ`, found `XYX`",
        ),
        ("position 0 0 0", "position 0 1 0", "a/s.asf:15:15: expected `position 0 0 0`, found `1`"),
        (
            "name lfemur",
            "name root",
            "a/s.asf:20:11: expected the name of a bone other than the root, found `root`",
        ),
        (
            "name lfemur\n",
            "name\n",
            "a/s.asf:20:10: expected the bone's name, found the end of the line or file",
        ),
        (
            "name ltibia",
            "name lfemur",
            "a/s.asf:31:11: expected another bone, found a second `lfemur`; the first is in line 18",
        ),
        (
            "direction 0 -2 0",
            "direction 0 0 0",
            "a/s.asf:28:3: bone `lfemur`: expected a direction for its length of 7, found 0 0 0",
        ),
        (
            "direction 0 -2 0",
            "direction 0 nan 0",
            "a/s.asf:21:18: expected a finite number, found `nan`",
        ),
        (
            "direction 0 -2 0",
            "direction 0 -2",
            "a/s.asf:21:20: expected a finite number, found the end of the line or file",
        ),
        (
            "     length 7\n",
            "",
            "a/s.asf:27:3: bone `lfemur`: expected `length` before its `end`, found none",
        ),
        ("length 7", "length -7", "a/s.asf:22:13: expected a length from 0, found `-7`"),
        (
            "90  XYZ",
            "90  XY",
            "a/s.asf:23:19: expected a sequence of the three axes, such as `XYZ`, found `XY`",
        ),
    ] {
        let found = error(what, with);
        assert!(found.starts_with(expected), "{what}: {found}");
    }
}

#[test]
fn refuses_wrong_degrees_of_dof_and_hierarchies() {
    for (what, with, expected) in [
        (
            "dof rx ry rz",
            "dof rx ry tz",
            "a/s.asf:24:15: bone `lfemur`: expected rx, ry or rz, found `tz`: bones that move or stretch are not supported",
        ),
        (
            "dof rx ry rz",
            "dof rx ry rx",
            "a/s.asf:24:15: expected each of rx, ry and rz at most once, found `rx`",
        ),
        ("    limits (-160.0 20.0)\n", "", "a/s.asf:25:13: expected `name`, `direction`"),
        (
            "    root lfemur head",
            "    root lfemur",
            "a/s.asf:46:1: bone `head`: expected a place below `root` in the hierarchy, found none",
        ),
        (
            "    root lfemur head",
            "    root lfemur neck",
            "a/s.asf:58:17: expected a bone of `:bonedata`, found `neck`",
        ),
        (
            "lfemur ltibia\n",
            "lfemur ltibia head\n",
            "a/s.asf:59:19: expected another child, found a second `head`; the first is in line 58",
        ),
        (
            "root lfemur head",
            "lfoot lfemur head",
            "a/s.asf:18:1: bone `lfemur`: expected a place below `root` in the hierarchy, found none",
        ),
        (":hierarchy", ":notes", "a/s.asf:62:1: expected a `:hierarchy` section, found the end"),
    ] {
        let found = error(what, with);
        assert!(found.starts_with(expected), "{what}: {found}");
    }
    let cut = &ASF[..ASF.find("     id 4").unwrap()];
    assert_eq!(
        read_texts(cut, AMC).unwrap_err().to_string(),
        "a/s.asf:47:1: expected the `end` of bone `without a name`, found the end of the line or file"
    );
}

#[test]
fn refuses_a_wrong_motion() {
    for (what, with, expected) in [
        (":FULLY-SPECIFIED", ":SPARSE", "a/s_1.amc:2:1: expected `:FULLY-SPECIFIED`, `:DEGREES`"),
        (
            "\n1\nroot",
            "\nroot",
            "a/s_1.amc:4:1: expected the number of the first frame, found `root`",
        ),
        (
            "\n2\n",
            "\n1\n",
            "a/s_1.amc:9:1: expected a frame number from 2 to 10002 after frame 1, found 1",
        ),
        (
            "\n2\n",
            "\n20000\n",
            "a/s_1.amc:9:1: expected a frame number from 2 to 10002 after frame 1, found 20000",
        ),
        ("\n2\n", "\n2 3\n", "a/s_1.amc:9:3: expected the end of the line, found `3`"),
        (
            "ltibia 90",
            "ltibia",
            "a/s_1.amc:12:7: frame 2, bone `ltibia`: expected 1 value (rx), found 0",
        ),
        (
            "ltibia 90",
            "ltibia 90 1",
            "a/s_1.amc:12:11: frame 2, bone `ltibia`: expected 1 value (rx), found 2",
        ),
        (
            "ltibia 90",
            "rtibia 90",
            "a/s_1.amc:12:1: expected a bone of the ASF file or the number of frame 3, found `rtibia`",
        ),
        (
            "ltibia 90",
            "lfemur 0 0 0",
            "a/s_1.amc:12:1: expected each bone once in frame 2, found `lfemur`",
        ),
        ("ltibia 90", "ltibia inf", "a/s_1.amc:12:8: expected a finite number, found `inf`"),
    ] {
        let found = error(what, with);
        assert!(found.starts_with(expected), "{what}: {found}");
    }
    assert_eq!(
        read_texts(ASF, "").unwrap_err().to_string(),
        "a/s_1.amc:1:1: expected the number of the first frame, found the end of the line or file"
    );
}

#[test]
fn finds_the_skeleton_of_a_motion() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let motion = at("07_01.amc");
    std::fs::write(&motion, AMC).unwrap();
    let error = read(&motion).unwrap_err().to_string();
    assert!(
        error.ends_with(
            "07_01.amc: expected its skeleton in the same folder (`07_01.asf` or `07.asf`, or the only *.asf there), \
             found 0 *.asf files, none with such a name"
        ),
        "{error}"
    );
    // The only file is found, then the subject's, then the trial's.
    for name in ["zz.asf", "07.ASF", "07_01.asf"] {
        std::fs::write(at(name), ASF).unwrap();
        assert_eq!(find_asf(&motion).unwrap(), at(name));
        assert_eq!(read(&motion).unwrap().frames.len(), 2);
    }
    assert!(find_asf(&at("08_01.amc")).is_err());
    let missing = read(&at("no.amc")).unwrap_err().to_string();
    assert!(missing.contains("no.amc: cannot be read"), "{missing}");
}

/// Asserts that the reader returns only finite numbers and unit rotations.
fn check(read: Result<Recording, Error>) {
    let Ok(recording) = read else { return };
    assert!(recording.metres_per_unit.is_none_or(|metres| metres > 0.0));
    for frame in &recording.frames {
        assert_eq!(frame.len(), recording.skeleton.joints.len());
        for sample in frame.iter().flatten() {
            assert!(sample.position_m.is_finite() && sample.rotation.is_normalized());
        }
    }
}

fn damaged(text: &str, damage: &[(prop::sample::Index, u8, u8)]) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for (at, kind, byte) in damage {
        let at = at.index(bytes.len());
        let other = usize::from(*byte) % bytes.len();
        match kind {
            0 => bytes[at] = *byte,
            1 => bytes.insert(at, *byte),
            2 => drop(bytes.drain(at..(at + other % 30).min(bytes.len() - 1).max(at))),
            _ => bytes.swap(at, other),
        }
    }
    bytes
}

proptest! {
    #[test]
    fn never_panics_on_bytes(
        asf in prop::collection::vec(any::<u8>(), 0..400),
        amc in prop::collection::vec(any::<u8>(), 0..400),
    ) {
        let path = Path::new("x");
        check(parse((&asf, path), (ASF.as_bytes(), path)));
        check(parse((ASF.as_bytes(), path), (&amc, path)));
    }

    #[test]
    fn never_panics_on_damaged_files(
        asf in prop::collection::vec((any::<prop::sample::Index>(), 0..4_u8, any::<u8>()), 0..4),
        amc in prop::collection::vec((any::<prop::sample::Index>(), 0..4_u8, any::<u8>()), 0..4),
    ) {
        let path = Path::new("x");
        check(parse((&damaged(ASF, &asf), path), (&damaged(AMC, &amc), path)));
    }

    #[test]
    fn never_panics_on_lines_of_the_format(
        lines in prop::collection::vec(
            prop::sample::select(ASF.lines().chain(AMC.lines()).collect::<Vec<_>>()),
            0..60,
        ),
    ) {
        let (path, text) = (Path::new("x"), lines.join("\n"));
        check(parse((text.as_bytes(), path), (AMC.as_bytes(), path)));
        check(parse((ASF.as_bytes(), path), (text.as_bytes(), path)));
    }
}
