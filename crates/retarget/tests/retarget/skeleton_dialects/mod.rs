//! Landmarks of skeletons with the names of many makers, also renamed, mirrored, rotated and scaled.

mod additions;
mod dialect;

use additions::additions;
use dialect::{DIALECTS, Dialect};
use glam::{DQuat, DVec3};
use proptest::prelude::*;
use sinew_mocap::Skeleton;
use sinew_retarget::skeleton::{MapHead, SkeletonMatch, figure_mapping};
use sinew_retarget::{Landmark, Side};

/// Minimum confidence for these skeletons, whose names are all clear.
const SURE: f64 = 0.6;

/// Returns the landmarks that differ from the expected ones.
fn wrong(dialect: &Dialect) -> Vec<String> {
    let matched = SkeletonMatch::new(&dialect.skeleton, &[]);
    let mut wrong = Vec::new();
    for landmark in Landmark::ALL {
        let found = matched.get(landmark);
        let name = found.map(|found| dialect.skeleton.joints[found.joint].name.as_str());
        let expected = dialect.expected.get(&landmark).map(String::as_str);
        if name != expected || found.is_some_and(|found| found.confidence < SURE) {
            wrong.push(format!(
                "{}: expected {expected:?}, found {name:?} {found:?}",
                landmark.name()
            ));
        }
    }
    wrong
}

#[test]
fn every_dialect_is_understood() {
    for dialect in DIALECTS.iter() {
        let maker = dialect.maker;
        assert_eq!(wrong(dialect), Vec::<String>::new(), "{maker}");
        let matched = SkeletonMatch::new(&dialect.skeleton, &[]);
        assert_eq!(matched.findings, Vec::<String>::new(), "{maker}");
        assert_eq!(
            matched.unit.as_ref().and_then(|unit| unit.metres_per_unit),
            Some(1.0),
            "{maker}"
        );
        assert_eq!(matched.up.as_ref().map(|up| up.axis), Some(DVec3::Y), "{maker}");
        let at = matched.directions.expect(maker);
        assert!(at.up.y > 0.99 && at.forward.z > 0.99 && at.left.x > 0.99, "{maker}: {at:?}");
    }
}

#[test]
fn every_dialect_maps_on_the_figure() {
    for dialect in DIALECTS.iter() {
        let maker = dialect.maker;
        let matched = SkeletonMatch::new(&dialect.skeleton, &[]);
        let head = MapHead { name: maker, metres_per_unit: 1.0, rate_hz: None };
        let proposed = figure_mapping(&dialect.skeleton, &matched, head)
            .unwrap_or_else(|error| panic!("{maker}: {error}"));
        assert_eq!(proposed.map.bodies.len(), 18, "{maker}");
        assert!(proposed.map.signature.matches(&dialect.skeleton), "{maker}");
        let rest_m = dialect.skeleton.rest_positions_m();
        for (body, part) in &proposed.map.bodies {
            let joint = |name: &str| dialect.skeleton.find(name).expect(maker);
            let end_m = part
                .end
                .rest_position_m(&dialect.skeleton, &rest_m)
                .unwrap_or_else(|error| panic!("{maker}: {error}"));
            joint(&part.rotation);
            let length_m = rest_m[joint(&part.origin)].distance(end_m);
            assert!(
                (0.005..0.6).contains(&length_m),
                "{maker}: {body} is {length_m} m long: {part:?}"
            );
        }
        let turns =
            |body: &str| dialect.skeleton.find(&proposed.map.bodies[body].rotation).expect(maker);
        let [abdomen, thigh_l, thigh_r] = ["abdomen", "thigh_l", "thigh_r"].map(turns);
        for joint in [abdomen, thigh_l, thigh_r] {
            assert!(dialect.skeleton.moves_with(turns("pelvis"), joint), "{maker}: {joint}");
        }
        let read: sinew_mocap::SkeletonMap = toml::from_str(&proposed.to_toml()).expect(maker);
        assert_eq!(read, proposed.map, "{maker}");
    }
}

/// Changes of a skeleton that do not affect the meaning of its joints.
#[derive(Debug, Clone)]
struct Change {
    prefix: &'static str,
    suffix: &'static str,
    case: u8,
    mirrored: bool,
    z_up: bool,
    unit: f64,
    order: u64,
}

