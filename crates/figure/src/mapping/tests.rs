use glam::{DQuat, DVec3};
use sinew_mocap::skeleton_map::End;
use sinew_mocap::{Clip, JointSample, Skeleton, SkeletonJoint};

use super::*;
use crate::body::{BODIES, Body};

/// Returns a chain of joints, each 1 m above its parent, with an end site 0.5 m above its top.
fn chain(names: &[&str]) -> Skeleton {
    let joint = |(i, name): (usize, &&str)| SkeletonJoint {
        name: (*name).to_owned(),
        parent: i.checked_sub(1),
        offset_m: if i == 0 { DVec3::ZERO } else { DVec3::Y },
        end_sites_m: if i + 1 == names.len() { vec![0.5 * DVec3::Y] } else { Vec::new() },
    };
    Skeleton { joints: names.iter().enumerate().map(joint).collect() }
}

/// Returns TOML of a mapping in which every body has joint `joint` and ends at `end`.
fn file(joint: &str, end: &str) -> String {
    let body = |Body { name, .. }: &Body| {
        format!("{name} = {{ origin = '{joint}', rotation = '{joint}', end = {end} }}")
    };
    let bodies = BODIES.iter().map(body).collect::<Vec<_>>().join("\n");
    format!("name = 'test'\nmetres_per_unit = 1\n[signature]\njoints = []\n[body]\n{bodies}")
}

fn message(file: &str) -> String {
    Mapping::parse(file).unwrap_err().to_string()
}

#[test]
fn knows_skeletons_by_different_names() {
    let names: Vec<&str> =
        known_skeletons().iter().map(|known| known.mapping.name.as_str()).collect();
    let expected = [
        "sinew",
        "cgspeed_mb",
        "cgspeed_mb_asf",
        "asfamc",
        "cmu_asf",
        "cgspeed_daz",
        "m21",
        "bandai",
        "geno",
        "deepmimic",
        "mixamo",
        "mixamo_body",
        "lafan1",
        "xsens_mvn",
        "xsens_bvh",
        "axis_neuron",
        "rokoko",
        "mocopi",
        "makehuman",
        "makehuman_walks",
        "second_life",
    ];
    assert_eq!(names, expected);
    for KnownSkeleton { about, mapping } in known_skeletons() {
        let fits = about.len() > 10 && about.len() < 100 && about.ends_with('.');
        assert!(fits, "{}: {about:?}", mapping.name);
    }
}

/// A skeleton with all joints of a map, and the additional ones of its makers' files, is recognized after any
/// prefix.
#[test]
fn known_skeletons_are_known_behind_any_prefix() {
    for KnownSkeleton { mapping, .. } in known_skeletons() {
        let signature = &mapping.signature;
        for prefix in ["", "mixamorig7:", "mixamorig", "Armature|Actor_"] {
            let mut names: Vec<String> = Vec::new();
            let parts = mapping.parts.iter().flat_map(|part| {
                let end = match &part.end {
                    End::Joint(end) | End::Site { site: end } | End::Beyond { beyond: end, .. } => {
                        end
                    }
                };
                [&part.origin, &part.rotation, end]
            });
            let all = signature.joints.iter().chain(&signature.zero_offsets);
            for name in all.chain(&signature.nonzero_offsets).chain(parts) {
                let name = format!("{prefix}{name}");
                if !names.contains(&name) {
                    names.push(name);
                }
            }
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let mut skeleton = chain(&names);
            for joint in &signature.zero_offsets {
                let joint = skeleton.find(&format!("{prefix}{joint}")).unwrap();
                skeleton.joints[joint].offset_m = DVec3::ZERO;
            }
            let known =
                choose(&skeleton).unwrap_or_else(|error| panic!("{}: {error}", mapping.name));
            assert_eq!(known.name, mapping.name, "{prefix}");
        }
    }
}

#[test]
fn a_known_map_is_named() {
    let named = |name: &str| Mapping::named(std::path::Path::new(name));
    assert_eq!(named("mixamo").unwrap().name, "mixamo");
    let error = named("miximo").unwrap_err().to_string();
    assert!(
        error.starts_with("miximo: no such file, and no known skeleton of that name"),
        "{error}"
    );
    assert!(error.ends_with("second_life"), "{error}");
}

#[test]
fn maps_the_built_in_skeleton_on_itself() {
    let clip = &crate::builtin::clips()[0];
    let mapping = choose(&clip.skeleton).unwrap();
    assert_eq!(mapping.name, "sinew");
    let binding = Binding::new(mapping, &clip.skeleton).unwrap();
    for (i, joint) in clip.skeleton.joints.iter().enumerate() {
        assert_eq!(joint.name, BODIES[i].name);
        if i > 0 {
            assert!((binding.offset_m[i] - joint.offset_m).length() < 1e-15);
        }
        if let Some(end_m) = joint.end_sites_m.first() {
            assert!((binding.segment_end_m[i] - *end_m).length() < 1e-15);
        }
    }
}

