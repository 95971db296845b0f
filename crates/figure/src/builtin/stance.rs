//! The fighter's guard stance, the steps that move it, and its sway.
//!
//! Everything up to the finished pose is written for an orthodox fighter, whose left side leads; a southpaw is the
//! mirror image. Stance frame: origin on the floor below the guard, y up, z towards the opponent.

use glam::{DQuat, DVec3};
use sinew_host_util::random::Random;

use super::skeleton::Side;
use super::timing::{Track, Track3};

/// Position of the pelvis in the stance frame, in metres.
pub(super) const PELVIS_M: DVec3 = DVec3::new(0.03, 0.87, -0.02);
/// Rotation of the pelvis relative to the stance, in degrees about x, y, z.
pub(super) const PELVIS_TURN_DEG: DVec3 = DVec3::new(4.0, -35.0, 0.0);
/// Rotation of the thorax relative to the pelvis, in degrees about x, y, z.
pub(super) const TRUNK_TURN_DEG: DVec3 = DVec3::new(13.0, -3.0, 0.0);
/// Positions of the wrists in the stance frame, left (leading) and right, in metres.
pub(super) const WRISTS_M: [DVec3; 2] =
    [DVec3::new(0.12, 1.43, 0.42), DVec3::new(-0.05, 1.42, 0.19)];
/// Direction of the elbows in the stance frame.
pub(super) const ELBOWS: [DVec3; 2] = [DVec3::new(0.35, -1.0, -0.1), DVec3::new(-0.45, -1.0, -0.1)];
/// Pronation of the forearms from the palm-down rest pose; the palms face inwards.
pub(super) const PRONATION_DEG: f64 = 5.0;
/// Position of the opponent's face in the stance frame.
pub(super) const OPPONENT_M: DVec3 = DVec3::new(0.0, 1.55, 1.3);

/// Positions of the balls of the feet in the stance frame, left and right.
const BALLS_M: [DVec3; 2] = [DVec3::new(0.10, 0.0, 0.36), DVec3::new(-0.17, 0.0, -0.20)];
/// Headings of the feet, as turns about y from z.
const FEET_DEG: [f64; 2] = [-18.0, -48.0];
/// Heights of the heels, as pitch of the feet. The rear heel is off the floor.
pub(super) const HEELS_DEG: [f64; 2] = [0.0, 12.0];

/// Pose of the stance frame in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stance {
    /// Origin of the frame, on the floor.
    pub origin_m: DVec3,
    /// Heading: the turn about y from the world's z to the direction of the opponent.
    pub heading_rad: f64,
}

impl Stance {
    /// Returns the rotation from the stance's axes to the world's.
    pub(super) fn rotation(&self) -> DQuat {
        DQuat::from_rotation_y(self.heading_rad)
    }

    fn ball_m(&self, side: Side) -> DVec3 {
        self.origin_m + self.rotation() * BALLS_M[side.index()]
    }

    fn foot_rad(&self, side: Side) -> f64 {
        self.heading_rad + foot_heading_rad(side)
    }
}

/// Returns the heading of a foot in guard relative to the stance.
pub(super) fn foot_heading_rad(side: Side) -> f64 {
    FEET_DEG[side.index()].to_radians()
}

/// A step that brings the whole stance to a new pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Step {
    pub start_s: f64,
    pub end_s: f64,
    pub to: Stance,
}

/// Tracks of the stance and of the feet, over a whole clip.
#[derive(Debug, Clone)]
pub(super) struct Footwork {
    origin: Track3,
    heading: Track,
    balls: [Track3; 2],
    feet: [Track; 2],
}

/// Greatest height of a stepping foot.
const STEP_HEIGHT_M: f64 = 0.04;
/// Share of a step's duration for which one foot is in the air. The times of the two feet overlap a little.
const FOOT_SHARE: f64 = 0.58;

impl Footwork {
    /// Builds the tracks from the first stance and all steps. The steps are in order and do not overlap.
    pub(super) fn new(first: Stance, steps: &[Step]) -> Self {
        let mut at = first;
        let mut origin = vec![(0.0, first.origin_m)];
        let mut heading = vec![(0.0, first.heading_rad)];
        let mut balls = Side::BOTH.map(|side| vec![(0.0, first.ball_m(side))]);
        let mut feet = Side::BOTH.map(|side| vec![(0.0, first.foot_rad(side))]);
        for step in steps {
            origin.extend([(step.start_s, at.origin_m), (step.end_s, step.to.origin_m)]);
            heading.extend([(step.start_s, at.heading_rad), (step.end_s, step.to.heading_rad)]);
            for side in Side::BOTH {
                let (start_s, end_s) = air_time(&at, step, side);
                let (from, to) = (at.ball_m(side), step.to.ball_m(side));
                let top = from.midpoint(to) + DVec3::Y * STEP_HEIGHT_M;
                let mid_s = f64::midpoint(start_s, end_s);
                balls[side.index()].extend([(start_s, from), (mid_s, top), (end_s, to)]);
                feet[side.index()]
                    .extend([(start_s, at.foot_rad(side)), (end_s, step.to.foot_rad(side))]);
            }
            at = step.to;
        }
        Self {
            origin: Track3::new(origin),
            heading: Track::new(heading),
            balls: balls.map(Track3::new),
            feet: feet.map(Track::new),
        }
    }

