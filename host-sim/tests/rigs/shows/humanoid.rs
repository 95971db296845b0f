//! A generated humanoid of hinges, like a URDF of a walking toy.

use std::fmt::Write as _;
use std::path::Path;

use sinew_show::Show;

use super::{done, independent, refused};
use crate::common::path;

fn link(name: &str, mass: f64) -> String {
    format!(
        "<link name='{name}'><inertial><origin xyz='0 0 -0.02'/><mass value='{mass}'/><inertia ixx='2e-4' iyy='2e-4' \
         izz='1e-4' ixy='0' ixz='0' iyz='0'/></inertial></link>\n"
    )
}

/// Returns a URDF, z up, x forward. `speed` in rad/s, `effort` in N m.
fn urdf(speed: f64, effort: f64) -> String {
    let mut text = String::from("<robot name='toy'>\n");
    text += &link("pelvis", 0.8);
    text += &link("torso", 0.8);
    text += &link("head", 0.2);
    let mut joints = vec![
        (
            "waist_yaw".to_owned(),
            "pelvis".to_owned(),
            "torso".to_owned(),
            [0.0, 0.0, 0.08],
            [0.0, 0.0, 1.0],
            1.5,
        ),
        (
            "head_yaw".to_owned(),
            "torso".to_owned(),
            "head".to_owned(),
            [0.0, 0.0, 0.16],
            [0.0, 0.0, 1.0],
            1.5,
        ),
    ];
    let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    for (side, out) in [("l", 1.0), ("r", -1.0)] {
        for (from, chain) in [
            (
                "pelvis",
                &[
                    ("hip_yaw", [0.0, 0.05 * out, -0.02], z, 1.2),
                    ("hip_roll", [0.0; 3], x, 1.2),
                    ("hip_pitch", [0.0; 3], y, 2.0),
                    ("knee", [0.0, 0.0, -0.14], y, 2.4),
                    ("ankle_pitch", [0.0, 0.0, -0.14], y, 1.2),
                    ("ankle_roll", [0.0; 3], x, 0.8),
                ][..],
            ),
            (
                "torso",
                &[
                    ("shoulder_pitch", [0.0, 0.1 * out, 0.12], y, 2.8),
                    ("shoulder_roll", [0.0; 3], x, 2.8),
                    ("shoulder_yaw", [0.0; 3], z, 2.8),
                    ("elbow", [0.0, 0.0, -0.12], y, 2.6),
                ][..],
            ),
        ] {
            let mut parent = from.to_owned();
            for (name, place, axis, range) in chain {
                let child = format!("{side}_{name}_link");
                text += &link(&child, 0.08);
                joints.push((
                    format!("{side}_{name}"),
                    parent,
                    child.clone(),
                    *place,
                    *axis,
                    *range,
                ));
                parent = child;
            }
            // A body beyond the elbow that can serve as a hand.
            if from == "torso" {
                let hand = format!("{side}_hand");
                text += &link(&hand, 0.03);
                let _ = writeln!(
                    text,
                    "<joint name='{side}_wrist_fixed' type='fixed'><parent link='{parent}'/><child link='{hand}'/>\
                     <origin xyz='0 0 -0.12'/></joint>"
                );
            }
        }
    }
    for (name, parent, child, [px, py, pz], [ax, ay, az], range) in joints {
        let least = if name.ends_with("knee") { -0.05 } else { -range };
        let _ = writeln!(
            text,
            "<joint name='{name}' type='revolute'><parent link='{parent}'/><child link='{child}'/><origin xyz='{px} {py} {pz}'/>\
             <axis xyz='{ax} {ay} {az}'/><limit lower='{least}' upper='{range}' effort='{effort}' velocity='{speed}'/></joint>"
        );
    }
    text + "</robot>\n"
}

pub(crate) fn toy(folder: &Path, speed: f64, effort: f64) -> String {
    let file = path(folder, "toy.urdf");
    std::fs::write(&file, urdf(speed, effort)).unwrap();
    file
}

