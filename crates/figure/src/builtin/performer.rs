//! Combines guard, steps, sway and moves into the pose at any time.

use glam::{DMat3, DQuat, DVec3};

use super::ik;
use super::skeleton::{
    ABDOMEN, ANKLE_HEIGHT_M, ANKLE_TO_BALL_M, FOREARM_M, Frame, HEAD, PELVIS, Pose, SHANK_M, Side,
    THIGH_M, THORAX, UPPER_ARM_M, offset_m,
};
use super::stance::{self, Footwork, Stance, Sway};
use super::timing::{Track, Track3};
use crate::BODY_COUNT;

/// Contribution of one strike to the guard pose. It is zero at the strike's start and end.
///
/// Vectors are in the stance's axes, in metres and radians; turns are angles about x, y, z.
#[derive(Debug, Clone, Default)]
pub(super) struct Move {
    pub pelvis_shift: Track3,
    pub pelvis_turn: Track3,
    /// Turn of the thorax relative to the pelvis.
    pub trunk_turn: Track3,
    pub arms: [ArmMove; 2],
    pub legs: [LegMove; 2],
}

/// Contribution of one strike to an arm in guard.
#[derive(Debug, Clone, Default)]
pub(super) struct ArmMove {
    pub wrist: Track3,
    /// Change of the direction in which the elbow points.
    pub elbow: Track3,
    pub pronation: Track,
    /// Forward movement of the shoulder, as the angle of the clavicle.
    pub protraction: Track,
    /// Upward movement of the shoulder, as the angle of the clavicle.
    pub elevation: Track,
}

/// Contribution of one strike to a leg on the floor.
#[derive(Debug, Clone, Default)]
pub(super) struct LegMove {
    /// Turn of the foot on its ball.
    pub pivot: Track,
    /// Pitch of the foot on its ball, heel up.
    pub heel: Track,
    pub ankle: Track3,
    /// Change of the direction in which the knee points.
    pub knee: Track3,
    /// Blend of the foot's rotation: at 0 the floor determines it, at 1 the shank does.
    pub loose: Track,
    /// Plantarflexion of a loose foot; positive turns the toes down.
    pub plantarflexion: Track,
}

/// Position of the stance, and frames of pelvis, abdomen and thorax in the world.
#[derive(Debug, Clone, Copy)]
pub(super) struct Trunk {
    stance_m: DVec3,
    /// Rotation from the stance's axes to the world's.
    axes: DQuat,
    pub pelvis: Frame,
    pub abdomen: Frame,
    pub thorax: Frame,
}

/// A fighter in one clip.
#[derive(Debug, Clone)]
pub(super) struct Performer {
    footwork: Footwork,
    sway: Sway,
    moves: Vec<Move>,
    guard: Guard,
}

/// The arms in guard.
#[derive(Debug, Clone, Copy)]
struct Guard {
    /// Rotation of the thorax in guard, in the stance's axes.
    thorax: DQuat,
    /// Position of the wrist and direction of the elbow on each side, in the thorax's frame.
    arms: [(DVec3, DVec3); 2],
}

/// Share of the trunk's turn that the abdomen makes. The thorax makes the rest.
const ABDOMEN_SHARE: f64 = 0.45;
/// Share of the trunk's turn that an arm in guard follows. With less than 1 the arm stays between chin and opponent.
const GUARD_FOLLOWS: f64 = 0.5;
/// Extension of the wrist per radian of elbow flexion. The wrist is bent in guard and straight at impact.
const WRIST_PER_ELBOW: f64 = 0.09;
/// Limits of the head's turn and nod, in degrees.
const HEAD_LIMIT_DEG: [f64; 2] = [75.0, 40.0];
/// Position of the eyes relative to the neck's joint.
const EYES_M: DVec3 = DVec3::new(0.0, 0.15, 0.10);

