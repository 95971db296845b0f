//! State errors: the difference between the desired and the measured figure, by the methods of Notman, Carlisle &
//! Manning, "Methods for Measuring State Error for Control of Animated Human Figures" (2011).
//!
//! | method | error of body i | reference frame |
//! | --- | --- | --- |
//! | [`local`] (3) | joint state | parent's |
//! | [`world`] (4) | world state | world |
//! | [`accumulated`] | state relative to an ancestor `l` | `l`'s; `l` = root is the egocentric case |
//! | [`linear_compensation`] (6)-(10) | world state, with the desired state turned towards the child's goal | world |
//!
//! The difference of two rotations is the rotation vector from the measured to the desired rotation, `Log(R_d R_mᵀ)`,
//! in the axes of the reference frame.

mod accumulated;
mod linear_compensation;
mod local;
mod world;

pub use accumulated::{References, ReferencesError, accumulated};
pub(crate) use linear_compensation::aimed;
pub use linear_compensation::{
    Aim, AimStatus, Aims, AimsError, Compensation, RateTerm, compensate, compensate_all,
    linear_compensation,
};
pub use local::local;
pub(crate) use local::of_joint;
pub use world::world;

use glam::{Quat, Vec3};

use crate::body_weight::BodyWeights;
use crate::math;
use crate::state::BodyState;

/// The difference between the desired and the measured state of a body, and its rate, in the axes of the method's
/// reference frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct StateError {
    /// Rotation vector from the measured to the desired orientation, rad.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub angular_rad: Vec3,
    /// Desired minus measured position, m.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub linear_m: Vec3,
    /// Desired minus measured angular velocity, rad/s.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub angular_rate_rad_s: Vec3,
    /// Desired minus measured linear velocity, m/s.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub linear_rate_m_s: Vec3,
}

impl StateError {
    /// Zero error: desired equals measured.
    pub const ZERO: Self = Self {
        angular_rad: Vec3::ZERO,
        linear_m: Vec3::ZERO,
        angular_rate_rad_s: Vec3::ZERO,
        linear_rate_m_s: Vec3::ZERO,
    };

    /// Returns the error of a body whose two states are given in the same frame, in the axes of that frame.
    ///
    /// The rate of the rotation vector is `ω_d - ω_m` to first order, and exactly in the direction that damping
    /// needs: `d/dt |e|²/2 = e · (ω_d - ω_m)`.
    ///
    /// ```
    /// use sinew_core::{BodyState, Transform, glam::Vec3, math, state_error::StateError};
    /// let turned = Transform::new(math::exp(Vec3::new(0.0, 0.2, 0.0)), Vec3::X);
    /// let desired = BodyState { pose: turned, ..BodyState::WORLD };
    /// let error = StateError::between(&desired, &BodyState::WORLD);
    /// assert!((error.angular_rad.y - 0.2).abs() < 1e-6);
    /// assert_eq!(error.linear_m, Vec3::X);
    /// ```
    #[inline]
    pub fn between(desired: &BodyState, measured: &BodyState) -> Self {
        Self::to_rotation(desired.pose.rotation, desired, measured)
    }

    /// Returns the error like [`Self::between`], with another desired rotation.
    #[inline]
    fn to_rotation(rotation: Quat, desired: &BodyState, measured: &BodyState) -> Self {
        Self {
            angular_rad: math::log(math::turn_in_world(measured.pose.rotation, rotation)),
            linear_m: desired.pose.translation_m - measured.pose.translation_m,
            angular_rate_rad_s: desired.velocity.angular - measured.velocity.angular,
            linear_rate_m_s: desired.velocity.linear - measured.velocity.linear,
        }
    }
}

/// A method of measuring the state error, with its parameters. `N` is the tree's capacity.
///
/// ```
/// use sinew_core::state_error::{Aims, Compensation, Method, References};
/// use sinew_core::{Body, TorqueController, ControllerError, Inertia, JointKind, Transform, Tree};
/// use sinew_core::control::Gains;
/// # let body = |parent| Body {
/// #     parent,
/// #     joint: JointKind::Spherical,
/// #     placement: Transform::IDENTITY,
/// #     inertia: Inertia::default(),
/// #     rotor_inertia: 0.0,
/// # };
/// let figure = Tree::<3>::from_bodies(&[None, Some(0), Some(1)].map(body))?;
/// let linear_compensation = Method::LinearCompensation {
///     aims: Aims::heaviest_child(&figure),
///     settings: Compensation::default(),
/// };
/// let egocentric = Method::Accumulated(References::egocentric(&figure));
/// let gains = Gains::critically_damped(200.0)?;
/// for method in [Method::Local, Method::World, egocentric, linear_compensation.clone()] {
///     TorqueController::new(figure.clone(), gains, method)?;
/// }
/// // A method that was made for another figure is refused.
/// let other = Tree::<3>::from_bodies(&[body(None)])?;
/// let refused = TorqueController::new(other, gains, linear_compensation);
/// assert!(matches!(refused, Err(ControllerError::Aims(_))));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case", deny_unknown_fields)
)]
pub enum Method<const N: usize> {
    /// Local Space Error, eq. (3).
    Local,
    /// World Space Error, eq. (4).
    World,
    /// Accumulated error seen from an ancestor of each body.
    Accumulated(References<N>),
    /// Linear Compensation Error, eq. (6)-(10).
    LinearCompensation {
        /// Aim of each body.
        aims: Aims<N>,
        /// Strength and rate term.
        settings: Compensation,
    },
    /// World Space Error that commands accelerations of bodies instead of joints. A body's world error then does not
    /// depend on its ancestors' errors, see [`resolved_acceleration`](crate::dynamics::resolved_acceleration). It
    /// needs inverse dynamics.
    ResolvedAcceleration {
        /// Weights of the bodies, used when not every body can reach its acceleration.
        weights: BodyWeights<N>,
    },
}
