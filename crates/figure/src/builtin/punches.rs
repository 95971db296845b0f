//! Punches as keyed poses: jab, cross, and hook and uppercut of either hand.
//!
//! The key poses are those of an orthodox fighter, whose left hand leads. Hips move before shoulders, and shoulders
//! before the fist. A straight punch stops at arm's length; hook and uppercut go through the target.

use glam::DVec3;

use super::performer::{ArmMove, Move, Performer, radians};
use super::skeleton::{ARM_M, Side};
use super::stance;
use super::strike::{Cue, StrikeKind};
use super::timing::Beats;

/// One key pose of a punch. Vectors are in the stance's axes.
struct Key {
    /// Time from the start of the punch, in seconds.
    time_s: f64,
    /// Position of the pelvis relative to guard, in metres.
    shift: DVec3,
    /// Rotation of the pelvis relative to guard, in degrees about x, y, z.
    pelvis: DVec3,
    /// Rotation of the thorax relative to the pelvis, as a difference from guard, in degrees.
    trunk: DVec3,
    /// Position of the wrist relative to the shoulder, in arm lengths.
    wrist: DVec3,
    /// Direction in which the elbow points.
    elbow: DVec3,
    pronation_deg: f64,
    protraction_deg: f64,
    elevation_deg: f64,
    /// Turn of the foot on the punching side about its ball, in degrees.
    pivot_deg: f64,
    /// Rise of the heel of the foot on the punching side, as pitch in degrees.
    heel_deg: f64,
}

/// A punch: its keys, the index of the impact key, and its duration.
struct Punch {
    keys: &'static [Key],
    impact: usize,
    length_s: f64,
}

const fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

const JAB: Punch = Punch {
    keys: &[
        Key {
            time_s: 0.12,
            shift: v(0.0, -0.010, 0.0),
            pelvis: v(0.0, 2.0, 0.0),
            trunk: v(0.0, 5.0, 0.0),
            wrist: v(-0.04, 0.06, 0.36),
            elbow: v(0.35, -1.0, -0.2),
            pronation_deg: 5.0,
            protraction_deg: -4.0,
            elevation_deg: 0.0,
            pivot_deg: 0.0,
            heel_deg: 0.0,
        },
        Key {
            time_s: 0.285,
            shift: v(-0.01, -0.015, 0.10),
            pelvis: v(2.0, -12.0, 0.0),
            trunk: v(3.0, -14.0, 0.0),
            wrist: v(-0.21, 0.12, 0.94),
            elbow: v(0.7, -0.8, 0.0),
            pronation_deg: 55.0,
            protraction_deg: 18.0,
            elevation_deg: 7.0,
            pivot_deg: 0.0,
            heel_deg: 0.0,
        },
        Key {
            time_s: 0.345,
            shift: v(-0.01, -0.015, 0.10),
            pelvis: v(2.0, -12.0, 0.0),
            trunk: v(3.0, -13.0, 0.0),
            wrist: v(-0.21, 0.12, 0.93),
            elbow: v(0.7, -0.8, 0.0),
            pronation_deg: 55.0,
            protraction_deg: 17.0,
            elevation_deg: 7.0,
            pivot_deg: 0.0,
            heel_deg: 0.0,
        },
    ],
    impact: 1,
    length_s: 0.74,
};

const CROSS: Punch = Punch {
    keys: &[
        Key {
            time_s: 0.14,
            shift: v(0.0, -0.010, -0.03),
            pelvis: v(0.0, -6.0, 0.0),
            trunk: v(0.0, -6.0, 0.0),
            wrist: v(0.08, 0.03, 0.36),
            elbow: v(-0.45, -1.0, -0.2),
            pronation_deg: 5.0,
            protraction_deg: -4.0,
            elevation_deg: 0.0,
            pivot_deg: 0.0,
            heel_deg: 2.0,
        },
        Key {
            time_s: 0.34,
            shift: v(0.02, -0.030, 0.12),
            pelvis: v(3.0, 43.0, 0.0),
            trunk: v(4.0, 28.0, 0.0),
            wrist: v(0.17, 0.12, 0.94),
            elbow: v(-0.7, -0.8, 0.0),
            pronation_deg: 60.0,
            protraction_deg: 20.0,
            elevation_deg: 7.0,
            pivot_deg: 36.0,
            heel_deg: 11.0,
        },
        Key {
            time_s: 0.40,
            shift: v(0.02, -0.030, 0.12),
            pelvis: v(3.0, 43.0, 0.0),
            trunk: v(4.0, 27.0, 0.0),
            wrist: v(0.17, 0.12, 0.93),
            elbow: v(-0.7, -0.8, 0.0),
            pronation_deg: 60.0,
            protraction_deg: 19.0,
            elevation_deg: 7.0,
            pivot_deg: 36.0,
            heel_deg: 11.0,
        },
    ],
    impact: 1,
    length_s: 0.87,
};

