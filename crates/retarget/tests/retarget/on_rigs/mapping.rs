//! Tests of mappings: written, read, and applied to a rig and a clip.

use glam::{DQuat, DVec3};
use proptest::prelude::*;
use sinew_mocap::{Clip, JointSample, Skeleton, SkeletonJoint};
use sinew_retarget::mapping::{Curve, Mapping, Performance, Point};
use sinew_retarget::performer::Performer;
use sinew_retarget::rig::RigMatch;
use sinew_retarget::solve::{Limb, bake};
use sinew_retarget::{Landmark, Side};
use sinew_rig::Mechanism;
use sinew_rig::mechanism::{JointModel, Link};

use super::examples::{Gait, figure, joints, walk};

fn proposed() -> (Mechanism, Mapping) {
    let mechanism = figure(9.0, 12.0);
    let rig = RigMatch::of(&mechanism).unwrap();
    let clip = walk(Gait::default(), 0.1);
    let of_clip = |_| (0.9, "by its \"name\"\nand more".to_owned());
    let names = ["figure", "walk"];
    let joints = joints(&clip.skeleton);
    let mapping = Mapping::propose(names, &mechanism, &rig, &clip.skeleton, &joints, of_clip);
    (mechanism, mapping)
}

/// Removes the data that the text contains only as comments.
fn without_comments(mut mapping: Mapping) -> Mapping {
    for entry in &mut mapping.landmarks {
        (entry.confidence, entry.reason) = (1.0, String::new());
    }
    mapping
}

#[test]
fn what_is_written_is_read() {
    let (_, mut mapping) = proposed();
    mapping.performance = Performance {
        scale: Some(0.5),
        mirror: true,
        travels: false,
        tilt_rad: 90.0_f64.to_radians(),
        arms: Limb::End,
        legs: Limb::Upper,
        forward: Some([0.0, 0.0, 1.0]),
        // Whole degrees, because others are rounded in the text.
        speed_rad_s: 360.0_f64.to_radians(),
    };
    mapping.landmarks[0].point =
        Some(Point { body: "a \"b\"".to_owned(), position_m: [0.1, -2.0, 3e-7] });
    mapping.curves.push(Curve {
        clip: "Jaw".to_owned(),
        axis: [1.0, 0.0, 0.0],
        rig: "jaw".to_owned(),
        points: vec![[0.0, 0.01], [1.0, 0.02]],
        slides: true,
    });
    let read = Mapping::read(&mapping.text()).unwrap();
    assert_eq!(without_comments(read), without_comments(mapping));
}

#[test]
fn a_proposal_gives_the_same_poses_as_the_match() {
    let (mechanism, mapping) = proposed();
    let clip = walk(Gait::default(), 0.5);
    let read = Mapping::read(&mapping.text()).unwrap();
    let performer_joints = read.performer_joints(&clip.skeleton).unwrap();
    assert_eq!(performer_joints, joints(&clip.skeleton));
    let performer = Performer::of(&clip, &performer_joints).unwrap();
    let [one, other] = [RigMatch::of(&mechanism).unwrap(), read.rig_match(&mechanism).unwrap()]
        .map(|rig| bake(&mechanism, &rig, &clip, &performer, &read.settings()));
    // The text has points with a precision of one micrometre.
    for (a, b) in one.q.iter().flatten().zip(other.q.iter().flatten()) {
        assert!((a - b).abs() < 1e-4, "{a} {b}");
    }
}

#[test]
fn a_part_of_a_clip_is_enough() {
    let (mechanism, mut mapping) = proposed();
    mapping.landmarks.retain(|entry| {
        use Landmark::{Chest, Elbow, Shoulder, Wrist};
        let left_arm = [Shoulder(Side::Left), Elbow(Side::Left), Wrist(Side::Left)];
        entry.landmark == Chest || left_arm.contains(&entry.landmark)
    });
    let clip = walk(Gait::default(), 0.3);
    let rig = mapping.rig_match(&mechanism).unwrap();
    let performer =
        Performer::of(&clip, &mapping.performer_joints(&clip.skeleton).unwrap()).unwrap();
    let baked = bake(&mechanism, &rig, &clip, &performer, &mapping.settings());
    let right_elbow =
        mechanism.bodies.iter().position(|link| link.joint_name == "right_elbow").unwrap();
    let at = mechanism.coordinate_ranges()[right_elbow].start;
    // The right arm has no target, therefore it stays at home.
    assert!(baked.q.iter().all(|q| q[at].abs() < 1e-12));
}

