//! `sinew play`: from a file to simulated servos.

use std::io::{BufRead as _, BufReader, Read as _};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::record::Field;
use rayon::prelude::*;

use super::{done, refused};
use crate::common::{command, path};

/// Writes a desk arm, and a show for it in which the first bending joint follows a forearm and swings by 60 deg.
pub(super) fn arm(folder: &Path) -> [String; 2] {
    arm_with(folder, &[])
}

/// Writes a desk arm and a show for it, with more options for the bake.
fn arm_with(folder: &Path, options: &[&str]) -> [String; 2] {
    let [rig, map, show] = ["arm.toml", "map.toml", "arm.show"].map(|name| path(folder, name));
    done(&["rig", "new", "--arm", "3", "-o", &rig]);
    let joint = &super::mechanism(&rig).bodies[2].joint_name;
    let curve = format!(
        "rig = \"arm\"\nclip = \"punches_01\"\n\n[[curve]]\nclip = \"forearm_l\"\naxis = [0, 0, 1]\nrig = \"{joint}\"\n\
         points_deg = [[-180, -60], [180, 60]]\n"
    );
    std::fs::write(&map, curve).unwrap();
    let bake = ["bake", "punches_01", "--rig", &rig, "--mapping", &map, "--seconds", "4", "--fit"];
    done(&[&bake[..], &["-o", &show], options].concat());
    [rig, show]
}

/// Returns mean and largest error from the table's row of a drive, deg.
#[track_caller]
pub(super) fn errors(table: &str, drive: &str) -> [f64; 2] {
    let row = table.lines().find(|line| line.trim_start().starts_with(drive)).expect(table);
    let numbers: Vec<f64> = row.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    // After the count of joints.
    [numbers[1], numbers[2]]
}

#[track_caller]
fn hash(table: &str) -> &str {
    table.split("hash ").nth(1).expect(table).trim()
}

#[test]
fn an_arm_plays_a_show_the_same_way_twice() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, show] = arm(folder.path());
    for (drive, rate, bound_deg) in [("current", "500 Hz", 3.0), ("position", "100 Hz", 5.0)] {
        let play = ["play", &show, "--rig", &rig, "--drive", drive];
        let [table, notes] = done(&play);
        assert!(notes.contains(rate), "{notes}");
        let approach = "going to the show's first pose";
        let states = ["limp", "arming", "holding", approach, "playing", "holding", "stopping"];
        let states = [&states[..], &["lowering", "limp"]].concat();
        let told: Vec<&str> = notes
            .lines()
            .filter_map(|line| line.split(" s  ").nth(1)?.split(": ").next())
            .collect();
        assert_eq!(told[told.len() - states.len()..], states, "{notes}");
        assert!(
            table.contains("faults: none") && table.contains(" 0 overruns, 0 not whole"),
            "{table}"
        );
        let [mean, largest] = errors(&table, drive);
        assert!(mean > 0.0 && mean <= bound_deg && largest < 15.0, "{table}");
        assert_eq!(hash(&table), hash(&done(&play)[0]));
    }
}

#[test]
fn a_loop_is_played_round_after_round() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, show] = arm_with(folder.path(), &["--loop"]);
    let bytes = std::fs::read(&show).unwrap();
    let round_s = f64::from(sinew_show::Show::open(&bytes).unwrap().duration_s());
    for (options, rounds) in [(&[][..], 2.0), (&["--rounds", "3"], 3.0)] {
        let [table, _] = done(&[&["play", &show, "--rig", &rig][..], options].concat());
        assert!(table.contains("faults: none"), "{table}");
        let ran_s = table.split("the show ran, ").nth(1).unwrap().split(' ').next().unwrap();
        let ran_s: f64 = ran_s.parse().unwrap();
        // The time is printed to 10 ms, and a stop command acts within a tick or two of 2 ms.
        assert!((ran_s - rounds * round_s).abs() < 0.01, "{ran_s} of {rounds} times {round_s}");
        // As in a show that ends: nothing jumps at the seam.
        assert!(errors(&table, "current")[1] < 15.0, "{table}");
    }
    let folder = tempfile::tempdir().unwrap();
    let [rig, once] = arm(folder.path());
    refused(&["play", &once, "--rig", &rig, "--rounds", "3"], "is not a loop");
}

