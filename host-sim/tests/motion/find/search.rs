//! Search with human figures, and messages for clips that cannot be searched or blended.

use std::fs;
use std::path::Path;

use super::{clips, json};
use crate::common::{sinew_in, text};

#[test]
fn a_moment_is_found_where_it_is_and_the_same_with_every_means() {
    let folder = tempfile::tempdir().expect("a folder");
    let names = clips(folder.path(), 3);
    // The query is a copy, so the clip itself counts.
    let query = folder.path().join("query.bvh");
    fs::copy(folder.path().join("clips").join(format!("{}.bvh", names[1])), query).expect("a copy");
    for (like, start_s, unit) in
        [("query.bvh@240", 2.0, "m"), ("query.bvh@2s", 2.0, "m"), ("query.bvh@2s..2.5s", 2.0, "m")]
    {
        for metric in ["line", "positions", "angles", "rotations"] {
            let arguments = [
                "clip",
                "find",
                "clips",
                "--like",
                like,
                "--metric",
                metric,
                "--check",
                "--weighted",
            ];
            let (found, told) = json(folder.path(), &arguments);
            assert!(told.contains("checked: the same moments"), "{told}");
            let first = &found["moments"][0];
            assert_eq!(first["clip"], names[1], "{like}, {metric}");
            assert!((first["time_s"].as_f64().unwrap() - start_s).abs() < 1e-6, "{first}");
            assert_eq!(first["frame"], 240);
            assert!(first["distance"].as_f64().unwrap() < 1e-3, "{first}");
            if metric == "line" {
                assert_eq!(found["unit"], unit);
                let computed = found["computed"].as_f64().unwrap();
                assert!(computed < 0.5 * found["distances"].as_f64().unwrap(), "{found}");
            }
            let moments = found["moments"].as_array().unwrap();
            assert_eq!(moments.len(), 10);
            for (k, a) in moments.iter().enumerate() {
                for b in &moments[..k] {
                    let apart_s = a["time_s"].as_f64().unwrap() - b["time_s"].as_f64().unwrap();
                    assert!(a["clip"] != b["clip"] || apart_s.abs() > 0.5 - 1e-6);
                    assert!(b["distance"].as_f64() <= a["distance"].as_f64());
                }
            }
        }
    }
    let one = sinew_in(
        folder.path(),
        &["clip", "find", "clips", "--like", "query.bvh@2s", "--threads", "1"],
    );
    let two = sinew_in(
        folder.path(),
        &["clip", "find", "clips", "--like", "query.bvh@2s", "--threads", "2"],
    );
    assert_eq!(text(&one.stdout), text(&two.stdout));
    assert!(
        text(&one.stdout)
            .starts_with("like the pose of query at 2.000 s, by line\n3 clips at 30 Hz")
    );
}

#[test]
fn where_the_query_is_from_does_not_count() {
    let folder = tempfile::tempdir().expect("a folder");
    let names = clips(folder.path(), 2);
    let like = format!("clips/{}.bvh@2s", names[0]);
    let (found, told) = json(folder.path(), &["clip", "find", "clips", "--like", &like]);
    assert!(told.contains(&format!("{}: the query's own place does not count", names[0])));
    for moment in found["moments"].as_array().unwrap() {
        let apart_s = (moment["time_s"].as_f64().unwrap() - 2.0).abs();
        assert!(moment["clip"] != names[0].as_str() || apart_s > 0.5 - 1e-6, "{moment}");
    }
    let csv = sinew_in(
        folder.path(),
        &["clip", "find", "clips", "--like", &like, "--format", "csv", "--count", "3"],
    );
    let csv = text(&csv.stdout);
    assert!(
        csv.starts_with("clip,file,time_s,frame,distance\n") && csv.lines().count() == 4,
        "{csv}"
    );
}