#[test]
fn a_map_that_nobody_has_edited_makes_the_same_show() {
    let folder = tempfile::tempdir().unwrap();
    let rig = toy(folder.path(), 12.0, 6.0);
    let [map, notes] = done(&["clip", "map", "punches_01", "--rig", &rig]);
    assert!(notes.contains("least sure"), "{notes}");
    assert!(map.contains("name = \"l_elbow\"") && map.contains("l_elbow\""), "{map}");
    let file = path(folder.path(), "map.toml");
    std::fs::write(&file, &map).unwrap();
    let [with, without] = ["with.show", "without.show"].map(|name| path(folder.path(), name));
    done(&["bake", "punches_01", "--rig", &rig, "--mapping", &file, "-o", &with]);
    let [report, notes] = done(&["bake", "punches_01", "--rig", &rig, "-o", &without]);
    assert_eq!(std::fs::read(with).unwrap(), std::fs::read(without).unwrap());
    assert!(notes.contains("8 limbs followed"), "{notes}");
    // Without a fit the show is as near to the performer as the retargeted motion. Both numbers are rounded to a
    // tenth.
    let mean = |text: &str, behind: &str| -> f64 {
        let (_, text) = text.split_once(behind).unwrap();
        text.split_whitespace().next().unwrap().parse().unwrap()
    };
    let [taken, shown] = [mean(&notes, "limbs followed, mean error "), mean(&report, "limbs: ")];
    assert!((taken - shown).abs() < 0.11, "{taken} {shown}");
    assert!(report.contains("l_knee") && report.contains("Not looked at: collisions"), "{report}");

    std::fs::write(&file, map.replace("l_elbow\"]", "l_ellbow\"]")).unwrap();
    refused(
        &["bake", "punches_01", "--rig", &rig, "--mapping", &file, "-o", &path(folder.path(), "x")],
        "l_ellbow",
    );
}

#[test]
fn a_fitted_show_exceeds_no_limit_by_an_independent_check() {
    let folder = tempfile::tempdir().unwrap();
    // Slow and weak: a punch is too fast for this rig.
    let rig = toy(folder.path(), 5.0, 1.2);
    let show = path(folder.path(), "punches.show");
    let bake = ["bake", "punches_01", "--rig", &rig, "--seconds", "6", "-o", &show];
    let [report, _] = done(&bake);
    assert!(report.contains("EXCEEDED"), "{report}");
    let fit = ["--fit", "--cue", "bow@2", "--time-code", "1:0:0:0@25"];
    let [report, _] = done(&[&bake[..], &fit, &["--keep-time=false"]].concat());
    assert!(
        super::within_limits(&report) && report.contains("SLOWED DOWN: 6.0 s became"),
        "{report}"
    );
    let bytes = std::fs::read(&show).unwrap();
    independent::exceeds_nothing(&super::mechanism(&rig), &bytes);
    // The show is slower, and its time code follows the clip: at the cue of 2 s it shows 2 s, within a frame.
    let show = Show::open(&bytes).unwrap();
    let bow = show.cues().next().unwrap();
    assert!(bow.sample > show.position_at_us(2_000_000).sample(), "{report}");
    let [one, at] = [show.time_code().unwrap(), show.time_code_at(bow.sample).unwrap()];
    assert!((49..=51).any(|frames| one.after(frames) == at), "{at:?}");
    assert!(report.contains("time code: 01:00:00:00 to 01:00:06:00 at 25 a second"), "{report}");
    // With a time code, a fit keeps the time, unless `--keep-time=false` is given.
    let path = path(folder.path(), "punches.show");
    let [report, _] = done(&[&bake[..], &fit].concat());
    assert!(super::within_limits(&report) && report.contains("TIME KEPT: 6.0 s"), "{report}");
    assert!(report.contains("left of "), "{report}");
    let bytes = std::fs::read(path).unwrap();
    independent::exceeds_nothing(&super::mechanism(&rig), &bytes);
    let show = Show::open(&bytes).unwrap();
    assert!((show.duration_s() - 6.0).abs() < 0.02);
    assert_eq!(show.cues().next().unwrap().sample, show.position_at_us(2_000_000).sample());
}

#[test]
fn a_clip_is_tracked_and_three_errors_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let rig = toy(folder.path(), 12.0, 6.0);
    let csv = path(folder.path(), "toy.csv");
    done(&["clip", "export", "kicks_01", "--rig", &rig, "--rate-hz", "50", "-o", &csv]);
    let table = std::fs::read_to_string(&csv).unwrap();
    let header = table.lines().next().unwrap();
    // A rig with feet travels.
    assert!(header.starts_with("time,root_x,") && header.contains(",l_knee_deg"), "{header}");
    let bvh = path(folder.path(), "toy.bvh");
    done(&["clip", "export", "kicks_01", "--rig", &rig, "--base", "stand", "-o", &bvh]);
    let methods = ["--methods", "recommended", "--seconds", "2"];
    let clips = ["evaluate", "--rig", &rig, "--clips", "kicks_01", "--fit"];
    let [table, _] = done(&[&clips[..], &methods].concat());
    let row = table.lines().rfind(|line| line.contains("Recommended")).expect("its row");
    let cells: Vec<f64> = row.split('|').filter_map(|cell| cell.trim().parse().ok()).collect();
    let [tracking, _, retargeting, _, total, _] = cells[..] else { panic!("{table}") };
    assert!(tracking < 1.0, "{table}");
    assert!(retargeting > 0.0 && (total - retargeting).abs() < 1.0, "{table}");
}