/// Starts a play in real time, and waits until its show runs. Its later notes remain readable.
fn playing(rig: &str, show: &str) -> (Child, BufReader<std::process::ChildStderr>) {
    let mut child = command()
        .args(["play", show, "--rig", rig, "--real-time"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut notes = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.ends_with("playing\n") {
        line.clear();
        assert!(notes.read_line(&mut line).unwrap() > 0, "it ended before");
    }
    (child, notes)
}

fn interrupt(child: &Child) {
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

#[test]
fn ctrl_c_brings_the_rig_to_rest_and_lets_it_down() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, show] = arm(folder.path());
    let (child, mut notes) = playing(&rig, &show);
    interrupt(&child);
    let output = child.wait_with_output().unwrap();
    let mut told = String::new();
    notes.read_to_string(&mut told).unwrap();
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{told}{table}");
    let states: Vec<&str> = told.lines().filter_map(|line| line.split(" s  ").nth(1)).collect();
    assert_eq!(states, ["stopping", "lowering", "limp"], "{told}");
    assert!(table.contains("faults: none"), "{table}");
}

#[test]
fn a_second_ctrl_c_ends_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, show] = arm(folder.path());
    let (mut child, mut notes) = playing(&rig, &show);
    interrupt(&child);
    let mut line = String::new();
    while !line.ends_with("stopping\n") {
        line.clear();
        assert!(notes.read_line(&mut line).unwrap() > 0, "it ended before");
    }
    interrupt(&child);
    let mut told = String::new();
    notes.read_to_string(&mut told).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(1), "{told}");
    // Its state, stopping or lowered already, depends on how busy the machine is.
    assert!(told.contains("torque was left on at 3 servos") && !told.contains("limp"), "{told}");
}

#[test]
fn two_buses_of_two_protocols_play_side_by_side() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, _] = arm(folder.path());
    let text = std::fs::read_to_string(&rig).unwrap();
    // Servos of two voltages have no common supply: each bus gets its own.
    let (head, supply) = text.split_once("[supply]").unwrap();
    let (_, behind) = supply.split_once("\n[").unwrap();
    let text = format!("{head}[{behind}");
    let (before, last) = text.rsplit_once("model = \"XL330-M288-T\"").unwrap();
    let with = |bus: &str| format!("{before}model = \"STS3215-7.4V\"\nbus = \"{bus}\"{last}");
    let map = path(folder.path(), "map.toml");
    let play = ["play", "punches_01", "--rig", &rig, "--mapping", &map, "--seconds", "3"];
    std::fs::write(&rig, with("tip")).unwrap();
    let [table, notes] = done(&play);
    assert!(notes.contains("bus \"main\": 2 servos at 4000000 bit/s, 2 by current"), "{notes}");
    assert!(notes.contains("bus \"tip\": 1 servos at 1000000 bit/s, 0 by current"), "{notes}");
    assert!(table.contains("faults: none"), "{table}");
    assert!(errors(&table, "current")[0] <= 3.0 && errors(&table, "position")[0] <= 5.0, "{table}");
    std::fs::write(&rig, with("main")).unwrap();
    refused(&play, "servos of two protocols");
}

#[test]
fn what_cannot_be_played_is_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, show] = arm(folder.path());
    let other = path(folder.path(), "other.toml");
    done(&["rig", "new", "--arm", "4", "-o", &other]);
    for (arguments, part) in [
        (&["play", &show, "--rig", &other][..], "does not play on this rig"),
        (&["play", &show, "--rig", &rig, "--servo", "xm430"], "each joint has a servo already"),
        (&["play", &show, "--rig", &rig, "--rate-hz", "2000"], "500 Hz is possible"),
        (&["play", &show, "--rig", &rig, "--rate-hz", "nan"], "a whole number from 1 to 10000"),
        (&["play", &show, "--rig", &rig, "--baud", "12345"], "4000000"),
        (&["play", &show, "--rig", &rig, "--seconds", "2"], "--seconds: is of clips"),
        (&["play", &rig, "--rig", &rig, "--seconds", "2"], "arm.toml"),
    ] {
        refused(arguments, part);
    }
    // A missing file is reported before anything else.
    let missing = path(folder.path(), "nosuch.show");
    let told = refused(&["play", &missing, "--rig", &rig], "nosuch.show: No such file");
    assert!(!told.contains("bus"), "{told}");
}

#[test]
fn a_recording_has_a_row_a_tick() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, show] = arm(folder.path());
    let file = path(folder.path(), "arm.parquet");
    let [table, _] = done(&["play", &show, "--rig", &rig, "--record", &file]);
    let reader = SerializedFileReader::new(std::fs::File::open(&file).unwrap()).unwrap();
    let kept = reader.metadata().file_metadata().key_value_metadata().unwrap();
    let rig_kept = kept.iter().find(|note| note.key == "rig").unwrap().value.as_deref().unwrap();
    assert_eq!(sinew_rig::toml_file::read(rig_kept).unwrap().servos.len(), 3);
    let (mut rows, mut sum, mut count, mut on) = (0, 0.0, 0.0, 0);
    for row in reader.get_row_iter(None).unwrap() {
        let row = row.unwrap();
        let (mut numbers, mut state) = (std::collections::HashMap::new(), String::new());
        for (name, field) in row.get_column_iter() {
            match field {
                Field::Double(x) => {
                    numbers.insert(name.as_str(), *x);
                }
                Field::Float(x) => {
                    numbers.insert(name.as_str(), f64::from(*x));
                }
                Field::Str(text) if name == "state" => state.clone_from(text),
                _ => {}
            }
        }
        rows += 1;
        // 500 ticks per second.
        assert!((numbers["time_s"] - f64::from(rows) * 2e-3).abs() < 1e-9, "{numbers:?}");
        if state == "playing" {
            let [commanded, measured] = ["bend2.commanded", "bend2.measured"].map(|n| numbers[n]);
            assert!((commanded - measured).abs() < 0.2, "{numbers:?}");
            (sum, count) = (sum + numbers["bend2.error"].abs(), count + 1.0);
            assert!((4.5..5.5).contains(&numbers["bend2.servo.voltage"]), "{numbers:?}");
            on += i32::from(numbers["bend2.servo.current"].abs() > 0.01);
        }
    }
    let ticks: i32 =
        table.split("ticks: ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert_eq!(rows, ticks);
    assert!(count > 500.0 && sum / count < 3_f64.to_radians() && on > 100, "{sum} {count} {on}");
    refused(&["play", &show, "--rig", &rig, "--record", &show], "is the show, which would be lost");
}