impl Performer {
    /// Creates a fighter who steps and sways. Moves are added with [`push`](Self::push).
    pub(super) fn new(footwork: Footwork, sway: Sway) -> Self {
        let neutral = trunk(
            &Stance { origin_m: DVec3::ZERO, heading_rad: 0.0 },
            stance::PELVIS_M,
            radians(stance::PELVIS_TURN_DEG),
            radians(stance::TRUNK_TURN_DEG),
        )
        .thorax;
        let to_thorax = neutral.rotation.conjugate();
        let arms = Side::BOTH.map(|side| {
            let wrist = stance::WRISTS_M[side.index()] - neutral.origin_m;
            (to_thorax * wrist, to_thorax * stance::ELBOWS[side.index()])
        });
        let guard = Guard { thorax: neutral.rotation, arms };
        Self { footwork, sway, moves: Vec::new(), guard }
    }

    /// Adds a move.
    pub(super) fn push(&mut self, strike: Move) {
        self.moves.push(strike);
    }

    /// Returns a copy of the performer with one more move.
    pub(super) fn with(&self, strike: Move) -> Self {
        let mut performer = self.clone();
        performer.push(strike);
        performer
    }

    fn sum<T: core::iter::Sum>(&self, part: impl Fn(&Move) -> T) -> T {
        self.moves.iter().map(part).sum()
    }

    /// Returns the stance at a time.
    pub(super) fn stance(&self, time_s: f64) -> Stance {
        self.footwork.stance(time_s)
    }

    /// Returns the trunk at a time.
    pub(super) fn trunk(&self, time_s: f64) -> Trunk {
        let shift = self.sway.shift_m(time_s) + self.sum(|m| m.pelvis_shift.at(time_s));
        let pelvis_turn =
            self.sway.pelvis_turn_rad(time_s) + self.sum(|m| m.pelvis_turn.at(time_s));
        let trunk_turn = self.sway.trunk_turn_rad(time_s) + self.sum(|m| m.trunk_turn.at(time_s));
        trunk(
            &self.stance(time_s),
            stance::PELVIS_M + shift,
            radians(stance::PELVIS_TURN_DEG) + pelvis_turn,
            radians(stance::TRUNK_TURN_DEG) + trunk_turn,
        )
    }

    fn clavicle(&self, time_s: f64, side: Side) -> DQuat {
        let protraction = self.sum(|m| m.arms[side.index()].protraction.at(time_s));
        let elevation = self.sum(|m| m.arms[side.index()].elevation.at(time_s));
        DQuat::from_rotation_y(-side.sign() * protraction)
            * DQuat::from_rotation_z(side.sign() * elevation)
    }

    /// Returns the world position of the shoulder.
    pub(super) fn shoulder_m(&self, time_s: f64, side: Side) -> DVec3 {
        let clavicle =
            self.trunk(time_s).thorax.child(side.clavicle(), self.clavicle(time_s, side));
        clavicle.point(offset_m(side.clavicle() + 1))
    }

    /// Returns the world position of the hip.
    pub(super) fn hip_m(&self, time_s: f64, side: Side) -> DVec3 {
        self.trunk(time_s).pelvis.point(offset_m(side.thigh()))
    }

    /// Returns the world position of the wrist and the direction of the elbow for an arm that stays in guard.
    pub(super) fn guard_arm(&self, time_s: f64, side: Side) -> (DVec3, DVec3) {
        self.guard_arm_on(&self.trunk(time_s), time_s, side)
    }

    /// Computes [`guard_arm`](Self::guard_arm) from a trunk that is already known.
    fn guard_arm_on(&self, trunk: &Trunk, time_s: f64, side: Side) -> (DVec3, DVec3) {
        let Trunk { axes, thorax, .. } = *trunk;
        let frame = Frame {
            rotation: (axes * self.guard.thorax).slerp(thorax.rotation, GUARD_FOLLOWS),
            ..thorax
        };
        let (wrist, elbow) = self.guard.arms[side.index()];
        (frame.point(wrist) + axes * self.sway.wrist_m(time_s, side), frame.rotation * elbow)
    }

