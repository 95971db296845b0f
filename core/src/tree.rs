//! The rig: a validated tree of bodies in regular numbering.

use core::fmt;

use glam::Quat;
use heapless::Vec;

use crate::body_set::BodySet;
use crate::inertia::{Inertia, InertiaError};
use crate::joint::{JointError, JointKind};
use crate::math;
use crate::transform::Transform;

/// A body, and the joint that connects it to its parent.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct Body {
    /// Index of the parent body (λ); `None` only for the root, whose parent is the world.
    pub parent: Option<usize>,
    /// Kind of the joint: the motions that it allows.
    pub joint: JointKind,
    /// Pose of the joint frame in the parent's body frame. The joint's own motion leads from the joint frame to the
    /// body frame.
    pub placement: Transform,
    /// Mass properties in the body frame.
    pub inertia: Inertia,
    /// Inertia that the rotor of the joint's drive adds to each of its dofs, after the gear: `J n²` for a rotor with
    /// inertia J and a gear ratio n. In kg m², or in kg for a joint that slides; zero without a rotor. Simulators
    /// call this value armature.
    ///
    /// The rotor resists acceleration along the joint only; the parent does not feel it. A fixed or a free joint has
    /// no drive and must have zero.
    #[cfg_attr(feature = "serde", serde(default, deserialize_with = "crate::read::finite"))]
    pub rotor_inertia: f32,
}

impl Body {
    /// Returns the rotation of the body in the joint frame if the motion subspace depends on it (universal joints
    /// only), else the identity. `rotation` is the body's rotation in its parent's frame.
    #[inline]
    pub(crate) fn rotation_in_joint(&self, rotation: Quat) -> Quat {
        if matches!(self.joint, JointKind::Universal { .. }) {
            self.turn_from_placement(rotation)
        } else {
            Quat::IDENTITY
        }
    }

    /// Returns the rotation of the body in the joint frame. Never inlined, since most joints do not need it.
    #[inline(never)]
    fn turn_from_placement(&self, rotation: Quat) -> Quat {
        self.placement.rotation.conjugate() * rotation
    }
}

/// A tree of at most `N` bodies (`N` up to [`BodySet::CAPACITY`]), immutable once built.
///
/// The sets have the paper's names: λ parent, κ supporters, ν subtree, µ children.
///
/// ```
/// use sinew_core::{Body, Inertia, JointKind, Transform, Tree, TreeError, glam::Vec3};
/// let body = |parent, x| Body {
///     parent,
///     joint: JointKind::Spherical,
///     placement: Transform::from_translation(Vec3::new(x, 0.0, 0.0)),
///     inertia: Inertia::default(),
///     rotor_inertia: 0.0,
/// };
/// let mut rig = Tree::<3>::new();
/// rig.push(body(None, 0.0))?;
/// rig.push(body(Some(0), 0.2))?;
/// rig.push(body(Some(1), 0.3))?;
/// assert!(rig.is_leaf(2) && !rig.is_leaf(0));
/// assert_eq!(rig.supporters(2).iter().collect::<Vec<_>>(), [0, 1, 2]);
/// assert_eq!(rig.push(body(Some(1), 0.1)), Err(TreeError::Full { capacity: 3 }));
/// # Ok::<(), TreeError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Tree<const N: usize> {
    bodies: Vec<Body, N>,
    /// Bodies that have children. The other sets are computed from the parents when they are needed: stored for
    /// each body, they would take a third of the tree's memory.
    inner: BodySet,
    shape: u32,
}

impl<const N: usize> Tree<N> {
    /// Creates an empty tree.
    pub fn new() -> Self {
        const { assert!(N <= BodySet::CAPACITY, "a tree holds at most BodySet::CAPACITY bodies") };
        Self { bodies: Vec::new(), inner: BodySet::EMPTY, shape: 0x811c_9dc5 }
    }

    /// Creates a tree from bodies, in their order. O(n).
    ///
    /// # Errors
    /// As in [`Self::push`].
    pub fn from_bodies(bodies: &[Body]) -> Result<Self, TreeError> {
        let mut tree = Self::new();
        for body in bodies {
            tree.push(*body)?;
        }
        Ok(tree)
    }

