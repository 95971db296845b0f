//! The names of methods and settings, as files, options and tables have them: here and nowhere else.

use core::fmt;

macro_rules! methods {
    ($($variant:ident = $name:literal, $label:literal, $summary:literal;)*) => {
        /// A method of measuring the state error, or a setting with one.
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
            /// Every one there is.
            pub const EVERY: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// The name in options and files.
            pub const fn as_str(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }

            /// The name in headings.
            pub const fn label(self) -> &'static str {
                match self {
                    $(Self::$variant => $label,)*
                }
            }

            /// What it does, in a line.
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
    /// The paper's three, in its order.
    pub const PAPER: [Self; 3] = [Self::Local, Self::World, Self::LinearCompensation];

    /// All that need no reference.
    pub const ALL: [Self; 7] = [
        Self::Local,
        Self::World,
        Self::Egocentric,
        Self::LinearCompensation,
        Self::ManifoldProjection,
        Self::ResolvedAcceleration,
        Self::Recommended,
    ];

    /// The method of that name.
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

/// How the weight of turns is shared among the bodies in the projection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum WeightsName {
    /// All have the same.
    Uniform,
    /// By importance: the length of what hangs on a body's joint. The mean is `rotation_m`.
    Lengths,
}

/// Which frames desired velocities and accelerations are differences of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Differences {
    /// This one and the next two: the paper's.
    Forward,
    /// The one before, this one and the next, so that velocities are of the same instant as measured ones.
    Aligned,
    /// This one and the two before: for a live stream, whose next frame is not known.
    Live,
}

impl Differences {
    /// How many frames they look ahead.
    pub(super) const fn frames_ahead(self) -> i32 {
        match self {
            Self::Forward => 2,
            Self::Aligned => 1,
            Self::Live => 0,
        }
    }
}

/// What a body of several children aims at.
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
    /// All of them, by least squares.
    AllChildren,
}

/// Where desired velocities come from, for forward differences.
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
    /// Backward differences of the bodies' world poses: of the same instant as the measured velocities.
    Backward,
    /// Omitted: every body is to stand still.
    Zero,
}

/// How joints share what their drives have together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Sharing {
    /// All torques are cut by the same factor.
    #[cfg_attr(feature = "serde", serde(rename = "alike"))]
    Uniform,
    /// What is cut is least in squares, by the motion of the skin that it makes: the weights of the
    /// [`TorqueSupply`](crate::supply::TorqueSupply).
    Importance,
    /// What carries the rig is left, and what accelerates it is cut by the same factor.
    Accelerations,
}

/// What the gains of a PD controller are multiplied with, joint by joint.
///
/// The rule: a joint's gains are those of unit inertia (kp, and kd for critical damping) times the constant inertia
/// that its drive works against in the rig's rest pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum GainsName {
    /// Nothing: all joints have the same.
    Uniform,
    /// The inertia of all bodies beyond the joint, their joints held: the composite-rigid-body inertia.
    CompositeInertia,
    /// The inertia of all bodies beyond the joint, their joints giving way: the articulated-body inertia.
    ArticulatedInertia,
}

/// The control law by the short name that settings have.
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