    /// Returns the world position of the ball of a foot on the floor.
    pub(super) fn ball_m(&self, time_s: f64, side: Side) -> DVec3 {
        self.footwork.ball_m(time_s, side)
    }

    /// Returns the frame of a foot that stays on the floor: world position of the ankle, and rotation.
    pub(super) fn planted_foot(&self, time_s: f64, side: Side) -> Frame {
        let turn = self.footwork.foot_rad(time_s, side)
            + self.sum(|m| m.legs[side.index()].pivot.at(time_s));
        let heel = stance::HEELS_DEG[side.index()].to_radians()
            + self.sum(|m| m.legs[side.index()].heel.at(time_s));
        let rotation = DQuat::from_rotation_y(turn) * DQuat::from_rotation_x(heel);
        let ankle_from_ball = DVec3::new(0.0, ANKLE_HEIGHT_M, -ANKLE_TO_BALL_M);
        Frame { rotation, origin_m: self.ball_m(time_s, side) + rotation * ankle_from_ball }
    }

    /// Returns the direction of the knee for a foot that stays on the floor: above the toes.
    pub(super) fn planted_knee(&self, time_s: f64, side: Side) -> DVec3 {
        let turn = self.footwork.foot_rad(time_s, side)
            + self.sum(|m| m.legs[side.index()].pivot.at(time_s));
        DQuat::from_rotation_y(turn) * DVec3::Z
    }

    /// Returns the pose at a time.
    pub(super) fn pose(&self, time_s: f64) -> Pose {
        let trunk = self.trunk(time_s);
        let mut rotation = vec![DQuat::IDENTITY; BODY_COUNT];
        rotation[PELVIS] = trunk.pelvis.rotation;
        rotation[ABDOMEN] = relative(&trunk.pelvis, trunk.abdomen.rotation);
        rotation[THORAX] = relative(&trunk.abdomen, trunk.thorax.rotation);
        rotation[HEAD] = head(&trunk);
        for side in Side::BOTH {
            rotation[side.clavicle()..=side.hand()]
                .copy_from_slice(&self.arm(time_s, &trunk, side));
            rotation[side.thigh()..=side.foot()].copy_from_slice(&self.leg(time_s, &trunk, side));
        }
        Pose { root_m: trunk.pelvis.origin_m, rotation }
    }

    /// Returns the rotations of clavicle, upper arm, forearm and hand.
    fn arm(&self, time_s: f64, trunk: &Trunk, side: Side) -> [DQuat; 4] {
        let sign = side.sign();
        let axes = trunk.axes;
        let (wrist, elbow) = self.guard_arm_on(trunk, time_s, side);
        let wrist = wrist + axes * self.sum(|m| m.arms[side.index()].wrist.at(time_s));
        let elbow = elbow + axes * self.sum(|m| m.arms[side.index()].elbow.at(time_s));
        let pronation = stance::PRONATION_DEG.to_radians()
            + self.sum(|m| m.arms[side.index()].pronation.at(time_s));

        let clavicle_turn = self.clavicle(time_s, side);
        let clavicle = trunk.thorax.child(side.clavicle(), clavicle_turn);
        let shoulder = clavicle.point(offset_m(side.clavicle() + 1));
        let limb = ik::solve(shoulder, wrist, UPPER_ARM_M, FOREARM_M, elbow);
        // In the rest pose the arm points along x and flexes forwards, about y.
        let upper = from_axes(limb.upper * sign, limb.hinge * -sign);
        let flexion = DQuat::from_rotation_y(-sign * limb.flexion_rad);
        [
            clavicle_turn,
            relative(&clavicle, upper),
            flexion * DQuat::from_rotation_x(pronation),
            DQuat::from_rotation_z(sign * WRIST_PER_ELBOW * limb.flexion_rad),
        ]
    }

