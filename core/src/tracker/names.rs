//! The names of methods and settings in files, options and tables, defined only in this module.

use core::fmt;

macro_rules! methods {
    ($($variant:ident = $name:literal, $label:literal, $summary:literal;)*) => {
        /// A method of measuring the state error, or a complete setting that includes such a method.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub enum MethodName {
            $(
                #[doc = concat!($summary, ".")]
                #[cfg_attr(feature = "serde", serde(rename = $name))]
                $variant,
            )*
        }

        impl MethodName {
            /// All methods.
            pub const EVERY: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// Returns the name in options and files.
            pub const fn as_str(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }

            /// Returns the name in headings.
            pub const fn label(self) -> &'static str {
                match self {
                    $(Self::$variant => $label,)*
                }
            }

            /// Returns a one-line description.
            pub const fn summary(self) -> &'static str {
                match self {
                    $(Self::$variant => $summary,)*
                }
            }
        }
    };
}

methods! {
    Local = "local", "Local", "Local Space Error: every joint relative to its parent";
    World = "world", "World", "World Space Error";
    Egocentric = "egocentric", "Egocentric",
        "Every body relative to the root, the root relative to the world";
    Accumulated = "accumulated", "Accumulated",
        "Descendants of `reference` relative to that body, all others relative to the world";
    LinearCompensation = "linear_compensation", "Linear Compensation",
        "Linear Compensation Error: bodies turn so that their child reaches its goal";
    ManifoldProjection = "manifold_projection", "Manifold Projection",
        "World Space Error with the rig's pose nearest to the performance as the goal";
    ResolvedAcceleration = "resolved_acceleration", "Resolved Acceleration",
        "Joint accelerations by which the world space errors of all bodies follow one law";
    Recommended = "recommended", "Recommended",
        "For real rigs: manifold projection, aligned differences, implicit gains, an observer that predicts";
}

impl MethodName {
    /// The paper's three methods, in the paper's order.
    pub const PAPER: [Self; 3] = [Self::Local, Self::World, Self::LinearCompensation];

    /// All methods except [`Self::Accumulated`], which equals [`Self::Egocentric`] unless
    /// [`Settings::reference`](super::Settings::reference) names a body other than the root.
    pub const ALL: [Self; 7] = [
        Self::Local,
        Self::World,
        Self::Egocentric,
        Self::LinearCompensation,
        Self::ManifoldProjection,
        Self::ResolvedAcceleration,
        Self::Recommended,
    ];

    /// Returns the method with this name.
    ///
    /// ```
    /// use sinew_core::tracker::MethodName;
    /// assert_eq!(MethodName::from_name("linear_compensation"), Some(MethodName::LinearCompensation));
    /// assert_eq!(MethodName::from_name("wrold"), None);
    /// ```
    pub fn from_name(name: &str) -> Option<Self> {
        Self::EVERY.into_iter().find(|method| method.as_str() == name)
    }
}

impl fmt::Display for MethodName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// The distribution of the projection's rotation weight among the bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum WeightsName {
    /// All bodies have the same weight.
    Uniform,
    /// Weights by importance: the length of the bones beyond a body's joint. Their mean is `rotation_m`.
    Lengths,
}

/// The frames whose differences give desired velocities and accelerations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Differences {
    /// The current frame and the next two, as in the paper.
    Forward,
    /// The frames before and after, and the current frame. Desired velocities are then for the same instant as
    /// measured ones.
    Aligned,
    /// The current frame and the two before it: for a live stream, whose next frame is unknown.
    Live,
}

impl Differences {
    /// Returns the number of frames that the differences look ahead.
    pub(super) const fn frames_ahead(self) -> i32 {
        match self {
            Self::Forward => 2,
            Self::Aligned => 1,
            Self::Live => 0,
        }
    }
}

/// The aim of a body with several children.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum AimName {
    /// The child with the heaviest subtree.
    HeaviestChild,
    /// All children, by least squares.
    AllChildren,
}

/// The source of the desired velocities, if forward differences are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum DesiredVelocity {
    /// Forward differences of the bodies' world poses.
    Bodies,
    /// Forward differences of the joints' poses.
    Joints,
    /// Backward differences of the bodies' world poses: for the same instant as the measured velocities.
    Backward,
    /// Zero: the desired velocity of every body is zero.
    Zero,
}

/// The rule by which joints share a common supply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Sharing {
    /// All torques are reduced by the same factor.
    #[cfg_attr(feature = "serde", serde(rename = "alike"))]
    Uniform,
    /// The weighted sum of squared reductions is minimal. The weights are those of the
    /// [`TorqueSupply`](crate::supply::TorqueSupply), for example the skin motion that a joint causes.
    Importance,
    /// The torques that carry the rig are kept; those that accelerate it are reduced by the same factor.
    Accelerations,
}

/// Factors of a PD controller's gains, joint by joint.
///
/// A joint's gains are those of unit inertia (kp, and kd for critical damping) times the constant inertia that its
/// drive works against in the rig's rest pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum GainsName {
    /// No factor: all joints have the same gains.
    Uniform,
    /// The inertia of all bodies beyond the joint, with their joints held: the composite-rigid-body inertia.
    CompositeInertia,
    /// The inertia of all bodies beyond the joint, with yielding joints: the articulated-body inertia.
    ArticulatedInertia,
}

/// Reads and writes the control law by its short name in settings.
#[cfg(feature = "serde")]
pub(super) mod law {
    use serde::{Deserialize as _, Deserializer, Serialize as _, Serializer};

    use crate::control::ControlLaw;

    #[derive(serde::Serialize, serde::Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Name {
        InverseDynamics,
        Pd,
    }

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde requires this signature")]
    pub(in crate::tracker) fn serialize<S: Serializer>(
        law: &ControlLaw,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        match law {
            ControlLaw::InverseDynamics => Name::InverseDynamics,
            ControlLaw::ProportionalDerivative => Name::Pd,
        }
        .serialize(to)
    }

    pub(in crate::tracker) fn deserialize<'de, D: Deserializer<'de>>(
        from: D,
    ) -> Result<ControlLaw, D::Error> {
        Ok(match Name::deserialize(from)? {
            Name::InverseDynamics => ControlLaw::InverseDynamics,
            Name::Pd => ControlLaw::ProportionalDerivative,
        })
    }
}
