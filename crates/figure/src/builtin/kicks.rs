//! Kicks as keyed poses: front, side and roundhouse kick, written for the right leg.
//!
//! Either leg may kick, in either stance. The keys give whole poses in the stance's axes. They are mirrored for
//! the left leg, and the guard pose is subtracted from them.

use glam::DVec3;

use super::performer::{ArmMove, LegMove, Move, Performer, radians};
use super::punches::raised;
use super::skeleton::{LEG_M, Side, mirror_point, mirror_turn};
use super::stance;
use super::strike::{Cue, StrikeKind};
use super::timing::Beats;

/// One key pose of a kick with the right leg. Vectors are in the stance's axes.
struct Key {
    /// Time from the start of the kick, in seconds.
    time_s: f64,
    /// Position of the pelvis relative to the ball of the supporting foot, at the pelvis's height in guard, in metres.
    /// The values keep the centre of mass above the foot.
    shift: DVec3,
    /// Rotation of the pelvis relative to the stance, in degrees about x, y, z.
    pelvis: DVec3,
    /// Rotation of the thorax relative to the pelvis, in degrees about x, y, z.
    trunk: DVec3,
    /// Position of the ankle relative to the hip, in leg lengths.
    ankle: DVec3,
    /// Direction in which the knee points.
    knee: DVec3,
    plantarflexion_deg: f64,
    /// Turn of the supporting foot relative to the stance, in degrees.
    pivot_deg: f64,
    /// Position of the wrist on the kicking side relative to guard, in metres: the arm swings against the leg.
    swing: DVec3,
}

/// A kick: its keys, the index of the impact key, and its duration.
struct Kick {
    keys: &'static [Key],
    impact: usize,
    length_s: f64,
}

const fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

const FRONT: Kick = Kick {
    keys: &[
        Key {
            time_s: 0.38,
            shift: v(-0.02, 0.02, -0.09),
            pelvis: v(-8.0, -4.0, -2.0),
            trunk: v(12.0, 0.0, 2.0),
            ankle: v(-0.02, -0.40, 0.30),
            knee: v(-0.1, 0.9, 0.9),
            plantarflexion_deg: 0.0,
            pivot_deg: 10.0,
            swing: v(-0.02, -0.05, 0.0),
        },
        Key {
            time_s: 0.56,
            shift: v(-0.02, 0.03, -0.04),
            pelvis: v(-24.0, 14.0, -4.0),
            trunk: v(12.0, 2.0, 3.0),
            ankle: v(0.09, 0.08, 0.955),
            knee: v(-0.15, 1.0, 0.0),
            plantarflexion_deg: 15.0,
            pivot_deg: 25.0,
            swing: v(-0.10, -0.22, -0.06),
        },
        Key {
            time_s: 0.82,
            shift: v(-0.02, 0.02, -0.10),
            pelvis: v(-8.0, 2.0, -2.0),
            trunk: v(12.0, 0.0, 2.0),
            ankle: v(0.0, -0.46, 0.32),
            knee: v(-0.1, 0.9, 0.9),
            plantarflexion_deg: 5.0,
            pivot_deg: 18.0,
            swing: v(-0.04, -0.10, -0.02),
        },
    ],
    impact: 1,
    length_s: 1.34,
};

const SIDE: Kick = Kick {
    keys: &[
        Key {
            time_s: 0.46,
            shift: v(-0.13, 0.03, -0.04),
            pelvis: v(4.0, 60.0, -10.0),
            trunk: v(10.0, -14.0, -4.0),
            ankle: v(0.14, -0.36, 0.24),
            knee: v(0.5, 0.8, 0.6),
            plantarflexion_deg: -10.0,
            pivot_deg: 60.0,
            swing: v(0.0, -0.06, 0.0),
        },
        Key {
            time_s: 0.65,
            shift: v(-0.09, 0.06, 0.07),
            pelvis: v(2.0, 98.0, -40.0),
            trunk: v(2.0, -16.0, -10.0),
            ankle: v(0.0, 0.08, 0.96),
            knee: v(0.95, 0.2, 0.0),
            plantarflexion_deg: -5.0,
            pivot_deg: 118.0,
            swing: v(-0.04, -0.18, 0.02),
        },
        Key {
            time_s: 0.94,
            shift: v(-0.13, 0.03, -0.05),
            pelvis: v(4.0, 66.0, -14.0),
            trunk: v(10.0, -12.0, -4.0),
            ankle: v(0.12, -0.40, 0.28),
            knee: v(0.5, 0.8, 0.6),
            plantarflexion_deg: -8.0,
            pivot_deg: 82.0,
            swing: v(0.0, -0.08, 0.0),
        },
    ],
    impact: 1,
    length_s: 1.50,
};

