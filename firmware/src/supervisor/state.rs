//! States of the supervisor, and sources of the pose that the rig follows.

use core::fmt;

use super::FaultSet;

/// State of the rig. The numbers are stored with faults: they are never changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum State {
    /// Not every servo and its registers were read since power-on. Torque is off.
    #[default]
    Off = 0,
    /// Torque is off, everything is read; the rig may be armed.
    Limp = 1,
    /// Torque is off; a user finds ranges by hand.
    Calibrating = 2,
    /// Torque is off; a user shows poses by hand.
    Teaching = 3,
    /// Torque comes on at the measured pose.
    Arming = 4,
    /// The rig holds the last commanded pose.
    Holding = 5,
    /// The rig follows a [`Feed`].
    Playing = 6,
    /// One operator jogs the rig slowly while the enabling button is held.
    Maintenance = 7,
    /// The rig moves to its rest pose; then it is lowered.
    Stopping = 8,
    /// The rig sinks slowly: less and less of its weight is carried, and movement is braked; then it is limp.
    Lowering = 9,
    /// Torque is off, and a fault is latched.
    Faulted = 10,
    /// The rig carries its own weight, and a user leads it by hand.
    Floating = 11,
}

impl State {
    /// Number of states.
    pub const COUNT: usize = 12;

    /// All states, by number.
    pub const ALL: [Self; Self::COUNT] = [
        Self::Off,
        Self::Limp,
        Self::Calibrating,
        Self::Teaching,
        Self::Arming,
        Self::Holding,
        Self::Playing,
        Self::Maintenance,
        Self::Stopping,
        Self::Lowering,
        Self::Faulted,
        Self::Floating,
    ];

    /// Returns the number of the state.
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// Returns whether the torque of servos may be on.
    pub const fn is_on(self) -> bool {
        use State::{Arming, Floating, Holding, Lowering, Maintenance, Playing, Stopping};
        matches!(self, Arming | Holding | Playing | Maintenance | Floating | Stopping | Lowering)
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Off => "off",
            Self::Limp => "limp",
            Self::Calibrating => "calibrating",
            Self::Teaching => "teaching",
            Self::Arming => "arming",
            Self::Holding => "holding",
            Self::Playing => "playing",
            Self::Maintenance => "maintenance",
            Self::Stopping => "stopping",
            Self::Lowering => "lowering",
            Self::Faulted => "faulted",
            Self::Floating => "floating",
        })
    }
}

/// A source of poses from outside. Each may fall silent, and then the rig holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Feed {
    /// A show in memory.
    Show,
    /// A live stream.
    Live,
    /// A user moves single joints.
    Jog,
}

impl fmt::Display for Feed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Show => "show",
            Self::Live => "live",
            Self::Jog => "jog",
        })
    }
}

/// Source of the pose that the rig follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Source {
    /// A feed from outside.
    Feed(Feed),
    /// The last commanded pose when this source began.
    Hold,
    /// The measured pose when this source began.
    Measured,
    /// The rig's rest pose.
    Rest,
    /// The current measured pose: a hand leads the rig.
    Led,
}

/// Extent of the permitted motion, from least to most.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Allows {
    /// Torque is off.
    Nothing,
    /// Effort that brakes, and that carries less and less of the rig's weight.
    Lower,
    /// Effort that carries the rig's weight, without a target pose.
    Carry,
    /// Effort towards a pose that does not move.
    Stand,
    /// Effort towards a pose that moves.
    Move,
}

/// A person at a terminal, by an id from the link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Operator(pub u8);

/// State of the supervisor without its clocks: a finite number of modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Mode {
    /// State of the rig.
    pub state: State,
    /// The feed that the rig follows: present in [`State::Playing`], and in [`State::Maintenance`] while the button
    /// is held.
    pub feed: Option<Feed>,
    /// Whether the rig has not reached its feed since it was armed or stood still: it moves at the soft speed.
    pub is_soft: bool,
    /// Operator who has the rig for maintenance, until he or she leaves it.
    pub operator: Option<Operator>,
    /// Faults that stay until they are cleared.
    pub latched: FaultSet,
}

impl Mode {
    /// Returns the source of the pose.
    pub const fn source(&self) -> Source {
        match (self.state, self.feed) {
            (State::Playing | State::Maintenance, Some(feed)) => Source::Feed(feed),
            (State::Stopping, _) => Source::Rest,
            (State::Arming | State::Lowering, _) => Source::Measured,
            (State::Floating, _) => Source::Led,
            _ => Source::Hold,
        }
    }

    /// Returns the extent of the permitted motion.
    pub const fn allows(&self) -> Allows {
        match (self.state, self.source()) {
            (state, _) if !state.is_on() => Allows::Nothing,
            (State::Lowering, _) => Allows::Lower,
            (State::Floating, _) => Allows::Carry,
            (_, Source::Feed(_) | Source::Rest) => Allows::Move,
            _ => Allows::Stand,
        }
    }
}
