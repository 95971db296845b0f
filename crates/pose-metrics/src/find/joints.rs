//! Matches the joints of two skeletons by name.

use sinew_mocap::Skeleton;

/// A difference between the joints of a skeleton and the expected joints.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Mismatch {
    /// A joint is missing.
    #[error("joint `{0}`: expected a joint of that name, found none")]
    Lacks(String),
    /// A joint is not expected.
    #[error("joint `{0}`: expected no joint of that name")]
    Has(String),
    /// A joint has another parent.
    #[error("joint `{joint}`: expected it on `{expected}`, found it on `{found}`")]
    HangsElsewhere {
        /// Name of the joint.
        joint: String,
        /// Name of the expected parent.
        expected: String,
        /// Name of the parent that was found.
        found: String,
    },
}

/// Returns, for each joint of `expected`, the joint of that name in `found`, within the subtree of the first
/// joint.
///
/// # Errors
/// [`Mismatch`] for the first joint that differs.
pub fn same_joints(expected: &Skeleton, found: &Skeleton) -> Result<Vec<usize>, Mismatch> {
    let parent = |of: &Skeleton, joint: usize| {
        of.joints[joint].parent.map_or_else(String::new, |parent| of.joints[parent].name.clone())
    };
    let mut joints = Vec::with_capacity(expected.joints.len());
    for (index, joint) in expected.joints.iter().enumerate() {
        let here = found.find(&joint.name).ok_or_else(|| Mismatch::Lacks(joint.name.clone()))?;
        let parents = (parent(expected, index), parent(found, here));
        if index > 0 && parents.0 != parents.1 {
            let (joint, (expected, found)) = (joint.name.clone(), parents);
            return Err(Mismatch::HangsElsewhere { joint, expected, found });
        }
        joints.push(here);
    }
    let (_, below) = found.subtree(joints[0]);
    let extra = below.iter().find(|joint| !joints.contains(joint));
    extra.map_or(Ok(joints), |joint| Err(Mismatch::Has(found.joints[*joint].name.clone())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_figure::builtin;

    #[test]
    fn joints_are_told_by_their_names_whatever_their_order() {
        let skeleton = builtin::clips().swap_remove(0).skeleton;
        let (hand, head) = (skeleton.find("hand_l").unwrap(), skeleton.find("head").unwrap());
        // The head, which has no children, is moved to the end.
        let mut other = skeleton.clone();
        let moved = other.joints.remove(head);
        for parent in other.joints.iter_mut().filter_map(|joint| joint.parent.as_mut()) {
            *parent -= usize::from(*parent > head);
        }
        other.joints.push(moved);
        let joints = same_joints(&skeleton, &other).unwrap();
        assert_eq!((joints[head], joints[hand]), (skeleton.joints.len() - 1, hand - 1));
        let error = |change: &dyn Fn(&mut Skeleton)| {
            let mut other = skeleton.clone();
            change(&mut other);
            same_joints(&skeleton, &other).unwrap_err().to_string()
        };
        assert_eq!(
            error(&|other| other.joints[head].name = "skull".into()),
            "joint `head`: expected a joint of that name, found none"
        );
        let hair = sinew_mocap::SkeletonJoint {
            name: "hair".into(),
            parent: Some(head),
            ..skeleton.joints[head].clone()
        };
        assert_eq!(
            error(&|other| other.joints.push(hair.clone())),
            "joint `hair`: expected no joint of that name"
        );
        assert_eq!(
            error(&|other| other.joints[hand].parent = Some(0)),
            "joint `hand_l`: expected it on `forearm_l`, found it on `pelvis`"
        );
    }
}
