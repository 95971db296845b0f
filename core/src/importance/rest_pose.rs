//! The skeleton on which importance is measured.

use core::fmt;

use glam::Vec3;
use heapless::Vec;

use crate::body_set::BodySet;
use crate::fixed;
use crate::transform::Transform;
use crate::tree::Tree;

/// A validated skeleton of 1 to `N` joints (`N` up to [`BodySet::CAPACITY`]) at rest: a tree with joints in any
/// order, and their positions.
///
/// ```
/// use sinew_core::{glam::Vec3, importance::{RestPose, RestPoseError}};
/// let positions_m = [Vec3::X, Vec3::ZERO, Vec3::Y];
/// let rest_pose = RestPose::<3>::new(&[Some(1), None, Some(0)], &positions_m)?;
/// assert_eq!(rest_pose.descendants(1).iter().collect::<Vec<_>>(), [0, 2]);
/// let loop_of_two = RestPose::<3>::new(&[Some(2), None, Some(0)], &positions_m);
/// assert_eq!(loop_of_two, Err(RestPoseError::Loop { joint: 2 }));
/// # Ok::<(), RestPoseError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct RestPose<const N: usize> {
    parents: Vec<Option<usize>, N>,
    positions_m: Vec<Vec3, N>,
    /// Indices of the joints, parents first.
    outwards: Vec<usize, N>,
}

impl<const N: usize> RestPose<N> {
    /// Validates a skeleton: the parent of each joint, in any order, and its position in world axes in m. O(n²).
    ///
    /// # Errors
    /// [`RestPoseError`] if there is no joint or more than `N`, the number of positions is not the number of joints,
    /// a position is not finite, a parent does not exist, a second joint has no parent, or a joint is its own
    /// ancestor.
    pub fn new(parents: &[Option<usize>], positions_m: &[Vec3]) -> Result<Self, RestPoseError> {
        const { assert!(N <= BodySet::CAPACITY, "a rest pose holds at most BodySet::CAPACITY joints") };
        let count = parents.len();
        if count == 0 {
            return Err(RestPoseError::Empty);
        }
        if count > N {
            return Err(RestPoseError::Full { capacity: N });
        }
        if positions_m.len() != count {
            return Err(RestPoseError::Count { expected: count, found: positions_m.len() });
        }
        if let Some(joint) = positions_m.iter().position(|position_m| !position_m.is_finite()) {
            return Err(RestPoseError::NonFinitePosition { joint });
        }
        let outwards = outwards(parents)?;
        Ok(Self {
            parents: fixed::collect(parents.iter().copied()),
            positions_m: fixed::collect(positions_m.iter().copied()),
            outwards,
        })
    }

    /// Returns the skeleton of a rig with every joint in the zero pose of its joint frame. Joints have the indices of
    /// their bodies. O(n²).
    ///
    /// # Errors
    /// [`RestPoseError`] if the tree has no body, or a position is too large for f32.
    pub fn of_tree(tree: &Tree<N>) -> Result<Self, RestPoseError> {
        let mut poses = Vec::<Transform, N>::new();
        for body in tree.bodies() {
            let parent = body.parent.and_then(|parent| poses.get(parent).copied());
            let pose = parent.map_or(body.placement, |parent| parent * body.placement);
            if poses.push(pose).is_err() {
                break; // Unreachable: the tree holds no more.
            }
        }
        let parents: Vec<Option<usize>, N> =
            fixed::collect(tree.bodies().iter().map(|body| body.parent));
        let positions_m: Vec<Vec3, N> = fixed::collect(poses.iter().map(|pose| pose.translation_m));
        Self::new(&parents, &positions_m)
    }

    /// Returns the number of joints, at least one.
    #[expect(clippy::len_without_is_empty, reason = "it is never empty")]
    pub fn len(&self) -> usize {
        self.parents.len()
    }

    /// Returns the parent of a joint; `None` for the root, and if there is no such joint.
    pub fn parent(&self, joint: usize) -> Option<usize> {
        self.parents.get(joint).copied().flatten()
    }

    /// Returns the position of a joint in world axes in m; the origin if there is no such joint.
    pub fn position_m(&self, joint: usize) -> Vec3 {
        self.positions_m.get(joint).copied().unwrap_or_default()
    }

