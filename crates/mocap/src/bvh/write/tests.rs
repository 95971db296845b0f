use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;

use proptest::prelude::*;

use super::super::parse;
use super::*;
use crate::{SkeletonJoint, gaps};

/// A spine with an arm on each side; the order is not depth-first.
fn skeleton() -> Skeleton {
    let joint = |name: &str, parent, x: f64, ends: &[f64]| SkeletonJoint {
        name: name.into(),
        parent,
        offset_m: DVec3::new(x, 0.25 * x, -0.125),
        end_sites_m: ends.iter().map(|end| DVec3::Y * *end).collect(),
    };
    Skeleton {
        joints: vec![
            joint("Hips", None, 0.0, &[]),
            joint("Left Arm:1", Some(0), 0.25, &[]),
            joint("RightArm", Some(0), -0.25, &[0.25, 0.5]),
            joint("LeftHand", Some(1), 0.5, &[0.125]),
            joint("Tail", Some(0), 0.0625, &[]),
        ],
    }
}

fn clip(frames: Vec<Vec<JointSample>>) -> Clip {
    Clip { name: "x".into(), skeleton: skeleton(), frame_time_s: 1.0 / 120.0, frames }
}

fn still() -> Vec<JointSample> {
    let joints = skeleton().joints;
    let sample = |joint: &SkeletonJoint| JointSample {
        rotation: DQuat::IDENTITY,
        position_m: joint.offset_m,
    };
    joints.iter().map(sample).collect()
}

/// Writes a clip and reads it again.
fn again(clip: &Clip, metres_per_unit: f64) -> Clip {
    let text = text(clip, metres_per_unit).unwrap();
    let recording = parse(text.as_bytes(), Path::new("x.bvh")).unwrap();
    let frame_time_s = recording.frame_time_s.unwrap();
    gaps::fill(recording.in_metres(metres_per_unit), frame_time_s, 0.0).unwrap().0
}

/// Returns the largest differences of rotations (rad) and positions (m), with joints matched by name.
fn differences(a: &Clip, b: &Clip) -> (f64, f64) {
    assert_eq!(
        (a.frames.len(), a.skeleton.joints.len()),
        (b.frames.len(), b.skeleton.joints.len())
    );
    assert!((a.frame_time_s - b.frame_time_s).abs() < 1e-9);
    let mut largest = (0.0_f64, 0.0_f64);
    for (index, joint) in a.skeleton.joints.iter().enumerate() {
        let place = b.skeleton.find(&joint.name).unwrap();
        let other = &b.skeleton.joints[place];
        let name = |clip: &Clip, parent: Option<usize>| {
            parent.map(|parent| clip.skeleton.joints[parent].name.clone())
        };
        assert_eq!(name(a, joint.parent), name(b, other.parent));
        largest.1 = largest.1.max((joint.offset_m - other.offset_m).length());
        for (a, b) in a.frames.iter().zip(&b.frames) {
            let turn = a[index].rotation.conjugate() * b[place].rotation;
            largest.0 = largest.0.max(2.0 * turn.xyz().length().min(1.0).asin());
            largest.1 = largest.1.max((a[index].position_m - b[place].position_m).length());
        }
    }
    largest
}

#[test]
fn the_text_is_what_other_programs_read() {
    let mut frame = still();
    frame[0] = JointSample {
        rotation: DQuat::from_rotation_z(FRAC_PI_2),
        position_m: DVec3::new(0.1, 0.9, -0.2),
    };
    frame[3].rotation = DQuat::from_rotation_x(-0.5 * FRAC_PI_2);
    let text = text(&clip(vec![frame]), 0.01).unwrap();
    let expected = "\
HIERARCHY
ROOT Hips
{
  OFFSET 0.000000 0.000000 -12.500000
  CHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation
  JOINT Left Arm:1
  {
    OFFSET 25.000000 6.250000 -12.500000
    CHANNELS 3 Zrotation Yrotation Xrotation
    JOINT LeftHand
    {
      OFFSET 50.000000 12.500000 -12.500000
      CHANNELS 3 Zrotation Yrotation Xrotation
      End Site
      {
        OFFSET 0.000000 12.500000 0.000000
      }
    }
  }
  JOINT RightArm
  {
    OFFSET -25.000000 -6.250000 -12.500000
    CHANNELS 3 Zrotation Yrotation Xrotation
    End Site
    {
      OFFSET 0.000000 25.000000 0.000000
    }
    End Site
    {
      OFFSET 0.000000 50.000000 0.000000
    }
  }
  JOINT Tail
  {
    OFFSET 6.250000 1.562500 -12.500000
    CHANNELS 3 Zrotation Yrotation Xrotation
    End Site
    {
      OFFSET 0.000000 0.000000 0.000000
    }
  }
}
MOTION
Frames: 1
Frame Time: 0.0083333333
10.000000 90.000000 -20.000000 90.000000 0.000000 0.000000 0.000000 0.000000 0.000000 \
0.000000 0.000000 -45.000000 0.000000 0.000000 0.000000 0.000000 0.000000 0.000000
";
    assert_eq!(text, expected);
}

