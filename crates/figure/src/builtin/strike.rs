//! Strikes: their kinds, and their description for the performer and for users of the clips.

use super::skeleton::Side;

/// A kind of strike.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StrikeKind {
    /// Straight punch of the leading hand.
    Jab,
    /// Straight punch of the rear hand.
    Cross,
    /// Level swing with a bent arm.
    Hook,
    /// Rising punch with a bent arm.
    Uppercut,
    /// Straight kick forwards with the ball of the foot.
    FrontKick,
    /// Straight kick sideways with the edge of the foot.
    SideKick,
    /// Level swing of the leg, instep first.
    RoundhouseKick,
}

impl StrikeKind {
    /// Returns whether the strike is a kick.
    pub const fn is_kick(self) -> bool {
        matches!(self, Self::FrontKick | Self::SideKick | Self::RoundhouseKick)
    }
}

/// A strike that a clip contains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strike {
    /// Kind of strike.
    pub kind: StrikeKind,
    /// Side of the fist or foot that strikes.
    pub side: Side,
    /// Time at which the limb leaves the guard, in seconds from the first frame.
    pub start_s: f64,
    /// Time at which the fist or foot is at the target, in seconds from the first frame.
    pub impact_s: f64,
    /// Time at which the fighter is back in guard, in seconds from the first frame.
    pub end_s: f64,
}

/// A strike as input of the performer, whose left side always leads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cue {
    pub kind: StrikeKind,
    pub side: Side,
    pub start_s: f64,
    /// Speed, as a multiple of the key poses' speed.
    pub tempo: f64,
    /// Turn of hips and trunk, as a multiple of the key poses' turn.
    pub power: f64,
    /// Aim above that of the key poses, as pitch.
    pub height_rad: f64,
}