    /// Returns the joints beyond a joint, without the joint itself. O(n).
    pub fn descendants(&self, joint: usize) -> BodySet {
        let mut descendants = BodySet::EMPTY;
        for &other in &self.outwards {
            let hangs = |parent| parent == joint || descendants.contains(parent);
            if self.parent(other).is_some_and(hangs) {
                descendants.insert(other);
            }
        }
        descendants
    }

    /// Returns the joints from a joint's parent to the root.
    pub(super) fn ancestors(&self, joint: usize) -> impl Iterator<Item = usize> + '_ {
        core::iter::successors(self.parent(joint), |joint| self.parent(*joint))
    }

    /// Returns the joints from the leaves to the root: children before their parents.
    pub(super) fn inwards(&self) -> impl Iterator<Item = usize> + '_ {
        self.outwards.iter().rev().copied()
    }
}

/// Sorts the joints with parents first, breadth first.
fn outwards<const N: usize>(parents: &[Option<usize>]) -> Result<Vec<usize, N>, RestPoseError> {
    let mut outwards = Vec::new();
    for (joint, &parent) in parents.iter().enumerate() {
        if let Some(parent) = parent {
            if parent >= parents.len() {
                return Err(RestPoseError::NoSuchParent { joint, parent });
            }
        } else if let Some(&root) = outwards.first() {
            return Err(RestPoseError::SecondRoot { joint, root });
        } else {
            let _ = outwards.push(joint); // There is room: each joint is reached once.
        }
    }
    let mut reached = BodySet::EMPTY;
    let mut next = 0;
    while let Some(&joint) = outwards.get(next) {
        reached.insert(joint);
        for (child, _) in parents.iter().enumerate().filter(|(_, parent)| **parent == Some(joint)) {
            let _ = outwards.push(child);
        }
        next = next.saturating_add(1);
    }
    let Some(astray) = (0..parents.len()).find(|joint| !reached.contains(*joint)) else {
        return Ok(outwards);
    };
    // Going up as many steps as there are joints ends inside the loop.
    let up = |joint: usize| parents.get(joint).copied().flatten().unwrap_or(joint);
    Err(RestPoseError::Loop { joint: parents.iter().fold(astray, |joint, _| up(joint)) })
}

/// An error in a skeleton.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RestPoseError {
    /// There is no joint.
    Empty,
    /// There are more joints than the capacity.
    Full {
        /// Maximum number of joints.
        capacity: usize,
    },
    /// The number of positions is not the number of joints.
    Count {
        /// Number of joints.
        expected: usize,
        /// Number of positions.
        found: usize,
    },
    /// A position has a NaN or infinite component.
    NonFinitePosition {
        /// Index of the joint.
        joint: usize,
    },
    /// The parent of a joint does not exist.
    NoSuchParent {
        /// Index of the joint.
        joint: usize,
        /// The invalid parent index.
        parent: usize,
    },
    /// A second joint has no parent.
    SecondRoot {
        /// Index of the second root.
        joint: usize,
        /// Index of the first joint without a parent.
        root: usize,
    },
    /// A joint is its own ancestor. This is also the error if every joint has a parent.
    Loop {
        /// Index of a joint in the loop.
        joint: usize,
    },
}

impl fmt::Display for RestPoseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("a rest pose needs at least one joint"),
            Self::Full { capacity } => write!(f, "there is room for {capacity} joints only"),
            Self::Count { expected, found } => {
                write!(f, "{expected} joints need as many positions, {found} were given")
            }
            Self::NonFinitePosition { joint } => {
                write!(f, "the position of joint {joint} is not finite")
            }
            Self::NoSuchParent { joint, parent } => {
                write!(f, "joint {joint} names joint {parent} as its parent, which does not exist")
            }
            Self::SecondRoot { joint, root } => {
                write!(
                    f,
                    "joint {joint} has no parent, but joint {root} is the root; give it a parent"
                )
            }
            Self::Loop { joint } => {
                write!(
                    f,
                    "joint {joint} is its own ancestor; one joint must be without a parent, above all others"
                )
            }
        }
    }
}

impl core::error::Error for RestPoseError {}
