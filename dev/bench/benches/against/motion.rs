//! A motion of a rig for all contenders: every joint as a sequence of turns about single axes, in f64.

use sinew_core::glam::{DQuat, DVec3};
use sinew_core::{Body, JointKind};

/// A turn about one axis: the motion of a revolute joint, or one of the three successive turns that make the motion of
/// a spherical joint.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Turn {
    /// Unit axis, in the frame after the earlier turns.
    pub(crate) axis: DVec3,
    pub(crate) angle_rad: f64,
    pub(crate) velocity_rad_s: f64,
    pub(crate) acceleration_rad_s2: f64,
}

/// Motion of a free root in the world, all in world axes. The acceleration is the classical acceleration of the root's
/// origin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RootMotion {
    pub(crate) rotation: DQuat,
    pub(crate) translation_m: DVec3,
    pub(crate) angular_velocity: DVec3,
    pub(crate) linear_velocity: DVec3,
    pub(crate) angular_acceleration: DVec3,
    pub(crate) linear_acceleration: DVec3,
}

/// A motion of a rig with a free root.
#[derive(Debug, Clone)]
pub(crate) struct RigMotion {
    pub(crate) root: RootMotion,
    /// Turns of joints 1.., each in the order in which they turn.
    pub(crate) turns: Vec<Vec<Turn>>,
}

impl RigMotion {
    /// Returns a random motion: angles up to 1 rad (so that cardan angles are not near their singular pose),
    /// velocities up to 3 rad/s, accelerations up to 20 rad/s².
    pub(crate) fn random(bodies: &[Body], seed: u64) -> Self {
        let mut numbers = Numbers(seed);
        let root = RootMotion {
            rotation: DQuat::from_scaled_axis(numbers.vector() * 2.0),
            translation_m: numbers.vector(),
            angular_velocity: numbers.vector() * 2.0,
            linear_velocity: numbers.vector() * 2.0,
            angular_acceleration: numbers.vector() * 10.0,
            linear_acceleration: numbers.vector() * 10.0,
        };
        let turns = bodies.iter().skip(1).map(|body| {
            axes(body.joint)
                .into_iter()
                .map(|axis| Turn {
                    axis,
                    angle_rad: numbers.next(),
                    velocity_rad_s: 3.0 * numbers.next(),
                    acceleration_rad_s2: 20.0 * numbers.next(),
                })
                .collect()
        });
        let turns = turns.collect();
        Self { root, turns }
    }
}

/// Rotation of a joint, and its angular velocity and acceleration relative to the parent, in body axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Turned {
    pub(crate) rotation: DQuat,
    pub(crate) velocity: DVec3,
    pub(crate) acceleration: DVec3,
}

/// Combines a sequence of turns.
pub(crate) fn together(turns: &[Turn]) -> Turned {
    let start =
        Turned { rotation: DQuat::IDENTITY, velocity: DVec3::ZERO, acceleration: DVec3::ZERO };
    turns.iter().fold(start, |inner, turn| {
        let rotation = DQuat::from_axis_angle(turn.axis, turn.angle_rad);
        let (back, spin) = (rotation.conjugate(), turn.axis * turn.velocity_rad_s);
        let carried = back * inner.velocity;
        Turned {
            rotation: inner.rotation * rotation,
            velocity: carried + spin,
            // The components of the earlier turns' velocity change as the axes turn.
            acceleration: back * inner.acceleration - spin.cross(carried)
                + turn.axis * turn.acceleration_rad_s2,
        }
    })
}

/// Returns the torques about the axes of a sequence of turns from the moment of the joint, both in body axes at the
/// end.
pub(crate) fn torques(turns: &[Turn], moment_nm: DVec3) -> Vec<f64> {
    let mut moment = moment_nm;
    let mut torques: Vec<f64> = turns
        .iter()
        .rev()
        .map(|turn| {
            let torque = turn.axis.dot(moment);
            moment = DQuat::from_axis_angle(turn.axis, turn.angle_rad) * moment;
            torque
        })
        .collect();
    torques.reverse();
    torques
}

/// Returns the axes about which a joint turns: cardan axes for a spherical joint.
pub(crate) fn axes(joint: JointKind) -> Vec<DVec3> {
    match joint {
        JointKind::Spherical => vec![DVec3::X, DVec3::Y, DVec3::Z],
        JointKind::Revolute { axis } => vec![axis.as_dvec3()],
        other => unreachable!("the rigs of this bench have no {other:?}"),
    }
}

/// Rounds a number to f32.
#[expect(clippy::cast_possible_truncation, reason = "rounding is meant")]
pub(crate) fn single(value: f64) -> f32 {
    value as f32
}

/// `SplitMix64` (Steele, Lea & Flood 2014), as numbers in [-1, 1).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }
}
