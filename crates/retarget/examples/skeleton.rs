//! Prints the landmark that each joint of each file's skeleton is matched to.
//!
//! `cargo run -p sinew-retarget --example skeleton -- [--map] FILE..`; `--map` prints a map onto the figure.

use std::path::Path;
use std::process::ExitCode;

use sinew_mocap::{Recording, format, gaps};
use sinew_retarget::skeleton::{MapHead, SkeletonMatch, figure_mapping, head_end};

fn main() -> ExitCode {
    let mut failed = false;
    let as_map = std::env::args_os().any(|argument| argument == "--map");
    for file in std::env::args_os().skip(1).filter(|argument| argument != "--map") {
        let file = Path::new(&file);
        match format::read(file) {
            Ok(recording) => print(file, recording, as_map),
            Err(error) => {
                failed = true;
                eprintln!("{error}");
            }
        }
    }
    if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

fn print(file: &Path, recording: Recording, as_map: bool) {
    let skeleton = recording.skeleton.clone();
    let told = recording.metres_per_unit;
    // The rate does not matter, because only poses are used, not speeds.
    let matched = match gaps::fill(recording, 0.01, 1e9) {
        Ok((clip, _)) => SkeletonMatch::of_clip(&clip),
        Err(_) => SkeletonMatch::new(&skeleton, &[]),
    };
    if as_map {
        let guess = matched.unit.as_ref().and_then(|unit| unit.metres_per_unit);
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        let metres_per_unit = told.or(guess).unwrap_or(1.0);
        let head = MapHead { name: &name, metres_per_unit, rate_hz: None };
        match figure_mapping(&skeleton, &matched, head) {
            Ok(proposed) => print!("{}", proposed.to_toml()),
            Err(error) => eprintln!("{}: {error}", file.display()),
        }
        return;
    }
    println!("{}: {} joints", file.display(), skeleton.joints.len());
    for (landmark, found) in matched.found() {
        let joint = &skeleton.joints[found.joint].name;
        println!("  {:<11} {joint:<28} {:.2}  {}", landmark.name(), found.confidence, found.reason);
    }
    for (landmark, reason) in matched.missing() {
        println!("  {:<11} {:<28}       {reason}", landmark.name(), "-");
    }
    if let Some((end, remark)) = head_end(&skeleton, &matched) {
        println!(
            "  head's end  {end:?}{}",
            remark.map_or(String::new(), |remark| format!(" ({remark})"))
        );
    }
    if let Some(unit) = &matched.unit {
        let told = told.map_or(String::new(), |metres| format!(" (the file states {metres} m)"));
        println!("  unit        {}{told}", unit.reason);
    }
    if let Some(up) = &matched.up {
        println!("  up          {}", up.reason);
    }
    if let Some(at) = &matched.directions {
        let place = at.frame.map_or("the rest pose".to_owned(), |frame| format!("frame {frame}"));
        println!(
            "  forward     {:.2} in {place}, left {:.2}, up {:.2}",
            at.forward, at.left, at.up
        );
    }
    for finding in &matched.findings {
        println!("  note        {finding}");
    }
}