#[test]
fn names_joints_and_mappings_when_none_matches() {
    assert_eq!(
        choose(&chain(&["a", "b"])).unwrap_err().to_string(),
        "no known skeleton has the joints a, b (tried: sinew, cgspeed_mb, cgspeed_mb_asf, asfamc, cmu_asf, \
         cgspeed_daz, m21, bandai, geno, deepmimic, mixamo, mixamo_body, lafan1, xsens_mvn, xsens_bvh, axis_neuron, \
         rokoko, mocopi, makehuman, makehuman_walks, second_life). Write a mapping, starting from the output of `sinew \
         clip map`, and give it with --mapping"
    );
}

#[test]
fn names_the_nearest_mapping_and_what_it_lacks() {
    let of = |name: &str| {
        &known_skeletons().iter().find(|known| known.mapping.name == name).unwrap().mapping
    };
    let mut names: Vec<&str> = of("geno")
        .signature
        .joints
        .iter()
        .map(String::as_str)
        .filter(|name| *name != "Neck1")
        .collect();
    let joints: Vec<String> = (0..60).map(|k| format!("finger_{k}")).collect();
    names.extend(joints.iter().map(String::as_str));
    let error = choose(&chain(&names)).unwrap_err().to_string();
    assert!(error.contains(" The nearest is `geno`: the clip lacks its Neck1. "), "{error}");
    assert!(error.contains("finger_29 and 30 more (tried"), "{error}");
    let prefixed: Vec<String> = names.iter().map(|name| format!("rig7:{name}")).collect();
    let prefixed: Vec<&str> = prefixed.iter().map(String::as_str).collect();
    let (mapping, lacking) = find_nearest(&chain(&prefixed)).unwrap();
    assert_eq!((mapping.name.as_str(), lacking), ("geno", vec!["Neck1"]));
    let names: Vec<&str> = of("bandai").signature.joints.iter().map(String::as_str).collect();
    assert_eq!(choose(&chain(&names)).unwrap().name, "bandai");
    // The skeleton has all names of cgspeed_mb, but a zero offset of that map is not zero here. It has no thorax
    // bone, and therefore is not asfamc either.
    let zero = of("cgspeed_mb");
    let mut skeleton =
        chain(&zero.signature.joints.iter().chain(&zero.signature.zero_offsets).fold(
            Vec::new(),
            |mut names, name| {
                if !names.contains(&name.as_str()) {
                    names.push(name.as_str());
                }
                names
            },
        ));
    let neck = skeleton.find("Neck").unwrap();
    skeleton.joints[neck].offset_m = DVec3::ZERO;
    let error = choose(&skeleton).unwrap_err().to_string();
    assert!(error.contains("all of its joints are there, but other offsets are zero"), "{error}");
}

#[test]
fn refuses_a_body_that_does_not_move_with_its_parent() {
    // b and c are both children of a.
    let mut skeleton = chain(&["a", "b", "c"]);
    skeleton.joints[2].parent = Some(0);
    let good = file("b", "'b'");
    assert!(Binding::new(&Mapping::parse(&good).unwrap(), &skeleton).is_ok());
    let foot = "foot_l = { origin = 'b', rotation = 'b'";
    for (key, wrong) in [
        ("origin", "foot_l = { origin = 'c', rotation = 'b'"),
        ("rotation", "foot_l = { origin = 'b', rotation = 'c'"),
    ] {
        let mapping = Mapping::parse(&good.replace(foot, wrong)).unwrap();
        assert_eq!(
            Binding::new(&mapping, &skeleton).unwrap_err().to_string(),
            format!(
                "mapping `test`: body `foot_l`, {key}: expected a joint that moves with `b`, whose frame \
                 its parent `shank_l` has; found `c`, which does not"
            )
        );
    }
}

#[test]
fn tells_skeletons_of_the_same_names_apart_by_their_offsets() {
    let of = |name: &str| {
        &known_skeletons().iter().find(|known| known.mapping.name == name).unwrap().mapping
    };
    let (zero, nonzero) = (of("cgspeed_mb"), of("asfamc"));
    let mut names: Vec<&str> = zero.signature.joints.iter().map(String::as_str).collect();
    names.extend(["LeftShoulder", "RightShoulder"]);
    let mut skeleton = chain(&names);
    assert_eq!(choose(&skeleton).unwrap().name, nonzero.name);
    for joint in &zero.signature.zero_offsets {
        let joint = skeleton.find(joint).unwrap();
        skeleton.joints[joint].offset_m = DVec3::ZERO;
    }
    assert_eq!(choose(&skeleton).unwrap().name, zero.name);
}

