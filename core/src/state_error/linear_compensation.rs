//! Linear Compensation Error: bodies turn so that their child reaches its goal.

use core::fmt;

use glam::{Quat, Vec3};
use heapless::Vec;

use super::StateError;
use crate::math;
use crate::state::BodyState;
use crate::transform::Transform;
use crate::tree::Tree;

/// How strongly, and with which rate term, Linear Compensation acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compensation {
    /// β of eq. (9): 0 is World Space Error exactly, 1 the paper's method.
    pub beta: f32,
    /// The derivative of the compensating rotation.
    pub rate_term: RateTerm,
}

impl Default for Compensation {
    /// β = 1 with the corrected rate.
    fn default() -> Self {
        Self { beta: 1.0, rate_term: RateTerm::default() }
    }
}

/// The extra term of the angular rate in eq. (10).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RateTerm {
    /// `β (z - p_d) × ė_lin / d²`: the rate of the rotation that is really applied, to first order in
    /// the linear error.
    #[default]
    Corrected,
    /// `β ė_lin × (z - p_d) / d²`: the sign as the paper prints it, which fits rotations of the other
    /// sense. For comparison.
    AsPrinted,
    /// No extra term.
    None,
}

/// What a body aims at.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Aim {
    /// Nothing: a leaf. World Space Error.
    #[default]
    None,
    /// The origin of this child, where the desired figure has it.
    Child(usize),
    /// A point fixed in the body, in body axes of the desired figure, m: (0, 0, d) in the paper.
    Point(Vec3),
}

/// What happened to a body's aim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AimStatus {
    /// A leaf: World Space Error.
    #[default]
    Leaf,
    /// Compensated.
    Compensated,
    /// The child lies in the desired direction already: no rotation, but its rate.
    Parallel,
    /// The measured origin is beyond the goal: the shortest rotation is half a turn about no particular
    /// axis, and a figure must not jump: World Space Error.
    Antiparallel,
    /// The measured origin is at the goal, no direction leads there: World Space Error.
    Coincident,
    /// The child sits (almost) at the body's origin, its direction is noise: World Space Error.
    ZeroAim,
}

/// Aims of all bodies, validated once.
#[derive(Debug, Clone, PartialEq)]
pub struct Aims<const N: usize> {
    aims: Vec<Aim, N>,
}

impl<const N: usize> Aims<N> {
    /// Aims by body.
    ///
    /// # Errors
    /// [`AimsError`] if there is not one for each body, one aims at what is not its child, or a point is
    /// not finite.
    pub fn new(tree: &Tree<N>, aims: &[Aim]) -> Result<Self, AimsError> {
        if aims.len() != tree.len() {
            return Err(AimsError::Count { expected: tree.len(), found: aims.len() });
        }
        for (body, aim) in aims.iter().enumerate() {
            match *aim {
                Aim::Child(child) if !tree.children(body).contains(child) => {
                    return Err(AimsError::NotAChild { body, child });
                }
                Aim::Point(point) if !point.is_finite() => {
                    return Err(AimsError::NonFinite { body });
                }
                _ => {}
            }
        }
        Ok(Self { aims: aims.iter().copied().collect() })
    }

    /// Every body aims at the child with the heaviest subtree (without masses: with most bodies), the
    /// lowest index among equals. O(n · depth).
    ///
    /// One child, not their mean: the mean of two hips and a spine is close to zero.
    ///
    /// ```
    /// use sinew_core::{Body, Inertia, JointKind, Transform, Tree, state_error::{Aim, Aims}};
    /// let body = |parent, mass_kg| Body {
    ///     parent,
    ///     joint: JointKind::Spherical,
    ///     placement: Transform::IDENTITY,
    ///     inertia: Inertia { mass_kg, ..Inertia::default() },
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
        // Where all masses are zero, most bodies decide; a tie of masses goes to the lower index.
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
        Self { aims: (0..tree.len()).map(aim).collect() }
    }

    /// The aims by body.
    pub fn as_slice(&self) -> &[Aim] {
        &self.aims
    }
}