fn change() -> impl Strategy<Value = Change> {
    let prefixes = prop::sample::select(vec![
        "",
        "mixamorig:",
        "mixamorig12:",
        "Armature|",
        "Bip001_",
        "b_",
        "Actor7:Body:",
    ]);
    let suffixes = prop::sample::select(vec!["", "_12", ".001", "_jnt", "_bone", ":7"]);
    let units = prop::sample::select(vec![1.0, 100.0, 39.37, 1000.0, 10.0, 17.7165]);
    (prefixes, suffixes, 0..3_u8, any::<bool>(), any::<bool>(), units, any::<u64>()).prop_map(
        |(prefix, suffix, case, mirrored, z_up, unit, order)| Change {
            prefix,
            suffix,
            case,
            mirrored,
            z_up,
            unit,
            order,
        },
    )
}

impl Change {
    fn name(&self, name: &str) -> String {
        let name = match self.case {
            0 => name.to_owned(),
            1 => name.to_lowercase(),
            _ => name.to_uppercase(),
        };
        format!("{}{name}{}", self.prefix, self.suffix)
    }

    /// Returns the changed skeleton. If it is mirrored, its sides are exchanged, because the names follow the
    /// sides.
    fn apply(&self, dialect: &Dialect) -> Dialect {
        let mut skeleton = in_other_order(&dialect.skeleton, self.order);
        for joint in &mut skeleton.joints {
            joint.name = self.name(&joint.name);
            if self.mirrored {
                // The right limbs move to the place of the left, and forward becomes backward.
                joint.offset_m *= DVec3::new(-1.0, 1.0, -1.0);
            }
            if self.z_up {
                joint.offset_m =
                    DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2) * joint.offset_m;
            }
            joint.offset_m *= self.unit;
        }
        let expected =
            dialect.expected.iter().map(|(landmark, name)| (*landmark, self.name(name))).collect();
        Dialect { maker: dialect.maker, skeleton, expected }
    }
}