    /// Returns the rotations of thigh, shank and foot.
    fn leg(&self, time_s: f64, trunk: &Trunk, side: Side) -> [DQuat; 3] {
        let Trunk { axes, pelvis, .. } = *trunk;
        let planted = self.planted_foot(time_s, side);
        let ankle = planted.origin_m + axes * self.sum(|m| m.legs[side.index()].ankle.at(time_s));
        let knee = self.planted_knee(time_s, side)
            + axes * self.sum(|m| m.legs[side.index()].knee.at(time_s));
        let loose = self.sum(|m| m.legs[side.index()].loose.at(time_s));
        let plantarflexion = self.sum(|m| m.legs[side.index()].plantarflexion.at(time_s));

        let hip = pelvis.point(offset_m(side.thigh()));
        let limb = ik::solve(hip, ankle, THIGH_M, SHANK_M, knee);
        // In the rest pose the leg points along -y and flexes about x.
        let thigh = from_axes(limb.hinge, -limb.upper);
        let flexion = DQuat::from_rotation_x(limb.flexion_rad);
        let shank = thigh * flexion;
        let on_floor = shank.conjugate() * planted.rotation;
        let foot = on_floor.slerp(DQuat::from_rotation_x(plantarflexion), loose);
        [relative(&pelvis, thigh), flexion, foot]
    }
}

fn trunk(stance: &Stance, pelvis_m: DVec3, pelvis_turn: DVec3, trunk_turn: DVec3) -> Trunk {
    let axes = stance.rotation();
    let pelvis = Frame {
        rotation: axes * from_turn(pelvis_turn),
        origin_m: stance.origin_m + axes * pelvis_m,
    };
    let abdomen = pelvis.child(ABDOMEN, from_turn(trunk_turn * ABDOMEN_SHARE));
    let thorax = abdomen.child(THORAX, from_turn(trunk_turn * (1.0 - ABDOMEN_SHARE)));
    Trunk { stance_m: stance.origin_m, axes, pelvis, abdomen, thorax }
}

/// Returns the rotation of the head, which looks at the opponent as far as the neck allows.
fn head(trunk: &Trunk) -> DQuat {
    let Trunk { stance_m, axes, thorax, .. } = *trunk;
    let opponent = stance_m + axes * stance::OPPONENT_M;
    let gaze = thorax.rotation.conjugate() * (opponent - thorax.point(offset_m(HEAD) + EYES_M));
    let turn = libm::atan2(gaze.x, gaze.z);
    let nod = -libm::atan2(gaze.y, libm::hypot(gaze.x, gaze.z));
    let [turn_limit, nod_limit] = HEAD_LIMIT_DEG.map(f64::to_radians);
    from_turn(DVec3::new(softly_limited(nod, nod_limit), softly_limited(turn, turn_limit), 0.0))
}

/// Returns the rotation made of a heading about y, then a pitch about x, then a roll about z.
fn from_turn(turn: DVec3) -> DQuat {
    DQuat::from_rotation_y(turn.y) * DQuat::from_rotation_x(turn.x) * DQuat::from_rotation_z(turn.z)
}

/// Returns the rotation with these x and y axes, which must be unit vectors at right angles.
fn from_axes(x: DVec3, y: DVec3) -> DQuat {
    DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))).normalize()
}

fn relative(parent: &Frame, world: DQuat) -> DQuat {
    (parent.rotation.conjugate() * world).normalize()
}

/// Limits an angle smoothly: small angles hardly change, and the result never exceeds the limit.
fn softly_limited(angle: f64, limit: f64) -> f64 {
    angle / libm::sqrt(1.0 + (angle / limit) * (angle / limit))
}

/// Converts degrees to radians.
pub(super) fn radians(degrees: DVec3) -> DVec3 {
    degrees * 1.0_f64.to_radians()
}