const LEAD_HOOK: Punch = Punch {
    keys: &[
        Key {
            time_s: 0.18,
            shift: v(0.03, -0.030, 0.03),
            pelvis: v(1.0, 10.0, 0.0),
            trunk: v(2.0, 12.0, -4.0),
            wrist: v(0.16, -0.04, 0.46),
            elbow: v(1.0, -0.7, -0.1),
            pronation_deg: 5.0,
            protraction_deg: -6.0,
            elevation_deg: 2.0,
            pivot_deg: 6.0,
            heel_deg: 4.0,
        },
        Key {
            time_s: 0.28,
            shift: v(0.02, -0.025, 0.05),
            pelvis: v(1.0, -6.0, 0.0),
            trunk: v(2.0, -2.0, -2.0),
            wrist: v(0.42, 0.08, 0.56),
            elbow: v(1.0, -0.3, 0.2),
            pronation_deg: 5.0,
            protraction_deg: 0.0,
            elevation_deg: 8.0,
            pivot_deg: -16.0,
            heel_deg: 12.0,
        },
        Key {
            time_s: 0.352,
            shift: v(0.0, -0.020, 0.06),
            pelvis: v(1.0, -22.0, 0.0),
            trunk: v(2.0, -14.0, 0.0),
            wrist: v(-0.10, 0.14, 0.71),
            elbow: v(1.0, 0.15, -0.1),
            pronation_deg: 8.0,
            protraction_deg: 12.0,
            elevation_deg: 10.0,
            pivot_deg: -36.0,
            heel_deg: 18.0,
        },
        Key {
            time_s: 0.435,
            shift: v(-0.01, -0.020, 0.05),
            pelvis: v(1.0, -29.0, 0.0),
            trunk: v(2.0, -19.0, 0.0),
            wrist: v(-0.40, 0.10, 0.42),
            elbow: v(1.0, 0.0, 0.3),
            pronation_deg: 8.0,
            protraction_deg: 14.0,
            elevation_deg: 8.0,
            pivot_deg: -42.0,
            heel_deg: 16.0,
        },
    ],
    impact: 2,
    length_s: 0.92,
};

const REAR_HOOK: Punch = Punch {
    keys: &[
        Key {
            time_s: 0.18,
            shift: v(-0.02, -0.030, -0.03),
            pelvis: v(1.0, -8.0, 0.0),
            trunk: v(2.0, -8.0, 3.0),
            wrist: v(-0.06, 0.0, 0.40),
            elbow: v(-1.0, -0.7, -0.1),
            pronation_deg: 5.0,
            protraction_deg: -6.0,
            elevation_deg: 2.0,
            pivot_deg: 0.0,
            heel_deg: 2.0,
        },
        Key {
            time_s: 0.30,
            shift: v(0.0, -0.030, 0.04),
            pelvis: v(1.0, 26.0, 0.0),
            trunk: v(2.0, 8.0, 2.0),
            wrist: v(-0.42, 0.08, 0.52),
            elbow: v(-1.0, -0.3, 0.2),
            pronation_deg: 5.0,
            protraction_deg: 2.0,
            elevation_deg: 8.0,
            pivot_deg: 22.0,
            heel_deg: 8.0,
        },
        Key {
            time_s: 0.38,
            shift: v(0.02, -0.025, 0.09),
            pelvis: v(2.0, 48.0, 0.0),
            trunk: v(2.0, 21.0, 0.0),
            wrist: v(0.15, 0.14, 0.73),
            elbow: v(-1.0, 0.15, -0.1),
            pronation_deg: 8.0,
            protraction_deg: 14.0,
            elevation_deg: 10.0,
            pivot_deg: 38.0,
            heel_deg: 11.0,
        },
        Key {
            time_s: 0.48,
            shift: v(0.03, -0.025, 0.08),
            pelvis: v(2.0, 56.0, 0.0),
            trunk: v(2.0, 27.0, 0.0),
            wrist: v(0.42, 0.08, 0.44),
            elbow: v(-1.0, 0.0, 0.3),
            pronation_deg: 8.0,
            protraction_deg: 15.0,
            elevation_deg: 8.0,
            pivot_deg: 44.0,
            heel_deg: 11.0,
        },
    ],
    impact: 2,
    length_s: 0.98,
};