#[test]
fn angles_go_on_through_the_lock_and_beyond_half_a_turn() {
    // The middle angle passes 90 deg while the others remain; with another choice of angles they would jump by 180
    // deg.
    let steps = 400;
    let at = |k: i32| f64::from(k) / f64::from(steps);
    let turns = (0..=steps).map(|k| {
        DQuat::from_rotation_z(0.3 + 3.0 * PI * at(k))
            * DQuat::from_rotation_y(PI * at(k))
            * DQuat::from_rotation_x(-0.2)
    });
    let mut angles = DVec3::new(0.3, 0.0, -0.2);
    for (k, turn) in turns.enumerate() {
        let next = zyx_rad(turn, angles);
        assert!((next - angles).abs().max_element() < 0.03, "{k}: {angles} to {next}");
        angles = next;
    }
    assert!((angles - DVec3::new(0.3 + 3.0 * PI, PI, -0.2)).length() < 1e-9, "{angles}");
}

#[test]
fn joints_that_slide_keep_doing_so() {
    let mut frame = still();
    frame[2].position_m.x += 0.01;
    let clip = clip(vec![still(), frame]);
    assert!(text(&clip, 1.0).unwrap().contains("JOINT RightArm\n  {\n    OFFSET -0.250000000 -0.062500000 -0.125000000\n    CHANNELS 6 Xposition"));
    assert!(differences(&clip, &again(&clip, 1.0)).1 < 1e-9);
}

#[test]
fn what_cannot_be_read_again_is_refused_by_name() {
    let error = |change: &dyn Fn(&mut Clip), metres_per_unit: f64| {
        let mut clip = clip(vec![still(), still()]);
        change(&mut clip);
        text(&clip, metres_per_unit).unwrap_err().to_string()
    };
    for (name, found) in [("", ""), ("a{", "a{"), (" a", " a"), ("a\nb", "a\\nb")] {
        let expected = format!(
            "joint 2: expected a name in one line, without braces or blanks around it, found `{found}`"
        );
        assert_eq!(error(&|clip| clip.skeleton.joints[2].name = name.into(), 1.0), expected);
    }
    assert_eq!(
        error(&|clip| clip.skeleton.joints[2].name = "Hips".into(), 1.0),
        "joint 2: expected a new name, found `Hips` again"
    );
    assert_eq!(
        error(&|clip| clip.frames[1][3].position_m.y = f64::NAN, 1.0),
        "frame 1, joint `LeftHand`: expected a finite position, at most 1e9 units away, found NaN"
    );
    assert_eq!(
        error(&|clip| clip.frames[1][3].rotation.w = f64::INFINITY, 1.0),
        "frame 1, joint `LeftHand`: expected a rotation by a unit quaternion, found inf"
    );
    assert_eq!(
        error(&|clip| _ = clip.frames[1].pop(), 1.0),
        "frame 1: expected one sample for each joint, found 4 samples"
    );
    assert_eq!(
        error(&|clip| clip.frames.clear(), 1.0),
        "the motion: expected at least one frame, found none"
    );
    assert_eq!(
        error(&|clip| clip.frame_time_s = f64::NAN, 1.0),
        "frame time: expected 0.00001 to 1 second, found NaN"
    );
    assert_eq!(
        error(&|_| (), 0.0),
        "metres per unit: expected a number from 0.000001 to 1000, found 0"
    );
    assert!(
        error(&|clip| clip.skeleton.joints[1].parent = None, 1.0)
            .starts_with("joint `Left Arm:1`: expected a parent")
    );
}

/// Generates rotations of all kinds: any, in gimbal lock, and close to it by powers of ten.
fn rotation() -> impl Strategy<Value = DQuat> {
    let angle = || -PI..PI;
    let lock = (prop::bool::ANY, -16.0..-1.0, angle(), angle(), prop::bool::ANY).prop_map(
        |(up, power, z, x, exact)| {
            let off = if exact { 0.0 } else { 10.0_f64.powf(power) };
            let y = if up { FRAC_PI_2 - off } else { off - FRAC_PI_2 };
            DQuat::from_rotation_z(z) * DQuat::from_rotation_y(y) * DQuat::from_rotation_x(x)
        },
    );
    let anywhere = (angle(), angle(), angle()).prop_map(|(x, y, z)| {
        DQuat::from_rotation_x(x) * DQuat::from_rotation_y(y) * DQuat::from_rotation_z(z)
    });
    prop_oneof![lock, anywhere]
}

proptest! {
    #[test]
    fn written_and_read_again_a_motion_is_the_same(
        rotations in prop::collection::vec(prop::collection::vec(rotation(), 5), 1..6),
        place in prop::array::uniform3(-20.0..20.0),
        unit in prop::sample::select(vec![1.0, 0.01, 0.0254 / 0.45]),
    ) {
        let frames = rotations.into_iter().map(|rotations| {
            let mut frame = still();
            frame[0].position_m = place.into();
            for (sample, rotation) in frame.iter_mut().zip(rotations) {
                sample.rotation = rotation;
            }
            frame
        });
        let clip = clip(frames.collect());
        let (turn, way_m) = differences(&clip, &again(&clip, unit));
        prop_assert!(turn < 2e-7 && way_m < 1e-7, "{turn} rad, {way_m} m");
    }
}
