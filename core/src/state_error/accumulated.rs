//! The generalised accumulated error: every body relative to a chosen ancestor.

use core::fmt;

use heapless::Vec;

use super::StateError;
use crate::fixed;
use crate::state::BodyState;
use crate::tree::Tree;

/// The validated reference body l of each joint: an ancestor, or `None` for the world.
///
/// The paper only requires `l < i`. A body that is not an ancestor is refused: its error would include joints that
/// joint `i` cannot correct.
///
/// ```
/// use sinew_core::state_error::{References, ReferencesError};
/// use sinew_core::{Body, Inertia, JointKind, Transform, Tree};
/// # let body = |parent| Body {
/// #     parent,
/// #     joint: JointKind::Spherical,
/// #     placement: Transform::IDENTITY,
/// #     inertia: Inertia::default(),
/// #     rotor_inertia: 0.0,
/// # };
/// // Hips, spine and head; a leg hangs on the hips.
/// let figure = Tree::<4>::from_bodies(&[None, Some(0), Some(1), Some(0)].map(body))?;
/// assert_eq!(References::egocentric(&figure).as_slice(), [None, Some(0), Some(0), Some(0)]);
/// assert_eq!(References::generations(&figure, 2).as_slice(), [None, None, Some(0), None]);
/// // The leg cannot correct an error of the spine.
/// let refused = References::new(&figure, &[None, None, None, Some(1)]);
/// assert_eq!(refused, Err(ReferencesError::NotAncestor { joint: 3, reference: 1 }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct References<const N: usize> {
    bodies: Vec<Option<usize>, N>,
}

impl<const N: usize> References<N> {
    /// Validates reference bodies, one per joint. O(n).
    ///
    /// # Errors
    /// [`ReferencesError`] if the number of references is not the number of joints, or a reference is not an
    /// ancestor.
    pub fn new(tree: &Tree<N>, references: &[Option<usize>]) -> Result<Self, ReferencesError> {
        if references.len() != tree.len() {
            return Err(ReferencesError::Count { expected: tree.len(), found: references.len() });
        }
        for (joint, reference) in references.iter().enumerate() {
            let is_ancestor = |reference: &usize| tree.is_ancestor(*reference, joint);
            if let Some(reference) = reference.filter(|reference| !is_ancestor(reference)) {
                return Err(ReferencesError::NotAncestor { joint, reference });
            }
        }
        Ok(Self { bodies: fixed::collect(references.iter().copied()) })
    }

    /// Returns the references of the egocentric case: every body relative to the root, the root relative to the
    /// world.
    pub fn egocentric(tree: &Tree<N>) -> Self {
        Self::of_ancestor(tree, 0)
    }

    /// Makes `ancestor` the reference of all bodies beyond it, and the world the reference of `ancestor` and all
    /// other bodies.
    pub fn of_ancestor(tree: &Tree<N>, ancestor: usize) -> Self {
        let seen = |joint| tree.is_ancestor(ancestor, joint).then_some(ancestor);
        Self { bodies: fixed::collect((0..tree.len()).map(seen)) }
    }

    /// Makes the ancestor `count` generations up the reference of every body, or the world if that is beyond the
    /// root. With 1 this is the parent, which gives the local error; with the depth of the tree it gives the world
    /// error. A body cannot be its own reference: 0 counts as 1. O(n · count).
    pub fn generations(tree: &Tree<N>, count: usize) -> Self {
        let above = |joint| (0..count.max(1)).try_fold(joint, |body, _| tree.parent(body));
        Self { bodies: fixed::collect((0..tree.len()).map(above)) }
    }

    /// Returns the reference bodies by joint.
    pub fn as_slice(&self) -> &[Option<usize>] {
        &self.bodies
    }
}

/// An error in reference bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ReferencesError {
    /// The number of references is not the number of joints.
    Count {
        /// Number of joints.
        expected: usize,
        /// Number of references.
        found: usize,
    },
    /// The reference is not an ancestor of the joint's body.
    NotAncestor {
        /// Index of the joint.
        joint: usize,
        /// Index of its reference body.
        reference: usize,
    },
}

impl fmt::Display for ReferencesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { expected, found } => {
                write!(f, "{expected} joints need as many reference bodies, {found} were given")
            }
            Self::NotAncestor { joint, reference } => write!(
                f,
                "body {reference} cannot be the reference of joint {joint}: it is not one of its ancestors"
            ),
        }
    }
}

impl core::error::Error for ReferencesError {}

/// Computes the error of each body relative to its reference body, in the axes of the reference. The desired pose is
/// taken relative to the desired reference, and the measured pose relative to the measured reference.
///
/// With the parent as reference this is [`local`](super::local()), with the world [`world`](super::world()). With
/// an ancestor l between them, it accumulates the errors of the joints between l and body i. O(n).
///
/// ```
/// use sinew_core::{BodyState, Transform, glam::Vec3, state_error::{StateError, accumulated}};
/// let at = |x| BodyState { pose: Transform::from_translation(Vec3::X * x), ..BodyState::WORLD };
/// // Both bodies are off by 0.1 m in the world, but relative to the root, the second has no error.
/// let (desired, measured) = ([at(1.0), at(1.5)], [at(0.9), at(1.4)]);
/// let mut errors = [StateError::ZERO; 2];
/// accumulated(&[None, Some(0)], &desired, &measured, &mut errors);
/// assert!((errors[0].linear_m.x - 0.1).abs() < 1e-6);
/// assert!(errors[1].linear_m.x.abs() < 1e-6);
/// ```
pub fn accumulated(
    references: &[Option<usize>],
    desired: &[BodyState],
    measured: &[BodyState],
    out: &mut [StateError],
) {
    let of_reference = |states: &[BodyState], reference: Option<usize>| {
        reference.and_then(|body| states.get(body)).copied().unwrap_or(BodyState::WORLD)
    };
    for (((reference, of_desired), of_measured), error) in
        references.iter().zip(desired).zip(measured).zip(out)
    {
        *error = StateError::between(
            &of_desired.seen_from(&of_reference(desired, *reference)),
            &of_measured.seen_from(&of_reference(measured, *reference)),
        );
    }
}