const LEAD_UPPERCUT: Punch = Punch {
    keys: &[
        Key {
            time_s: 0.20,
            shift: v(0.03, -0.065, 0.02),
            pelvis: v(2.0, 8.0, 0.0),
            trunk: v(7.0, 9.0, -7.0),
            wrist: v(0.05, -0.46, 0.30),
            elbow: v(0.5, -0.5, -1.0),
            pronation_deg: -40.0,
            protraction_deg: -4.0,
            elevation_deg: -2.0,
            pivot_deg: 4.0,
            heel_deg: 2.0,
        },
        Key {
            time_s: 0.295,
            shift: v(0.01, -0.030, 0.05),
            pelvis: v(0.0, -8.0, 0.0),
            trunk: v(2.0, -2.0, -3.0),
            wrist: v(-0.05, -0.34, 0.60),
            elbow: v(0.5, -0.9, -0.5),
            pronation_deg: -70.0,
            protraction_deg: 4.0,
            elevation_deg: 0.0,
            pivot_deg: -10.0,
            heel_deg: 8.0,
        },
        Key {
            time_s: 0.372,
            shift: v(0.0, 0.0, 0.07),
            pelvis: v(-3.0, -20.0, 0.0),
            trunk: v(-6.0, -13.0, 3.0),
            wrist: v(-0.17, 0.16, 0.68),
            elbow: v(0.4, -1.0, 0.0),
            pronation_deg: -80.0,
            protraction_deg: 12.0,
            elevation_deg: 10.0,
            pivot_deg: -24.0,
            heel_deg: 15.0,
        },
        Key {
            time_s: 0.455,
            shift: v(0.0, 0.0, 0.06),
            pelvis: v(-3.0, -22.0, 0.0),
            trunk: v(-7.0, -15.0, 3.0),
            wrist: v(-0.20, 0.46, 0.50),
            elbow: v(0.4, -1.0, 0.3),
            pronation_deg: -75.0,
            protraction_deg: 12.0,
            elevation_deg: 12.0,
            pivot_deg: -26.0,
            heel_deg: 14.0,
        },
    ],
    impact: 2,
    length_s: 0.98,
};

const REAR_UPPERCUT: Punch = Punch {
    keys: &[
        Key {
            time_s: 0.20,
            shift: v(-0.02, -0.065, -0.01),
            pelvis: v(2.0, -6.0, 0.0),
            trunk: v(7.0, -8.0, 7.0),
            wrist: v(-0.03, -0.48, 0.28),
            elbow: v(-0.5, -0.5, -1.0),
            pronation_deg: -40.0,
            protraction_deg: -4.0,
            elevation_deg: -2.0,
            pivot_deg: 0.0,
            heel_deg: 0.0,
        },
        Key {
            time_s: 0.31,
            shift: v(0.01, -0.040, 0.05),
            pelvis: v(0.0, 24.0, 0.0),
            trunk: v(2.0, 8.0, 3.0),
            wrist: v(0.04, -0.38, 0.58),
            elbow: v(-0.5, -0.9, -0.5),
            pronation_deg: -70.0,
            protraction_deg: 4.0,
            elevation_deg: 0.0,
            pivot_deg: 20.0,
            heel_deg: 8.0,
        },
        Key {
            time_s: 0.39,
            shift: v(0.02, -0.005, 0.10),
            pelvis: v(-2.0, 42.0, 0.0),
            trunk: v(-6.0, 22.0, -3.0),
            wrist: v(0.16, 0.14, 0.68),
            elbow: v(-0.4, -1.0, 0.0),
            pronation_deg: -80.0,
            protraction_deg: 14.0,
            elevation_deg: 10.0,
            pivot_deg: 36.0,
            heel_deg: 11.0,
        },
        Key {
            time_s: 0.48,
            shift: v(0.02, 0.0, 0.09),
            pelvis: v(-2.0, 45.0, 0.0),
            trunk: v(-7.0, 25.0, -3.0),
            wrist: v(0.20, 0.46, 0.50),
            elbow: v(-0.4, -1.0, 0.3),
            pronation_deg: -75.0,
            protraction_deg: 14.0,
            elevation_deg: 12.0,
            pivot_deg: 38.0,
            heel_deg: 11.0,
        },
    ],
    impact: 2,
    length_s: 1.04,
};