    /// Adds a body and returns its index. O(1).
    ///
    /// # Errors
    /// [`TreeError`], and the tree is unchanged, if the tree is full, the parent was not added before, there is already
    /// a root, a number of the body is invalid, or a fixed or free joint has a rotor.
    pub fn push(&mut self, body: Body) -> Result<usize, TreeError> {
        let index = self.bodies.len();
        if index == N {
            return Err(TreeError::Full { capacity: N });
        }
        match body.parent {
            None if index > 0 => return Err(TreeError::SecondRoot { body: index }),
            Some(parent) if parent >= index => {
                return Err(TreeError::ParentNotFirst { body: index, parent });
            }
            _ => {}
        }
        body.joint.validate().map_err(|error| TreeError::Joint { body: index, error })?;
        let rotation = body.placement.rotation;
        if !body.placement.is_finite() {
            return Err(TreeError::NonFinitePlacement { body: index });
        }
        if !math::is_unit(rotation) {
            return Err(TreeError::RotationNotUnit { body: index });
        }
        body.inertia.validate().map_err(|error| TreeError::Inertia { body: index, error })?;
        let value = body.rotor_inertia;
        if !(0.0..=f32::MAX).contains(&value) {
            return Err(TreeError::RotorInertia { body: index, value });
        }
        if value > 0.0 && matches!(body.joint, JointKind::Fixed | JointKind::Free) {
            return Err(TreeError::RotorWithoutDrive { body: index, value });
        }

        let placement = Transform::new(math::unit(rotation), body.placement.translation_m);
        self.bodies
            .push(Body { joint: body.joint.normalized(), placement, ..body })
            .map_err(|_| TreeError::Full { capacity: N })?;
        let after_parent = body.parent.map_or(0, |parent| parent.saturating_add(1));
        let word = u32::try_from(after_parent).unwrap_or(u32::MAX);
        self.shape = (self.shape ^ word).wrapping_mul(0x0100_0193);
        if let Some(parent) = body.parent {
            self.inner.insert(parent);
        }
        Ok(index)
    }

    /// Returns the bodies in regular numbering.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Returns a hash (FNV-1a) of the parents. World states depend only on joint states and on these parents.
    pub(crate) fn shape(&self) -> u32 {
        self.shape
    }

    /// Returns the number of bodies.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Returns `true` if there is no body.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Returns λ, the parent of a body; `None` for the root, and if there is no such body.
    pub fn parent(&self, body: usize) -> Option<usize> {
        self.bodies.get(body).and_then(|body| body.parent)
    }

    /// Returns κ, the joints that support a body, from the root to its own. O(depth).
    pub fn supporters(&self, body: usize) -> BodySet {
        self.inward(body).collect()
    }

    /// Returns ν, the bodies that joint `body` moves, including `body`. O(n).
    pub fn subtree(&self, body: usize) -> BodySet {
        let mut subtree = BodySet::EMPTY;
        if body < self.len() {
            subtree.insert(body);
        }
        // Parents come first.
        for (index, other) in self.bodies.iter().enumerate().skip(body) {
            if other.parent.is_some_and(|parent| subtree.contains(parent)) {
                subtree.insert(index);
            }
        }
        subtree
    }

    /// Returns µ, the children of a body. O(n).
    pub fn children(&self, body: usize) -> BodySet {
        let bodies = self.bodies.iter().enumerate();
        bodies.filter(|(_, other)| other.parent == Some(body)).map(|(index, _)| index).collect()
    }

    /// Returns `true` if a body has no children. O(1).
    pub fn is_leaf(&self, body: usize) -> bool {
        body < self.len() && !self.inner.contains(body)
    }

    /// Returns the bodies without children, in rising order. O(n).
    pub fn leaves(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.len()).filter(|body| self.is_leaf(*body))
    }

    /// Returns `true` if `ancestor` supports `body` and is not `body` itself. O(depth).
    pub fn is_ancestor(&self, ancestor: usize, body: usize) -> bool {
        self.inward(body).skip(1).any(|supporter| supporter == ancestor)
    }

    /// Returns a body, if it exists, and its ancestors, up to the root.
    fn inward(&self, body: usize) -> impl Iterator<Item = usize> + '_ {
        let first = (body < self.len()).then_some(body);
        core::iter::successors(first, |body| self.parent(*body))
    }
}

// Not derived, so that a capacity that is too large does not compile here either.
impl<const N: usize> Default for Tree<N> {
    fn default() -> Self {
        Self::new()
    }
}

/// An error in a body that was to be added to a tree.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TreeError {
    /// The tree is full.
    Full {
        /// Maximum number of bodies.
        capacity: usize,
    },
    /// The parent was not added before its child, or is the child itself.
    ParentNotFirst {
        /// Index of the body.
        body: usize,
        /// Index of its parent.
        parent: usize,
    },
    /// A body after the first has no parent.
    SecondRoot {
        /// Index of the body.
        body: usize,
    },
    /// The placement of the joint has a NaN or infinite component.
    NonFinitePlacement {
        /// Index of the body.
        body: usize,
    },
    /// The rotation of the joint's placement is not a unit quaternion.
    RotationNotUnit {
        /// Index of the body.
        body: usize,
    },
    /// The joint model is invalid.
    Joint {
        /// Index of the body.
        body: usize,
        /// Error in the joint model.
        error: JointError,
    },
    /// No real body has these mass properties.
    Inertia {
        /// Index of the body.
        body: usize,
        /// Error in the mass properties.
        error: InertiaError,
    },
    /// The rotor inertia is NaN, infinite or negative.
    RotorInertia {
        /// Index of the body.
        body: usize,
        /// Rotor inertia, kg m² or kg.
        value: f32,
    },
    /// A fixed or free joint, which has no drive, has a rotor inertia.
    RotorWithoutDrive {
        /// Index of the body.
        body: usize,
        /// Rotor inertia, kg m² or kg.
        value: f32,
    },
}

