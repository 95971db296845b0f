//! Commands that are ended while they write: each file must be the old one or the new one, and the next run removes
//! unfinished files. Prints a table; `docs/hostile.md` has its sums.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use crate::common::{command, end_by};

/// Environment variable with the number of runs that each signal ends, for each command.
const KILLS: &str = "SINEW_KILLS";
const SIGNALS: [&str; 4] = ["-KILL", "-INT", "-TERM", "-HUP"];

/// Commands that write `out`, or that write nothing.
const COMMANDS: [&str; 18] = [
    "rig new --arm 40 -o out.toml --force",
    "rig import arm.toml -o out.toml --force",
    "rig view arm.toml -o out.html",
    "rig check arm.toml",
    "clip inspect clip.bvh",
    "clip map clip.bvh",
    "clip export kicks_01 --rig arm.toml -o out.csv",
    "clip blend clip.bvh clip.bvh --blend-s 0.1 --output out.bvh --picture out.svg",
    "clip find . --like clip.bvh@0.3s --picture out.svg",
    "clip weights clip.bvh --picture out.svg",
    "bake kicks_01 --rig arm.toml --fit -o out.show --html out.html",
    "play short.show --rig arm.toml --fast --record out.parquet",
    "record --rig arm.toml -o out.show",
    "report play.parquet --rig arm.toml -o out.html",
    "servo tap turn1 --rig arm.toml --target sim --inertia-kg-m2 0.0018 -o out.toml",
    "evaluate --clips clip.bvh --methods local --seconds 0.3 --output out",
    "evaluate sweep sweep.toml --clips clip.bvh --seconds 0.3 --output out",
    "evaluate robustness --clips clip.bvh --methods local --seconds 0.3 --rigs 4",
];
/// Content of an output file before a run.
const OLD: &[u8] = b"what was there before";
const SWEEP: &str = "setup.plant.kind = 'articulated'\n\n[[grid]]\ncontroller.method = ['local', 'world']\n\
    dimensions.scale = [0.9, 1.0, 1.1]\n";

type Files = BTreeMap<String, Vec<u8>>;

/// Returns all files below a folder, by their path.
fn files(folder: &Path) -> Files {
    let mut found = Files::new();
    for entry in fs::read_dir(folder).expect("the folder").map(|entry| entry.expect("it")) {
        let (name, path) = (entry.file_name().into_string().expect("UTF-8"), entry.path());
        if path.is_dir() {
            found.extend(files(&path).into_iter().map(|(at, text)| (format!("{name}/{at}"), text)));
        } else {
            found.insert(name, fs::read(path).expect("the file"));
        }
    }
    found
}

fn start(folder: &Path, args: &str) -> Child {
    let mut command = command();
    command.args(args.split(' ')).current_dir(folder).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().expect("the command starts")
}

#[track_caller]
fn done(folder: &Path, args: &str) {
    assert!(start(folder, args).wait().expect("it ends").success(), "{args}");
}

/// Writes files into a new folder.
fn folder_of(files: &Files) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in files {
        fs::write(folder.path().join(name), text).expect("a file");
    }
    folder
}

/// Returns whether a file is hidden: it is unfinished, in an unfinished folder, or the mark of a folder of results.
fn is_hidden(path: &str) -> bool {
    path.split('/').any(|name| name.starts_with('.'))
}

fn is_unfinished(path: &str) -> bool {
    path.split('/').any(|name| name.starts_with('.') && name != ".sinew")
}

/// Counts of runs by the files that they left.
#[derive(Default)]
struct Left {
    runs: usize,
    olds: usize,
    news: usize,
    /// Runs after which the folder of results had only some of the new files.
    parts: usize,
    /// Runs that left an unfinished, hidden file.
    unfinished: usize,
}

