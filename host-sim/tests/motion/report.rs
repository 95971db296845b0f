//! The files of a report: complete, self-contained, and the same bytes every time.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::common::command;

/// Runs `sinew evaluate` on two seconds of the built-in clips, and returns the files that it writes, by name.
fn files(threads: &str) -> BTreeMap<String, Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    let output = command()
        .args(["evaluate", "--seconds", "2", "--playback", "kicks_02", "--threads", threads])
        .args([Path::new("--output"), folder.path()])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            (name, fs::read(path).unwrap())
        })
        .collect()
}

#[test]
fn the_same_command_writes_the_same_bytes_on_any_number_of_threads() {
    let once = files("1");
    assert_eq!(once, files("2"));

    let page = str::from_utf8(&once["index.html"]).unwrap();
    for table in 1..=4 {
        assert!(page.contains(&format!("<b>Table {table}.</b>")), "table {table}");
    }
    // Except for names of XML namespaces, the page has no address that could be fetched.
    let addresses = page.match_indices("http").filter(|(at, _)| {
        let rest = &page[*at..];
        !rest.starts_with("http://www.w3.org/2000/svg") && !rest.starts_with("http-equiv")
    });
    assert_eq!(addresses.count(), 0);
    for what in [" src=", "@import", "url(\"", "url('", "<iframe", "<object"] {
        assert!(!page.contains(what), "{what}");
    }

    let names: Vec<&str> = once.keys().map(String::as_str).collect();
    for picture in
        ["figure4", "front-x1.1", "course-x1", "course-x1.1", "joints-x1", "distribution-x1.1"]
    {
        for format in ["svg", "png"] {
            let name = format!("{picture}.{format}");
            assert!(names.contains(&name.as_str()), "{name} is not among {names:?}");
        }
    }

    // The animated picture is small enough for a README.
    let moving = str::from_utf8(&once["playback.svg"]).unwrap();
    assert!(moving.len() < 500_000, "{} bytes", moving.len());
    assert!(moving.contains("@keyframes") && moving.matches("moment still").count() == 1);
}

#[test]
fn an_unknown_clip_to_play_is_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let output = command()
        .args(["evaluate", "--playback", "kicks_99"])
        .args([Path::new("--output"), folder.path()])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(error.contains("--playback: expected one of punches_01"), "{error}");
    assert!(error.contains("found `kicks_99`"), "{error}");
}
