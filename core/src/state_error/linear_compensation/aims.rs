//! Aims of the bodies of a tree.

use core::fmt;

use glam::Vec3;
use heapless::Vec;

use crate::body_set::BodySet;
use crate::fixed;
use crate::tree::Tree;

/// The aim of a body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Aim {
    /// Nothing: a leaf, with World Space Error.
    #[default]
    None,
    /// The origin of this child in the desired figure.
    Child(usize),
    /// The origins of these children together: the rotation minimises the sum of their squared distances from their
    /// positions in the desired figure.
    Children(BodySet),
    /// A point fixed in the body, in body axes of the desired figure, m: (0, 0, d) in the paper.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    Point(Vec3),
}

/// The validated aims of all bodies.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Aims<const N: usize> {
    aims: Vec<Aim, N>,
}

impl<const N: usize> Aims<N> {
    /// Validates aims, one per body. O(n).
    ///
    /// # Errors
    /// [`AimsError`] if the number of aims is not the number of bodies, an aim is not a child of its body, or a point
    /// is not finite.
    pub fn new(tree: &Tree<N>, aims: &[Aim]) -> Result<Self, AimsError> {
        if aims.len() != tree.len() {
            return Err(AimsError::Count { expected: tree.len(), found: aims.len() });
        }
        for (body, aim) in aims.iter().enumerate() {
            match *aim {
                Aim::Child(child) if !tree.children(body).contains(child) => {
                    return Err(AimsError::NotAChild { body, child });
                }
                Aim::Children(set) => {
                    let children = tree.children(body);
                    if let Some(child) = set.iter().find(|child| !children.contains(*child)) {
                        return Err(AimsError::NotAChild { body, child });
                    }
                }
                Aim::Point(point) if !point.is_finite() => {
                    return Err(AimsError::NonFinite { body });
                }
                _ => {}
            }
        }
        Ok(Self { aims: fixed::collect(aims.iter().copied()) })
    }

    /// Aims every body at the child with the heaviest subtree (without masses: with most bodies); among equals, at
    /// the lowest index. O(n · depth).
    ///
    /// It does not aim at the children's mean, because the mean of two hips and a spine is close to zero.
    ///
    /// ```
    /// use sinew_core::{Body, Inertia, JointKind, Transform, Tree, state_error::{Aim, Aims}};
    /// let body = |parent, mass_kg| Body {
    ///     parent,
    ///     joint: JointKind::Spherical,
    ///     placement: Transform::IDENTITY,
    ///     inertia: Inertia { mass_kg, ..Inertia::default() },
    ///     rotor_inertia: 0.0,
    /// };
    /// let tree = Tree::<3>::from_bodies(&[body(None, 1.0), body(Some(0), 1.0), body(Some(0), 2.0)])?;
    /// assert_eq!(Aims::heaviest_child(&tree).as_slice(), [Aim::Child(2), Aim::None, Aim::None]);
    /// # Ok::<(), sinew_core::TreeError>(())
    /// ```
    pub fn heaviest_child(tree: &Tree<N>) -> Self {
        let weight = |body: usize| -> (f32, usize) {
            let subtree = tree.subtree(body);
            let mass = subtree
                .iter()
                .filter_map(|member| tree.bodies().get(member))
                .map(|member| member.inertia.mass_kg)
                .sum();
            (mass, subtree.len())
        };
        // If all masses are zero, the number of bodies decides. Equal masses select the lower index.
        let massless = weight(0).0 <= 0.0;
        let heavier = |a: (f32, usize), b: (f32, usize)| {
            if massless { a.1 > b.1 } else { a.0 > b.0 }
        };
        let aim = |body: usize| {
            let mut best: Option<(usize, (f32, usize))> = None;
            for child in tree.children(body).iter() {
                let candidate = weight(child);
                if best.is_none_or(|(_, so_far)| heavier(candidate, so_far)) {
                    best = Some((child, candidate));
                }
            }
            best.map_or(Aim::None, |(child, _)| Aim::Child(child))
        };
        Self { aims: fixed::collect((0..tree.len()).map(aim)) }
    }

    /// Aims every body at all its children, by least squares.
    ///
    /// A body with a single child aims at this child, like [`Self::heaviest_child`]. O(n).
    ///
    /// ```
    /// use sinew_core::{Body, BodySet, Inertia, JointKind, Transform, Tree, state_error::{Aim, Aims}};
    /// # let body = |parent| Body {
    /// #     parent,
    /// #     joint: JointKind::Spherical,
    /// #     placement: Transform::IDENTITY,
    /// #     inertia: Inertia::default(),
    /// #     rotor_inertia: 0.0,
    /// # };
    /// // Hips with two legs, one of which has a foot.
    /// let tree = Tree::<4>::from_bodies(&[None, Some(0), Some(0), Some(1)].map(body))?;
    /// let legs: BodySet = [1, 2].into_iter().collect();
    /// let aims = [Aim::Children(legs), Aim::Child(3), Aim::None, Aim::None];
    /// assert_eq!(Aims::all_children(&tree).as_slice(), aims);
    /// # Ok::<(), sinew_core::TreeError>(())
    /// ```
    pub fn all_children(tree: &Tree<N>) -> Self {
        let aim = |body: usize| {
            let children = tree.children(body);
            let mut each = children.iter();
            match (each.next(), each.next()) {
                (None, _) => Aim::None,
                (Some(child), None) => Aim::Child(child),
                _ => Aim::Children(children),
            }
        };
        Self { aims: fixed::collect((0..tree.len()).map(aim)) }
    }

    /// Returns the aims by body.
    pub fn as_slice(&self) -> &[Aim] {
        &self.aims
    }
}

/// An error in aims.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum AimsError {
    /// The number of aims is not the number of bodies.
    Count {
        /// Number of bodies.
        expected: usize,
        /// Number of aims.
        found: usize,
    },
    /// A body aims at a body that is not its child.
    NotAChild {
        /// Index of the body.
        body: usize,
        /// Index of the body it aims at.
        child: usize,
    },
    /// A point has a NaN or infinite component.
    NonFinite {
        /// Index of the body.
        body: usize,
    },
}

impl fmt::Display for AimsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { expected, found } => {
                write!(f, "{expected} bodies need as many aims, {found} were given")
            }
            Self::NotAChild { body, child } => {
                write!(f, "body {body} cannot aim at body {child}: it is not one of its children")
            }
            Self::NonFinite { body } => write!(f, "the aim of body {body} is not finite"),
        }
    }
}

impl core::error::Error for AimsError {}
