//! No command overwrites its input, even if the output is another name of it. A file that cannot be written is refused
//! before any work.

use std::fs;
use std::path::Path;

use crate::common::sinew_in;

/// Returns exit code and standard error of a command in a folder.
fn sinew(folder: &Path, args: &[&str]) -> (Option<i32>, String) {
    let output = sinew_in(folder, args);
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Every command that writes a file. IN stands for each input file, OUT for the output.
const COMMANDS: &[&[&str]] = &[
    &["rig", "view", "IN", "-o", "OUT"],
    &["rig", "import", "IN", "-o", "OUT", "--force"],
    &["board", "doctor", "--rig", "IN", "-o", "OUT", "--port", "no-port"],
    &["board", "simulate", "--rig", "IN", "--pty", "OUT"],
    &["board", "simulate", "--rig", "arm.toml", "--flash", "IN", "--pty", "OUT"],
    &["servo", "simulate", "--rig", "IN", "--pty", "OUT"],
    &["servo", "tap", "turn1", "--rig", "IN", "--target", "sim", "-o", "OUT"],
    &["bake", "IN", "--rig", "arm.toml", "-o", "OUT"],
    &["bake", "kicks_01", "--rig", "IN", "-o", "OUT"],
    &["bake", "kicks_01", "--rig", "IN", "-o", "new.show", "--html", "OUT"],
    &["bake", "kicks_01", "--rig", "arm.toml", "--mapping", "IN", "-o", "OUT"],
    &["play", "IN", "--rig", "arm.toml", "--record", "OUT"],
    &["play", "kicks_01", "--rig", "IN", "--record", "OUT"],
    &["record", "--rig", "IN", "-o", "OUT"],
    &["record", "--rig", "arm.toml", "--guide", "IN", "-o", "new.csv", "-o", "OUT"],
    &["report", "IN", "-o", "OUT"],
    &["report", "new.parquet", "--rig", "IN", "-o", "OUT"],
    &["clip", "blend", "IN@1.0s", "kicks_01", "--output", "OUT"],
    &["clip", "blend", "kicks_01", "IN", "--output", "new.bvh", "--picture", "OUT"],
    &["clip", "find", ".", "--like", "IN@1.0s", "--picture", "OUT"],
    &["clip", "weights", "IN", "--picture", "OUT"],
    &["clip", "export", "IN", "--rig", "arm.toml", "-o", "OUT"],
    &["clip", "export", "kicks_01", "--rig", "IN", "-o", "OUT"],
    &["clip", "jaw", "IN", "-o", "OUT"],
    &["clip", "jaw", "talk.wav", "--rig", "IN", "-o", "OUT"],
    &["clip", "idle", "--rig", "IN", "-o", "OUT"],
    &["evaluate", "sweep", "IN", "--output", "OUT"],
];

#[cfg(unix)]
#[test]
fn no_command_writes_over_what_it_reads() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    assert_eq!(sinew(folder, &["rig", "new", "--arm", "3", "-o", "arm.toml"]).0, Some(0));
    let input = folder.join("m21.bvh");
    // The command must be refused before it reads this text.
    let text = b"some text";
    fs::write(&input, text).expect("a file");
    fs::create_dir(folder.join("below")).expect("a folder");
    fs::hard_link(&input, folder.join("hard.bvh")).expect("a link");
    std::os::unix::fs::symlink("m21.bvh", folder.join("soft.bvh")).expect("a link");
    std::os::unix::fs::symlink("../m21.bvh", folder.join("below/far.bvh")).expect("a link");
    let whole = input.to_str().expect("a name");
    for command in COMMANDS {
        for [read, out] in [
            ["m21.bvh", "m21.bvh"],
            ["m21.bvh", "below/../m21.bvh"],
            ["m21.bvh", whole],
            ["m21.bvh", "hard.bvh"],
            ["hard.bvh", "m21.bvh"],
            ["soft.bvh", "m21.bvh"],
            ["m21.bvh", "below/far.bvh"],
        ] {
            let args: Vec<String> =
                command.iter().map(|word| word.replace("IN", read).replace("OUT", out)).collect();
            let args: Vec<&str> = args.iter().map(String::as_str).collect();
            let (code, said) = sinew(folder, &args);
            assert!(code == Some(2) && said.contains("would be lost"), "{args:?}: {said}");
            assert_eq!(fs::read(&input).expect("the file"), text, "{args:?}");
        }
    }
}

#[test]
fn what_cannot_be_written_is_said_before_anything_is_done() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    assert_eq!(sinew(folder, &["rig", "new", "--arm", "3", "-o", "arm.toml"]).0, Some(0));
    for args in [
        // That port does not exist. The output must be checked before the port, which would be another error.
        &["record", "--rig", "arm.toml", "--target", "no-port", "-o", "none/led.show"][..],
        &["board", "doctor", "--port", "no-port", "-o", "none/doctor.txt"],
        &["play", "kicks_01", "--rig", "none.toml", "--record", "none/play.parquet"],
        &["bake", "kicks_01", "--rig", "none.toml", "-o", "none/kick.show"],
    ] {
        let (code, said) = sinew(folder, args);
        assert!(code == Some(2) && said.contains("cannot be written"), "{args:?}: {said}");
    }
    assert_eq!(fs::read_dir(folder).expect("the folder").count(), 1);
}