    /// Returns the stance at a time.
    pub(super) fn stance(&self, time_s: f64) -> Stance {
        Stance { origin_m: self.origin.at(time_s), heading_rad: self.heading.at(time_s) }
    }

    /// Returns the world position of the ball of a foot.
    pub(super) fn ball_m(&self, time_s: f64, side: Side) -> DVec3 {
        self.balls[side.index()].at(time_s)
    }

    /// Returns the heading of a foot: its turn about y from the world's z.
    pub(super) fn foot_rad(&self, time_s: f64, side: Side) -> f64 {
        self.feet[side.index()].at(time_s)
    }
}

/// Returns the start and end of a foot's time in the air. The foot on the side of the movement goes first, to keep
/// the legs from crossing.
fn air_time(from: &Stance, step: &Step, side: Side) -> (f64, f64) {
    let way = step.to.origin_m - from.origin_m;
    let lead_from_rear = from.rotation() * (BALLS_M[0] - BALLS_M[1]);
    let first = if way.dot(lead_from_rear) >= 0.0 { Side::Left } else { Side::Right };
    let air_s = FOOT_SHARE * (step.end_s - step.start_s);
    if side == first {
        (step.start_s, step.start_s + air_s)
    } else {
        (step.end_s - air_s, step.end_s)
    }
}

/// Involuntary movement: bounce, shift of weight and breath as sums of sines.
#[derive(Debug, Clone)]
pub(super) struct Sway {
    /// Shift of the pelvis, in the stance's axes.
    shift_m: Waves,
    /// Turn of the pelvis. The trunk turns in the opposite direction.
    turn_rad: Waves,
    /// Shift of each wrist.
    wrists_m: [Waves; 2],
}

#[derive(Debug, Clone)]
struct Waves(Vec<Wave>);

#[derive(Debug, Clone, Copy)]
struct Wave {
    amplitude: DVec3,
    frequency_hz: f64,
    phase_rad: f64,
}

impl Waves {
    /// Draws one wave for each `(amplitude, lowest frequency, highest frequency)`, frequencies in Hz.
    fn new(random: &mut Random, bands: &[(DVec3, f64, f64)]) -> Self {
        let mut wave = |&(amplitude, low_hz, high_hz): &(DVec3, f64, f64)| Wave {
            amplitude,
            frequency_hz: random.between(low_hz, high_hz),
            phase_rad: random.between(0.0, core::f64::consts::TAU),
        };
        Self(bands.iter().map(&mut wave).collect())
    }

    fn at(&self, time_s: f64) -> DVec3 {
        let value = |wave: &Wave| {
            wave.amplitude
                * libm::sin(core::f64::consts::TAU * wave.frequency_hz * time_s + wave.phase_rad)
        };
        self.0.iter().map(value).sum()
    }
}

impl Sway {
    /// Draws the waves of a clip.
    pub(super) fn new(random: &mut Random) -> Self {
        let degree = 1.0_f64.to_radians();
        let shift = [
            (DVec3::new(0.000, 0.009, 0.002), 1.5, 2.1),
            (DVec3::new(0.008, 0.002, 0.004), 0.5, 0.9),
            (DVec3::new(0.004, 0.000, 0.009), 0.4, 0.8),
        ];
        let turn = [
            (DVec3::new(0.6, 0.4, 0.6) * degree, 0.20, 0.30),
            (DVec3::new(0.5, 2.0, 0.8) * degree, 0.6, 1.0),
            (DVec3::new(0.3, 1.0, 0.3) * degree, 1.3, 1.9),
        ];
        let wrist = [
            (DVec3::new(0.006, 0.010, 0.006), 0.7, 1.2),
            (DVec3::new(0.004, 0.006, 0.008), 1.4, 2.2),
        ];
        Self {
            shift_m: Waves::new(random, &shift),
            turn_rad: Waves::new(random, &turn),
            wrists_m: Side::BOTH.map(|_| Waves::new(random, &wrist)),
        }
    }

    /// Returns the shift of the pelvis in the stance's axes.
    pub(super) fn shift_m(&self, time_s: f64) -> DVec3 {
        self.shift_m.at(time_s)
    }

    /// Returns the turn of the pelvis, as angles about x, y, z.
    pub(super) fn pelvis_turn_rad(&self, time_s: f64) -> DVec3 {
        self.turn_rad.at(time_s)
    }

    /// Returns the turn of the trunk, which undoes half of the pelvis's turn.
    pub(super) fn trunk_turn_rad(&self, time_s: f64) -> DVec3 {
        -0.5 * self.turn_rad.at(time_s)
    }

    /// Returns the shift of a wrist in the stance's axes.
    pub(super) fn wrist_m(&self, time_s: f64, side: Side) -> DVec3 {
        self.wrists_m[side.index()].at(time_s)
    }
}
