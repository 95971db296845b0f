//! Commands that are killed while they write. The file must be the old one or the new one, and the next run removes
//! leftovers.

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::common::command;

/// Number of kills of each command, spread over its run time.
const KILLS: u32 = 8;

/// Commands that write `out`, and whether an unfinished file is kept.
const COMMANDS: [(&[&str], bool); 5] = [
    (&["rig", "new", "--arm", "40", "-o", "out", "--force"], false),
    (&["rig", "view", "arm.toml", "-o", "out"], false),
    (&["clip", "export", "kicks_01", "--rig", "arm.toml", "-o", "out.csv"], false),
    (&["bake", "kicks_01", "--rig", "arm.toml", "--fit", "-o", "out"], false),
    (&["play", "kick.show", "--rig", "arm.toml", "--fast", "--record", "out"], true),
];

fn start(folder: &Path, args: &[&str]) -> std::process::Child {
    let mut command = command();
    command.args(args).current_dir(folder).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().expect("the command starts")
}

/// Counts the hidden files with an ending.
fn hidden(folder: &Path, ending: &str) -> usize {
    let names =
        fs::read_dir(folder).expect("the folder").map(|entry| entry.expect("it").file_name());
    names.filter(|name| name.to_string_lossy().ends_with(ending)).count()
}

#[test]
fn a_command_that_is_killed_leaves_the_old_file_or_the_new_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for args in [
        &["rig", "new", "--arm", "6", "-o", "arm.toml"][..],
        &["bake", "kicks_01", "--rig", "arm.toml", "--fit", "-o", "kick.show"],
    ] {
        assert!(start(folder, args).wait().expect("it ends").success(), "{args:?}");
    }
    println!("command: kills; old file, new file; unfinished files left, after the next run");
    for (args, is_kept) in COMMANDS {
        let out = folder.join(args.iter().find(|word| word.starts_with("out")).expect("a file"));
        let begin = Instant::now();
        assert!(start(folder, args).wait().expect("it ends").success(), "{args:?}");
        let took = begin.elapsed();
        let new = fs::read(&out).expect("the file");
        let old = b"what was there before".as_slice();
        let ([mut olds, mut news], mut most) = ([0, 0], 0);
        for kill in 0..KILLS {
            fs::write(&out, old).expect("the old file");
            let mut child = start(folder, args);
            // Most kills are near the command's end, where it writes.
            std::thread::sleep(took * (40 + 70 * kill / KILLS) / 100 + Duration::from_millis(3));
            let _ = child.kill();
            child.wait().expect("it ends");
            let found = fs::read(&out).expect("the file");
            olds += u32::from(found == old);
            news += u32::from(found == new);
            most = most.max(hidden(folder, ".part"));
        }
        assert_eq!(olds + news, KILLS, "{args:?}");
        assert!(start(folder, args).wait().expect("it ends").success(), "{args:?}");
        assert_eq!(hidden(folder, ".new.part"), 0, "{args:?}");
        let left = hidden(folder, ".part");
        assert!(is_kept || left == 0, "{args:?}: {left}");
        println!("{}: {KILLS}; {olds}, {news}; {most}, {left}", args.join(" "));
    }
}