/// The robots of `SINEW_DATA` play a walk by current, by position, and with the drives that Poppy really has; and a
/// fight by current and by position. Prints rows of docs/play.md.
#[test]
#[ignore = "needs SINEW_DATA"]
fn robots_follow_within_their_bounds() {
    let data: std::path::PathBuf = std::env::var_os("SINEW_DATA").expect("SINEW_DATA").into();
    let folder = tempfile::tempdir().unwrap();
    let [op3, poppy] = ["op3.toml", "poppy.toml"].map(|name| path(folder.path(), name));
    let import = |file: &str, more: &[&str], rig: &str| {
        let file = data.join("urdf").join(file);
        let import = ["rig", "import", file.to_str().unwrap(), "--repair-inertia", "-o", rig];
        done(&[&import[..], more].concat());
    };
    import("robotis-op3/robotis_op3.urdf", &[], &op3);
    // The check reports this axis.
    let turned = ["--turn-axis", "l_knee_y"];
    import("poppy-humanoid/Poppy_Humanoid.urdf", &turned, &poppy);
    let built = ["mx-28", "l_hip_y=mx-64", "r_hip_y=mx-64", "abs_x=mx-64", "abs_y=mx-64"];
    let ways: [(&str, &str, &[&str], &[&str]); 7] = [
        ("OP3", &op3, &["xm430"], &["current"]),
        ("OP3", &op3, &["xm430"], &["position"]),
        (
            "OP3",
            &op3,
            &[
                "xm430",
                "head_*=xl430",
                "l_sho_*=xl430",
                "r_sho_*=xl430",
                "l_el=xl430",
                "r_el=xl430",
            ],
            &["current", "position"],
        ),
        ("Poppy", &poppy, &["mx-64"], &["current"]),
        ("Poppy", &poppy, &["mx-64"], &["position"]),
        ("Poppy", &poppy, &built, &["current", "position"]),
        // Weak servos carry stronger ones.
        ("Poppy", &poppy, &["mx-28", "l_*=mx-64", "r_*=mx-64"], &["current", "position"]),
    ];
    // The fight takes six times as long, so it runs with three ways: the two with only one drive, and the hardest.
    let walk = ways.iter().map(|way| ("walk/07_01.bvh", way));
    let fight = [&ways[0], &ways[4], &ways[6]].map(|way| ("fight/02_05.bvh", way));
    let runs: Vec<_> = walk.chain(fight).collect();
    let rows: Vec<String> = runs
        .par_iter()
        .flat_map_iter(|(clip, (name, rig, servos, drives))| {
            let file = data.join("cmu").join(clip);
            let mut play = vec!["play", file.to_str().unwrap(), "--rig", rig];
            play.extend(servos.iter().flat_map(|servo| ["--servo", servo]));
            if let [drive] = drives {
                play.extend(["--drive", drive]);
            }
            let [table, notes] = done(&play);
            assert!(
                table.contains("faults: none") && table.contains(" 0 overruns, 0 not whole"),
                "{table}"
            );
            let rate = notes.split("position; ").nth(1).unwrap().split(',').next().unwrap();
            let row = |drive: &&str| {
                let [mean, largest] = errors(&table, drive);
                // Required bounds for a fitted show.
                let bound_deg = if *drive == "current" { 3.0 } else { 5.0 };
                assert!(mean <= bound_deg, "{name}, {clip}: {table}");
                let line = table.lines().find(|line| line.trim_start().starts_with(drive));
                let joints = line.unwrap().split_whitespace().nth(2).unwrap();
                let hash = hash(&table);
                format!(
                    "| {name} | {clip} | {drive}, {joints} joints | {rate} | {mean:.2} | {largest:.2} | `{hash}` |"
                )
            };
            drives.iter().map(row).collect::<Vec<_>>()
        })
        .collect();
    println!("{}", rows.join("\n"));
}
