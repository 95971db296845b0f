//! `sinew find` and `sinew blend` as commands: what they print, draw and write, and their exit codes.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use glam::{DQuat, DVec3};
use serde_json::Value;
use sinew_mocap::{Clip, JointSample, Skeleton, SkeletonJoint, bvh, gaps};
use sinew_sim::builtin;
use sinew_sim::pipeline::{self, Settings};

/// The first built-in clips as BVH files in the folder `clips`, and their names.
fn clips(folder: &Path, count: usize) -> Vec<String> {
    fs::create_dir_all(folder.join("clips")).expect("a folder to write to");
    builtin::clips()
        .into_iter()
        .take(count)
        .map(|clip| {
            let frame_time_s = clip.frame_time_s.expect("a rate");
            let (clip, _) = gaps::fill(clip, frame_time_s, 0.5).expect("short gaps");
            let file = folder.join("clips").join(format!("{}.bvh", clip.name));
            bvh::write(&file, &clip, 1.0).expect("a clip that can be written");
            clip.name
        })
        .collect()
}

fn sinew(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sinew"));
    command.current_dir(folder).args(arguments).output().expect("the command runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn json(folder: &Path, arguments: &[&str]) -> (Value, String) {
    let output = sinew(folder, &[arguments, &["--format", "json"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    (serde_json::from_slice(&output.stdout).expect("JSON"), text(&output.stderr))
}

#[test]
fn a_moment_is_found_where_it_is_and_the_same_with_every_means() {
    let folder = tempfile::tempdir().expect("a folder");
    let names = clips(folder.path(), 3);
    // The query is a copy: the clip itself counts.
    let query = folder.path().join("query.bvh");
    fs::copy(folder.path().join("clips").join(format!("{}.bvh", names[1])), query).expect("a copy");
    for (like, start_s, unit) in
        [("query.bvh@240", 2.0, "m"), ("query.bvh@2s", 2.0, "m"), ("query.bvh@2s..2.5s", 2.0, "m")]
    {
        for metric in ["line", "positions", "angles", "rotations"] {
            let arguments =
                ["find", "clips", "--like", like, "--metric", metric, "--check", "--weighted"];
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
    let one = sinew(folder.path(), &["find", "clips", "--like", "query.bvh@2s", "--threads", "1"]);
    let two = sinew(folder.path(), &["find", "clips", "--like", "query.bvh@2s", "--threads", "2"]);
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
    let (found, told) = json(folder.path(), &["find", "clips", "--like", &like]);
    assert!(told.contains(&format!("{}: where the query is from does not count", names[0])));
    for moment in found["moments"].as_array().unwrap() {
        let apart_s = (moment["time_s"].as_f64().unwrap() - 2.0).abs();
        assert!(moment["clip"] != names[0].as_str() || apart_s > 0.5 - 1e-6, "{moment}");
    }
    let csv = sinew(
        folder.path(),
        &["find", "clips", "--like", &like, "--format", "csv", "--count", "3"],
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
    let (found, told) = json(folder.path(), &["find", "clips", "--like", "query.bvh@9"]);
    assert_eq!((&found["clips"], &found["left_out"]), (&1.into(), &3.into()));
    for why in
        ["joint `hair`: expected no joint", "README.md: neither its name", "of another character"]
    {
        let is_told = |line: &str| line.starts_with("left out: ") && line.contains(why);
        assert!(told.lines().any(is_told), "{why}: {told}");
    }
    let whole =
        ["evaluate", "--clips", "clips", "--seconds", "0.1", "--scale", "1", "--methods", "local"];
    let done = sinew(folder.path(), &whole);
    let said = text(&done.stderr);
    assert!(done.status.success() && said.contains("of another character"), "{said}");
    let strict = sinew(folder.path(), &[&whole[..], &["--strict"]].concat());
    assert_eq!(strict.status.code(), Some(2), "{}", text(&strict.stderr));
    let strict = ["find", "clips", "--like", "query.bvh@9", "--strict"];
    let strict = sinew(folder.path(), &strict);
    assert_eq!(strict.status.code(), Some(2), "{}", text(&strict.stderr));
    let refused = sinew(folder.path(), &["find", "clips/hair.bvh", "--like", "query.bvh@9"]);
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
    let arm = sinew(folder.path(), &["rig", "new", "--arm", "6"]);
    fs::write(folder.path().join("arm.toml"), arm.stdout).expect("a file");
    let sweep = "[[grid]]\ncontroller.method = ['local']\n";
    fs::write(folder.path().join("sweep.toml"), sweep).expect("a file");
    let of = |words: &str| -> Vec<String> { words.split(' ').map(str::to_owned).collect() };
    for words in [
        "find clips --like query.bvh@9",
        "evaluate --clips clips --seconds 0.1 --scale 1 --methods local",
        "latency --clips clips --seconds 0.2 --rates 500 --methods world",
        "robustness --clips clips --seconds 0.1 --seeds 1",
        "evaluate --rig arm.toml --clips clips --seconds 0.1 --methods local",
        "sweep sweep.toml --clips clips --seconds 0.1 --out swept",
    ] {
        let arguments = of(words);
        let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let done = sinew(folder.path(), &words);
        let said = text(&done.stderr);
        assert!(done.status.success(), "{words:?}: {said}");
        for (file, why) in [("cut.bvh", "expected"), ("packed.bvh", "found bytes that are no text")]
        {
            let is_told = |line: &str| {
                line.starts_with("left out: ") && line.contains(file) && line.contains(why)
            };
            assert!(said.lines().any(is_told), "{words:?}, {file}: {said}");
        }
        assert!(!said.contains("left out: clips/wide.bvh"), "{said}");
        let strict = sinew(folder.path(), &[&words[..], &["--strict"]].concat());
        let said = text(&strict.stderr);
        assert_eq!(strict.status.code(), Some(2), "{words:?}: {said}");
        assert!(said.contains("error: clips/cut.bvh"), "{words:?}: {said}");
    }
    // Where nothing can be used, the first says why.
    for name in &names {
        fs::remove_file(file(&format!("{name}.bvh"))).expect("a file");
    }
    fs::remove_file(file("wide.bvh")).expect("a file");
    let none = sinew(folder.path(), &["find", "clips", "--like", "query.bvh@9"]);
    assert_eq!(none.status.code(), Some(2));
    assert!(text(&none.stderr).contains("error: clips/cut.bvh"), "{}", text(&none.stderr));
}

#[test]
fn a_blend_is_a_file_that_is_read_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let names = clips(folder.path(), 2);
    let [a, b] = [0, 1].map(|clip| format!("clips/{}.bvh", names[clip]));
    let (a_part, b_part) = (format!("{a}@1.0s..1.4s"), format!("{b}@2s..2.4s"));
    let arguments = ["blend", &a_part, &b_part, "--out", "joined.bvh", "--picture", "joined.svg"];
    let (told, _) = json(folder.path(), &arguments);
    let number = |name: &str| told[name].as_f64().unwrap();
    assert!(number("positions_m") <= number("geodesic_m"), "{told}");
    assert!(number("geodesic_m") <= number("line_m") * (1.0 + 1e-3), "{told}");
    assert!(number("solved") < number("pairs") && told["not_converged"] == 0, "{told}");
    assert!((1.0..=1.4).contains(&told["middle_a"]["time_s"].as_f64().unwrap()), "{told}");
    assert!((2.0..=2.4).contains(&told["middle_b"]["time_s"].as_f64().unwrap()), "{told}");
    assert!((number("blend_s") - 0.5).abs() < 1e-9);
    let read = |file: &str| {
        let path = folder.path().join(file);
        pipeline::load_clip(&sinew_mocap::files::ClipFile::new(&path), &Settings::default())
            .expect("a clip")
            .0
    };
    let (joined, first) = (read("joined.bvh"), read(&a));
    assert_eq!(joined.clip.frames.len() as u64, told["frames"].as_u64().unwrap());
    assert_eq!(
        (joined.clip.skeleton, joined.clip.frame_time_s.to_bits()),
        (first.clip.skeleton, first.clip.frame_time_s.to_bits())
    );
    // Up to the blend it is the first clip.
    let leaves = usize::try_from(told["leaves_a"]["frame"].as_u64().unwrap()).unwrap();
    for (joined, first) in
        joined.clip.frames[..=leaves].iter().flatten().zip(first.clip.frames.iter().flatten())
    {
        assert!(joined.position_m.distance(first.position_m) < 1e-6);
        assert!(joined.rotation.dot(first.rotation).abs() > 1.0 - 1e-12);
    }
    let picture = fs::read_to_string(folder.path().join("joined.svg")).expect("a picture");
    assert!(!picture.contains("NaN") && !picture.contains("inf") && !picture.contains("var("));
}

/// Where a blend would leave next to nothing of a clip it is not put, and what would do is told and does.
#[test]
fn a_blend_leaves_enough_of_both_clips() {
    let folder = tempfile::tempdir().expect("a folder");
    // A period of 1.05 s: of all places that are alike, the earliest is taken.
    bvh::write(&folder.path().join("a.bvh"), &creature(12, 0), 0.01).expect("a clip");
    let blend = |leave: &[&'static str]| {
        let all = [&["blend", "a.bvh", "a.bvh", "--out", "b.bvh", "--seconds", "0.4"], leave];
        all.concat()
    };
    for (leave, left_s) in [(&[][..], 0.5), (&["--leave", "0.8"], 0.8), (&["--leave", "0"], 0.0)] {
        let (told, _) = json(folder.path(), &blend(leave));
        let time_s = |name: &str| told[name]["time_s"].as_f64().expect("a time");
        let end_s = 59.0 / 30.0;
        let (before_s, after_s) = (time_s("leaves_a"), end_s - time_s("middle_b") - 0.2);
        assert!(before_s >= left_s - 1e-9 && after_s >= left_s - 1e-9, "{told}");
        assert!(left_s > 0.0 || before_s < 0.1, "{told}");
    }
    let refused = sinew(folder.path(), &blend(&["--leave", "1.6"]));
    assert_eq!(refused.status.code(), Some(2));
    let told = text(&refused.stderr);
    let expected =
        "expected at least 2.000 s, the blend and 1.600 s of the clip alone, found 1.967 s";
    assert!(told.contains(expected), "{told}");
    assert!(told.contains("--leave 1.566 would do"), "{told}");
    let (_, _) = json(folder.path(), &blend(&["--leave", "1.566"]));
}

#[test]
fn pictures_are_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    let names = clips(folder.path(), 1);
    for (part, name) in [("@2s", "pose.svg"), ("@2s..2.4s", "clip.png")] {
        let like = format!("clips/{}.bvh{part}", names[0]);
        let output = sinew(
            folder.path(),
            &["find", "clips", "--like", &like, "--count", "3", "--out", name],
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
            vec!["find", "clips", "--like", &bad],
            "expected FILE@FRAME (from 0), FILE@SECONDSs, FILE@FROM..TO",
        ),
        (vec!["find", "clips", "--like", &own], "after the last @"),
        (vec!["find", "clips", "--like", &far], "expected a place from frame 0 (0.000 s) to frame"),
        (vec!["find", "clips", "--like", &backwards], "expected FROM before TO, found 20..10"),
        (vec!["find", "--like", &pose], "CLIP"),
        (vec!["find", "no.bvh", "--like", &pose], "no.bvh: cannot be read"),
        (
            vec!["find", "clips", "--like", &pose, "--root", "tail"],
            "root tail: expected a joint of the skeleton",
        ),
        (
            vec!["find", "clips", "--like", &pose, "--rate", "nan"],
            "expected a number of Hz from 1 to 1000",
        ),
        (vec!["find", "clips", "--like", &pose, "--count", "0"], "--count"),
        (
            vec!["find", "clips", "--like", &pose, "--apart", "-1"],
            "expected a number of seconds from 0",
        ),
        (
            vec!["find", "clips", "--like", &pose, "--steps", "5", "--metric", "angles"],
            "--steps: expected with the metrics line and geodesic",
        ),
        (
            vec!["find", "clips", "--like", &pose, "--out", "a.jpg"],
            "expected a picture named *.svg or *.png",
        ),
        (vec!["blend", &file, &file, "--out", "a.txt"], "--out a.txt: expected a file named *.bvh"),
        (
            vec!["blend", &file, &file, "--out", "a.bvh", "--seconds", "900"],
            "expected at least 900.500 s, the blend and 0.500 s of the clip alone",
        ),
        (
            vec!["blend", &file, &file, "--out", "a.bvh", "--leave", "-1"],
            "expected a number of seconds from 0",
        ),
        (
            vec!["blend", &start, &file, "--out", "a.bvh"],
            "expected a place at least 0.750 s from the clip's start and 0.250 s from its end",
        ),
        (
            vec!["blend", &file, &file, "--out", "no/a.bvh", "--seconds", "0"],
            "expected a number of seconds above 0",
        ),
        (
            vec!["blend", &pose, &pose, "--out", "no/a.bvh", "--seconds", "0.1"],
            "--out no/a.bvh: expected a folder that is there",
        ),
    ] {
        let output = sinew(folder.path(), &arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(text(&output.stderr).contains(told), "{arguments:?}: {}", text(&output.stderr));
        assert!(output.stdout.is_empty(), "{arguments:?}");
    }
}

/// A creature of so many joints, each with two below it, that writhes; the last `still` of them do not.
fn creature(joints: usize, still: usize) -> Clip {
    let joint = |index: usize| SkeletonJoint {
        name: format!("feeler_{index}"),
        parent: index.checked_sub(1).map(|before| before / 2),
        offset_m: DVec3::new(0.1, 0.02 * (index % 2) as f64, 0.01 * (index % 5) as f64),
        end_sites_m: Vec::new(),
    };
    let skeleton = Skeleton { joints: (0..joints).map(joint).collect() };
    let sample = |frame: usize, index: usize| JointSample {
        rotation: if index < joints - still {
            DQuat::from_rotation_z(0.3 * libm::sin(0.2 * frame as f64 + index as f64))
        } else {
            DQuat::from_rotation_x(0.1)
        },
        position_m: skeleton.joints[index].offset_m,
    };
    let frames = (0..60).map(|frame| (0..joints).map(|index| sample(frame, index)).collect());
    Clip {
        name: "creature".into(),
        frames: frames.collect(),
        skeleton: skeleton.clone(),
        frame_time_s: 1.0 / 30.0,
    }
}

#[test]
fn any_skeleton_is_searched_and_blended() {
    let folder = tempfile::tempdir().expect("a folder");
    for (joints, still) in [(12, 0), (200, 0), (300, 100)] {
        bvh::write(&folder.path().join("a.bvh"), &creature(joints, still), 0.01).expect("a clip");
        let arguments = ["find", "a.bvh", "--like", "a.bvh@20", "--check", "--apart", "0.2"];
        for metric in ["positions", "line"] {
            let (found, told) =
                json(folder.path(), &[&arguments[..], &["--metric", metric]].concat());
            assert!(told.contains("checked: the same moments"), "{told}");
            // All joints swing 0.2 rad a frame: a period of 31.4 frames.
            assert_eq!(found["moments"][0]["frame"], 51, "{found}");
        }
    }
    let blend =
        ["blend", "a.bvh@15", "a.bvh@40", "--out", "b.bvh", "--seconds", "0.2", "--leave", "0"];
    bvh::write(&folder.path().join("a.bvh"), &creature(40, 10), 0.01).expect("a clip");
    let (blended, _) = json(folder.path(), &blend);
    assert!(blended["geodesic_m"].as_f64().is_some_and(|length_m| length_m > 0.0), "{blended}");
    let read = bvh::read(&folder.path().join("b.bvh")).expect("a clip");
    assert_eq!(read.skeleton.joints.len(), 40);
    let drawn = sinew(folder.path(), &[&blend[..], &["--picture", "b.svg"]].concat());
    assert!(
        text(&drawn.stderr).contains("expected a human, which alone is drawn"),
        "{}",
        text(&drawn.stderr)
    );
    bvh::write(&folder.path().join("a.bvh"), &creature(300, 20), 0.01).expect("a clip");
    let refused = sinew(folder.path(), &["find", "a.bvh", "--like", "a.bvh@20"]);
    let told = text(&refused.stderr);
    assert!(told.contains("expected at most 256 joints that move, found 2"), "{told}");
}

/// A dog that trots, with the names that capture software gives its joints: those of a human, and a tail.
fn dog() -> Clip {
    const JOINTS: [(&str, &str, [f64; 3]); 23] = [
        ("Hips", "", [0.0, 0.45, 0.0]),
        ("Spine", "Hips", [0.0, 0.02, 0.15]),
        ("Spine1", "Spine", [0.0, 0.02, 0.2]),
        ("Neck", "Spine1", [0.0, 0.08, 0.12]),
        ("Head", "Neck", [0.0, 0.1, 0.12]),
        ("LeftShoulder", "Spine1", [0.05, 0.03, 0.05]),
        ("LeftArm", "LeftShoulder", [0.03, -0.08, 0.03]),
        ("LeftForeArm", "LeftArm", [0.0, -0.16, -0.03]),
        ("LeftHand", "LeftForeArm", [0.0, -0.2, 0.0]),
        ("RightShoulder", "Spine1", [-0.05, 0.03, 0.05]),
        ("RightArm", "RightShoulder", [-0.03, -0.08, 0.03]),
        ("RightForeArm", "RightArm", [0.0, -0.16, -0.03]),
        ("RightHand", "RightForeArm", [0.0, -0.2, 0.0]),
        ("LeftUpLeg", "Hips", [0.06, -0.03, -0.05]),
        ("LeftLeg", "LeftUpLeg", [0.0, -0.18, 0.04]),
        ("LeftFoot", "LeftLeg", [0.0, -0.17, -0.06]),
        ("RightUpLeg", "Hips", [-0.06, -0.03, -0.05]),
        ("RightLeg", "RightUpLeg", [0.0, -0.18, 0.04]),
        ("RightFoot", "RightLeg", [0.0, -0.17, -0.06]),
        ("Tail", "Hips", [0.0, 0.03, -0.1]),
        ("Tail1", "Tail", [0.0, 0.0, -0.12]),
        ("Tail2", "Tail1", [0.0, 0.0, -0.12]),
        ("Tail3", "Tail2", [0.0, 0.0, -0.12]),
    ];
    let joint = |(name, parent, offset_m): &(&str, &str, [f64; 3])| SkeletonJoint {
        name: (*name).into(),
        parent: JOINTS.iter().position(|(other, ..)| other == parent),
        offset_m: DVec3::from_array(*offset_m),
        end_sites_m: if matches!(*name, "Head" | "Tail3") {
            vec![DVec3::new(0.0, 0.0, 0.1)]
        } else {
            Vec::new()
        },
    };
    let skeleton = Skeleton { joints: JOINTS.iter().map(joint).collect() };
    // A stride takes 20 frames; legs across from each other go together.
    let sample = |frame: usize, index: usize| {
        let name = JOINTS[index].0;
        let phase = core::f64::consts::TAU * frame as f64 / 20.0;
        let across = matches!(name, "LeftArm" | "LeftForeArm" | "RightUpLeg" | "RightLeg");
        let swing = libm::sin(if across { phase } else { phase + core::f64::consts::PI });
        let rotation = match name {
            "Tail" | "Tail1" | "Tail2" | "Tail3" => DQuat::from_rotation_y(0.2 * swing),
            "Hips" => DQuat::from_rotation_y(0.03 * swing),
            _ if name.contains("Arm") || name.contains("Leg") => {
                DQuat::from_rotation_x(0.4 * swing)
            }
            _ => DQuat::from_rotation_x(0.05 * libm::cos(phase)),
        };
        let ahead_m = if index == 0 { 0.04 * frame as f64 } else { 0.0 };
        let position_m = skeleton.joints[index].offset_m + DVec3::Z * ahead_m;
        JointSample { rotation, position_m }
    };
    let frames = (0..90).map(|frame| (0..JOINTS.len()).map(|index| sample(frame, index)).collect());
    Clip {
        name: "dog".into(),
        frames: frames.collect(),
        frame_time_s: 1.0 / 30.0,
        skeleton: skeleton.clone(),
    }
}

#[test]
fn a_quadruped_is_searched_and_blended() {
    let folder = tempfile::tempdir().expect("a folder");
    bvh::write(&folder.path().join("dog.bvh"), &dog(), 0.01).expect("a clip");
    for metric in ["positions", "line", "angles", "rotations"] {
        let arguments = ["find", "dog.bvh", "--like", "dog.bvh@33", "--check", "--metric", metric];
        let (found, told) = json(folder.path(), &arguments);
        assert!(told.contains("checked: the same moments"), "{told}");
        // A stride before or after.
        let frame = found["moments"][0]["frame"].as_u64().expect("a frame");
        assert!([13, 53, 73].contains(&frame), "{metric}: {found}");
        assert!(found["moments"][0]["distance"].as_f64().unwrap() < 1e-3, "{found}");
    }
    let blend = ["blend", "dog.bvh@20..30", "dog.bvh@52..58", "--out", "b.bvh", "--seconds", "0.4"];
    let (blended, _) = json(folder.path(), &blend);
    let number = |name: &str| blended[name].as_f64().expect("a number");
    assert_eq!(blended["not_converged"], 0, "{blended}");
    // The places have other phases of the stride: there is a way to go.
    assert!(number("geodesic_m") > 0.01, "{blended}");
    assert!(number("positions_m") <= number("geodesic_m"), "{blended}");
    assert!(number("geodesic_m") <= number("line_m") * (1.0 + 1e-3), "{blended}");
    let read = bvh::read(&folder.path().join("b.bvh")).expect("a clip");
    assert_eq!(read.skeleton.joints.len(), 23);
}

/// A chain of so many joints, all of which swing.
fn chain(joints: usize) -> Clip {
    let joint = |index: usize| SkeletonJoint {
        name: format!("link_{index}"),
        parent: index.checked_sub(1),
        offset_m: DVec3::Y * 0.02,
        end_sites_m: Vec::new(),
    };
    let skeleton = Skeleton { joints: (0..joints).map(joint).collect() };
    let sample = |frame: usize, index: usize| JointSample {
        rotation: DQuat::from_rotation_z(
            0.05 * libm::sin(core::f64::consts::TAU * frame as f64 / 30.0 + 0.3 * index as f64),
        ),
        position_m: skeleton.joints[index].offset_m,
    };
    let frames = (0..60).map(|frame| (0..joints).map(|index| sample(frame, index)).collect());
    Clip {
        name: "chain".into(),
        frames: frames.collect(),
        skeleton: skeleton.clone(),
        frame_time_s: 1.0 / 30.0,
    }
}

#[test]
fn a_chain_of_256_joints_is_searched_and_one_of_257_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    bvh::write(&folder.path().join("a.bvh"), &chain(256), 0.01).expect("a clip");
    for metric in ["positions", "line"] {
        let arguments = [
            "find", "a.bvh", "--like", "a.bvh@20", "--check", "--apart", "0.2", "--metric", metric,
        ];
        let (found, told) = json(folder.path(), &arguments);
        assert!(told.contains("checked: the same moments"), "{told}");
        // All joints swing once in 30 frames.
        assert_eq!(found["moments"][0]["frame"], 50, "{found}");
    }
    bvh::write(&folder.path().join("a.bvh"), &chain(257), 0.01).expect("a clip");
    let blend =
        ["blend", "a.bvh@15", "a.bvh@40", "--out", "b.bvh", "--seconds", "0.2", "--leave", "0"];
    for arguments in [&["find", "a.bvh", "--like", "a.bvh@20"][..], &blend] {
        let refused = sinew(folder.path(), arguments);
        let told = text(&refused.stderr);
        assert_eq!(refused.status.code(), Some(2), "{told}");
        assert!(told.contains("a.bvh: expected at most 256 joints that move, found 257"), "{told}");
    }
    assert!(!folder.path().join("b.bvh").exists());
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn a_face_of_163_joints_is_searched_and_blended() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = std::env::var_os("SINEW_DATA").expect("SINEW_DATA is set");
    let face = Path::new(&data).join("foreign/bvh/makehuman_face.bvh").display().to_string();
    let like = format!("{face}@20");
    for metric in ["positions", "line"] {
        let (found, told) =
            json(folder.path(), &["find", &face, "--like", &like, "--check", "--metric", metric]);
        assert!(told.contains("checked: the same moments"), "{told}");
        assert!(found["moments"].as_array().is_some_and(|moments| !moments.is_empty()), "{found}");
    }
    let (from, to) = (format!("{face}@20"), format!("{face}@40"));
    let (blended, _) =
        json(folder.path(), &["blend", &from, &to, "--out", "face.bvh", "--seconds", "0.3"]);
    assert_eq!(blended["not_converged"], 0, "{blended}");
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
        let arguments = ["find", &folder_of_clips, "--like", &like, "--rate", "12", "--check"];
        let (found, told) = json(folder.path(), &arguments);
        assert!(told.contains("checked: the same moments"), "{told}");
        // The files of 31 joints; the others are of other skeletons.
        assert_eq!((&found["clips"], &found["left_out"]), (&175.into(), &81.into()));
        let computed = found["computed"].as_f64().unwrap();
        let spared = 1.0 - computed / found["distances"].as_f64().unwrap();
        assert!(spared > least, "{like}: {spared}");
    }
}
