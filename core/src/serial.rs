//! Reads and writes settings and states with serde, in the form that the crate's documentation describes.
//!
//! Plain types derive the traits and read their numbers through `read`. Types with rules are handled in this module
//! and are created by their constructors.

use core::fmt;
use core::marker::PhantomData;

use glam::Vec3;
use heapless::Vec;
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
use serde::ser::{Serialize, SerializeSeq, Serializer};

use crate::body_weight::{BodyWeight, BodyWeights};
use crate::control::{ControlLaw, Gains, TorqueLimit};
use crate::controller::{ControllerError, TorqueController};
use crate::dynamics::ReflectedInertia;
use crate::importance::Importance;
use crate::state_error::{Aim, Aims, Method, References};
use crate::{
    Body, BodySet, Inertia, JointKind, JointState, JointStates, JointTargets, Transform, Tree,
    TreeError, Twist,
};

/// A list of at most `N` items.
struct List<T, const N: usize>(Vec<T, N>);

impl<'de, T: Deserialize<'de>, const N: usize> Deserialize<'de> for List<T, N> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Items<T, const N: usize>(PhantomData<T>);

        impl<'de, T: Deserialize<'de>, const N: usize> Visitor<'de> for Items<T, N> {
            type Value = List<T, N>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a list of at most {N} items")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Self::Value, A::Error> {
                let mut list = Vec::new();
                while let Some(item) = items.next_element()? {
                    if list.push(item).is_err() {
                        return Err(A::Error::invalid_length(N.saturating_add(1), &self));
                    }
                }
                Ok(List(list))
            }
        }

        from.deserialize_seq(Items(PhantomData))
    }
}

/// Returns the simplest tree with the given parents, body by body.
fn skeleton<const N: usize>(
    parents: impl Iterator<Item = Option<usize>>,
) -> Result<Tree<N>, TreeError> {
    let mut tree = Tree::new();
    for parent in parents {
        let (placement, inertia) = (Transform::IDENTITY, Inertia::default());
        tree.push(Body { parent, joint: JointKind::Free, placement, inertia, rotor_inertia: 0.0 })?;
    }
    Ok(tree)
}

/// Returns a tree of `count` bodies in which every body supports all bodies after it.
fn chain<const N: usize>(count: usize) -> Result<Tree<N>, TreeError> {
    skeleton((0..count).map(|body| body.checked_sub(1)))
}

impl Serialize for BodySet {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut members = to.serialize_seq(Some(self.len()))?;
        for body in self.iter() {
            members.serialize_element(&body)?;
        }
        members.end()
    }
}

impl<'de> Deserialize<'de> for BodySet {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let List::<usize, { Self::CAPACITY }>(bodies) = List::deserialize(from)?;
        let mut set = Self::EMPTY;
        for body in bodies {
            if body >= Self::CAPACITY {
                let most = Self::CAPACITY;
                return Err(D::Error::custom(format_args!("body {body} must be below {most}")));
            }
            if set.contains(body) {
                return Err(D::Error::custom(format_args!("body {body} is in the set twice")));
            }
            set.insert(body);
        }
        Ok(set)
    }
}

impl<const N: usize> Serialize for Tree<N> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        self.bodies().serialize(to)
    }
}

impl<'de, const N: usize> Deserialize<'de> for Tree<N> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let List::<Body, N>(bodies) = List::deserialize(from)?;
        Self::from_bodies(&bodies).map_err(D::Error::custom)
    }
}

impl<const N: usize> Serialize for JointStates<N> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        self.as_slice().serialize(to)
    }
}

impl<'de, const N: usize> Deserialize<'de> for JointStates<N> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let List::<JointState, N>(list) = List::deserialize(from)?;
        let mut states = Self::rest(&chain::<N>(list.len()).map_err(D::Error::custom)?);
        for (joint, state) in list.into_iter().enumerate() {
            states
                .set(joint, state)
                .map_err(|error| D::Error::custom(format_args!("joint {joint}: {error}")))?;
        }
        Ok(states)
    }
}

/// A joint of [`JointTargets`].
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Target {
    pose: Transform,
    velocity: Twist,
    acceleration: Twist,
}

impl<const N: usize> Serialize for JointTargets<N> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut targets = to.serialize_seq(Some(self.states().len()))?;
        for (state, acceleration) in self.states().iter().zip(self.accelerations()) {
            let JointState { pose, velocity } = *state;
            targets.serialize_element(&Target { pose, velocity, acceleration: *acceleration })?;
        }
        targets.end()
    }
}

impl<'de, const N: usize> Deserialize<'de> for JointTargets<N> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let List::<Target, N>(list) = List::deserialize(from)?;
        let mut targets = Self::rest(&chain::<N>(list.len()).map_err(D::Error::custom)?);
        for (joint, Target { pose, velocity, acceleration }) in list.into_iter().enumerate() {
            targets
                .set(joint, JointState { pose, velocity }, acceleration)
                .map_err(|error| D::Error::custom(format_args!("joint {joint}: {error}")))?;
        }
        Ok(targets)
    }
}

impl<const N: usize> Serialize for Aims<N> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        self.as_slice().serialize(to)
    }
}

impl<'de, const N: usize> Deserialize<'de> for Aims<N> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let List::<Aim, N>(aims) = List::deserialize(from)?;
        // Each body is the child of the body that aims at it. A body that two others aim at, or that precedes its
        // parent, is refused.
        let aims_at = |aim: &Aim, child: usize| match *aim {
            Aim::Child(one) => one == child,
            Aim::Children(several) => several.contains(child),
            Aim::None | Aim::Point(_) => false,
        };
        let parent = |child: usize| {
            let before = aims.iter().take(child);
            let found = before.into_iter().position(|aim| aims_at(aim, child));
            (child > 0).then(|| found.unwrap_or(0))
        };
        let tree = skeleton::<N>((0..aims.len()).map(parent)).map_err(D::Error::custom)?;
        Self::new(&tree, &aims).map_err(D::Error::custom)
    }
}