#[test]
fn what_cannot_be_is_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let rig = toy(folder.path(), 12.0, 6.0);
    let out = path(folder.path(), "x.show");
    let empty = path(folder.path(), "empty.toml");
    std::fs::write(&empty, "").unwrap();
    for (arguments, part) in [
        (&["bake", "punches_01", "--rig", &rig, "-o", &rig][..], "is the rig, which would be lost"),
        (
            &["bake", "punches_01", "--rig", &rig, "--html", &out, "-o", &out],
            "two files to write are one",
        ),
        (&["bake", "punches_01", "--rig", &rig, "--mapping", &empty, "-o", &out], "empty.toml"),
        (&["bake", "punch_01", "--rig", &rig, "-o", &out], "punches_01"),
        (&["bake", "nothing.bvh", "--rig", &rig, "-o", &out], "nothing.bvh"),
        (&["bake", "punches_01", "--rig", "nothing.urdf", "-o", &out], "nothing.urdf"),
        (&["bake", "punches_01", "--fit", "-o", &out], "--rig"),
        (
            &["bake", "punches_01", "--rig", &rig, "--time-code", "25:0:0:0@25", "-o", &out],
            "a clock can show",
        ),
        (&["clip", "export", "punches_01", "--rig", &rig, "-o", "x.xyz"], ".csv, .bvh or .json"),
        (
            &["clip", "export", "punches_01", "--rig", &rig, "-o", &path(folder.path(), "x.json")],
            "the rig has no servos",
        ),
    ] {
        refused(arguments, part);
    }
    assert!(!Path::new(&out).exists());
}

/// The robots of `SINEW_DATA`: each performs a walk and a fight within its limits, and tracks them.
#[test]
#[ignore = "needs SINEW_DATA"]
fn robots_perform_a_walk_and_a_fight() {
    let data: std::path::PathBuf = std::env::var_os("SINEW_DATA").expect("SINEW_DATA").into();
    let folder = tempfile::tempdir().unwrap();
    let show = path(folder.path(), "x.show");
    for file in [
        "urdf/robotis-op3/robotis_op3.urdf",
        "urdf/poppy-humanoid/Poppy_Humanoid.urdf",
        "urdf/open-duck-mini/open_duck_mini_v2.urdf",
        "foreign/urdf/so100.urdf",
        "foreign/urdf/h1.urdf",
        "foreign/urdf/talos_reduced.urdf",
    ] {
        let source = data.join(file);
        let rig = path(folder.path(), "rig.toml");
        let mut import = vec![
            "rig",
            "import",
            source.to_str().unwrap(),
            "--repair-inertia",
            "--force",
            "-o",
            &rig,
        ];
        if file.contains("poppy") {
            // The check reports this axis.
            import.extend(["--turn-axis", "l_knee_y"]);
        }
        done(&import);
        for clip in ["walk/07_01.bvh", "fight/02_05.bvh"] {
            let clip = data.join("cmu").join(clip);
            let clip = clip.to_str().unwrap();
            let bake = ["bake", clip, "--rig", &rig, "--fit", "-o", &show];
            let [report, _] = done(&bake);
            assert!(super::within_limits(&report), "{file}, {clip}: {report}");
            independent::exceeds_nothing(&super::mechanism(&rig), &std::fs::read(&show).unwrap());
            let evaluate = ["evaluate", "--rig", &rig, "--clips", clip, "--fit"];
            let methods = ["--methods", "recommended", "--seconds", "5", "--format", "csv"];
            let [table, _] = done(&[&evaluate[..], &methods].concat());
            let mut rows = csv::Reader::from_reader(table.as_bytes());
            let mut rows = rows.records().map(Result::unwrap);
            let mean: f64 = rows.find(|row| &row[2] == "all").expect("a row")[4].parse().unwrap();
            assert!(mean < 1.0, "{file}, {clip}: {mean} deg");
        }
    }
}
