//! Tests of blending two clips into one.

use std::fs;

use sinew_figure::pipeline::{self, Settings};
use sinew_mocap::bvh;

use super::any_skeleton::creature;
use super::{clips, json};
use crate::common::{sinew_in, text};

#[test]
fn a_blend_is_a_file_that_is_read_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let names = clips(folder.path(), 2);
    let [a, b] = [0, 1].map(|clip| format!("clips/{}.bvh", names[clip]));
    let (a_part, b_part) = (format!("{a}@1.0s..1.4s"), format!("{b}@2s..2.4s"));
    let arguments =
        ["clip", "blend", &a_part, &b_part, "--output", "joined.bvh", "--picture", "joined.svg"];
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
    // Up to the blend the result is the first clip.
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

/// A blend that would leave almost nothing of a clip is refused, with a proposal of options. The proposed options work.
#[test]
fn a_blend_leaves_enough_of_both_clips() {
    let folder = tempfile::tempdir().expect("a folder");
    // The clip has a period of 1.05 s: among equally near places the earliest is used.
    bvh::write(&folder.path().join("a.bvh"), &creature(12, 0), 0.01).expect("a clip");
    let blend = |leave: &[&'static str]| {
        let all =
            [&["clip", "blend", "a.bvh", "a.bvh", "--output", "b.bvh", "--blend-s", "0.4"], leave];
        all.concat()
    };
    for (leave, left_s) in
        [(&[][..], 0.5), (&["--alone-s", "0.8"], 0.8), (&["--alone-s", "0"], 0.0)]
    {
        let (told, _) = json(folder.path(), &blend(leave));
        let time_s = |name: &str| told[name]["time_s"].as_f64().expect("a time");
        let end_s = 59.0 / 30.0;
        let (before_s, after_s) = (time_s("leaves_a"), end_s - time_s("middle_b") - 0.2);
        assert!(before_s >= left_s - 1e-9 && after_s >= left_s - 1e-9, "{told}");
        assert!(left_s > 0.0 || before_s < 0.1, "{told}");
    }
    let refused = sinew_in(folder.path(), &blend(&["--alone-s", "1.6"]));
    assert_eq!(refused.status.code(), Some(2));
    let told = text(&refused.stderr);
    let expected =
        "expected at least 2.000 s, the blend and 1.600 s of the clip alone, found 1.967 s";
    assert!(told.contains(expected), "{told}");
    assert!(told.contains("--alone-s 1.566 would do"), "{told}");
    let (_, _) = json(folder.path(), &blend(&["--alone-s", "1.566"]));
}
