use std::fs;
use std::io::Write as _;

use super::*;

#[test]
fn a_file_is_the_old_one_until_the_new_one_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.show");
    write(&file, "old").unwrap();
    let mut pending = Pending::begin(&file).unwrap();
    pending.write_all(b"half of the n").unwrap();
    assert_eq!(fs::read_to_string(&file).unwrap(), "old");
    drop(pending);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left beside it");
    write(&file, "new").unwrap();
    assert_eq!(fs::read_to_string(&file).unwrap(), "new");
    assert!(write(folder.path(), "no folder is a file").is_err());
}

#[cfg(unix)]
#[test]
fn links_stay_links_and_devices_devices() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("a"), "old").unwrap();
    std::os::unix::fs::symlink("a", at("b")).unwrap();
    write(&at("b"), "new").unwrap();
    assert_eq!(fs::read_to_string(at("a")).unwrap(), "new");
    assert!(at("b").is_symlink());
    write(Path::new("/dev/null"), "gone").unwrap();
    assert!(!fs::metadata("/dev/null").unwrap().is_file());
    assert!(write(Path::new("/dev/full"), "the disk is full").is_err());
}

#[test]
fn one_file_is_known_by_all_its_names() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("more")).unwrap();
    fs::write(at("a"), "").unwrap();
    fs::write(at("b"), "").unwrap();
    fs::hard_link(at("a"), at("more/c")).unwrap();
    assert!(same(&at("a"), &at("more/../a")) && same(&at("a"), &at("more/c")));
    assert!(!same(&at("a"), &at("b")) && !same(&at("a"), &at("none")));
    assert!(same(&at("more/../none"), &at("none")), "files that are to come, too");
    let refused = distinct(&[&at("more/c")], &[("clip", Some(&at("a")))]).unwrap_err().to_string();
    assert!(refused.contains("is the clip, which would be lost"), "{refused}");
    assert!(distinct(&[&at("a"), &at("more/c")], &[]).is_err());
}

/// Lists the names in a folder, without this program's own files.
fn listed(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<_> = names.filter(|name| !name.starts_with(".sinew")).collect();
    names.sort();
    names
}

#[test]
fn a_folder_has_the_results_of_one_run() {
    let place = tempfile::tempdir().unwrap();
    let place = place.path();
    fs::write(place.join("mine.txt"), "").unwrap();
    let run = |kind: &str, names: &[&str]| {
        let folder = Folder::open(place, kind, &[]).unwrap();
        for name in names {
            fs::write(folder.stage().join(name), kind).unwrap();
        }
        folder
    };
    run("mds", &["mds.txt"]).finish().unwrap();
    run("evaluate", &["table.txt", "ratios-x1.1.png"]).finish().unwrap();
    // A run that stops before its end changes nothing.
    drop(run("evaluate", &["table.txt", "other.png"]));
    assert_eq!(listed(place), ["mds.txt", "mine.txt", "ratios-x1.1.png", "table.txt"]);
    let files = run("evaluate", &["table.txt", "ratios-x1.png"]).finish().unwrap();
    assert_eq!(files, ["ratios-x1.png", "table.txt"].map(|name| place.join(name)));
    assert_eq!(listed(place), ["mds.txt", "mine.txt", "ratios-x1.png", "table.txt"]);
}

#[test]
fn two_runs_into_one_folder_and_results_over_inputs_are_refused() {
    let place = tempfile::tempdir().unwrap();
    let place = place.path();
    let first = Folder::open(place, "evaluate", &[]).unwrap();
    let busy = Folder::open(place, "mds", &[]).unwrap_err().to_string();
    assert!(busy.contains("another run writes into this folder"), "{busy}");
    drop(first);

    let input = place.join("result.csv");
    fs::write(&input, "a sweep").unwrap();
    let folder = Folder::open(place, "evaluate", &[("sweep", Some(&input))]).unwrap();
    fs::write(folder.stage().join("result.csv"), "results").unwrap();
    let refused = folder.finish().unwrap_err().to_string();
    assert!(refused.contains("is the sweep, and would be lost"), "{refused}");
    assert_eq!(fs::read_to_string(&input).unwrap(), "a sweep");
}

#[cfg(unix)]
#[test]
fn a_link_to_what_is_not_there_is_not_replaced() {
    let place = tempfile::tempdir().unwrap();
    let link = place.path().join("link");
    std::os::unix::fs::symlink("gone", &link).unwrap();
    let refused = format!("{:#}", write(&link, "text").unwrap_err());
    assert!(refused.contains("a link to a file that does not exist"), "{refused}");
    assert!(fs::symlink_metadata(&link).unwrap().file_type().is_symlink());
}

#[test]
fn what_dead_programs_left_is_removed_or_told() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for name in [
        ".a.77-0.new.part",
        ".a.77-1.part",
        ".a.b.77-0.new.part",
        ".a.notes.part",
        ".ab.7-0.new.part",
    ] {
        fs::write(at(name), "half").unwrap();
    }
    // A running program holds its lock.
    let alive = fs::File::create(at(".a.78-0.new.part")).unwrap();
    alive.try_lock().unwrap();
    write(&at("a"), "whole").unwrap();
    let left = [
        ".a.77-1.part",
        ".a.78-0.new.part",
        ".a.b.77-0.new.part",
        ".a.notes.part",
        ".ab.7-0.new.part",
        "a",
    ];
    assert_eq!(listed(folder.path()), left);
    assert_eq!(file::left_beside(&at("a")), [at(".a.77-1.part")]);

    let mut kept = Pending::begin_kept(&at("a")).unwrap();
    kept.write_all(b"half").unwrap();
    let name = format!(".a.{}-0.part", std::process::id());
    assert!(at(&name).exists() && file::left_beside(&at("a")).len() == 1);
    drop(kept);
    assert_eq!(fs::read(at(&name)).unwrap(), b"half");
    assert_eq!(file::left_beside(&at("a")).len(), 2);
}

#[cfg(unix)]
#[test]
fn a_file_keeps_its_permissions() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a");
    fs::write(&file, "old").unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
    write(&file, "new").unwrap();
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
}