#[test]
fn a_face_follows_curves_alone() {
    let turn = |name: &str| Link {
        name: name.to_owned(),
        joint_name: name.to_owned(),
        ranges: vec![[-0.2, 0.3]],
        speed: 2.0,
        ..Link::on(Some(0), JointModel::Revolute(DVec3::X), DVec3::ZERO)
    };
    let skull = Link::on(None, JointModel::Fixed, DVec3::ZERO);
    let mechanism =
        Mechanism { bodies: vec![skull, turn("jaw"), turn("brow")], linked: Vec::new() };
    let text = "[[curve]]\nclip = \"LeftLeg\"\naxis = [1, 0, 0]\nrig = \"jaw\"\npoints_deg = [[0, 0], [40, 20]]\n";
    let mapping = Mapping::read(text).unwrap();
    let mut clip = walk(Gait::default(), 1.0);
    let knee = clip.skeleton.find("LeftLeg").unwrap();
    for (k, frame) in clip.frames.iter_mut().enumerate() {
        frame[knee].rotation = DQuat::from_rotation_x((k as f64).to_radians());
    }
    let rig = mapping.rig_match(&mechanism).unwrap();
    let performer =
        Performer::of(&clip, &mapping.performer_joints(&clip.skeleton).unwrap()).unwrap();
    let mut baked = bake(&mechanism, &rig, &clip, &performer, &mapping.settings());
    mapping.curves(&mechanism, &clip.skeleton).unwrap().put(&clip, &mut baked.q);
    for (k, q) in baked.q.iter().enumerate() {
        // Half the angle; the range ends at 0.3 rad. Half a degree per frame is 1.05 rad/s.
        let expected = (0.5 * (k as f64).min(40.0)).to_radians().min(0.3);
        assert!((q[0] - expected).abs() < 1e-12, "{k}: {} {expected}", q[0]);
        assert!(q[1].abs() < 1e-12);
    }
}

/// Returns a clip whose one joint has the given angles about y, deg, and the positions of a rig's joint by a curve.
fn driven(points: [[f64; 2]; 2], angles_deg: &[f64]) -> Vec<f64> {
    let free = Link {
        joint_name: "lever".to_owned(),
        ..Link::on(Some(0), JointModel::Revolute(DVec3::X), DVec3::ZERO)
    };
    let base = Link::on(None, JointModel::Fixed, DVec3::ZERO);
    let mechanism = Mechanism { bodies: vec![base, free], linked: Vec::new() };
    let text = format!(
        "[performance]\nspeed_deg_s = 1e6\n[[curve]]\nclip = \"dial\"\naxis = [0, 1, 0]\nrig = \"lever\"\n\
         points_deg = {points:?}\n"
    );
    let dial = SkeletonJoint {
        name: "dial".to_owned(),
        parent: None,
        offset_m: DVec3::ZERO,
        end_sites_m: Vec::new(),
    };
    let sample = |(k, angle): (usize, &f64)| {
        let rotation = DQuat::from_rotation_y(angle.to_radians());
        // Both signs of a quaternion are one rotation.
        let rotation = if k % 3 == 1 { -rotation } else { rotation };
        vec![JointSample { rotation, position_m: DVec3::ZERO }]
    };
    let clip = Clip {
        name: "dial".to_owned(),
        skeleton: Skeleton { joints: vec![dial] },
        frame_time_s: 1.0 / 60.0,
        frames: angles_deg.iter().enumerate().map(sample).collect(),
    };
    let mut rows = vec![vec![0.0]; clip.frames.len()];
    let curves = Mapping::read(&text).unwrap().curves(&mechanism, &clip.skeleton).unwrap();
    curves.put(&clip, &mut rows);
    rows.into_iter().map(|row| row[0].to_degrees()).collect()
}

