//! Inputs that once caused a failure (`attack/`), each with its command. Now they are refused with a message, or read
//! correctly.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::common::{command, sinew_in, text};

/// Returns the path of a hostile file.
fn attack(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/attack").join(name)
}

/// Creates a temporary folder with a copy of each of these files.
fn folder_with(names: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in names {
        fs::copy(attack(name), folder.path().join(name)).expect("a copy");
    }
    folder
}

/// Runs a command that must be refused, and returns its standard error.
fn refused(folder: &Path, words: &[&str]) -> String {
    let output = sinew_in(folder, words);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{words:?}: {said}");
    assert!(said.lines().any(|line| line.starts_with("error: ")), "{said}");
    said
}

/// Runs a command that must succeed, and returns its standard error.
fn done(folder: &Path, words: &[&str]) -> String {
    let output = sinew_in(folder, words);
    let said = text(&output.stderr);
    assert!(output.status.success(), "{words:?}: {said}");
    said
}

#[test]
fn golden_numbers_that_are_all_zero_are_held_against_what_comes_out() {
    for name in ["verify_zero.json", "verify_zero_control.json"] {
        let folder = folder_with(&[name]);
        let output = sinew_in(folder.path(), &["evaluate", "verify", "."]);
        let printed = String::from_utf8_lossy(&output.stdout);
        assert_eq!(output.status.code(), Some(1), "{name}: {printed}");
        assert!(printed.contains("FAIL"), "{printed}");
    }
}

#[test]
fn a_failed_verification_fails_though_its_reader_is_gone() {
    let folder = folder_with(&["verify_zero.json"]);
    let mut child = command()
        .current_dir(folder.path())
        .args(["evaluate", "verify", "."])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the command runs");
    drop(child.stdout.take());
    assert_eq!(child.wait().expect("it ends").code(), Some(1));
}

#[test]
fn damaged_geometry_is_refused_or_filled_and_told() {
    let folder = folder_with(&["thigh_404m.bvh", "root_spike_1e9.bvh", "root_spike_10m.bvh"]);
    let folder = folder.path();
    let evaluate = |clip| ["evaluate", "--clips", clip, "--methods", "local", "--seconds", "0.2"];
    let said = refused(folder, &evaluate("thigh_404m.bvh"));
    assert!(said.contains("thigh_404m: the bone to joint `RightLeg` is 403.649 m long"), "{said}");
    for spike in ["root_spike_1e9.bvh", "root_spike_10m.bvh"] {
        let said = done(folder, &evaluate(spike));
        assert!(said.contains("no body jumps faster than 50 m/s: Hips in 1 frame"), "{said}");
        assert!(said.contains("filled 1 gap"), "{said}");
    }
}

#[test]
fn a_command_keeps_what_it_reads() {
    let folder = folder_with(&["m21.bvh"]);
    let folder = folder.path();
    let clip = fs::read(folder.join("m21.bvh")).expect("the clip");
    fs::hard_link(folder.join("m21.bvh"), folder.join("linked.bvh")).expect("a link");
    done(folder, &["rig", "new", "--arm", "3", "-o", "arm.toml"]);
    for out in ["m21.bvh", "./m21.bvh", "linked.bvh"] {
        let said = refused(folder, &["bake", "m21.bvh", "--rig", "arm.toml", "--output", out]);
        assert!(said.contains("is the clip, which would be lost"), "{said}");
        let said = refused(folder, &["clip", "blend", "m21.bvh", "m21.bvh", "--output", out]);
        assert!(said.contains("is the A, which would be lost"), "{said}");
    }
    let sweep = ["--clips", "m21.bvh", "--output", "."];
    fs::write(folder.join("result.csv"), "a sweep").expect("a file");
    let said = refused(folder, &[&["evaluate", "--sweep", "result.csv"], &sweep[..]].concat());
    assert!(said.contains("is the sweep, which would be lost"), "{said}");
    assert_eq!(fs::read(folder.join("m21.bvh")).expect("the clip"), clip);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_the_old_file() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    fs::write(folder.join("k.toml"), "old").expect("the folder can be written");
    // The shell limits files to 1 kB, less than a rig.
    let words = format!("ulimit -f 1; '{}' rig new --arm 6 -o k.toml", env!("CARGO_BIN_EXE_sinew"));
    let shell = Command::new("sh").current_dir(folder).args(["-c", &words]).output();
    assert!(!shell.expect("a shell").status.success());
    assert_eq!(fs::read(folder.join("k.toml")).expect("the file"), b"old");
}