/// Starts a command several times, and ends each run by a signal. `inputs`: the files that it reads. Returns a row of
/// the table.
fn row(args: &str, inputs: &Files, signals: &[&str], times: u32) -> String {
    let folder = folder_of(inputs);
    let begin = Instant::now();
    done(folder.path(), args);
    let took = begin.elapsed();
    let mut new = files(folder.path());
    new.retain(|path, _| !inputs.contains_key(path) && !is_hidden(path));
    // A journal grows, and is read by the next run.
    let is_journal = |path: &str| path.ends_with("journal.jsonl");
    let mut left = Left::default();
    let mut again = folder_of(inputs);
    for (signal, index) in
        signals.iter().flat_map(|signal| vec![*signal; times as usize]).zip(0_u32..)
    {
        let folder = folder_of(inputs);
        // `tap` refuses a file that exists.
        let has_old = !args.starts_with("servo tap");
        for path in new.keys().filter(|path| has_old && !path.contains('/')) {
            fs::write(folder.path().join(path), OLD).expect("the old file");
        }
        let mut child = start(folder.path(), args);
        // Half of the runs are ended near their end, where they write.
        let place = (index * 37) % 100;
        let share = if index % 2 == 0 { place } else { 80 + place / 4 };
        std::thread::sleep(took * share / 100 + Duration::from_millis(3));
        end_by(&mut child, signal);
        let found = files(folder.path());
        let is_as = |path: &String, text: &[u8]| found.get(path).map(Vec::as_slice) == Some(text);
        let is_old = |path: &&String| found.get(*path).is_none_or(|text| text == OLD);
        let is_new = |path: &&String| is_as(path, &new[*path]);
        for (path, text) in inputs {
            assert!(is_as(path, text), "{args} {signal}: {path} was read");
        }
        let outs: Vec<&String> = new.keys().filter(|path| !is_journal(path)).collect();
        let [olds, news] = [
            outs.iter().filter(|path| is_old(path)).count(),
            outs.iter().filter(|path| is_new(path)).count(),
        ];
        assert_eq!(olds + news, outs.len(), "{args} {signal}: a file is damaged");
        let others =
            found.keys().filter(|path| !inputs.contains_key(*path) && !new.contains_key(*path));
        let (others, unknown): (Vec<&String>, _) = others.partition(|path| is_hidden(path));
        assert!(unknown.is_empty(), "{args} {signal}: {unknown:?}");
        let is_left = others.iter().any(|path| is_unfinished(path));
        left.runs += 1;
        left.unfinished += usize::from(is_left);
        left.olds += usize::from(news == 0);
        left.news += usize::from(olds == 0 && news > 0);
        left.parts += usize::from(olds > 0 && news > 0);
        if is_left || index == 0 && news == 0 {
            again = folder;
        }
    }
    // The next run does its work, and removes what the ended one left.
    done(again.path(), args);
    let found = files(again.path());
    for (path, text) in new.iter().filter(|(path, _)| !is_journal(path)) {
        assert!(found.get(path) == Some(text), "{args}: {path} after the next run");
    }
    let hidden = found.keys().filter(|path| is_unfinished(path)).count();
    let Left { runs, olds, news, parts, unfinished } = left;
    let name: Vec<&str> =
        args.split(' ').take_while(|word| !word.starts_with('-') && !word.contains('.')).collect();
    format!(
        "| `{}` | {runs} | {olds} | {news} | {parts} | {unfinished} | {hidden} |",
        name.join(" ")
    )
}

/// Returns the files that commands read.
fn inputs() -> Files {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    done(folder, "rig new --arm 3 -o arm.toml");
    let clip = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/attack/m21.bvh");
    fs::copy(clip, folder.join("clip.bvh")).expect("a copy");
    done(folder, "bake clip.bvh --rig arm.toml --fit --seconds 1 -o short.show");
    done(folder, "play short.show --rig arm.toml --fast --record play.parquet");
    fs::write(folder.join("sweep.toml"), SWEEP).expect("a file");
    files(folder)
}

#[cfg(unix)]
#[test]
fn a_command_that_is_killed_leaves_the_old_file_or_the_new_one() {
    let inputs = inputs();
    for args in ["rig view", "clip export", "play", "record"] {
        let args = COMMANDS.into_iter().find(|command| command.starts_with(args));
        println!("{}", row(args.expect("it is there"), &inputs, &["-KILL"], 2));
    }
}

/// Ends runs of all commands by all signals, which takes minutes.
#[cfg(unix)]
#[test]
fn each_ended_command_leaves_old_files_or_new_ones() {
    let inputs = inputs();
    let times = std::env::var(KILLS).map_or(1, |times| times.parse().expect("a number"));
    println!(
        "| command | ended | old files or none | all new | some new | with an unfinished file | after the next run |"
    );
    for args in COMMANDS {
        println!("{}", row(args, &inputs, &SIGNALS, times));
    }
}