#[test]
fn an_even_turn_through_half_a_turn_is_even() {
    let angles: Vec<f64> = (0..121).map(|k| 150.0 + 0.5 * f64::from(k)).collect();
    let lever = driven([[100.0, -60.0], [240.0, 60.0]], &angles);
    for (k, (lever, angle)) in lever.iter().zip(&angles).enumerate() {
        let expected = -60.0 + 120.0 * (angle - 100.0) / 140.0;
        assert!((lever - expected).abs() < 1e-9, "{k}: {lever} {expected}");
    }
}

proptest! {
    /// A random walk of an angle, with any number of turns, gives the positions of its angles with turns, if the
    /// first angle is within half a turn of the middle of the points.
    #[test]
    fn random_turns_are_followed(
        middle in -400.0..400.0_f64,
        half_width in 20.0..2000.0_f64,
        first in -175.0..175.0_f64,
        steps in prop::collection::vec(-170.0..170.0_f64, 2..80),
    ) {
        let walk = steps.iter().scan(middle + first, |angle, step| {
            let now = *angle;
            *angle += step;
            Some(now)
        });
        let angles: Vec<f64> = walk.collect();
        let points = [[middle - half_width, -50.0], [middle + half_width, 70.0]];
        for (angle, lever) in angles.iter().zip(driven(points, &angles)) {
            let share = ((angle - points[0][0]) / (2.0 * half_width)).clamp(0.0, 1.0);
            prop_assert!((lever - (-50.0 + 120.0 * share)).abs() < 1e-6, "{angle}: {lever}");
        }
    }
}

#[test]
fn errors_name_the_item_and_what_would_be_right() {
    let (mechanism, mapping) = proposed();
    for (text, expected) in [
        (
            "[[landmark]]\nname = \"knee\"\n",
            "line 2, column 8: landmark[0].name: expected one of pelvis",
        ),
        (
            "[performance]\nscale = \"big\"\n",
            "line 2, column 9: invalid value: string \"big\", expected a number above 0",
        ),
        (
            "[performance]\nscale = -1\n",
            "line 2, column 9: performance.scale: expected a number above 0, or \"auto\", found -1",
        ),
        (
            "[performance]\nspeed_deg_s = nan\n",
            "line 2, column 15: performance.speed_deg_s: expected a number above 0",
        ),
        (
            "[performance]\narms = \"hand\"\n",
            "line 2, column 8: unknown variant `hand`, expected one of `both`, `end`, `upper`",
        ),
        (
            "[[landmark]]\nname = \"l_knee\"\njoints = [\"a\"]\n",
            "line 3, column 1: unknown field `joints`, expected one of",
        ),
        (
            "[[curve]]\nclip = \"a\"\naxis = [1, 0, 0]\nrig = \"b\"\npoints_deg = [[1, 0], [0, 0]]\n",
            "line 5, column 14: curve[0].points_deg: expected two or more points",
        ),
        (
            "[[landmark]]\nname = \"l_knee\"\nrig = [\"a\"]\n[[landmark]]\nname = \"l_hip\"\nrig = [\"a\"]\n",
            "landmark l_hip: expected a joint of the rig once, found `a`, which landmark l_knee has as well",
        ),
    ] {
        let error = Mapping::read(text).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}");
    }
    let text = mapping.text().replace("\"left_knee\"", "\"left_kneee\"");
    let error = Mapping::read(&text).unwrap().rig_match(&mechanism).unwrap_err().to_string();
    assert!(
        error.starts_with(
            "landmark l_knee.rig: expected a joint of the rig (waist_yaw, left_hip_pitch"
        ),
        "{error}"
    );
    assert!(error.ends_with("found `left_kneee`"), "{error}");
}
