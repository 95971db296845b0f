//! Scripts of the clips: strikes in shuffled order with steps between them, all from seeds.

use glam::{DQuat, DVec3};
use sinew_host_util::random::{Random, Subject};

use super::skeleton::Side;
use super::stance::{Stance, Step};
use super::strike::{Cue, Strike, StrikeKind};
use super::timing::RATE_HZ;
use super::{kicks, punches};
use Side::{Left as Lead, Right as Rear};
use StrikeKind::{Cross, FrontKick, Hook, Jab, RoundhouseKick, SideKick, Uppercut};

/// The events of one clip, from which its motion is computed.
#[derive(Debug, Clone)]
pub(super) struct Script {
    pub name: String,
    pub seed: u64,
    /// The leading side. For a right lead the performance is mirrored.
    pub lead: Side,
    /// Number of frames to record.
    pub frames: u32,
    pub first: Stance,
    pub steps: Vec<Step>,
    pub cues: Vec<Cue>,
}

impl Script {
    /// Returns the strikes as they appear in the clip, with the clip's sides.
    pub(super) fn strikes(&self) -> impl Iterator<Item = Strike> {
        self.cues.iter().map(|cue| {
            let side = if self.lead == Side::Left { cue.side } else { cue.side.opposite() };
            let (impact_s, end_s) = timing_s(cue);
            Strike { kind: cue.kind, side, start_s: cue.start_s, impact_s, end_s }
        })
    }
}

/// Returns the lowest and highest aim of a kind of strike relative to its key pose, as pitch in radians.
const fn heights_rad(kind: StrikeKind) -> (f64, f64) {
    match kind {
        Jab | Cross => (-0.08, 0.12),
        Hook | Uppercut => (-0.05, 0.08),
        FrontKick => (-0.05, 0.28),
        SideKick => (-0.08, 0.18),
        RoundhouseKick => (-0.05, 0.32),
    }
}

/// Returns impact and end of a strike, in seconds from the first frame.
fn timing_s(cue: &Cue) -> (f64, f64) {
    let (impact_s, end_s) = if cue.kind.is_kick() {
        kicks::timing_s(cue.kind)
    } else {
        punches::timing_s(cue.kind, cue.side)
    };
    (cue.start_s + impact_s / cue.tempo, cue.start_s + end_s / cue.tempo)
}

/// Ten strikes of a clip, and the time for each strike with the step that follows it.
struct Programme {
    slot_s: f64,
    strikes: [(StrikeKind, Side); 10],
}

const PUNCHES_A: Programme = Programme {
    slot_s: PUNCH_SLOT_S,
    strikes: [
        (Jab, Lead),
        (Jab, Lead),
        (Jab, Lead),
        (Cross, Rear),
        (Cross, Rear),
        (Hook, Lead),
        (Hook, Lead),
        (Hook, Rear),
        (Uppercut, Lead),
        (Uppercut, Rear),
    ],
};
const PUNCHES_B: Programme = Programme {
    slot_s: PUNCH_SLOT_S,
    strikes: [
        (Jab, Lead),
        (Jab, Lead),
        (Cross, Rear),
        (Cross, Rear),
        (Cross, Rear),
        (Hook, Lead),
        (Hook, Rear),
        (Uppercut, Lead),
        (Uppercut, Rear),
        (Uppercut, Rear),
    ],
};
const KICKS_A: Programme = Programme {
    slot_s: KICK_SLOT_S,
    strikes: [
        (FrontKick, Lead),
        (FrontKick, Rear),
        (FrontKick, Rear),
        (FrontKick, Rear),
        (SideKick, Lead),
        (SideKick, Lead),
        (SideKick, Rear),
        (RoundhouseKick, Lead),
        (RoundhouseKick, Rear),
        (RoundhouseKick, Rear),
    ],
};
const KICKS_B: Programme = Programme {
    slot_s: KICK_SLOT_S,
    strikes: [
        (FrontKick, Lead),
        (FrontKick, Rear),
        (FrontKick, Rear),
        (SideKick, Lead),
        (SideKick, Lead),
        (SideKick, Rear),
        (RoundhouseKick, Lead),
        (RoundhouseKick, Rear),
        (RoundhouseKick, Rear),
        (RoundhouseKick, Rear),
    ],
};