/// Returns the joints in another order, parents before children.
fn in_other_order(skeleton: &Skeleton, seed: u64) -> Skeleton {
    let mut state = seed;
    let mut order: Vec<usize> = vec![0];
    let mut open: Vec<usize> = (1..skeleton.joints.len()).collect();
    while !open.is_empty() {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let ready: Vec<usize> = open
            .iter()
            .copied()
            .filter(|joint| order.contains(&skeleton.joints[*joint].parent.unwrap_or(0)))
            .collect();
        let next = ready[usize::try_from(state >> 33).expect("31 bits") % ready.len()];
        order.push(next);
        open.retain(|joint| *joint != next);
    }
    let place =
        |joint: usize| order.iter().position(|other| *other == joint).expect("all are there");
    let joints = order.iter().map(|joint| {
        let mut moved = skeleton.joints[*joint].clone();
        moved.parent = moved.parent.map(place);
        moved
    });
    Skeleton { joints: joints.collect() }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// MMD's names have no case; `l5` in lower case has no meaning.
    #[test]
    fn names_in_other_dress_mean_the_same(which in 0..DIALECTS.len(), change in change()) {
        let dialect = &DIALECTS[which];
        let maker = dialect.maker;
        prop_assume!(!(maker == "xsens_mvn" && change.case == 1));
        let changed = change.apply(dialect);
        prop_assert_eq!(wrong(&changed), Vec::<String>::new(), "{}", maker);
        let matched = SkeletonMatch::new(&changed.skeleton, &[]);
        let unit = matched.unit.as_ref().and_then(|unit| unit.metres_per_unit).expect("a usual unit");
        prop_assert!((unit * change.unit - 1.0).abs() < 1e-3, "{:?}", matched.unit);
        prop_assert_eq!(matched.up.as_ref().map(|up| up.axis), Some(if change.z_up { DVec3::Z } else { DVec3::Y }));
        prop_assert_eq!(matched.findings, Vec::<String>::new());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// Fingers, twists, ends, helpers and more joints of the spine do not change any landmark.
    #[test]
    fn what_is_no_landmark_changes_none(which in 0..DIALECTS.len(), additions in additions()) {
        let dialect = &DIALECTS[which];
        let more = additions.apply(dialect);
        prop_assert_eq!(wrong(&more), Vec::<String>::new(), "{}: {:?}", dialect.maker, additions);
    }

    /// A mirror image is a human too: left becomes right, whatever the names are.
    #[test]
    fn of_a_mirror_image_the_sides_change(which in 0..DIALECTS.len(), seed in any::<u64>()) {
        let mut joints = in_other_order(&DIALECTS[which].skeleton, seed);
        for (place, joint) in joints.joints.iter_mut().enumerate() {
            joint.name = format!("joint_{place}");
        }
        let matched = SkeletonMatch::new(&joints, &[]);
        for joint in &mut joints.joints {
            joint.offset_m.x = -joint.offset_m.x;
        }
        let mirrored = SkeletonMatch::new(&joints, &[]);
        // Only feet that point forward determine the sides; without them, the file's order does not change.
        let rest_m = joints.rest_positions_m();
        let at_m = |landmark| matched.joint(landmark).map(|joint| rest_m[joint]);
        let of_leg = [Landmark::Hip, Landmark::Ankle, Landmark::Toe].map(|place| at_m(place(Side::Left)));
        let tells = matched.directions.zip(of_leg[0]).zip(of_leg[1]).zip(of_leg[2]).is_some_and(
            |(((at, hip_m), ankle_m), toe_m)| {
                let foot_m = toe_m - ankle_m;
                foot_m.dot(at.forward).abs() > 0.1 * hip_m.distance(ankle_m)
            },
        );
        prop_assume!(tells);
        for (landmark, found) in matched.found() {
            let other = match landmark {
                Landmark::Shoulder(side) => Landmark::Shoulder(side.other()),
                Landmark::Elbow(side) => Landmark::Elbow(side.other()),
                Landmark::Wrist(side) => Landmark::Wrist(side.other()),
                Landmark::Hip(side) => Landmark::Hip(side.other()),
                Landmark::Knee(side) => Landmark::Knee(side.other()),
                Landmark::Ankle(side) => Landmark::Ankle(side.other()),
                Landmark::Toe(side) => Landmark::Toe(side.other()),
                middle => middle,
            };
            prop_assert_eq!(mirrored.joint(other), Some(found.joint), "{}: {}", DIALECTS[which].maker, landmark.name());
        }
    }
}

/// Names without meaning: tree and lengths must suffice, with lower confidence.
#[test]
fn without_names_the_tree_tells() {
    let (mut right, mut all) = (0, 0);
    let mut lines = Vec::new();
    for dialect in DIALECTS.iter() {
        let (maker, mut dialect) = (dialect.maker, dialect.clone());
        let joint_of =
            |name: &String| dialect.skeleton.find(name).expect("expected joints are there");
        let expected: Vec<(Landmark, usize)> =
            dialect.expected.iter().map(|(landmark, name)| (*landmark, joint_of(name))).collect();
        for (place, joint) in dialect.skeleton.joints.iter_mut().enumerate() {
            joint.name = format!("joint_{place}");
        }
        let matched = SkeletonMatch::new(&dialect.skeleton, &[]);
        let mut missed = Vec::new();
        for (landmark, joint) in &expected {
            all += 1;
            if matched.joint(*landmark) == Some(*joint) {
                right += 1;
            } else {
                missed.push(landmark.name());
            }
            assert!(matched.get(*landmark).is_none_or(|found| found.confidence < 0.75), "{maker}");
        }
        lines.push(format!(
            "{maker}: {} of {}, not {missed:?}",
            expected.len() - missed.len(),
            expected.len()
        ));
    }
    println!("{}\nwithout names: {right} of {all}", lines.join("\n"));
    assert!(right * 100 >= all * 80, "{}", lines.join("\n"));
}

/// Names determine the side; toes that point the other way are reported.
#[test]
fn sides_against_the_toes_are_told() {
    let mut dialect = DIALECTS[0].clone();
    for joint in &mut dialect.skeleton.joints {
        joint.offset_m.x = -joint.offset_m.x;
    }
    let matched = SkeletonMatch::new(&dialect.skeleton, &[]);
    assert!(
        matched.findings.iter().any(|finding| finding.contains("wrong sides")),
        "{:?}",
        matched.findings
    );
    let hip = matched.get(Landmark::Hip(Side::Left)).expect("a hip");
    assert_eq!(
        dialect.skeleton.joints[hip.joint].name,
        dialect.expected[&Landmark::Hip(Side::Left)]
    );
    assert!(hip.confidence < 0.9 && hip.reason.contains("the other side"), "{hip:?}");
}