#[test]
fn finds_segment_ends_at_joints_sites_and_beyond() {
    let skeleton = chain(&["a", "b", "c"]);
    for (end, height_m) in
        [("'c'", 1.0), ("{ site = 'c' }", 1.5), ("{ beyond = 'c', ratio = 0.25 }", 1.25)]
    {
        let mapping = Mapping::parse(&file("b", end)).unwrap();
        let binding = Binding::new(&mapping, &skeleton).unwrap();
        assert_eq!(binding.segment_end_m[0], height_m * DVec3::Y, "{end}");
    }
}

#[test]
fn folds_the_joints_between_two_bodies() {
    // Every body has its origin at `a` and the rotation of `c`, except the pelvis, which has the rotation of `a`.
    let text = file("c", "'c'").replace("origin = 'c'", "origin = 'a'").replacen(
        "rotation = 'c'",
        "rotation = 'a'",
        1,
    );
    let skeleton = chain(&["a", "b", "c"]);
    let turn =
        |angle| JointSample { rotation: DQuat::from_rotation_x(angle), position_m: DVec3::Y };
    let clip = Clip {
        name: "test".to_owned(),
        skeleton,
        frame_time_s: 0.01,
        frames: vec![vec![turn(0.1), turn(0.2), turn(0.4)]],
    };
    let binding = Binding::new(&Mapping::parse(&text).unwrap(), &clip.skeleton).unwrap();
    let motion = binding.map(&clip);
    let angles = motion.rotation[0].iter().map(|rotation| {
        let (axis, angle) = rotation.to_axis_angle();
        axis.x * angle
    });
    for (i, angle) in angles.enumerate() {
        let expected = match BODIES[i].parent {
            None => 0.1,
            Some(0) => 0.6,
            Some(_) => 0.0,
        };
        assert!((angle - expected).abs() < 1e-12, "{} {angle}", BODIES[i].name);
    }
    let worst_m = binding.worst_distance_m(&clip, &motion);
    assert!(worst_m.iter().all(|worst_m| *worst_m < 1e-15), "{worst_m:?}");
}

#[test]
fn names_what_a_given_mapping_lacks() {
    let skeleton = chain(&["a", "b"]);
    let bind = |joint, end| {
        let mapping = Mapping::parse(&file(joint, end)).unwrap();
        Binding::new(&mapping, &skeleton).unwrap_err().to_string()
    };
    let lacks = bind("hip", "'a'");
    assert!(
        lacks.starts_with("mapping `test`: 18 mistakes\n  body `pelvis` needs joint `hip`\n"),
        "{lacks}"
    );
    assert!(lacks.ends_with("  body `foot_r` needs joint `hip`\n  The clip has a, b"), "{lacks}");
    let lacks = bind("a", "{ site = 'a' }");
    assert!(
        lacks.starts_with(
            "mapping `test`: 18 mistakes\n  the end of body `pelvis` needs an end site"
        ),
        "{lacks}"
    );
    let one = file("a", "'a'").replacen("end = 'a'", "end = 'x'", 1);
    let one = Binding::new(&Mapping::parse(&one).unwrap(), &skeleton).unwrap_err().to_string();
    assert_eq!(one, "mapping `test`: body `pelvis` needs joint `x`, but the clip has a, b");
}

#[test]
fn refuses_wrong_files() {
    let good = file("a", "'a'");
    assert!(Mapping::parse(&good).is_ok());
    for (what, with, expected) in [
        ("pelvis", "hips", "[body]: expected `pelvis`, which is missing"),
        (
            "thorax",
            "hips",
            "[body]: expected `thorax`, which is missing; expected only pelvis, abdomen",
        ),
        ("[body]", "[body]\ntail = { origin = 'a', rotation = 'a', end = 'a' }", "found `tail`"),
        ("unit = 1", "unit = nan", "metres_per_unit: expected above zero, found NaN"),
        ("unit = 1", "unit = -1", "metres_per_unit: expected above zero, found -1"),
        ("name = 'test'\n", "", "expected `name` before the first table, which is missing"),
        ("metres_per_unit = 1\n", "", "expected `metres_per_unit` before the first table"),
        ("joints = []", "", "missing field `joints`"),
        ("[signature]\njoints = []", "", "expected the table `[signature]`, which is missing"),
        (
            "unit = 1",
            "unit = 1\nrate_hz = 0",
            "rate_hz: expected a number from 1 to 100000, found 0",
        ),
        ("unit = 1", "unit = 'cm'", "line 2, column 19"),
        ("joints = []", "joint = []", "unknown field `joint`"),
        ("end = 'a'", "end = 3", "expected a joint's name, { site = \"joint\" }"),
        ("end = 'a'", "end = { beyond = 'a', ratio = inf }", "ratio: expected finite, found inf"),
    ] {
        assert!(good.contains(what), "{what}");
        let message = message(&good.replacen(what, with, 1));
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn names_a_file_that_cannot_be_read() {
    let error = Mapping::read(std::path::Path::new("no/such.toml")).unwrap_err().to_string();
    assert!(error.starts_with("no/such.toml: cannot be read: "), "{error}");
}
