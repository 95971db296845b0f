//! Measures the reaction to a fault in a state: a cell of `docs/fault-matrix.md`, for a controller or a whole node.

use sinew_firmware::supervisor::{Fault, Reaction, Row, State, TABLE};

use super::test_rig::{NOTHING_A, SERVOS};

/// A device under test: a controller with its servos, or a whole node.
pub(crate) trait Tried {
    fn tick(&mut self);
    fn state(&self) -> State;
    /// Returns whether the fault's condition is detected.
    fn has(&self, fault: Fault) -> bool;
    fn servos_on(&self) -> usize;
    fn most_current_a(&self) -> f64;
    fn sent_off(&self) -> bool;
    fn ticks_of(&self, seconds: f64) -> u32;
}

/// Returns the row of a fault in the table of reactions.
pub(crate) fn row(fault: Fault) -> &'static Row {
    TABLE.iter().find(|row| row.fault == fault).unwrap()
}

/// Measured reaction to a fault in a state.
pub(crate) struct Cell {
    pub(crate) reaction: Reaction,
    noticed: u32,
    /// Number of ticks from the detection until the bytes for torque off are sent, and until torque is off. 0 is the
    /// tick of the detection.
    off: [Option<u32>; 2],
    off_s: f64,
}

/// Measures the reaction, beginning with the tick in which the condition was planted. Asserts everything that must be
/// true.
pub(crate) fn measure(tried: &mut impl Tried, fault: Fault, state: State) -> Cell {
    let reaction = row(fault).reaction(state);
    let carried_a = tried.most_current_a();
    let mut noticed = 0_u32;
    loop {
        tried.tick();
        noticed += 1;
        if tried.has(fault) {
            break;
        }
        assert!(noticed < 4_000, "{fault} is not noticed in {state}");
        assert_eq!(tried.state(), state, "{state} ended before {fault}");
    }
    let (mut bytes, mut torque) = (None, None);
    for tick in 0..tried.ticks_of(20.0) {
        let is_off = tried.servos_on() == 0 && tried.most_current_a() < NOTHING_A;
        bytes = bytes.or_else(|| tried.sent_off().then_some(tick));
        torque = torque.or_else(|| is_off.then_some(tick));
        let stays = matches!(reaction, Reaction::Note | Reaction::Hold | Reaction::Stop)
            || fault == Fault::TorqueStuck;
        if tick == 0 {
            let expected: &[State] = match reaction {
                Reaction::Limp => &[State::Faulted],
                Reaction::Lower => &[State::Lowering],
                Reaction::Stop => &[State::Stopping],
                Reaction::Hold => &[State::Holding, State::Maintenance],
                Reaction::Note => &[state],
            };
            let now = tried.state();
            assert!(expected.contains(&now), "{fault} in {state}: {now}, {reaction}");
        }
        if (bytes.is_some() && torque.is_some()) || (stays && tick == 2) {
            break;
        }
        // A rig that is lowered is still carried on the way down: after half a second part of the torque is still
        // there. The minimum share of effort is 0.3, and a sixth of the weight of a joint at rest is carried even
        // after 2.5 s of 3 s. Servos that have stopped by themselves carry nothing.
        if reaction == Reaction::Lower
            && tick == tried.ticks_of(0.5)
            && fault != Fault::ServoStopped
        {
            assert_eq!(tried.servos_on(), SERVOS, "{fault} in {state}");
            let later_a = tried.most_current_a();
            assert!(later_a > 0.05 * carried_a, "{fault} in {state}: {carried_a} to {later_a}");
        }
        tried.tick();
    }
    let off_s = bytes.map_or(0.0, |bytes| f64::from(bytes) / f64::from(tried.ticks_of(1.0)));
    Cell { reaction, noticed, off: [bytes, torque], off_s }
}

impl Cell {
    /// Returns the text of the cell on the page.
    pub(crate) fn words(&self, fault: Fault, state: State) -> String {
        let Self { reaction, noticed, off, off_s } = self;
        match (reaction, off) {
            (Reaction::Limp, [Some(bytes), Some(torque)]) => {
                assert!(*bytes <= 2 && *torque <= 2, "{fault} in {state}: {bytes}, {torque}");
                format!("{noticed}; off {bytes}, {torque}")
            }
            // A packet cannot do more than this.
            (Reaction::Limp, [Some(bytes), None]) if fault == Fault::TorqueStuck => {
                assert_eq!(*bytes, 0, "in {state}");
                format!("{noticed}; off {bytes}, stuck")
            }
            (Reaction::Lower, [Some(bytes), Some(torque)]) => {
                assert!(bytes.abs_diff(*torque) <= 2, "{fault} in {state}");
                format!("{noticed}; lowers 0, off {off_s:.1} s")
            }
            (Reaction::Note, [Some(0), Some(0)]) => format!("{noticed}; is off"),
            (Reaction::Note, _) => format!("{noticed}; told"),
            (Reaction::Hold, [None, None]) => format!("{noticed}; holds 0"),
            (Reaction::Stop, [None, None]) => format!("{noticed}; stops 0"),
            found => panic!("{fault} in {state}: {found:?}"),
        }
    }
}

/// Source of the page.
const PAGE: &str = include_str!("../../../../docs/fault-matrix.md");

/// Returns a table's lines. `cell` returns the text of a cell, `ends` the last cells of a row.
pub(crate) fn table(
    heads: &[&str],
    cell: impl Fn(Fault, State) -> String,
    ends: impl Fn(Fault, &[String]) -> Vec<String>,
) -> Vec<String> {
    let line = |cells: Vec<String>| format!("| {} |", cells.join(" | "));
    let owned = |text: &str| text.to_owned();
    let mut head = vec![String::new(), owned("fault")];
    head.extend(State::ALL.map(|state| state.to_string()));
    head.extend(heads.iter().map(|head| owned(head)));
    let mut rule = vec![owned("---:")];
    rule.resize(head.len(), owned("---"));
    // An empty cell contains one space.
    let mut lines = vec![line(head).replacen("|  |", "| |", 1), line(rule)];
    for row in TABLE {
        let cells = State::ALL.map(|state| cell(row.fault, state));
        let mut all = vec![row.fault.number().to_string(), owned(row.fault.name())];
        all.extend_from_slice(&cells);
        all.extend(ends(row.fault, &cells));
        lines.push(line(all));
    }
    lines
}

/// Returns the lines of a table of the page; `index` 0 is the first table.
pub(crate) fn of_page(index: usize) -> Vec<&'static str> {
    let tables: Vec<Vec<&str>> = PAGE
        .split("\n\n")
        .map(|part| part.lines().filter(|line| line.starts_with('|')).collect::<Vec<_>>())
        .filter(|lines| !lines.is_empty())
        .collect();
    tables.get(index).cloned().unwrap_or_default()
}

/// Fails with the required text if a table of the page differs.
pub(crate) fn must_be(index: usize, table: &[String]) {
    let is_same = of_page(index).iter().eq(table.iter());
    assert!(is_same, "table {index} of docs/fault-matrix.md must be:\n{}", table.join("\n"));
}
