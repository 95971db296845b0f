//! Events for the model: every command in every situation. One fault represents all faults of its kind, two operators
//! represent all operators, and zero, one, two or all faults are present.

use sinew_firmware::supervisor::{
    Command, Event, Fault, FaultSet, Feed, Feeds, Moving, Operator, Overload, Registers, TABLE,
};

/// Faults that the supervisor handles by name: each represents its kind.
const NAMED: [Fault; 2] = [Fault::ServoSilent, Fault::EStop];

/// Returns one fault for each kind of row in the table.
pub(crate) fn kinds() -> Vec<Fault> {
    let of_row = |fault: Fault| {
        let row = TABLE.iter().find(|row| row.fault == fault).unwrap();
        (row.reactions, row.clears)
    };
    let mut kinds: Vec<Fault> = Vec::new();
    for fault in NAMED.into_iter().chain(Fault::ALL) {
        if !kinds.iter().any(|kind| of_row(*kind) == of_row(fault)) {
            kinds.push(fault);
        }
    }
    assert!(NAMED.iter().all(|fault| kinds.contains(fault)), "two named faults of one kind");
    kinds
}

/// All events: every command in every situation.
pub(crate) struct Events {
    commands: Vec<Option<Command>>,
    situations: Vec<Event>,
}

impl Events {
    /// Creates all events: with none of these faults present at the same time, with one, with two, and with all.
    pub(crate) fn new(faults: &[Fault]) -> Self {
        // The order is fixed, so that a step that breaks two rules reports the same rule in every run.
        let mut sets = vec![FaultSet::EMPTY];
        let pairs = faults
            .iter()
            .flat_map(|one| faults.iter().map(|other| FaultSet::of(*one).with(*other)));
        for set in pairs.chain([faults.iter().copied().collect()]) {
            if !sets.contains(&set) {
                sets.push(set);
            }
        }
        let mut situations = Vec::new();
        for present in sets {
            for bits in 0_u32..1 << 10 {
                let is = |bit: u32| bits >> bit & 1 == 1;
                // All conditions for arming are met, or one of them is missing.
                let missing = [bits >> 2 & 1, bits >> 9 & 1];
                let overload = Overload::Servo { dof: 0, mnm: 600, most_mnm: 520 };
                let moving = Moving { dof: 0, mrad_s: 500, most_mrad_s: 349 };
                situations.push(Event {
                    command: None,
                    present,
                    uploaded: if is(0) { FaultSet::OF_SHOW } else { FaultSet::EMPTY },
                    measured: is(1),
                    registers: if missing == [1, 0] { Registers::Unread } else { Registers::Same },
                    stop_tested: missing != [0, 1],
                    // Arming uses no feed.
                    moving: (missing == [1, 1] && !is(3)).then_some(moving),
                    overload: (missing == [1, 1] && is(3)).then_some(overload),
                    // `carries` and `arrived` share a bit: an event for which one matters does not depend on the
                    // other.
                    carries: is(7),
                    feeds: Feeds { show: is(3), live: is(4), jog: is(5) },
                    enabled: is(6),
                    arrived: is(7),
                    time_over: is(8),
                });
            }
        }
        Self { commands: commands(), situations }
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = Event> {
        let with = |command| self.situations.iter().map(move |event| Event { command, ..*event });
        self.commands.iter().copied().flat_map(with)
    }
}

fn commands() -> Vec<Option<Command>> {
    let mut commands = vec![
        None,
        Some(Command::Arm),
        Some(Command::Disarm),
        Some(Command::Hold),
        Some(Command::Stop),
        Some(Command::Calibrate),
        Some(Command::Teach),
        Some(Command::Float),
        Some(Command::ClearFaults),
        Some(Command::EStop),
    ];
    commands.extend([Feed::Show, Feed::Live, Feed::Jog].map(|feed| Some(Command::Play(feed))));
    // Two operators represent all: the supervisor only checks whether they are the same.
    for operator in [Operator(1), Operator(2)] {
        let all = [Command::Maintain, Command::Enable, Command::Leave];
        commands.extend(all.map(|command| Some(command(operator))));
    }
    commands
}
