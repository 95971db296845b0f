//! Files of many makers (`foreign/` of the data): the kind of each and the commands that read it, as in the page
//! `docs/foreign-files.md`; and files that were once misread without a message.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::common::{sinew, text};

fn data() -> PathBuf {
    PathBuf::from(std::env::var_os("SINEW_DATA").expect("SINEW_DATA names the folder of the data"))
}

/// Returns exit code and standard error of a command.
fn said(words: &[&str]) -> (Option<i32>, String) {
    let output = sinew(words);
    (output.status.code(), text(&output.stderr))
}

fn inspected(file: &Path) -> Value {
    let output = sinew(&["clip", "inspect", &file.display().to_string(), "--format", "json"]);
    let list: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    list[0].clone()
}

/// Returns the files below a folder, except descriptions of their origin.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut to_come = vec![folder.to_path_buf()];
    while let Some(folder) = to_come.pop() {
        for entry in fs::read_dir(&folder).expect("the data") {
            let path = entry.expect("the data").path();
            let is = |name: &str| path.extension().is_some_and(|extension| extension == name);
            if path.is_dir() {
                to_come.push(path);
            } else if !is("md") && !is("asf") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Returns, for each command to try: its label, and all arguments of `sinew` for this file.
fn tried(file: &str) -> [(&'static str, Vec<&str>); 5] {
    let query = |words: &[_]| words.to_vec();
    [
        ("weights", query(&["clip", "weights", file, "--method", "lengths"])),
        ("map", query(&["clip", "map", file])),
        (
            "evaluate",
            query(&["evaluate", "--clips", file, "--methods", "local", "--seconds", "0.2"]),
        ),
        ("find", query(&["clip", "find", file, "--like", file])),
        ("rig", query(&["rig", "import", file])),
    ]
}

fn page(folder: &Path) -> String {
    let mut page = String::from(
        "# Files of many makers\n\n\
         What `sinew clip inspect` says of each, and which commands read it as it is: without `--mapping`, `--up` or\n\
         `--metres-per-unit`. `evaluate` stands for `bake` and `sweep` too, which read clips in the same way. Below the\n\
         table is why others refuse a file. The files are not part of this repository; a test with `SINEW_DATA` makes this\n\
         page, and compares it (`INSTA_UPDATE=always` writes it).\n\n\
         | file | what | joints | frames | unit, m | up | height, m | read by |\n\
         | --- | --- | ---: | ---: | ---: | --- | ---: | --- |\n",
    );
    let mut refusals = String::from("\n## Why others refuse\n");
    for path in files(folder) {
        let (file, name) = (
            path.display().to_string(),
            path.strip_prefix(folder).expect("below").display().to_string(),
        );
        let it = inspected(&path);
        let mut readers = vec![];
        let mut refused: Vec<(String, Vec<&str>)> = Vec::new();
        for (command, words) in tried(&file) {
            let (code, said) = said(&words);
            if code == Some(0) {
                readers.push(command);
                continue;
            }
            let error =
                said.lines().find_map(|line| line.strip_prefix("error: ")).unwrap_or("no reason");
            let error = error.replace(&file, "it").replace(&folder.display().to_string(), "");
            match refused.iter_mut().find(|(reason, _)| *reason == error) {
                Some((_, commands)) => commands.push(command),
                None => refused.push((error, vec![command])),
            }
        }
        let number = |key: &str| it[key].as_f64().map_or("-".to_owned(), |x| short(x, key));
        let what = it["error"].as_str().map_or_else(
            || {
                format!(
                    "{}, {}",
                    it["kind"].as_str().unwrap_or("-"),
                    it["format"].as_str().unwrap_or("-")
                )
            },
            |_| "not read".to_owned(),
        );
        let _ = writeln!(
            page,
            "| {name} | {what} | {} | {} | {} | {} | {} | {} |",
            number("joints"),
            number("frames"),
            number("metres_per_unit"),
            it["up"].as_str().unwrap_or("-"),
            number("height_m"),
            readers.join(", "),
        );
        let _ = writeln!(refusals, "\n**{name}**");
        for (reason, commands) in refused {
            let _ = writeln!(
                refusals,
                "{}",
                wrapped(&format!("- {}: {}", commands.join(", "), escaped(&reason)))
            );
        }
    }
    page + &refusals
}

fn short(x: f64, key: &str) -> String {
    match key {
        "height_m" => format!("{x:.2}"),
        "metres_per_unit" => {
            format!("{x:.6}").trim_end_matches('0').trim_end_matches('.').to_owned()
        }
        _ => format!("{x}"),
    }
}

/// Escapes text for a Markdown table.
fn escaped(reason: &str) -> String {
    reason.chars().take(300).collect::<String>().replace('<', "\\<").replace('|', "\\|")
}

/// Wraps text at 118 characters.
fn wrapped(text: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("one");
        if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > 118 {
            lines.push(format!("  {word}"));
        } else {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines.join("\n")
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn the_page_tells_what_every_file_is() {
    let page = page(&data().join("foreign"));
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/foreign-files.md");
    if std::env::var_os("INSTA_UPDATE").is_some_and(|update| update == "always") {
        fs::write(&committed, &page).expect("the page is written");
    }
    let committed = fs::read_to_string(committed).unwrap_or_default();
    assert!(
        page == committed,
        "docs/foreign-files.md must be (INSTA_UPDATE=always writes it):\n{page}"
    );
}

/// The clip's z axis points up. Once the figure was read as lying down.
#[test]
#[ignore = "needs SINEW_DATA"]
fn a_clip_with_z_up_stands() {
    let file = data().join("foreign/bvh/ad_fair1_dab.bvh");
    let it = inspected(&file);
    assert_eq!(it["up"], "z", "{it}");
    let told = said(&["clip", "map", &file.display().to_string()]).1;
    assert!(told.contains("z is up"), "{told}");
}

/// Its `length` is 0.01, but its numbers are metres: by the rule for CMU's files the figure would be 4.5 cm tall.
#[test]
#[ignore = "needs SINEW_DATA"]
fn an_asf_in_metres_is_as_tall_as_a_person() {
    let it = inspected(&data().join("foreign/amc/zump/walking.amc"));
    let height_m = it["height_m"].as_f64().expect("a height");
    assert!((1.5..2.0).contains(&height_m), "{it}");
    assert_eq!(it["metres_per_unit"], 1.0, "{it}");
}

/// The file is an arm on a desk. Once it was read as 1.22 m tall, because its length was compared with a person's arms.
#[test]
#[ignore = "needs SINEW_DATA"]
fn a_robot_arm_has_no_persons_height() {
    let it = inspected(&data().join("foreign/urdf/so100.urdf"));
    let height_m = it["height_m"].as_f64().expect("a height");
    assert!((0.1..0.2).contains(&height_m), "{it}");
    assert_eq!(it["up"], "z", "{it}");
}

/// Once a bone 50 m long was used for weights without a message.
#[test]
#[ignore = "needs SINEW_DATA"]
fn a_fox_of_a_hundred_metres_is_refused_until_its_unit_is_told() {
    let fox = data().join("foreign/gltf/Fox.glb").display().to_string();
    let (code, told) = said(&["clip", "weights", &fox]);
    assert_eq!(code, Some(2), "{told}");
    assert!(told.contains("--metres-per-unit 0.01 for centimetres"), "{told}");
    let (code, told) = said(&["clip", "weights", &fox, "--metres-per-unit", "0.01"]);
    assert_eq!(code, Some(0), "{told}");
}

/// CMU's own skeletons in metres and in millimetres. With the unit that other files with this skeleton have, they would
/// be 7 cm and half a metre tall.
#[test]
#[ignore = "needs SINEW_DATA"]
fn a_known_skeleton_in_another_unit_keeps_its_height() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = fs::read_to_string(data().join("cmu/fight/14_01.bvh")).expect("a clip");
    let height_m = |factor: f64, name: &str| {
        let file = folder.path().join(name);
        fs::write(&file, scaled(&text, factor)).expect("a file");
        let it = inspected(&file);
        let (code, told) = said(&[
            "evaluate",
            "--clips",
            &file.display().to_string(),
            "--methods",
            "local",
            "--seconds",
            "0.2",
        ]);
        assert_eq!(code, Some(0), "{told}");
        it["height_m"].as_f64().expect("a height")
    };
    let own_m = height_m(1.0, "own.bvh");
    for (factor, name) in
        [(0.01, "metres.bvh"), (10.0, "millimetres.bvh"), (0.393_700_8, "inches.bvh")]
    {
        let found_m = height_m(factor, name);
        assert!((found_m / own_m - 1.0).abs() < 0.02, "{name}: {found_m} m for {own_m} m");
    }
}

/// Scales a BVH to another unit: its offsets, and the root's position in every frame.
fn scaled(text: &str, factor: f64) -> String {
    let (head, motion) = text.split_once("MOTION").expect("a motion");
    let number =
        |word: &str| word.parse::<f64>().map_or(word.to_owned(), |x| format!("{:.6}", factor * x));
    let offsets = head.lines().map(|line| match line.split_once("OFFSET") {
        Some((before, numbers)) => {
            let scaled: Vec<_> = numbers.split_whitespace().map(number).collect();
            format!("{before}OFFSET {}", scaled.join(" "))
        }
        None => line.to_owned(),
    });
    let frames = motion.lines().take(80).map(|line| {
        let words: Vec<_> = line.split_whitespace().collect();
        if words.first().is_none_or(|word| word.parse::<f64>().is_err()) {
            return line.to_owned();
        }
        let scaled = words
            .iter()
            .enumerate()
            .map(|(place, word)| if place < 3 { number(word) } else { (*word).to_owned() });
        scaled.collect::<Vec<_>>().join(" ")
    });
    let frames: Vec<_> = frames.collect();
    let rows = frames
        .iter()
        .filter(|line| line.starts_with(|c: char| c == '-' || c.is_ascii_digit()))
        .count();
    let frames = frames.iter().map(|line| {
        if line.trim_start().starts_with("Frames") {
            format!("Frames: {rows}")
        } else {
            line.clone()
        }
    });
    let lines: Vec<_> = offsets.chain(["MOTION".to_owned()]).chain(frames).collect();
    lines.join("\n")
}
