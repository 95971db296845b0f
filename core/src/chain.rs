//! Constructors of bodies by the kind of their joint, and of trees that are one chain.

use glam::Vec3;

use crate::inertia::Inertia;
use crate::joint::JointKind;
use crate::transform::Transform;
use crate::tree::{Body, Tree, TreeError};

impl Body {
    /// Creates a body on a joint of any kind, without a rotor.
    fn on(
        parent: Option<usize>,
        joint: JointKind,
        placement: impl Into<Transform>,
        inertia: Inertia,
    ) -> Self {
        Self { parent, joint, placement: placement.into(), inertia, rotor_inertia: 0.0 }
    }

    /// Creates a body that is welded to its parent.
    ///
    /// `parent`, `placement` and `inertia` are as in [`Body::revolute`].
    pub fn fixed(parent: Option<usize>, placement: impl Into<Transform>, inertia: Inertia) -> Self {
        Self::on(parent, JointKind::Fixed, placement, inertia)
    }

    /// Creates a body that turns about one axis.
    ///
    /// - `parent`: index of the parent body; `None` for the root.
    /// - `axis`: unit vector in the joint frame.
    /// - `placement`: joint frame in the parent's body frame. A [`Vec3`] in m is a frame that is not turned.
    /// - `inertia`: mass properties in the body frame.
    ///
    /// [`Tree::push`] validates the arguments. The drive has no rotor: set [`Body::rotor_inertia`] of a geared drive.
    ///
    /// ```
    /// use sinew_core::{Body, Inertia, JointKind, glam::Vec3};
    /// let link = Inertia::of_box(0.2, Vec3::Y * 0.05, Vec3::new(0.04, 0.1, 0.04));
    /// let forearm = Body { rotor_inertia: 0.01, ..Body::revolute(Some(0), Vec3::X, Vec3::Y * 0.1, link) };
    /// assert_eq!(forearm.joint, JointKind::Revolute { axis: Vec3::X });
    /// assert_eq!(forearm.placement.translation_m, Vec3::Y * 0.1);
    /// ```
    pub fn revolute(
        parent: Option<usize>,
        axis: Vec3,
        placement: impl Into<Transform>,
        inertia: Inertia,
    ) -> Self {
        Self::on(parent, JointKind::Revolute { axis }, placement, inertia)
    }

    /// Creates a body that slides along one axis.
    ///
    /// Arguments are those of [`Body::revolute`].
    pub fn prismatic(
        parent: Option<usize>,
        axis: Vec3,
        placement: impl Into<Transform>,
        inertia: Inertia,
    ) -> Self {
        Self::on(parent, JointKind::Prismatic { axis }, placement, inertia)
    }

    /// Creates a body on a ball joint.
    ///
    /// `parent`, `placement` and `inertia` are as in [`Body::revolute`].
    pub fn spherical(
        parent: Option<usize>,
        placement: impl Into<Transform>,
        inertia: Inertia,
    ) -> Self {
        Self::on(parent, JointKind::Spherical, placement, inertia)
    }
}

impl<const N: usize> Tree<N> {
    /// Creates a chain: the first body is the root, and the parent of each other body is the body before it. O(n).
    ///
    /// The function ignores the parents that the bodies name.
    ///
    /// # Errors
    /// As [`Self::push`].
    ///
    /// ```
    /// use sinew_core::{Body, Inertia, Tree, glam::Vec3};
    /// let inertia = Inertia::of_box(0.2, Vec3::Y * 0.05, Vec3::new(0.04, 0.1, 0.04));
    /// let about = |axis| Body::revolute(None, axis, Vec3::Y * 0.1, inertia);
    /// let arm = Tree::<3>::serial_chain(&[Vec3::Y, Vec3::X, Vec3::X].map(about))?;
    /// assert_eq!([0, 1, 2].map(|body| arm.parent(body)), [None, Some(0), Some(1)]);
    /// # Ok::<(), sinew_core::TreeError>(())
    /// ```
    pub fn serial_chain(bodies: &[Body]) -> Result<Self, TreeError> {
        let mut tree = Self::new();
        for body in bodies {
            let parent = tree.len().checked_sub(1);
            tree.push(Body { parent, ..*body })?;
        }
        Ok(tree)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    #[test]
    fn each_kind_has_its_joint_and_the_placement_as_given() {
        let turned = Transform::new(Quat::from_xyzw(0.0, 0.0, 1.0, 0.0), Vec3::X);
        let inertia = Inertia::of_box(1.0, Vec3::ZERO, Vec3::ONE);
        let of =
            |joint| Body { parent: Some(3), joint, placement: turned, inertia, rotor_inertia: 0.0 };
        let axis = Vec3::Z;
        assert_eq!(Body::fixed(Some(3), turned, inertia), of(JointKind::Fixed));
        assert_eq!(Body::spherical(Some(3), turned, inertia), of(JointKind::Spherical));
        let revolute = Body::revolute(Some(3), axis, turned, inertia);
        assert_eq!(revolute, of(JointKind::Revolute { axis }));
        let prismatic = Body::prismatic(Some(3), axis, turned, inertia);
        assert_eq!(prismatic, of(JointKind::Prismatic { axis }));
    }

    #[test]
    fn a_chain_has_its_own_parents_and_refuses_as_a_tree_does() {
        let body = Body::revolute(Some(7), Vec3::X, Vec3::ZERO, Inertia::default());
        let chain = Tree::<4>::serial_chain(&[body; 3]).unwrap();
        assert_eq!([0, 1, 2].map(|body| chain.parent(body)), [None, Some(0), Some(1)]);
        assert_eq!(Tree::<2>::serial_chain(&[body; 3]), Err(TreeError::Full { capacity: 2 }));
        let skew = Body::revolute(None, Vec3::X * 2.0, Vec3::ZERO, Inertia::default());
        assert!(matches!(
            Tree::<2>::serial_chain(&[body, skew]),
            Err(TreeError::Joint { body: 1, .. })
        ));
        assert!(Tree::<2>::serial_chain(&[]).unwrap().is_empty());
    }
}
