//! States, and where the pose comes from that the rig follows.

use core::fmt;

use super::FaultSet;

/// What the rig does. The numbers are stored with faults: they are never changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum State {
    /// Since power-on not every servo was read, its registers too. Torque is off.
    #[default]
    Off = 0,
    /// Torque is off, all is known; it may be armed.
    Limp = 1,
    /// Torque is off; ranges are found by hand.
    Calibrating = 2,
    /// Torque is off; poses are shown by hand.
    Teaching = 3,
    /// Torque comes on at the measured pose.
    Arming = 4,
    /// It stands where it was commanded last.
    Holding = 5,
    /// It follows a [`Feed`].
    Playing = 6,
    /// One operator jogs it slowly, as long as the enabling button is held.
    Maintenance = 7,
    /// It goes to its rest pose; then it is lowered.
    Stopping = 8,
    /// It sinks slowly: less and less of its weight is carried, and what moves is braked; then it is limp.
    Lowering = 9,
    /// Torque is off, and a fault is latched.
    Faulted = 10,
    /// It carries its own weight, and goes where it is led by hand.
    Floating = 11,
}

impl State {
    /// How many there are.
    pub const COUNT: usize = 12;

    /// All of them, by number.
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

    /// Its number.
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// Whether the torque of servos may be on.
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

/// Who gives poses from outside. Each may fall silent, and then the rig holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Feed {
    /// A show in memory.
    Show,
    /// A live stream.
    Live,
    /// Somebody moves single joints.
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

/// Where the pose comes from that the rig follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Source {
    /// From outside.
    Feed(Feed),
    /// The pose that was commanded last when this source began.
    Hold,
    /// The pose that was measured when this source began.
    Measured,
    /// The rig's rest pose.
    Rest,
    /// Wherever a hand leads the rig: the pose that is measured now.
    Led,
}

/// How much a state allows, from least to most.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Allows {
    /// Torque is off.
    Nothing,
    /// Effort that brakes, and carries less and less of the rig's weight.
    Lower,
    /// Effort that carries the rig's weight, towards no pose.
    Carry,
    /// Effort, towards a pose that stands.
    Stand,
    /// Effort, towards a pose that moves.
    Move,
}

/// Somebody at a terminal: an id that the link gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Operator(pub u8);

/// What the supervisor remembers, but for its clocks: a finite number of modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Mode {
    /// The state.
    pub state: State,
    /// Whom it follows: some in [`State::Playing`], and in [`State::Maintenance`] while the button is held.
    pub feed: Option<Feed>,
    /// It was armed, or stood, and has not arrived at its feed since: it moves at the soft speed.
    pub is_soft: bool,
    /// Who has the rig for maintenance, until he or she leaves it.
    pub operator: Option<Operator>,
    /// Faults that stay until they are cleared.
    pub latched: FaultSet,
}

impl Mode {
    /// Where the pose comes from.
    pub const fn source(&self) -> Source {
        match (self.state, self.feed) {
            (State::Playing | State::Maintenance, Some(feed)) => Source::Feed(feed),
            (State::Stopping, _) => Source::Rest,
            (State::Arming | State::Lowering, _) => Source::Measured,
            (State::Floating, _) => Source::Led,
            _ => Source::Hold,
        }
    }

    /// How much it allows.
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