#[test]
fn other_skeletons_are_left_out_of_folders_and_refused_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let names = clips(folder.path(), 1);
    let file = |name: &str| folder.path().join("clips").join(name);
    let whole = fs::read_to_string(file(&format!("{}.bvh", names[0]))).expect("a file");
    fs::write(folder.path().join("query.bvh"), &whole).expect("a file");
    let hair = "JOINT hair\n{\nOFFSET 0 0.1 0\nCHANNELS 0\n}\nEnd Site";
    fs::write(file("hair.bvh"), whole.replacen("End Site", hair, 1)).expect("a file");
    fs::write(file("README.md"), "mine").expect("a file");
    let dog = format!("{{\"Frames\": [[{0}], [{0}]]}}", ["0.01"; 84].join(", "));
    fs::write(file("dog.txt"), dog).expect("a file");
    let (found, told) = json(folder.path(), &["clip", "find", "clips", "--like", "query.bvh@9"]);
    assert_eq!((&found["clips"], &found["left_out"]), (&1.into(), &3.into()));
    for why in
        ["joint `hair`: expected no joint", "README.md: neither its name", "of another character"]
    {
        let is_told = |line: &str| line.starts_with("left out: ") && line.contains(why);
        assert!(told.lines().any(is_told), "{why}: {told}");
    }
    let whole =
        ["evaluate", "--clips", "clips", "--seconds", "0.1", "--scale", "1", "--methods", "local"];
    let done = sinew_in(folder.path(), &whole);
    let said = text(&done.stderr);
    assert!(done.status.success() && said.contains("of another character"), "{said}");
    let strict = sinew_in(folder.path(), &[&whole[..], &["--strict"]].concat());
    assert_eq!(strict.status.code(), Some(2), "{}", text(&strict.stderr));
    let strict = ["clip", "find", "clips", "--like", "query.bvh@9", "--strict"];
    let strict = sinew_in(folder.path(), &strict);
    assert_eq!(strict.status.code(), Some(2), "{}", text(&strict.stderr));
    let refused =
        sinew_in(folder.path(), &["clip", "find", "clips/hair.bvh", "--like", "query.bvh@9"]);
    assert_eq!(refused.status.code(), Some(2));
    let why = "error: clips/hair.bvh: joint `hair`: expected no joint of that name";
    assert!(text(&refused.stderr).contains(why), "{}", text(&refused.stderr));
}

#[test]
fn damaged_files_are_left_out_of_folders() {
    let folder = tempfile::tempdir().expect("a folder");
    let names = clips(folder.path(), 2);
    let file = |name: &str| folder.path().join("clips").join(name);
    let [whole, other] =
        [0, 1].map(|clip| fs::read(file(&format!("{}.bvh", names[clip]))).expect("a file"));
    fs::write(folder.path().join("query.bvh"), &whole).expect("a file");
    fs::write(file("cut.bvh"), &whole[..whole.len() / 3]).expect("a file");
    fs::write(file("packed.bvh"), b"\x1f\x8b\x08\0\x99\xfe").expect("a file");
    let utf16 = text(&other).encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>();
    fs::write(file("wide.bvh"), [&b"\xff\xfe"[..], &utf16].concat()).expect("a file");
    let arm = sinew_in(folder.path(), &["rig", "new", "--arm", "6"]);
    fs::write(folder.path().join("arm.toml"), arm.stdout).expect("a file");
    let sweep = "[[grid]]\ncontroller.method = ['local']\n";
    fs::write(folder.path().join("sweep.toml"), sweep).expect("a file");
    let of = |words: &str| -> Vec<String> { words.split(' ').map(str::to_owned).collect() };
    for words in [
        "clip find clips --like query.bvh@9",
        "evaluate --clips clips --seconds 0.1 --scale 1 --methods local",
        "evaluate latency --clips clips --seconds 0.2 --rates-hz 500 --methods world",
        "evaluate robustness --clips clips --seconds 0.1 --rigs 1",
        "evaluate --rig arm.toml --clips clips --seconds 0.1 --methods local",
        "evaluate sweep sweep.toml --clips clips --seconds 0.1 --output swept",
    ] {
        let arguments = of(words);
        let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let done = sinew_in(folder.path(), &words);
        let said = text(&done.stderr);
        assert!(done.status.success(), "{words:?}: {said}");
        for (file, why) in
            [("cut.bvh", "expected"), ("packed.bvh", "found bytes that are not text")]
        {
            let is_told = |line: &str| {
                line.starts_with("left out: ") && line.contains(file) && line.contains(why)
            };
            assert!(said.lines().any(is_told), "{words:?}, {file}: {said}");
        }
        assert!(!said.contains("left out: clips/wide.bvh"), "{said}");
        let strict = sinew_in(folder.path(), &[&words[..], &["--strict"]].concat());
        let said = text(&strict.stderr);
        assert_eq!(strict.status.code(), Some(2), "{words:?}: {said}");
        assert!(said.contains("error: clips/cut.bvh"), "{words:?}: {said}");
    }
    // If no file can be used, the error is that of the first.
    for name in &names {
        fs::remove_file(file(&format!("{name}.bvh"))).expect("a file");
    }
    fs::remove_file(file("wide.bvh")).expect("a file");
    let none = sinew_in(folder.path(), &["clip", "find", "clips", "--like", "query.bvh@9"]);
    assert_eq!(none.status.code(), Some(2));
    assert!(text(&none.stderr).contains("error: clips/cut.bvh"), "{}", text(&none.stderr));
}

