//! The table of faults. The page `docs/faults.md` is printed from this table and from the faults' texts.

use super::{Clears, Fault, FaultSet, Reaction, Row};
use crate::supervisor::State;

/// Returns those of the faults that do more in a state than being reported.
pub(in crate::supervisor) fn reacting(faults: FaultSet, state: State) -> FaultSet {
    if faults.is_empty() {
        return faults;
    }
    let rows = TABLE.iter().filter(|row| faults.contains(row.fault));
    rows.filter(|row| row.reaction(state) > Reaction::Note).map(|row| row.fault).collect()
}

/// Faults with which the rig cannot be armed.
pub(in crate::supervisor) const SERIOUS: FaultSet = sets()[0];

/// Faults that a command clears.
pub(in crate::supervisor) const BY_COMMAND: FaultSet = sets()[1];

/// Faults that an upload clears.
pub(in crate::supervisor) const BY_UPLOAD: FaultSet = sets()[2];

/// Returns the serious faults, those that a command clears, and those that an upload clears.
#[expect(clippy::indexing_slicing, clippy::arithmetic_side_effects, reason = "at build time")]
const fn sets() -> [FaultSet; 3] {
    let mut sets = [FaultSet::EMPTY; 3];
    let mut index = 0;
    while index < Fault::COUNT {
        let row = &TABLE[index];
        if row.is_serious() {
            sets[0] = sets[0].with(row.fault);
        }
        match row.clears {
            Clears::Itself => {}
            Clears::Command => sets[1] = sets[1].with(row.fault),
            Clears::Upload => sets[2] = sets[2].with(row.fault),
        }
        index += 1;
    }
    sets
}

/// Reactions to a warning.
const NOTE: [Reaction; State::COUNT] = [Reaction::Note; State::COUNT];

/// Reactions that switch torque off at once, in any state.
const LIMP: [Reaction; State::COUNT] = [Reaction::Limp; State::COUNT];

/// Returns a row of reactions: while torque is off, a fault is only reported.
const fn reactions(on: [Reaction; 7]) -> [Reaction; State::COUNT] {
    const OFF: Reaction = Reaction::Note;
    let [arming, holding, playing, maintenance, stopping, lowering, floating] = on;
    [OFF, OFF, OFF, OFF, arming, holding, playing, maintenance, stopping, lowering, OFF, floating]
}

const LOWER: [Reaction; State::COUNT] = reactions([Reaction::Lower; 7]);

/// Reactions that move the rig to its rest pose. While it is being armed, and while a person jogs or leads it, the rig
/// is lowered instead. A rig that is already being lowered must not rise again.
const STOP: [Reaction; State::COUNT] = {
    use Reaction::{Lower, Stop};
    reactions([Lower, Stop, Stop, Lower, Stop, Lower, Lower])
};

/// Reactions that make a rig hold if it plays a feed or is in maintenance. All other motions continue.
const HOLD: [Reaction; State::COUNT] = {
    use Reaction::{Hold, Note};
    reactions([Note, Note, Hold, Hold, Note, Note, Note])
};

/// Reactions to a fault of the show: a rig that plays a show then holds its pose.
const HOLD_SHOW: [Reaction; State::COUNT] = {
    use Reaction::{Hold, Note};
    reactions([Note, Note, Hold, Note, Note, Note, Note])
};

/// The table, ordered by number.
pub const TABLE: &[Row; Fault::COUNT] = &[
    Row { fault: Fault::LinkLate, reactions: HOLD, clears: Clears::Itself },
    Row { fault: Fault::LinkLost, reactions: LOWER, clears: Clears::Command },
    Row { fault: Fault::ServoSilent, reactions: LOWER, clears: Clears::Command },
    Row { fault: Fault::ServoError, reactions: LOWER, clears: Clears::Command },
    Row { fault: Fault::HotMeasured, reactions: STOP, clears: Clears::Command },
    Row { fault: Fault::HotWinding, reactions: STOP, clears: Clears::Command },
    Row { fault: Fault::SupplyLow, reactions: LOWER, clears: Clears::Command },
    Row { fault: Fault::SupplyHigh, reactions: LOWER, clears: Clears::Command },
    Row { fault: Fault::FollowingError, reactions: LOWER, clears: Clears::Command },
    Row { fault: Fault::Range, reactions: LOWER, clears: Clears::Command },
    Row { fault: Fault::NotFinite, reactions: LIMP, clears: Clears::Command },
    Row { fault: Fault::Overrun, reactions: LOWER, clears: Clears::Command },
    Row { fault: Fault::SettingsBad, reactions: LIMP, clears: Clears::Upload },
    Row { fault: Fault::ShowBad, reactions: HOLD_SHOW, clears: Clears::Upload },
    Row { fault: Fault::ShowForeign, reactions: HOLD_SHOW, clears: Clears::Upload },
    Row { fault: Fault::EStop, reactions: LIMP, clears: Clears::Command },
    Row { fault: Fault::WatchdogReset, reactions: LIMP, clears: Clears::Command },
    Row { fault: Fault::BrownOut, reactions: LIMP, clears: Clears::Command },
    Row { fault: Fault::Panic, reactions: LIMP, clears: Clears::Command },
    Row { fault: Fault::ServoStopped, reactions: LOWER, clears: Clears::Command },
    Row { fault: Fault::TorqueStuck, reactions: LIMP, clears: Clears::Command },
    Row { fault: Fault::HostDeaf, reactions: STOP, clears: Clears::Command },
    Row { fault: Fault::Jump, reactions: LOWER, clears: Clears::Command },
    Row { fault: Fault::Swing, reactions: NOTE, clears: Clears::Itself },
];
