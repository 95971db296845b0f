//! What a tick brings to a mode.

use super::{Command, FaultSet, Feed, Moving, Registers};

/// What a tick brings. Clocks come as what they say about the state before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[expect(clippy::struct_excessive_bools, reason = "each is a fact of its own")]
pub struct Event {
    /// A command, if one came.
    pub command: Option<Command>,
    /// Faults whose condition is there.
    pub present: FaultSet,
    /// What a good upload has mended: [`FaultSet::OF_SHOW`]. Good settings, or a good rig, count after a restart.
    pub uploaded: FaultSet,
    /// Every servo has a valid reading that is new enough; of those that tell nothing none is asked for.
    pub measured: bool,
    /// What servos hold in their registers.
    pub registers: Registers,
    /// The way to stop was tested since the rig became limp.
    pub stop_tested: bool,
    /// A joint that moves too fast to be armed.
    pub moving: Option<Moving>,
    /// Which feeds give poses.
    pub feeds: Feeds,
    /// Every servo takes an effort, so that the rig can carry itself. Asked for by floating alone.
    pub carries: bool,
    /// The enabling button is held.
    pub enabled: bool,
    /// The blend to the source is over, and the rig is there; or the rig is down.
    pub arrived: bool,
    /// The time of a state that ends by itself is over.
    pub time_over: bool,
}

/// Which feeds give poses in this tick: a show that is good and chosen, a stream that is not late, a jog that is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Feeds {
    /// [`Feed::Show`].
    pub show: bool,
    /// [`Feed::Live`].
    pub live: bool,
    /// [`Feed::Jog`].
    pub jog: bool,
}

impl Feeds {
    /// Whether a feed gives poses.
    pub const fn gives(self, feed: Feed) -> bool {
        match feed {
            Feed::Show => self.show,
            Feed::Live => self.live,
            Feed::Jog => self.jog,
        }
    }
}