const ROUNDHOUSE: Kick = Kick {
    keys: &[
        Key {
            time_s: 0.42,
            shift: v(-0.10, 0.03, -0.06),
            pelvis: v(4.0, 18.0, -20.0),
            trunk: v(6.0, -6.0, -4.0),
            ankle: v(-0.52, -0.16, 0.14),
            knee: v(0.05, 0.35, 1.0),
            plantarflexion_deg: 20.0,
            pivot_deg: 45.0,
            swing: v(0.02, -0.05, 0.06),
        },
        Key {
            time_s: 0.62,
            shift: v(-0.10, 0.06, 0.04),
            pelvis: v(-2.0, 68.0, -32.0),
            trunk: v(4.0, -16.0, -8.0),
            ankle: v(0.04, 0.12, 0.955),
            knee: v(1.0, 0.4, 0.1),
            plantarflexion_deg: 38.0,
            pivot_deg: 92.0,
            swing: v(-0.12, -0.30, -0.02),
        },
        Key {
            time_s: 0.70,
            shift: v(-0.10, 0.06, 0.04),
            pelvis: v(-2.0, 80.0, -30.0),
            trunk: v(4.0, -16.0, -8.0),
            ankle: v(0.34, 0.06, 0.80),
            knee: v(1.0, 0.6, -0.2),
            plantarflexion_deg: 34.0,
            pivot_deg: 100.0,
            swing: v(-0.12, -0.30, -0.02),
        },
        Key {
            time_s: 0.97,
            shift: v(-0.12, 0.03, -0.05),
            pelvis: v(2.0, 32.0, -12.0),
            trunk: v(8.0, -8.0, -4.0),
            ankle: v(0.0, -0.54, 0.26),
            knee: v(0.3, 0.4, 1.0),
            plantarflexion_deg: 10.0,
            pivot_deg: 60.0,
            swing: v(-0.06, -0.12, -0.04),
        },
    ],
    impact: 1,
    length_s: 1.52,
};

/// Time by which the pelvis moves earlier than the foot, in seconds. The next constant is the corresponding time of the
/// trunk.
const HIPS_AHEAD_S: f64 = 0.060;
const TRUNK_AHEAD_S: f64 = 0.030;
/// Change of the elbow's direction per metre of swing: outwards and back, so that it is never parallel to the arm.
const ELBOW_PER_SWING: DVec3 = v(-1.6, 1.6, -1.0);
/// Rise of the supporting heel while the foot turns, as pitch in degrees.
const PIVOT_HEEL_DEG: f64 = 7.0;

fn kick(kind: StrikeKind) -> &'static Kick {
    match kind {
        StrikeKind::FrontKick => &FRONT,
        StrikeKind::SideKick => &SIDE,
        StrikeKind::RoundhouseKick => &ROUNDHOUSE,
        _ => unreachable!("{kind:?} is a punch"),
    }
}

/// Returns the times of impact and end of a kick, in seconds from its start, at tempo 1.
pub(super) fn timing_s(kind: StrikeKind) -> (f64, f64) {
    let kick = kick(kind);
    (kick.keys[kick.impact].time_s, kick.length_s)
}

/// Adds a kick to the performance.
pub(super) fn perform(performer: &mut Performer, cue: &Cue) {
    let Kick { keys, length_s, .. } = kick(cue.kind);
    let foot = Beats::new(
        cue.start_s,
        keys.iter().map(|key| cue.start_s + key.time_s / cue.tempo),
        cue.start_s + length_s / cue.tempo,
    );
    let (hips, trunk) = (foot.ahead_by(HIPS_AHEAD_S), foot.ahead_by(TRUNK_AHEAD_S));
    let (leg, support) = (cue.side.index(), cue.side.opposite());
    // The keys describe the right leg.
    let point = |right: DVec3| if cue.side == Side::Right { right } else { mirror_point(right) };
    let turn =
        |right: DVec3| radians(if cue.side == Side::Right { right } else { mirror_turn(right) });

    let stance_at = performer.stance(cue.start_s);
    let to_stance = stance_at.rotation().conjugate();
    let ball_m = performer.ball_m(cue.start_s, support);
    let to_ball = to_stance * (ball_m - stance_at.origin_m) - stance::PELVIS_M.with_y(0.0);
    let support_heading = stance::foot_heading_rad(support);

    let mut strike = Move {
        pelvis_shift: hips.track3(keys.iter().map(|key| to_ball + point(key.shift))),
        pelvis_turn: hips
            .track3(keys.iter().map(|key| turn(key.pelvis) - radians(stance::PELVIS_TURN_DEG))),
        trunk_turn: trunk
            .track3(keys.iter().map(|key| turn(key.trunk) - radians(stance::TRUNK_TURN_DEG))),
        ..Move::default()
    };
    strike.arms[leg] = ArmMove {
        wrist: trunk.track3(keys.iter().map(|key| point(key.swing) * cue.power)),
        elbow: trunk.track3(keys.iter().map(|key| point(ELBOW_PER_SWING) * key.swing.length())),
        ..ArmMove::default()
    };
    strike.legs[support.index()] = LegMove {
        pivot: hips
            .track(keys.iter().map(|key| turn(DVec3::Y * key.pivot_deg).y - support_heading)),
        heel: hips.track(
            keys.iter().map(|_| (PIVOT_HEEL_DEG - stance::HEELS_DEG[support.index()]).to_radians()),
        ),
        ..LegMove::default()
    };
    strike.legs[leg] = LegMove {
        loose: foot.track(keys.iter().map(|_| 1.0)),
        plantarflexion: foot.track(keys.iter().map(|key| key.plantarflexion_deg.to_radians())),
        ..LegMove::default()
    };

    // The foot's target depends on where the pelvis has moved the hip by then.
    let carried = performer.with(strike.clone());
    let offsets: Vec<(DVec3, DVec3)> = keys
        .iter()
        .zip(foot.keys_s())
        .map(|(key, &time_s)| {
            let hip =
                carried.hip_m(time_s, cue.side) - carried.planted_foot(time_s, cue.side).origin_m;
            let aim = point(raised(key.ankle, cue.height_rad)) * LEG_M;
            let knee = point(key.knee) - to_stance * carried.planted_knee(time_s, cue.side);
            (to_stance * hip + aim, knee)
        })
        .collect();
    strike.legs[leg].ankle = foot.track3(offsets.iter().map(|&(ankle, _)| ankle));
    strike.legs[leg].knee = foot.track3(offsets.iter().map(|&(_, knee)| knee));
    performer.push(strike);
}