#[test]
fn names_cannot_break_pictures_or_command_the_terminal() {
    let folder = folder_with(&["png_ctrl.bvh", "esc.glb"]);
    let folder = folder.path();
    done(
        folder,
        &["clip", "weights", "png_ctrl.bvh", "--metres-per-unit", "0.01", "--picture", "p.png"],
    );
    assert!(fs::read(folder.join("p.png")).expect("the picture").starts_with(b"\x89PNG"));
    let output = sinew_in(folder, &["clip", "weights", "esc.glb"]);
    assert!(output.status.success());
    assert!(!output.stdout.contains(&0x1b), "{}", String::from_utf8_lossy(&output.stdout));

    let long = fs::read_to_string(attack("png_ctrl.bvh")).expect("the file");
    let long = long.replacen("ROOT ", &format!("ROOT {}", "X".repeat(22_000)), 1);
    fs::write(folder.join("long.bvh"), long).expect("the folder can be written");
    let said = refused(folder, &["clip", "weights", "long.bvh", "--metres-per-unit", "0.01"]);
    assert!(said.contains("a name of at most 256 bytes"), "{said}");
}

#[cfg(target_os = "linux")]
#[test]
fn words_that_are_not_text_are_words() {
    use std::os::unix::ffi::OsStrExt as _;
    let folder = folder_with(&["m21.bvh"]);
    let words = [
        "evaluate",
        "--clips",
        "m21.bvh",
        "--seconds",
        "0.1",
        "--scale",
        "1",
        "--methods",
        "local",
        "--output",
    ];
    let out = std::ffi::OsStr::from_bytes(b"o\xff");
    let output = command().current_dir(folder.path()).args(words).arg(out).output();
    let output = output.expect("the command runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(folder.path().join(out).join("index.html").is_file());
}

#[test]
fn keys_without_end_are_refused_in_a_line() {
    let folder = folder_with(&["m21.bvh"]);
    let folder = folder.path();
    let dots = "a.".repeat(15_000);
    fs::write(folder.join("dots.toml"), format!("[[grid]]\n{dots}a = [1]\n")).expect("a file");
    let said = [
        refused(folder, &["evaluate", "sweep", "dots.toml", "--output", "out", "--dry-run"]),
        refused(folder, &["evaluate", "--clips", "m21.bvh", "--set", &format!("{dots}a=1")]),
    ];
    for said in said {
        assert!(said.len() < 8_000, "{} bytes", said.len());
    }
}

#[test]
fn small_files_cannot_ask_for_much() {
    let folder = folder_with(&[]);
    let folder = folder.path();
    let write = |name: &str, text: String| fs::write(folder.join(name), text).expect("a file");
    // 1,024 joints, only one of them with a channel: two bytes make a frame of 64 kB.
    let joints: Vec<_> =
        (0..1023).map(|j| format!("JOINT j{j} {{ OFFSET 0 1 0 CHANNELS 0\n")).collect();
    let joints = joints.concat();
    let head = format!(
        "HIERARCHY\nROOT r\n{{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n{joints}{}\n}}",
        "}".repeat(1023)
    );
    let amp = format!("{head}\nMOTION\nFrames: 90000\nFrame Time: 0.01\n{}", "0\n".repeat(90_000));
    let frames = 2 * amp.len() / 1024;
    write("amp.bvh", amp);
    let said = refused(folder, &["clip", "weights", "amp.bvh", "--metres-per-unit", "1"]);
    assert!(said.contains(&format!("expected at most {frames} frames")), "{said}");

    let links: Vec<_> = (0..20_000).map(|link| format!("<link name='l{link}'/>")).collect();
    let links = links.concat();
    write("links.urdf", format!("<robot name='r'>{links}</robot>"));
    let said = refused(folder, &["clip", "weights", "links.urdf"]);
    assert!(said.contains("expected one link that no joint moves"), "{said}");

    // 10,000 buffers that all name the file itself.
    let buffers = vec![r#"{"byteLength": 1, "uri": "self.gltf"}"#; 10_000].join(",");
    let nodes = vec!["{}"; 10_001].join(",");
    write("self.gltf", format!(r#"{{"asset": {{"version": "2.0"}}, "buffers": [{buffers}]}}"#));
    let said = refused(folder, &["clip", "weights", "self.gltf"]);
    assert!(said.contains("a node with a mesh and a skin"), "{said}");
    write("nodes.gltf", format!(r#"{{"asset": {{"version": "2.0"}}, "nodes": [{nodes}]}}"#));
    let said = refused(folder, &["clip", "weights", "nodes.gltf"]);
    assert!(said.contains("at most 10000 nodes"), "{said}");

    let list: Vec<String> = (1..=400).map(|value| value.to_string()).collect();
    let list = list.join(",");
    write("cells.toml", format!("[[grid]]\ncontroller.kp = [{list}]\ncontroller.kv = [{list}]\n"));
    let said =
        refused(folder, &["evaluate", "sweep", "cells.toml", "--output", "out", "--dry-run"]);
    assert!(said.contains("at most 100000 cells"), "{said}");
}

#[cfg(unix)]
#[test]
fn what_may_never_end_is_no_file() {
    let folder = folder_with(&[]);
    let folder = folder.path();
    let made = Command::new("mkfifo").arg(folder.join("fifo.bvh")).status();
    assert!(made.expect("mkfifo runs").success());
    for words in [
        ["evaluate", "--clips", "/dev/zero"],
        ["evaluate", "--clips", "fifo.bvh"],
        ["evaluate", "--setup", "/dev/zero"],
    ] {
        let said = refused(folder, &words);
        assert!(said.contains("found a pipe or a device"), "{said}");
    }
    let said = refused(folder, &["clip", "weights", "/dev/zero"]);
    assert!(said.contains("found a pipe or a device"), "{said}");
}

#[cfg(unix)]
#[test]
fn buffers_are_in_the_folder_of_their_file() {
    let folder = folder_with(&[]);
    let folder = folder.path();
    fs::create_dir(folder.join("model")).expect("a folder");
    fs::write(folder.join("secret.bin"), "secret").expect("a file");
    std::os::unix::fs::symlink("../secret.bin", folder.join("model/data.bin")).expect("a link");
    let text =
        r#"{"asset": {"version": "2.0"}, "buffers": [{"byteLength": 6, "uri": "data.bin"}]}"#;
    fs::write(folder.join("model/a.gltf"), text).expect("a file");
    let said = refused(folder, &["clip", "weights", "model/a.gltf"]);
    assert!(said.contains("a link to elsewhere"), "{said}");
}

#[test]
fn two_runs_into_one_folder_are_refused() {
    let folder = folder_with(&["m21.bvh"]);
    let folder = folder.path();
    fs::create_dir(folder.join("out")).expect("a folder");
    let lock = fs::File::create(folder.join("out/.sinew")).expect("a file");
    lock.lock().expect("nobody else has it");
    let said = refused(folder, &["evaluate", "--clips", "m21.bvh", "--output", "out"]);
    assert!(said.contains("another run writes into this folder"), "{said}");
}

/// First bytes of a show of format version 1.
const SHOW_OF_VERSION_1: [u8; 32] = *b"SNWS\x01\0\x12\0\x02\0\0\0\x0a\xd7\x23\x3c0123456789abcdef";

#[test]
fn a_show_of_version_1_is_refused_with_how_to_make_it_anew() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    fs::write(folder.join("old.show"), SHOW_OF_VERSION_1).expect("a file");
    done(folder, &["rig", "new", "--arm", "3", "-o", "arm.toml"]);
    let said = refused(folder, &["play", "old.show", "--rig", "arm.toml"]);
    let why = "old.show: the show is of version 1, which is no longer read: bake it again from its clip, with `sinew \
        bake CLIP --rig RIG`";
    assert!(said.contains(why), "{said}");
    // `bake` does not make such a show either: without a rig it used to write the figure's poses.
    let said = refused(folder, &["bake", "kicks_01", "--output", "new.show"]);
    assert!(said.contains("--rig: expected the rig that performs the show"), "{said}");
}

/// Limits close to zero are refused where the rig's file is read, because no clip could be fitted to them.
#[test]
fn an_acceleration_of_almost_nothing_is_refused_with_its_line() {
    let folder = folder_with(&["acc_panic.toml"]);
    for words in [
        &["rig", "check", "acc_panic.toml"][..],
        &["play", "kicks_01", "--rig", "acc_panic.toml", "--fast"],
    ] {
        let said = refused(folder.path(), words);
        assert!(said.contains("line 69, column 23: joint[1].acceleration_deg_s2"), "{said}");
    }
}

/// The first pose of the show is outside a joint's range: if the show were accepted, the arm would never reach that
/// pose and would wait without end.
#[test]
fn a_show_that_begins_beyond_a_range_is_refused() {
    let folder = folder_with(&["out_of_range.show"]);
    let arm = "../tests/support/rigs/arm_62ff7e0.toml";
    let arm = fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join(arm)).expect("the rig");
    let arm = arm.to_str().expect("a path of UTF-8");
    let said = refused(folder.path(), &["play", "out_of_range.show", "--rig", arm, "--fast"]);
    assert!(said.contains("the show begins with dof "), "{said}");
    assert!(said.contains("beyond its range of "), "{said}");
}

/// The rig has fourteen strong servos on light bodies. Explicit torques between them once diverged and caused a panic.
#[test]
fn a_long_chain_of_strong_servos_plays() {
    let folder = folder_with(&["chain14.toml"]);
    let words = ["play", "kicks_01", "--rig", "chain14.toml", "--fast"];
    let output = sinew_in(folder.path(), &words);
    let printed = text(&output.stdout);
    assert!(output.status.success(), "{printed}{}", text(&output.stderr));
    assert!(printed.contains("faults: none"), "{printed}");
}

/// A file that a command cannot use is refused with its kind, and with a command that accepts it.
#[test]
fn a_file_of_another_kind_is_named() {
    let folder = folder_with(&["m21.bvh", "esc.glb"]);
    let folder = folder.path();
    fs::write(folder.join("rig.urdf"), "<robot name='a'><link name='b'/></robot>").expect("a file");
    fs::write(folder.join("map.toml"), "name = 'a'\n[body]\n").expect("a file");
    fs::write(folder.join("a.show"), SHOW_OF_VERSION_1).expect("a file");
    let files = [
        ("m21.bvh", "a BVH motion, for `sinew clip`, `bake`"),
        ("esc.glb", "a glTF character, for `sinew clip inspect`"),
        ("rig.urdf", "a URDF rig, for `sinew rig`"),
        ("map.toml", "a mapping on the human figure, for `--mapping` without"),
        ("a.show", "a show, for `sinew play`"),
    ];
    let commands: [(&[&str], &[&str]); 6] = [
        (&["rig", "import"], &["rig.urdf"]),
        (&["evaluate", "--clips"], &["m21.bvh"]),
        (&["evaluate", "--setup"], &[]),
        (&["evaluate", "sweep", "--output", "out"], &[]),
        (&["evaluate", "figure"], &[]),
        (&["report"], &[]),
    ];
    for (command, takes) in commands {
        for (file, is) in files.iter().filter(|(file, _)| !takes.contains(file)) {
            let said = refused(folder, &[command, &[*file]].concat());
            assert!(said.contains(&format!("found {is}")), "{command:?} {file}: {said}");
        }
    }
}
