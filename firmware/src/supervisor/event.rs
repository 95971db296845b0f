//! Input of a tick for a change of mode.

use super::{Command, FaultSet, Feed, Moving, Overload, Registers};

/// Input of a tick for a change of mode. It contains no times: clocks appear only as conditions of the state
/// before, such as `time_over`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[expect(clippy::struct_excessive_bools, reason = "each is a fact of its own")]
pub struct Event {
    /// A command, if one arrived.
    pub command: Option<Command>,
    /// Faults whose condition is present.
    pub present: FaultSet,
    /// Faults that a valid upload has cleared: [`FaultSet::OF_SHOW`]. Valid settings, or a valid rig, take effect
    /// after a restart.
    pub uploaded: FaultSet,
    /// Whether every servo that reports has a valid reading that is new enough.
    pub measured: bool,
    /// Result of comparing the servos' registers.
    pub registers: Registers,
    /// Whether the way to stop was tested since the rig became limp.
    pub stop_tested: bool,
    /// A joint that moves too fast for arming.
    pub moving: Option<Moving>,
    /// A load that servos or supply cannot hold. Used only by arming.
    pub overload: Option<Overload>,
    /// Feeds that have poses.
    pub feeds: Feeds,
    /// Whether every servo accepts an effort, so that the rig can carry itself. Used only by floating.
    pub carries: bool,
    /// Whether the enabling button is held.
    pub enabled: bool,
    /// Whether the blend to the source has ended, and the rig has reached it; or whether a lowered rig is down.
    pub arrived: bool,
    /// Whether the time of a state that ends by itself has passed.
    pub time_over: bool,
}

/// Feeds that have poses in this tick: a valid selected show, a stream that is not late, a jog that is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Feeds {
    /// Whether [`Feed::Show`] has poses.
    pub show: bool,
    /// Whether [`Feed::Live`] has poses.
    pub live: bool,
    /// Whether [`Feed::Jog`] has poses.
    pub jog: bool,
}

impl Feeds {
    /// Returns whether a feed has poses.
    pub const fn gives(self, feed: Feed) -> bool {
        match feed {
            Feed::Show => self.show,
            Feed::Live => self.live,
            Feed::Jog => self.jog,
        }
    }
}
