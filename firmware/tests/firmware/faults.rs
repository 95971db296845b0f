//! Faults keep their numbers, and the page of the book contains the table.

use std::fmt::Write;

use sinew_firmware::supervisor::{Fault, FaultSet, Reaction, State, TABLE};

const PAGE: &str = include_str!("../../../docs/faults.md");

/// Numbers and names are in users' notes: a line may be added, and none may be changed.
#[test]
fn numbers_are_never_changed() {
    let names = [
        (1, "link late"),
        (2, "link lost"),
        (3, "servo silent"),
        (4, "servo's own error"),
        (5, "hot, measured"),
        (6, "hot, by I²t"),
        (7, "supply low"),
        (8, "supply high"),
        (9, "following error"),
        (10, "out of range"),
        (11, "not finite"),
        (12, "overrun"),
        (13, "settings bad"),
        (14, "show bad"),
        (15, "show of another rig"),
        (16, "emergency stop"),
        (17, "watchdog reset"),
        (18, "brown-out"),
        (19, "panic"),
        (20, "servo has stopped"),
        (21, "torque stuck"),
        (22, "host deaf"),
        (23, "jump"),
        (64, "swing"),
    ];
    assert!(Fault::ALL.map(|fault| (fault.number(), fault.name())).into_iter().eq(names));
    assert!(TABLE.iter().map(|row| row.fault).eq(Fault::ALL));
    for fault in Fault::ALL {
        assert!(FaultSet::of(fault).iter().eq([fault]));
    }
    // The numbers of states must not change either: they are stored with faults.
    let states = [
        "off",
        "limp",
        "calibrating",
        "teaching",
        "arming",
        "holding",
        "playing",
        "maintenance",
        "stopping",
        "lowering",
        "faulted",
        "floating",
    ];
    assert_eq!(State::ALL.map(|state| state.to_string()), states);
    assert!(State::ALL.map(State::number).into_iter().eq(0..12));
}

/// A fault never leads to a state with more torque, and torque that is off stays off.
#[test]
fn reactions_lead_down() {
    for row in TABLE {
        let at = |state: State| row.reaction(state);
        assert!(at(State::Lowering) != Reaction::Stop && at(State::Arming) != Reaction::Stop);
        for by_hand in [State::Maintenance, State::Floating] {
            assert!(at(by_hand) != Reaction::Stop, "past the hands of an operator");
        }
        for state in State::ALL.into_iter().filter(|state| !state.is_on()) {
            assert!(matches!(at(state), Reaction::Note | Reaction::Limp), "{} {state}", row.fault);
        }
    }
}

#[test]
fn the_page_is_the_table() {
    let (_, faults) = PAGE.split_once("\n## Faults\n").unwrap();
    let of_page: Vec<&str> = faults.lines().filter(|line| line.starts_with('|')).collect();
    let printed = tables();
    let of_table: Vec<&str> = printed.lines().collect();
    assert!(of_page == of_table, "the tables of docs/faults.md must be:\n{printed}");
}

fn tables() -> String {
    let mut text = "| | fault | when | what to do | latches | cleared by |\n".to_owned();
    text.push_str("| ---: | --- | --- | --- | --- | --- |\n");
    for row in TABLE {
        let (number, name) = (row.fault.number(), row.fault.name());
        let latches = if row.latches() { "yes" } else { "no" };
        let (when, remedy, clears) = (row.fault.when(), row.fault.remedy(), row.clears);
        writeln!(text, "| {number} | {name} | {when} | {remedy} | {latches} | {clears} |").unwrap();
    }
    let states = State::ALL.map(|state| format!(" {state} |")).concat();
    writeln!(text, "| | fault |{states}").unwrap();
    writeln!(text, "| ---: | --- |{}", " --- |".repeat(State::COUNT)).unwrap();
    for row in TABLE {
        let reactions = row.reactions.map(|reaction| format!(" {reaction} |")).concat();
        writeln!(text, "| {} | {} |{reactions}", row.fault.number(), row.fault.name()).unwrap();
    }
    text
}
