//! A face: it follows a clip's jaw and brows by curves, and plays with pulses.

use std::fmt::Write as _;
use std::path::Path;

use sinew_performance::play::Recording;
use sinew_show::{Player, Show};

use super::done;
use crate::common::path;

/// A head with a jaw and two brows, 60 frames at 30 Hz: the jaw opens to 20 degrees and closes, and the brows rise by
/// 10 degrees.
fn bvh() -> String {
    let mut text = String::from(
        "HIERARCHY\nROOT Head\n{\nOFFSET 0 160 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n",
    );
    for (name, offset) in [("Jaw", "0 -5 3"), ("LeftBrow", "3 8 8"), ("RightBrow", "-3 8 8")] {
        let _ = writeln!(
            text,
            "JOINT {name}\n{{\nOFFSET {offset}\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{{\nOFFSET 0 0 5\n}}\n}}"
        );
    }
    text += "}\nMOTION\nFrames: 60\nFrame Time: 0.0333333\n";
    for frame in 0..60 {
        let phase = 0.5 - 0.5 * (std::f64::consts::TAU * f64::from(frame) / 59.0).cos();
        let (jaw, brow) = (20.0 * phase, -10.0 * phase);
        let _ = writeln!(text, "0 160 0 0 0 0 0 {jaw:.6} 0 0 {brow:.6} 0 0 {brow:.6} 0");
    }
    text
}

#[test]
fn eight_servos_of_a_face_follow_by_curves() {
    let folder = tempfile::tempdir().unwrap();
    let [clip, rig, map, show] =
        ["face.bvh", "face.toml", "map.toml", "face.show"].map(|name| path(folder.path(), name));
    std::fs::write(&clip, bvh()).unwrap();
    done(&["rig", "new", "--face", "-o", &rig]);
    let mechanism = super::mechanism(&rig);
    // The first eight hinges of the face; each gets a share of its range.
    let hinges: Vec<_> = mechanism
        .bodies
        .iter()
        .zip(mechanism.coordinate_ranges())
        .filter(|(link, range)| range.len() == 1 && link.ranges.len() == 1)
        .filter(|(link, _)| {
            !mechanism.linked.iter().any(|l| {
                mechanism.bodies[l.body].name == link.name
                    || mechanism.bodies[l.other].name == link.name
            })
        })
        .take(8)
        .collect();
    assert_eq!(hinges.len(), 8);
    let mut text = String::from("rig = \"face\"\nclip = \"face\"\n");
    let sources = [("Jaw", 20.0), ("LeftBrow", -10.0), ("RightBrow", -10.0)];
    for (k, (link, _)) in hinges.iter().enumerate() {
        let (joint, most) = sources[k % 3];
        let [from, to] = ends(link.home[0], link.ranges[0]).map(f64::to_degrees);
        let points = if most > 0.0 {
            format!("[[0, {from}], [{most}, {to}]]")
        } else {
            format!("[[{most}, {to}], [0, {from}]]")
        };
        let _ = writeln!(
            text,
            "\n[[curve]]\nclip = \"{joint}\"\naxis = [1, 0, 0]\nrig = \"{}\"\npoints_deg = {points}",
            link.joint_name
        );
    }
    std::fs::write(&map, &text).unwrap();
    let arguments = [
        "bake",
        &clip,
        "--rig",
        &rig,
        "--mapping",
        &map,
        "--cutoff-hz",
        "0",
        "--metres-per-unit",
        "0.01",
        "-o",
        &show,
    ];
    let [_, notes] = done(&arguments);
    assert!(notes.contains("8 joint(s) follow by curves"), "{notes}");
    let bytes = std::fs::read(&show).unwrap();
    let show = Show::open(&bytes).unwrap();
    let mut player = Player::<64>::new(show).unwrap();
    let (nq, nv) = (show.channel_count(), show.dof_count());
    // In the middle of the clip all hinges are at the ends of their curves, except for the rounding of the show.
    let (mut q, mut qd, mut qdd) = (vec![0.0; nq], vec![0.0; nv], vec![0.0; nv]);
    let middle = show.position_at_us(super::whole_us(f64::from(show.duration_s()) / 2.0));
    player.state_at(middle, &mut q, &mut qd, &mut qdd).unwrap();
    for (link, range) in hinges {
        let [_, to] = ends(link.home[0], link.ranges[0]);
        let off_deg = (f64::from(q[range.start]) - to).to_degrees();
        // 0.25 degrees of the show, and the clip's samples are not exactly at the middle.
        assert!(off_deg.abs() < 0.3, "{}: {off_deg}", link.joint_name);
    }
}

/// Returns home, and the point a third of the way to the farther end of the range.
fn ends(home: f64, [least, most]: [f64; 2]) -> [f64; 2] {
    let far = if most - home > home - least { most } else { least };
    [home, home + (far - home) / 3.0]
}

/// Eyes and jaw are driven by pulses of a PCA9685. Such servos report nothing, so no measurement is recorded.
#[test]
fn a_face_performs_by_pulses() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, csv, show, recorded] = ["face.toml", "talk.csv", "talk.show", "talk.parquet"]
        .map(|name| path(folder.path(), name));
    done(&["rig", "new", "--face", "-o", &rig]);
    std::fs::write(&csv, "time,jaw_rad,eye_turn_left_rad\n0,0,0\n0.5,-0.3,0.2\n1,0,0\n").unwrap();
    done(&["bake", &csv, "--rig", &rig, "--fit", "-o", &show]);
    let [table, told] = done(&["play", &show, "--rig", &rig, "--record", &recorded]);
    assert!(told.contains("14 servos on pulses of a PCA9685"), "{told}");
    assert!(table.contains("faults: none") && table.contains(" 0 answered"), "{table}");
    let jaw = table.lines().find(|line| line.starts_with(" jaw ")).unwrap();
    let cells: Vec<&str> = jaw.split_whitespace().collect();
    assert_eq!([cells[1], cells[5], cells[6], cells[7]], ["pulses", "-", "-", "-"], "{table}");
    let largest: f64 = cells[3].parse().unwrap();
    // The jaw opens by 17 deg. It lags; without pulses it would not move at all.
    assert!(largest > 0.1 && largest < 6.0, "{table}");
    let recording = Recording::open(Path::new(&recorded)).unwrap();
    let at = recording.joints().iter().position(|joint| joint == "jaw").unwrap();
    for part in recording.parts() {
        let part = part.unwrap();
        let rows = &part.joints[at];
        assert!(rows.measured.iter().chain(&rows.error).all(|x| x.is_nan()));
        assert!(rows.commanded.iter().all(|x| x.is_finite()));
        assert!(part.servos.iter().all(|servo| servo.current.iter().all(|x| x.is_nan())));
    }
    super::refused(
        &["record", "--target", "sim", "--rig", &rig, "-o", &csv],
        "is driven by pulses",
    );
}