const PUNCH_SLOT_S: f64 = 1.70;
const KICK_SLOT_S: f64 = 2.17;
/// Time in guard before the first strike, in seconds.
const LEAD_IN_S: f64 = 0.30;
/// Time in guard after the last step, in seconds: enough for the differences that the evaluation forms at the end.
const LEAD_OUT_S: f64 = 0.20;
/// Shortest and longest delay from the start of a slot to the start of its strike, in seconds. Hips move before
/// the limb.
const SLOT_TO_START_S: (f64, f64) = (0.08, 0.18);

/// Maximum speed of the whole stance in a step, in metres per second. `STEP_M` is the maximum length of a step.
const STEP_SPEED_M_S: f64 = 0.5;
const STEP_M: f64 = 0.20;
/// Maximum distance from the place where the fighter began, in metres.
const RING_M: f64 = 0.8;
/// Maximum turn of the stance in one step; `LARGEST_TURN_DEG` is the maximum of its heading.
const STEP_TURN_DEG: f64 = 8.0;
const LARGEST_TURN_DEG: f64 = 25.0;

/// Returns the twelve clips: 80 punches and 40 kicks. The left side leads in half of the clips, the right side in the
/// others.
///
/// Every programme is performed in both stances equally often, which makes left and right strikes equally
/// frequent.
pub(super) fn scripts() -> Vec<Script> {
    let punches = [
        &PUNCHES_A, &PUNCHES_A, &PUNCHES_B, &PUNCHES_B, &PUNCHES_A, &PUNCHES_A, &PUNCHES_B,
        &PUNCHES_B,
    ];
    let kicks = [&KICKS_A, &KICKS_A, &KICKS_B, &KICKS_B];
    let numbered = |name: &'static str, programmes: &[&'static Programme], first_seed: u64| {
        let clips: Vec<Script> = (1_u64..)
            .zip(programmes)
            .map(|(number, programme)| {
                let lead = if number % 2 == 1 { Side::Left } else { Side::Right };
                script(format!("{name}_{number:02}"), first_seed + number, lead, programme)
            })
            .collect();
        clips
    };
    let mut scripts = numbered("punches", &punches, 100);
    scripts.extend(numbered("kicks", &kicks, 200));
    scripts
}

fn script(name: String, seed: u64, lead: Side, programme: &Programme) -> Script {
    let mut random = Random::new(seed, Subject::Script);
    let mut footwork = Random::new(seed, Subject::Footwork);
    let mut strikes = programme.strikes;
    random.shuffle(&mut strikes);

    let first = Stance { origin_m: DVec3::ZERO, heading_rad: 0.0 };
    let mut at = first;
    let (mut cues, mut steps) = (Vec::new(), Vec::new());
    let mut slot_s = LEAD_IN_S;
    for (kind, side) in strikes {
        let (lowest_rad, highest_rad) = heights_rad(kind);
        let cue = Cue {
            kind,
            side,
            start_s: slot_s + random.between(SLOT_TO_START_S.0, SLOT_TO_START_S.1),
            tempo: random.between(0.95, 1.06),
            power: random.between(0.85, 1.08),
            height_rad: random.between(lowest_rad, highest_rad),
        };
        slot_s += programme.slot_s;
        let step = Step { start_s: timing_s(&cue).1, end_s: slot_s, to: at };
        at = next_stance(&mut footwork, &at, step.end_s - step.start_s);
        steps.push(Step { to: at, ..step });
        cues.push(cue);
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some thousands")]
    let frames = libm::ceil((slot_s + LEAD_OUT_S) * RATE_HZ) as u32;
    Script { name, seed, lead, frames, first, steps, cues }
}

/// Draws a step in a random direction that does not leave the ring.
fn next_stance(random: &mut Random, at: &Stance, time_s: f64) -> Stance {
    let longest_m = STEP_M.min(STEP_SPEED_M_S * time_s);
    let length_m = longest_m * random.between(0.5, 1.0);
    let way = DQuat::from_rotation_y(random.between(0.0, core::f64::consts::TAU)) * DVec3::Z;
    let outwards = (at.origin_m + way * length_m).length() > RING_M;
    let origin_m = at.origin_m + way * if outwards { -length_m } else { length_m };

    let turn = random.between(-STEP_TURN_DEG, STEP_TURN_DEG).to_radians();
    let largest = LARGEST_TURN_DEG.to_radians();
    Stance { origin_m, heading_rad: (at.heading_rad + turn).clamp(-largest, largest) }
}
