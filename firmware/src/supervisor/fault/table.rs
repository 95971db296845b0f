//! The one table of faults. The page `docs/faults.md` is printed from it.

use super::{Clears, Fault, FaultSet, Reaction, Row};
use crate::supervisor::State;

/// Those of some faults that have a reaction in a state.
pub(in crate::supervisor) fn reacting(faults: FaultSet, state: State) -> FaultSet {
    if faults.is_empty() {
        return faults;
    }
    let rows = TABLE.iter().filter(|row| faults.contains(row.fault));
    rows.filter(|row| row.reaction(state) > Reaction::Note).map(|row| row.fault).collect()
}

/// Faults with which the rig is not armed.
pub(in crate::supervisor) const SERIOUS: FaultSet = sets()[0];

/// Faults that a command clears.
pub(in crate::supervisor) const BY_COMMAND: FaultSet = sets()[1];

/// Faults that an upload clears.
pub(in crate::supervisor) const BY_UPLOAD: FaultSet = sets()[2];

/// Serious faults; those that a command clears; those that an upload clears.
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

/// Torque is off at once, whatever the state.
const LIMP: [Reaction; State::COUNT] = [Reaction::Limp; State::COUNT];

/// A row of reactions: where torque is off, a fault is only told.
const fn reactions(on: [Reaction; 7]) -> [Reaction; State::COUNT] {
    const OFF: Reaction = Reaction::Note;
    let [arming, holding, playing, maintenance, stopping, lowering, floating] = on;
    [OFF, OFF, OFF, OFF, arming, holding, playing, maintenance, stopping, lowering, OFF, floating]
}

const LOWER: [Reaction; State::COUNT] = reactions([Reaction::Lower; 7]);

/// To the rest pose, but not past the hands of whoever jogs or leads it, and not up again from being lowered.
const STOP: [Reaction; State::COUNT] = {
    use Reaction::{Lower, Stop};
    reactions([Lower, Stop, Stop, Lower, Stop, Lower, Lower])
};

/// What moves holds.
const HOLD: [Reaction; State::COUNT] = {
    use Reaction::{Hold, Note};
    reactions([Note, Note, Hold, Hold, Note, Note, Note])
};

/// Of the show: what plays holds.
const HOLD_SHOW: [Reaction; State::COUNT] = {
    use Reaction::{Hold, Note};
    reactions([Note, Note, Hold, Note, Note, Note, Note])
};

/// The table, by number.
pub const TABLE: &[Row; Fault::COUNT] = &[
    Row {
        fault: Fault::LinkLate,
        when: "no valid message came for 0.2 s (setting)",
        remedy: "look at cable and host; play again",
        reactions: HOLD,
        clears: Clears::Itself,
    },
    Row {
        fault: Fault::LinkLost,
        when: "no valid message came for 2 s (setting)",
        remedy: "look at cable and host",
        reactions: LOWER,
        clears: Clears::Command,
    },
    Row {
        fault: Fault::ServoSilent,
        when: "a servo missed 5 replies in a row (setting), or its reading is too old",
        remedy: "look at its plug, its id and its supply",
        reactions: LOWER,
        clears: Clears::Command,
    },
    Row {
        fault: Fault::ServoError,
        when: "a servo reports an error: overload, encoder, shock",
        remedy: "read the error with `sinew servo`; restart the servo",
        reactions: LOWER,
        clears: Clears::Command,
    },
    Row {
        fault: Fault::HotMeasured,
        when: "a servo is at its own limit of temperature, less 5 degC",
        remedy: "let it cool; lighten its load",
        reactions: STOP,
        clears: Clears::Command,
    },
    Row {
        fault: Fault::HotWinding,
        when: "by its current, a winding has the heat of the continuous current and more",
        remedy: "let it cool; lighten its load",
        reactions: STOP,
        clears: Clears::Command,
    },
    Row {
        fault: Fault::SupplyLow,
        when: "the filtered voltage is at a servo's minimum, plus 5 %",
        remedy: "a stronger supply, thicker wires, or less at once",
        reactions: LOWER,
        clears: Clears::Command,
    },
    Row {
        fault: Fault::SupplyHigh,
        when: "the filtered voltage is at a servo's maximum, less 5 %",
        remedy: "the right supply; one that takes what brakes give back",
        reactions: LOWER,
        clears: Clears::Command,
    },
    Row {
        fault: Fault::FollowingError,
        when: "a servo is 15 deg from where it should be, for 0.2 s (settings)",
        remedy: "look what holds it; check its load",
        reactions: LOWER,
        clears: Clears::Command,
    },
    Row {
        fault: Fault::Range,
        when: "a servo was measured outside of its range",
        remedy: "bring it back by hand; calibrate it",
        reactions: LOWER,
        clears: Clears::Command,
    },
    Row {
        fault: Fault::NotFinite,
        when: "a number is NaN or infinite: a reading, a target, a command",
        remedy: "keep the record, and report it",
        reactions: LIMP,
        clears: Clears::Command,
    },
    Row {
        fault: Fault::Overrun,
        when: "more than 3 ticks in 500 took too long (settings)",
        remedy: "a lower rate, a faster bus, or a smaller rig",
        reactions: LOWER,
        clears: Clears::Command,
    },
    Row {
        fault: Fault::SettingsBad,
        when: "settings or rig cannot be read, cannot be, or only older ones are whole",
        remedy: "upload them again",
        reactions: LIMP,
        clears: Clears::Upload,
    },
    Row {
        fault: Fault::ShowBad,
        when: "the show that is played cannot be read",
        remedy: "upload it again",
        reactions: HOLD_SHOW,
        clears: Clears::Upload,
    },
    Row {
        fault: Fault::ShowForeign,
        when: "the show that is played is of another rig",
        remedy: "bake it for this rig",
        reactions: HOLD_SHOW,
        clears: Clears::Upload,
    },
    Row {
        fault: Fault::EStop,
        when: "the emergency stop is pressed, or was commanded",
        remedy: "look why; release it",
        reactions: LIMP,
        clears: Clears::Command,
    },
    Row {
        fault: Fault::WatchdogReset,
        when: "the board begins, since its watchdog has reset it",
        remedy: "keep the record, and report it",
        reactions: LIMP,
        clears: Clears::Command,
    },
    Row {
        fault: Fault::BrownOut,
        when: "the board begins, since its own supply broke down",
        remedy: "feed the board apart from the servos",
        reactions: LIMP,
        clears: Clears::Command,
    },
    Row {
        fault: Fault::Panic,
        when: "the board begins, since its program stopped itself",
        remedy: "keep the record, and report it",
        reactions: LIMP,
        clears: Clears::Command,
    },
    Row {
        fault: Fault::ServoStopped,
        when: "a servo with torque heard nothing for 0.1 s: its own watchdog has stopped it",
        remedy: "look at the bus and its cable; keep the record",
        reactions: LOWER,
        clears: Clears::Command,
    },
    Row {
        fault: Fault::TorqueStuck,
        when: "torque was switched off, and a servo's register says that it is on",
        remedy: "cut its supply; restart the servo, or replace it",
        reactions: LIMP,
        clears: Clears::Command,
    },
];