#[test]
fn pictures_are_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    let names = clips(folder.path(), 1);
    for (part, name) in [("@2s", "pose.svg"), ("@2s..2.4s", "clip.png")] {
        let like = format!("clips/{}.bvh{part}", names[0]);
        let output = sinew_in(
            folder.path(),
            &["clip", "find", "clips", "--like", &like, "--count", "3", "--picture", name],
        );
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(fs::metadata(folder.path().join(name)).expect("a picture").len() > 5000);
    }
    let svg = fs::read_to_string(folder.path().join("pose.svg")).expect("a picture");
    assert_eq!(svg.matches("class=\"stage\"").count(), 4);
}

#[test]
fn what_cannot_be_done_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let names = clips(folder.path(), 1);
    let file = format!("clips/{}.bvh", names[0]);
    let at = |part: &str| format!("{file}@{part}");
    let (bad, far, backwards, start) = (at("x"), at("999999"), at("20..10"), at("0.1s"));
    let pose = at("9");
    let own = format!("{file}@");
    for (arguments, told) in [
        (
            vec!["clip", "find", "clips", "--like", &bad],
            "expected FILE@FRAME (from 0), FILE@SECONDSs, FILE@FROM..TO",
        ),
        (vec!["clip", "find", "clips", "--like", &own], "after the last @"),
        (
            vec!["clip", "find", "clips", "--like", &far],
            "expected a place from frame 0 (0.000 s) to frame",
        ),
        (
            vec!["clip", "find", "clips", "--like", &backwards],
            "expected FROM before TO, found 20..10",
        ),
        (vec!["clip", "find", "--like", &pose], "CLIP"),
        (vec!["clip", "find", "no.bvh", "--like", &pose], "no.bvh: cannot be read"),
        (
            vec!["clip", "find", "clips", "--like", &pose, "--root", "tail"],
            "root tail: expected a joint of the skeleton",
        ),
        (
            vec!["clip", "find", "clips", "--like", &pose, "--rate-hz", "nan"],
            "expected a number of Hz from 1 to 1000",
        ),
        (vec!["clip", "find", "clips", "--like", &pose, "--count", "0"], "--count"),
        (
            vec!["clip", "find", "clips", "--like", &pose, "--apart-s", "-1"],
            "expected a number of seconds from 0",
        ),
        (
            vec!["clip", "find", "clips", "--like", &pose, "--steps", "5", "--metric", "angles"],
            "--steps: expected only with the metrics line and geodesic",
        ),
        (
            vec!["clip", "find", "clips", "--like", &pose, "--picture", "a.jpg"],
            "expected a picture named *.svg or *.png",
        ),
        (
            vec!["clip", "blend", &file, &file, "--output", "a.txt"],
            "--output a.txt: expected a file named *.bvh",
        ),
        (
            vec!["clip", "blend", &file, &file, "--output", "a.bvh", "--blend-s", "900"],
            "expected at least 900.500 s, the blend and 0.500 s of the clip alone",
        ),
        (
            vec!["clip", "blend", &file, &file, "--output", "a.bvh", "--alone-s", "-1"],
            "expected a number of seconds from 0",
        ),
        (
            vec!["clip", "blend", &start, &file, "--output", "a.bvh"],
            "expected a place at least 0.750 s from the clip's start and 0.250 s from its end",
        ),
        (
            vec!["clip", "blend", &file, &file, "--output", "no/a.bvh", "--blend-s", "0"],
            "expected a number of seconds above 0",
        ),
        (
            vec!["clip", "blend", &pose, &pose, "--output", "no/a.bvh", "--blend-s", "0.1"],
            "no/a.bvh: cannot be written: expected an existing folder",
        ),
    ] {
        let output = sinew_in(folder.path(), &arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(text(&output.stderr).contains(told), "{arguments:?}: {}", text(&output.stderr));
        assert!(output.stdout.is_empty(), "{arguments:?}");
    }
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn cmu_is_searched_exactly_and_mostly_spared() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = std::env::var_os("SINEW_DATA").expect("SINEW_DATA is set");
    let broad = Path::new(&data).join("cmu/broad-12hz");
    let of = |file: &str| broad.join(file).display().to_string();
    let folder_of_clips = broad.display().to_string();
    for (like, least) in [("05_05.bvh@5s", 0.95), ("05_10.bvh@4s..6s", 0.95)] {
        let like = of(like);
        let arguments =
            ["clip", "find", &folder_of_clips, "--like", &like, "--rate-hz", "12", "--check"];
        let (found, told) = json(folder.path(), &arguments);
        assert!(told.contains("checked: the same moments"), "{told}");
        // Clips with 31 joints are searched; the others have other skeletons.
        assert_eq!((&found["clips"], &found["left_out"]), (&175.into(), &81.into()));
        let computed = found["computed"].as_f64().unwrap();
        let spared = 1.0 - computed / found["distances"].as_f64().unwrap();
        assert!(spared > least, "{like}: {spared}");
    }
}
