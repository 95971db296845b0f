//! Joints that makers add and that are not landmarks.

use glam::DVec3;
use proptest::prelude::*;
use sinew_mocap::SkeletonJoint;
use sinew_retarget::{Landmark, Side};

use super::dialect::Dialect;

/// Kinds of added joints.
#[derive(Debug, Clone)]
#[expect(clippy::struct_excessive_bools, reason = "files have each of these, or have it not")]
pub(crate) struct Additions {
    fingers: bool,
    twists: bool,
    ends: Option<&'static str>,
    helpers: bool,
    /// Names of a left and a right joint between pelvis and thigh whose bone has no length, such as CMU's `LHipJoint`.
    hips: Option<[&'static str; 2]>,
    spine: bool,
}

pub(crate) fn additions() -> impl Strategy<Value = Additions> {
    let ends = prop::option::of(prop::sample::select(vec!["_end", "Nub", "_End", ".tip"]));
    let hips = prop::option::of(prop::sample::select(vec![
        ["LHipJoint", "RHipJoint"],
        ["leftHipNull_x", "rightHipNull_x"],
        ["Helper_7x", "Helper_8x"],
    ]));
    let flags = (any::<bool>(), any::<bool>(), any::<bool>(), any::<bool>());
    (flags, ends, hips).prop_map(|((fingers, twists, helpers, spine), ends, hips)| Additions {
        fingers,
        twists,
        ends,
        helpers,
        hips,
        spine,
    })
}

impl Additions {
    /// Returns the dialect with these joints added.
    pub(crate) fn apply(&self, dialect: &Dialect) -> Dialect {
        let mut dialect = dialect.clone();
        if self.spine {
            split_the_bone_below_the_chest(&mut dialect);
        }
        for (place, side) in Side::ALL.into_iter().enumerate() {
            if let Some(names) = self.hips {
                let hip = find(&dialect, Landmark::Hip(side));
                put_before(&mut dialect, names[place], hip);
            }
        }
        for (side, word) in [(Side::Left, "Left"), (Side::Right, "Right")] {
            let sign = if side == Side::Left { 1.0 } else { -1.0 };
            if self.fingers {
                let wrist = find(&dialect, Landmark::Wrist(side));
                for (place, finger) in
                    ["Thumb", "Index", "Middle", "Ring", "Pinky"].into_iter().enumerate()
                {
                    let mut on = wrist;
                    for knuckle in 1..=3 {
                        let first = DVec3::new(0.08 * sign, 0.0, 0.04 - 0.02 * place as f64);
                        let offset_m = if knuckle == 1 { first } else { DVec3::X * 0.025 * sign };
                        on = add(
                            &mut dialect,
                            &format!("{word}Hand{finger}{knuckle}x"),
                            on,
                            offset_m,
                        );
                    }
                }
            }
            if self.twists {
                for (upper, lower) in [
                    (Landmark::Shoulder(side), Landmark::Elbow(side)),
                    (Landmark::Elbow(side), Landmark::Wrist(side)),
                    (Landmark::Hip(side), Landmark::Knee(side)),
                ] {
                    let (on, lower) = (find(&dialect, upper), find(&dialect, lower));
                    let name = format!("{}_twist_01x", dialect.skeleton.joints[on].name);
                    let rest_m = dialect.skeleton.rest_positions_m();
                    add(&mut dialect, &name, on, 0.5 * (rest_m[lower] - rest_m[on]));
                }
            }
        }
        if self.helpers {
            for name in ["ik_target_x", "camera_helper_x", "weapon_prop_x"] {
                add(&mut dialect, name, 0, DVec3::new(0.0, 0.3, 0.4));
            }
        }
        if let Some(end) = self.ends {
            for joint in 0..dialect.skeleton.joints.len() {
                let is_leaf =
                    dialect.skeleton.joints.iter().all(|other| other.parent != Some(joint));
                if is_leaf {
                    let SkeletonJoint { name, offset_m, .. } =
                        dialect.skeleton.joints[joint].clone();
                    add(&mut dialect, &format!("{name}{end}"), joint, 0.4 * offset_m);
                }
            }
        }
        dialect
    }
}

fn find(dialect: &Dialect, landmark: Landmark) -> usize {
    dialect.skeleton.find(&dialect.expected[&landmark]).expect("a landmark of the dialect")
}

fn add(dialect: &mut Dialect, name: &str, on: usize, offset_m: DVec3) -> usize {
    let parent = Some(on);
    dialect.skeleton.joints.push(SkeletonJoint {
        name: name.to_owned(),
        parent,
        offset_m,
        end_sites_m: Vec::new(),
    });
    dialect.skeleton.joints.len() - 1
}

/// Inserts a joint between a joint and its parent, at the place of the parent.
fn put_before(dialect: &mut Dialect, name: &str, joint: usize) {
    let joints = &mut dialect.skeleton.joints;
    let Some(parent) = joints[joint].parent else { return };
    for parent in joints.iter_mut().filter_map(|joint| joint.parent.as_mut()) {
        *parent += usize::from(*parent >= joint);
    }
    joints[joint].parent = Some(joint);
    let helper = SkeletonJoint {
        name: name.to_owned(),
        parent: Some(parent),
        offset_m: DVec3::ZERO,
        end_sites_m: Vec::new(),
    };
    joints.insert(joint, helper);
}

/// Adds a joint in the middle of the bone that ends in the chest.
fn split_the_bone_below_the_chest(dialect: &mut Dialect) {
    let chest = find(dialect, Landmark::Chest);
    // NAO's trunk is one joint. OpenPose has no chest, and its neck carries the arms: a spine below it would be the
    // chest.
    let Some(below) = dialect.skeleton.joints[chest].parent else { return };
    if dialect.skeleton.joints[chest].name == "Neck" {
        return;
    }
    let joints = &mut dialect.skeleton.joints;
    let half_m = 0.5 * joints[chest].offset_m;
    for parent in joints.iter_mut().filter_map(|joint| joint.parent.as_mut()) {
        *parent += usize::from(*parent >= chest);
    }
    joints[chest].parent = Some(chest);
    joints[chest].offset_m = half_m;
    joints.insert(
        chest,
        SkeletonJoint {
            name: "Spine_7x".to_owned(),
            parent: Some(below),
            offset_m: half_m,
            end_sites_m: Vec::new(),
        },
    );
}