/// Time by which the hips move earlier than the fist, in seconds. The next two constants are the corresponding times of
/// the trunk and of the shoulder girdle.
const HIPS_AHEAD_S: f64 = 0.050;
const TRUNK_AHEAD_S: f64 = 0.025;
const GIRDLE_AHEAD_S: f64 = 0.010;

fn punch(kind: StrikeKind, side: Side) -> &'static Punch {
    match (kind, side) {
        (StrikeKind::Jab, _) => &JAB,
        (StrikeKind::Cross, _) => &CROSS,
        (StrikeKind::Hook, Side::Left) => &LEAD_HOOK,
        (StrikeKind::Hook, Side::Right) => &REAR_HOOK,
        (StrikeKind::Uppercut, Side::Left) => &LEAD_UPPERCUT,
        (StrikeKind::Uppercut, Side::Right) => &REAR_UPPERCUT,
        (kind, _) => unreachable!("{kind:?} is a kick"),
    }
}

/// Returns the times of impact and end of a punch, in seconds from its start, at tempo 1.
pub(super) fn timing_s(kind: StrikeKind, side: Side) -> (f64, f64) {
    let punch = punch(kind, side);
    (punch.keys[punch.impact].time_s, punch.length_s)
}

/// Adds a punch to the performance.
pub(super) fn perform(performer: &mut Performer, cue: &Cue) {
    let Punch { keys, length_s, .. } = punch(cue.kind, cue.side);
    let fist = Beats::new(
        cue.start_s,
        keys.iter().map(|key| cue.start_s + key.time_s / cue.tempo),
        cue.start_s + length_s / cue.tempo,
    );
    let (hips, trunk) = (fist.ahead_by(HIPS_AHEAD_S), fist.ahead_by(TRUNK_AHEAD_S));
    let girdle = fist.ahead_by(GIRDLE_AHEAD_S);
    let side = cue.side.index();

    let mut strike = Move {
        pelvis_shift: hips.track3(keys.iter().map(|key| key.shift * cue.power)),
        pelvis_turn: hips.track3(keys.iter().map(|key| radians(key.pelvis) * cue.power)),
        trunk_turn: trunk.track3(keys.iter().map(|key| radians(key.trunk) * cue.power)),
        ..Move::default()
    };
    strike.legs[side].pivot = hips.track(keys.iter().map(|key| key.pivot_deg.to_radians()));
    strike.legs[side].heel = hips.track(keys.iter().map(|key| key.heel_deg.to_radians()));
    strike.arms[side] = ArmMove {
        pronation: fist
            .track(keys.iter().map(|key| (key.pronation_deg - stance::PRONATION_DEG).to_radians())),
        protraction: girdle.track(keys.iter().map(|key| key.protraction_deg.to_radians())),
        elevation: girdle.track(keys.iter().map(|key| key.elevation_deg.to_radians())),
        ..ArmMove::default()
    };

    // The fist's target depends on where the trunk has moved the shoulder by then.
    let carried = performer.with(strike.clone());
    let offsets: Vec<(DVec3, DVec3)> = keys
        .iter()
        .zip(fist.keys_s())
        .map(|(key, &time_s)| {
            let to_stance = carried.stance(time_s).rotation().conjugate();
            let (wrist, elbow) = carried.guard_arm(time_s, cue.side);
            let shoulder = to_stance * (carried.shoulder_m(time_s, cue.side) - wrist);
            let aim = raised(key.wrist, cue.height_rad) * ARM_M;
            (shoulder + aim, key.elbow - to_stance * elbow)
        })
        .collect();
    strike.arms[side].wrist = fist.track3(offsets.iter().map(|&(wrist, _)| wrist));
    strike.arms[side].elbow = fist.track3(offsets.iter().map(|&(_, elbow)| elbow));
    performer.push(strike);
}

/// Rotates a reach upwards about x by `height_rad`, to aim higher.
pub(super) fn raised(reach: DVec3, height_rad: f64) -> DVec3 {
    let (sin, cos) = (libm::sin(height_rad), libm::cos(height_rad));
    DVec3::new(reach.x, reach.y * cos + reach.z * sin, reach.z * cos - reach.y * sin)
}