impl fmt::Display for TreeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Full { capacity } => write!(f, "the tree is full: it holds {capacity} bodies"),
            Self::ParentNotFirst { body, parent } => write!(
                f,
                "body {body} names body {parent} as its parent; a parent must come before its children"
            ),
            Self::SecondRoot { body } => {
                write!(f, "body {body} has no parent, but body 0 is the root; give it a parent")
            }
            Self::NonFinitePlacement { body } => {
                write!(f, "the placement of joint {body} is not finite")
            }
            Self::RotationNotUnit { body } => {
                write!(f, "the placement of joint {body} needs a unit quaternion")
            }
            Self::Joint { body, error } => write!(f, "joint {body}: {error}"),
            Self::Inertia { body, error } => write!(f, "body {body}: {error}"),
            Self::RotorInertia { body, value } => {
                write!(
                    f,
                    "body {body}: the rotor inertia is {value}; it must be a finite number, zero or more"
                )
            }
            Self::RotorWithoutDrive { body, value } => write!(
                f,
                "body {body}: the rotor inertia is {value}; it must be 0, since a fixed or free joint has no drive"
            ),
        }
    }
}

impl core::error::Error for TreeError {}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn body(parent: Option<usize>) -> Body {
        Body {
            parent,
            joint: JointKind::Spherical,
            placement: Transform::IDENTITY,
            inertia: Inertia::default(),
            rotor_inertia: 0.0,
        }
    }

    #[test]
    fn every_refusal_has_its_name_and_leaves_the_tree_as_it_was() {
        let mut tree = Tree::<4>::new();
        assert_eq!(tree.push(body(Some(0))), Err(TreeError::ParentNotFirst { body: 0, parent: 0 }));
        tree.push(body(None)).unwrap();
        assert_eq!(tree.push(body(None)), Err(TreeError::SecondRoot { body: 1 }));
        assert_eq!(tree.push(body(Some(1))), Err(TreeError::ParentNotFirst { body: 1, parent: 1 }));
        let nan = Transform::from_translation(Vec3::new(0.0, f32::NAN, 0.0));
        assert_eq!(
            tree.push(Body { placement: nan, ..body(Some(0)) }),
            Err(TreeError::NonFinitePlacement { body: 1 })
        );
        let long = Transform::new(Quat::from_xyzw(0.0, 0.0, 0.0, 2.0), Vec3::ZERO);
        assert_eq!(
            tree.push(Body { placement: long, ..body(Some(0)) }),
            Err(TreeError::RotationNotUnit { body: 1 })
        );
        let axis = JointKind::Revolute { axis: Vec3::ZERO };
        assert_eq!(
            tree.push(Body { joint: axis, ..body(Some(0)) }),
            Err(TreeError::Joint { body: 1, error: JointError::AxisNotUnit { length: 0.0 } })
        );
        let inertia = Inertia { mass_kg: f32::INFINITY, ..Inertia::default() };
        assert_eq!(
            tree.push(Body { inertia, ..body(Some(0)) }),
            Err(TreeError::Inertia { body: 1, error: InertiaError::NonFinite("mass") })
        );
        for value in [-0.1, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(
                tree.push(Body { rotor_inertia: value, ..body(Some(0)) }),
                Err(TreeError::RotorInertia { body: 1, value })
            );
        }
        let nan = tree.push(Body { rotor_inertia: f32::NAN, ..body(Some(0)) });
        assert!(matches!(nan, Err(TreeError::RotorInertia { body: 1, value }) if value.is_nan()));
        for joint in [JointKind::Fixed, JointKind::Free] {
            assert_eq!(
                tree.push(Body { joint, rotor_inertia: 0.1, ..body(Some(0)) }),
                Err(TreeError::RotorWithoutDrive { body: 1, value: 0.1 })
            );
        }
        assert_eq!(tree.len(), 1);
    }

    #[test]
    fn the_sets_follow_the_tree() {
        //      0
        //     / \
        //    1   3
        //    |   |
        //    2   4
        let tree =
            Tree::<8>::from_bodies(&[None, Some(0), Some(1), Some(0), Some(3)].map(body)).unwrap();
        let list = |set: BodySet| set.iter().collect::<heapless::Vec<usize, 8>>();
        assert_eq!(list(tree.supporters(4)), [0, 3, 4]);
        assert_eq!(list(tree.subtree(3)), [3, 4]);
        assert_eq!(list(tree.subtree(0)), [0, 1, 2, 3, 4]);
        assert_eq!(list(tree.children(0)), [1, 3]);
        assert_eq!(tree.leaves().collect::<heapless::Vec<usize, 8>>(), [2, 4]);
        assert_eq!(tree.parent(4), Some(3));
        assert!(tree.is_ancestor(0, 4) && !tree.is_ancestor(1, 4) && !tree.is_ancestor(4, 4));
    }

    #[test]
    fn the_largest_tree_can_be_filled() {
        let mut chain = Tree::<128>::new();
        for index in 0..128usize {
            assert_eq!(chain.push(body(index.checked_sub(1))), Ok(index));
        }
        assert_eq!(chain.push(body(Some(0))), Err(TreeError::Full { capacity: 128 }));
        assert_eq!(chain.supporters(127).len(), 128);
    }
}