/// Why aims were refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum AimsError {
    /// There must be one for each body.
    Count {
        /// Number of bodies.
        expected: usize,
        /// Number of aims.
        found: usize,
    },
    /// A body aims at one that is not its child.
    NotAChild {
        /// The body.
        body: usize,
        /// What it aims at.
        child: usize,
    },
    /// A point has a NaN or infinite component.
    NonFinite {
        /// The body.
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

/// Below this length an aim, or the way to the goal, has no direction in f32: positions of a few metres
/// carry some 5e-7 m of rounding, so a direction over 1 mm is good to 1e-3 rad at best.
const SHORTEST_AIM_M: f32 = 1e-3;

/// Below this sine two directions are parallel to f32 rounding, and the axis between them is noise.
const SMALLEST_SINE: f32 = 1e-6;

/// Linear Compensation Error of each body in world axes: eq. (6)-(10) of Notman et al. (2011). O(n).
///
/// `status` tells what became of each body's aim.
pub fn linear_compensation(
    aims: &[Aim],
    settings: Compensation,
    desired: &[BodyState],
    measured: &[BodyState],
    out: &mut [StateError],
    status: &mut [AimStatus],
) {
    for ((((aim, of_desired), of_measured), error), status) in
        aims.iter().zip(desired).zip(measured).zip(out).zip(status)
    {
        // z - p_d of eq. (6): the goal is where the *desired* figure has the child. Only then is the
        // child's own linear error what is minimised, whatever the model's dimensions.
        let goal_arm = match *aim {
            Aim::None => None,
            Aim::Child(child) => desired
                .get(child)
                .map(|child| child.pose.translation_m - of_desired.pose.translation_m),
            Aim::Point(point) => Some(of_desired.pose.rotation * point),
        };
        (*error, *status) = compensate(goal_arm, settings, of_desired, of_measured);
    }
}

/// Linear Compensation Error of one body, in world axes. `goal_arm_m` is `z - p_d`, from the desired
/// origin to the goal of the aimed child, in world axes; `None` for a leaf.
///
/// Three points where the paper's printed form does not do what its text wants are put right: the angle
/// is taken by atan2, the rotation turns *towards* the goal, and the rate has the sign of that rotation
/// ([`RateTerm`]).
///
/// ```
/// use sinew_core::{BodyState, Transform, glam::Vec3};
/// use sinew_core::state_error::{AimStatus, Compensation, compensate};
/// // The measured body hangs 0.1 m beside the desired one: to reach the goal 0.3 m below, it must turn.
/// let desired = BodyState::WORLD;
/// let measured = BodyState { pose: Transform::from_translation(Vec3::X * 0.1), ..BodyState::WORLD };
/// let goal_arm = Some(Vec3::new(0.0, -0.3, 0.0));
/// let (error, status) = compensate(goal_arm, Compensation::default(), &desired, &measured);
/// assert_eq!(status, AimStatus::Compensated);
/// assert!((error.angular_rad.z + (0.1f32 / 0.3).atan()).abs() < 1e-6);
/// ```
pub fn compensate(
    goal_arm_m: Option<Vec3>,
    settings: Compensation,
    desired: &BodyState,
    measured: &BodyState,
) -> (StateError, AimStatus) {
    let world = StateError::between(desired, measured);
    let Some(arm) = goal_arm_m else { return (world, AimStatus::Leaf) };
    let distance = math::length(arm);
    if distance < SHORTEST_AIM_M {
        return (world, AimStatus::ZeroAim);
    }
    // z - p_m; the difference of the origins first, so that its rounding does not grow with the distance
    // from the world's origin, and a figure without error is not turned.
    let way = world.linear_m + arm;
    let way_length = math::length(way);
    if way_length < SHORTEST_AIM_M {
        return (world, AimStatus::Coincident);
    }
    let r_desired = arm * (1.0 / distance); // (7)
    let r_measured = way * (1.0 / way_length); // (8)
    let axis = r_desired.cross(r_measured);
    let (sine, cosine) = (math::length(axis), r_desired.dot(r_measured));

    let (turn, status) = if sine >= SMALLEST_SINE {
        let angle = math::atan2(sine, cosine);
        (math::exp(axis * (settings.beta * angle / sine)), AimStatus::Compensated)
    } else if cosine > 0.0 {
        (Quat::IDENTITY, AimStatus::Parallel)
    } else {
        return (world, AimStatus::Antiparallel);
    };
    let turned = Transform { rotation: turn * desired.pose.rotation, ..desired.pose }; // (9)
    let mut error = StateError::between(&BodyState { pose: turned, ..*desired }, measured); // (10)

    let rate = arm.cross(error.linear_rate_m_s) * (settings.beta / (distance * distance));
    error.angular_rate_rad_s += match settings.rate_term {
        RateTerm::Corrected => rate,
        RateTerm::AsPrinted => -rate,
        RateTerm::None => Vec3::ZERO,
    };
    (error, status)
}
