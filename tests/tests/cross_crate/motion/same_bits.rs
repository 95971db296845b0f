//! Conditions for the same bits on every machine: glam without SIMD, and a single module for elementary functions.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Returns the features that the whole workspace, host tools included, enables in the core's glam.
fn glam_features() -> BTreeSet<String> {
    let output = Command::new(env!("CARGO"))
        .current_dir(workspace())
        .args(["tree", "--locked", "--workspace", "--edges", "normal,build,dev"])
        .args([
            "--prefix",
            "none",
            "--format",
            "{p} {f}",
            "--invert",
            "glam@0.34.2",
            "--depth",
            "0",
        ])
        .output()
        .expect("cargo can be run");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("cargo prints text");
    text.lines()
        .filter_map(|line| line.strip_prefix("glam v0.34.2 "))
        .flat_map(|features| features.split(',').map(|feature| feature.trim().to_owned()))
        .collect()
}

#[test]
fn glam_has_no_simd_and_no_elementary_functions_of_the_platform() {
    let features = glam_features();
    for needed in ["libm", "scalar-math"] {
        assert!(features.contains(needed), "{needed} is off: {features:?}");
    }
    for forbidden in ["std", "default", "core-simd", "nostd-libm"] {
        assert!(!features.contains(forbidden), "{forbidden} is on: {features:?}");
    }
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).expect("the core's sources are there") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files.extend(rust_files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// Returns lines of code with their numbers, without comments and tests.
fn code(text: &str) -> Vec<(usize, &str)> {
    let lines: Vec<_> = text.lines().collect();
    // The test module is the last item of a file.
    let tests =
        lines.windows(2).position(|pair| pair[0] == "#[cfg(test)]" && pair[1].starts_with("mod "));
    let without_comment = |line| str::split("//", line);
    lines[..tests.unwrap_or(lines.len())]
        .iter()
        .enumerate()
        .map(|(index, line)| (index + 1, without_comment(line)))
        .collect()
}

/// A variant of `str::split_once` that returns the whole line if there is no separator.
mod str {
    pub(super) fn split<'a>(separator: &str, line: &'a str) -> &'a str {
        line.split_once(separator).map_or(line, |(before, _)| before)
    }
}

/// Elementary functions of f32 and of glam's types (which compute a root or an angle by themselves), and functions
/// that differ between machines.
const NOT_IN_CORE: [&str; 45] = [
    "f64",
    "mul_add",
    ".sqrt(",
    ".sin(",
    ".cos(",
    ".tan(",
    ".sin_cos(",
    ".asin(",
    ".acos(",
    ".atan(",
    ".atan2(",
    ".exp(",
    ".exp2(",
    ".ln(",
    ".log10(",
    ".powf(",
    ".powi(",
    ".cbrt(",
    ".hypot(",
    ".round(",
    ".floor(",
    ".ceil(",
    ".trunc(",
    ".fract(",
    ".rem_euclid(",
    ".length()",
    ".length_recip",
    ".distance(",
    ".normalize(",
    ".normalize_",
    ".try_normalize",
    ".angle_between",
    ".slerp(",
    ".lerp(",
    ".project_on",
    ".reject_from",
    ".rotate_towards",
    ".to_scaled_axis",
    ".to_axis_angle",
    ".to_euler",
    "from_scaled_axis",
    "from_axis_angle",
    "from_rotation_",
    "from_euler",
    "Affine3",
];

#[test]
fn elementary_functions_come_in_by_one_door() {
    let source = workspace().join("core/src");
    let files = rust_files(&source);
    assert!(files.len() > 10, "{files:?}");
    for file in files {
        let text = fs::read_to_string(&file).expect("a source file");
        let is_door = file == source.join("math.rs");
        for (number, line) in code(&text) {
            let found = NOT_IN_CORE.iter().find(|name| line.contains(**name));
            assert!(
                found.is_none(),
                "{}:{number}: {} in: {line}",
                file.display(),
                found.unwrap_or(&"")
            );
            let calls_libm = line.contains("libm");
            assert!(
                !calls_libm || is_door,
                "{}:{number}: only math.rs may call libm",
                file.display()
            );
        }
    }
}

#[test]
fn the_search_finds_what_it_looks_for() {
    let text = "let a = v.length(); // .sqrt(\n/// b.sqrt()\n#[cfg(test)]\nmod tests { f64 }";
    let code = code(text);
    assert_eq!(code.len(), 2);
    assert!(code[0].1.contains(".length()") && !code[0].1.contains(".sqrt("));
    assert!(!code[1].1.contains(".sqrt("));
}