impl<const N: usize> Serialize for References<N> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        self.as_slice().serialize(to)
    }
}

impl<'de, const N: usize> Deserialize<'de> for References<N> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let List::<Option<usize>, N>(references) = List::deserialize(from)?;
        let tree = chain::<N>(references.len()).map_err(D::Error::custom)?;
        Self::new(&tree, &references).map_err(D::Error::custom)
    }
}

impl<const N: usize> Serialize for BodyWeights<N> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        self.as_slice().serialize(to)
    }
}

impl<'de, const N: usize> Deserialize<'de> for BodyWeights<N> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let List::<BodyWeight, N>(weights) = List::deserialize(from)?;
        let tree = chain::<N>(weights.len()).map_err(D::Error::custom)?;
        Self::new(&tree, &weights).map_err(D::Error::custom)
    }
}

impl<const N: usize> Serialize for Importance<N> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        self.as_slice().serialize(to)
    }
}

impl<'de, const N: usize> Deserialize<'de> for Importance<N> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let List::<f32, N>(weights) = List::deserialize(from)?;
        Self::new(&weights).map_err(D::Error::custom)
    }
}

/// The serialized form of [`Gains`].
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "Gains", deny_unknown_fields)]
struct GainsFields {
    kp: f32,
    kd: f32,
    linear_kp: f32,
    linear_kd: f32,
}

impl Serialize for Gains {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        GainsFields {
            kp: self.kp(),
            kd: self.kd(),
            linear_kp: self.linear_kp(),
            linear_kd: self.linear_kd(),
        }
        .serialize(to)
    }
}

impl<'de> Deserialize<'de> for Gains {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let fields = GainsFields::deserialize(from)?;
        Self::new(fields.kp, fields.kd)
            .and_then(|gains| gains.with_linear(fields.linear_kp, fields.linear_kd))
            .map_err(D::Error::custom)
    }
}

/// The serialized form of a [`TorqueLimit`]. JSON and similar formats have no infinity.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "TorqueLimit", deny_unknown_fields)]
struct TorqueLimitFields {
    // The key must be present, because a missing key is more likely a mistake than the wish for no bound.
    #[serde(deserialize_with = "Option::deserialize")]
    moment_nm: Option<f32>,
    #[serde(deserialize_with = "Option::deserialize")]
    force_n: Option<f32>,
}

impl Serialize for TorqueLimit {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let bound = |bound: f32| bound.is_finite().then_some(bound);
        TorqueLimitFields { moment_nm: bound(self.moment_nm()), force_n: bound(self.force_n()) }
            .serialize(to)
    }
}

impl<'de> Deserialize<'de> for TorqueLimit {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let fields = TorqueLimitFields::deserialize(from)?;
        let bound = |bound: Option<f32>| bound.unwrap_or(f32::INFINITY);
        Self::new(bound(fields.moment_nm), bound(fields.force_n)).map_err(D::Error::custom)
    }
}

/// The form in which a [`TorqueController`] is written.
#[derive(serde::Serialize)]
#[serde(rename = "Controller")]
struct ControllerFields<'a, const N: usize> {
    tree: &'a Tree<N>,
    gains: &'a [Gains],
    method: &'a Method<N>,
    law: ControlLaw,
    gravity_m_s2: Vec3,
    limits: &'a [TorqueLimit],
    inertias: &'a [ReflectedInertia],
}

/// The form in which a [`TorqueController`] is read.
#[derive(serde::Deserialize)]
#[serde(rename = "Controller", deny_unknown_fields)]
pub(crate) struct ControllerParts<const N: usize> {
    tree: Tree<N>,
    gains: List<Gains, N>,
    method: Method<N>,
    law: ControlLaw,
    gravity_m_s2: Vec3,
    limits: List<TorqueLimit, N>,
    inertias: List<ReflectedInertia, N>,
}

impl<const N: usize> Serialize for TorqueController<N> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        ControllerFields {
            tree: self.tree(),
            gains: self.gains(),
            method: self.method(),
            law: self.law(),
            gravity_m_s2: self.gravity_m_s2(),
            limits: self.limits(),
            inertias: self.inertias(),
        }
        .serialize(to)
    }
}

impl<const N: usize> TryFrom<ControllerParts<N>> for TorqueController<N> {
    type Error = ControllerError;

    fn try_from(parts: ControllerParts<N>) -> Result<Self, ControllerError> {
        let (List(gains), List(limits), List(inertias)) =
            (parts.gains, parts.limits, parts.inertias);
        let found = gains.len();
        let Some(first) = gains.first() else {
            return Err(ControllerError::GainsCount { expected: parts.tree.len(), found });
        };
        let mut controller = Self::new(parts.tree, *first, parts.method)?
            .with_joint_gains(&gains)?
            .with_limits(&limits)?
            .with_gravity(parts.gravity_m_s2)?;
        if !inertias.is_empty() {
            controller = controller.with_inertia_scaled_pd(&inertias)?;
        }
        controller.with_law(parts.law)
    }
}

impl<'de, const N: usize> Deserialize<'de> for TorqueController<N> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let parts = ControllerParts::<N>::deserialize(from)?;
        Self::try_from(parts).map_err(D::Error::custom)
    }
}
