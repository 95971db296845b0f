//! Strikes: their kinds, and how the performer and the clips name them.

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
    /// Whether a leg strikes.
    pub const fn is_kick(self) -> bool {
        matches!(self, Self::FrontKick | Self::SideKick | Self::RoundhouseKick)
    }
}

/// A strike that a clip holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strike {
    /// The kind.
    pub kind: StrikeKind,
    /// The side of the fist or foot that strikes.
    pub side: Side,
    /// When it leaves the guard, in seconds from the first frame.
    pub start_s: f64,
    /// When fist or foot is at the target.
    pub impact_s: f64,
    /// When the fighter is back in guard.
    pub end_s: f64,
}

/// A strike as the performer is given it, who always leads with the left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cue {
    pub kind: StrikeKind,
    pub side: Side,
    pub start_s: f64,
    /// Speed as a multiple of the key poses' own.
    pub tempo: f64,
    /// Turn of hips and trunk as a multiple of the key poses' own.
    pub power: f64,
    /// Aim above the key poses' own, as pitch.
    pub height_rad: f64,
}
