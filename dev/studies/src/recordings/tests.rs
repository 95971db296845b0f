use std::collections::BTreeSet;
use std::path::PathBuf;

use glam::DVec3;

use super::*;

#[test]
fn the_first_tenth_of_a_second_is_left_out() {
    let kept = |rate, first, count| thinned(rate, SETTLING_S, first, count).collect::<Vec<_>>();
    assert_eq!(kept(12.0, 0, 5), [2, 3, 4]);
    assert_eq!(kept(120.0, 1, 35), [13, 23, 33]);
    assert!(kept(120.0, 1, 3).is_empty());
    assert_eq!(thinned(12.0, 0.0, 0, 3).collect::<Vec<_>>(), [0, 1, 2]);
}

#[test]
fn built_in_clips_are_on_one_skeleton() {
    let recordings = Recordings::built_in();
    let joints = recordings.skeleton.joints.len();
    assert_eq!(recordings.sequences.len(), 12);
    for sequence in &recordings.sequences {
        assert!(sequence.frames.len() > 50, "{}", sequence.file);
        assert!(sequence.frames.iter().all(|pose| pose.len() == joints));
    }
    let kicks = recordings.sequences.iter().filter(|sequence| sequence.class == Class::Kick);
    assert_eq!(kicks.count(), 4);
}

#[test]
fn the_joint_on_the_floor_is_left_out_and_its_turn_kept() {
    let joint = |name: &str, parent| SkeletonJoint {
        name: name.to_owned(),
        parent,
        offset_m: DVec3::Y,
        end_sites_m: Vec::new(),
    };
    let mut skeleton = Skeleton {
        joints: vec![
            joint(BANDAI_FLOOR, None),
            joint("Hips", Some(0)),
            joint("Spine", Some(1)),
            joint("Leg", Some(1)),
        ],
    };
    let (floor, hips) = (DQuat::from_rotation_y(0.3), DQuat::from_rotation_x(0.2));
    let mut frames = vec![vec![floor, hips, DQuat::IDENTITY, DQuat::IDENTITY]];
    leave_out_floor(&mut skeleton, &mut frames, Path::new("a.bvh")).unwrap();
    let parents: Vec<_> = skeleton.joints.iter().map(|joint| joint.parent).collect();
    assert_eq!(parents, [None, Some(0), Some(0)]);
    assert_eq!(frames, [[floor * hips, DQuat::IDENTITY, DQuat::IDENTITY]]);
    let mut other = Skeleton {
        joints: vec![joint(BANDAI_FLOOR, None), joint("Hips", Some(0)), joint("Prop", Some(0))],
    };
    let told = leave_out_floor(&mut other, &mut [], Path::new("a.bvh")).unwrap_err().to_string();
    assert!(told.contains("Prop hangs on joint_Root"), "{told}");
}

fn data() -> PathBuf {
    PathBuf::from(std::env::var("SINEW_DATA").expect("the tests' runner sets it"))
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn no_trial_of_cmu_counts_twice() {
    let recordings = Recordings::cmu(&data().join("cmu")).unwrap();
    let sequences = &recordings.sequences;
    let trials: BTreeSet<_> = sequences.iter().map(|s| (&s.subject, &s.trial)).collect();
    assert_eq!((trials.len(), sequences.len()), (178, 178));
    assert!(sequences.iter().any(|s| s.file == "fight/135_11_first1630.bvh"), "only there");
    assert_eq!(recordings.skeleton.joints.len(), 31);
    let count = |class| sequences.iter().filter(|s| s.class == class).count();
    assert_eq!((count(Class::Walk), count(Class::Run)), (69, 19));
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn bandai_is_on_one_skeleton_and_broad_on_all() {
    let bandai = Recordings::bandai(&data().join("bandai")).unwrap();
    assert_eq!((bandai.sequences.len(), bandai.skeleton.joints.len()), (424, 21));
    assert_eq!(bandai.skeleton.joints[0].name, "Hips");
    let broad = broad(&data()).unwrap();
    assert_eq!(broad.len(), 680);
    for own in &broad {
        let file = &own.sequences[0].file;
        assert!(own.sequences[0].frames.len() >= 8, "{file}");
        let bones = own.skeleton.joints.iter().skip(1);
        let bones_m: f64 = bones.map(|joint| joint.offset_m.length()).sum();
        assert!((3.0..8.0).contains(&bones_m), "{file}: bones of {bones_m} m in all");
        if own.sequences[0].data_set == DataSet::Bandai {
            for (joint, of_one) in own.skeleton.joints.iter().zip(&bandai.skeleton.joints).skip(1) {
                let off_m = (joint.offset_m - of_one.offset_m).length();
                assert!(off_m < 5e-4, "{file}: {}: {off_m}", joint.name);
            }
        }
    }
}
