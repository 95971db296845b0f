//! The search and the rules. They use nothing of the supervisor's internals except the table of faults.

use std::collections::{HashSet, VecDeque};
use std::fmt;
use std::sync::LazyLock;

use sinew_firmware::supervisor::{
    Allows, Answer, Command, Event, Fault, FaultSet, Mode, Reaction, Registers, Source, State,
    TABLE,
};

use super::events::Events;

/// Numbers of modes and steps that were checked.
pub(crate) struct Counts {
    pub(crate) modes: usize,
    pub(crate) steps: usize,
}

/// A broken rule, with the step that breaks it.
pub(crate) struct Violation {
    pub(crate) rule: &'static str,
    from: Watched,
    event: Event,
    to: Mode,
    answer: Option<Answer>,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rule, from, event, to, answer } = self;
        write!(f, "broken: {rule}\nfrom {from:?}\nby {event:?}\nto {to:?}\nanswer {answer:?}")
    }
}

/// A mode with an observer's memory of the events that led to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
struct Watched {
    mode: Mode,
    /// Whether an arm command was applied since torque was off.
    was_armed: bool,
    /// Whether a stop, a disarm command or a fault has begun to end the rig's motion.
    is_ending: bool,
    /// Whether a fault that stops the rig occurred, with neither a clear command nor an upload since then.
    is_blamed: bool,
}

/// Checks every mode that `step` can reach, with every event. The search is breadth first, so that a broken rule is
/// found with few steps.
pub(crate) fn check(
    events: &Events,
    step: impl Fn(Mode, &Event) -> (Mode, Option<Answer>),
) -> Result<Counts, Box<Violation>> {
    let mut found = HashSet::from([Watched::default()]);
    let mut waiting = VecDeque::from([Watched::default()]);
    let mut steps = 0;
    // Consecutive events usually lead to the same mode: it is looked up only once.
    let mut last = Watched::default();
    while let Some(from) = waiting.pop_front() {
        for event in events.iter() {
            let (to, answer) = step(from.mode, &event);
            steps += 1;
            let watched = from.after(&event, to, answer);
            if let Err(rule) = keeps_rules(&from, &event, &watched, answer) {
                return Err(Box::new(Violation { rule, from, event, to, answer }));
            }
            if answer.is_some_and(|answer| answer.is_err()) {
                let silent = step(from.mode, &Event { command: None, ..event }).0;
                if silent != to {
                    let rule = "a refused command changes nothing";
                    return Err(Box::new(Violation { rule, from, event, to, answer }));
                }
            }
            if watched != from && watched != last {
                last = watched;
                if found.insert(watched) {
                    waiting.push_back(watched);
                }
            }
        }
    }
    let modes: HashSet<Mode> = found.iter().map(|watched| watched.mode).collect();
    Ok(Counts { modes: modes.len(), steps })
}

impl Watched {
    fn after(&self, event: &Event, mode: Mode, answer: Option<Answer>) -> Self {
        let is_applied = |command| event.command == Some(command) && is_ok(answer);
        let is_on = mode.allows() > Allows::Nothing;
        let reaction = reaction(present(self.mode.state, event), self.mode.state);
        let ends =
            is_applied(Command::Stop) || is_applied(Command::Disarm) || reaction >= Reaction::Stop;
        let is_forgiven = is_applied(Command::ClearFaults) || !event.uploaded.is_empty();
        Self {
            mode,
            was_armed: is_on && (self.was_armed || is_applied(Command::Arm)),
            is_ending: is_on && (self.is_ending || ends),
            is_blamed: reaction >= Reaction::Stop || self.is_blamed && !is_forgiven,
        }
    }
}

/// Returns the rule that a step breaks, if any.
fn keeps_rules(
    from: &Watched,
    event: &Event,
    to: &Watched,
    answer: Option<Answer>,
) -> Result<(), &'static str> {
    let (before, after) = (from.mode.allows(), to.mode.allows());
    let source = to.mode.source();
    let moves = after == Allows::Move;
    let is_armed_now = event.command == Some(Command::Arm) && is_ok(answer);
    let faults = present(from.mode.state, event);
    let worst = reaction(faults, to.mode.state);
    let answered = event.command.is_some() == answer.is_some();
    let is_led = answer.is_none_or(|answer| answer.is_err() || answer == Ok(to.mode.state));
    hold(answered && is_led, "every command is answered with the state it led to")?;
    hold(
        !matches!(event.command, Some(Command::Stop | Command::Disarm | Command::EStop))
            || is_ok(answer),
        "stop, disarm and e-stop are never refused",
    )?;
    hold(after == Allows::Nothing || to.was_armed, "torque comes on by an arm command alone")?;
    hold(
        before > Allows::Nothing
            || after == Allows::Nothing
            || (to.mode.state == State::Arming
                && event.measured
                && event.registers == Registers::Same
                && event.stop_tested
                && event.moving.is_none()
                && event.overload.is_none()),
        "arming is from rest, measured, of servos that are set up and bear the rig, with a tested stop",
    )?;
    hold(
        !is_armed_now || !from.is_blamed && worst == Reaction::Note,
        "after a fault nothing is armed that was not cleared",
    )?;
    hold(after <= Allows::Lower || event.measured, "what holds or moves is measured")?;
    hold(
        !matches!(source, Source::Feed(feed) if moves && !event.feeds.gives(feed)),
        "what moves has a live source",
    )?;
    hold(
        after <= Allows::Lower || worst <= Reaction::Stop && is_followed(worst, &to.mode),
        "no fault goes without its reaction",
    )?;
    hold(
        reaction(faults, from.mode.state) < Reaction::Limp || after == Allows::Nothing,
        "limp at once is in the same tick",
    )?;
    hold(
        !from.is_ending || rank(to.mode.state) <= rank(from.mode.state) - i8::from(event.time_over),
        "what ends comes nearer to its end",
    )?;
    hold(!to.is_ending || rank(to.mode.state) <= 2, "what is to end ends")?;
    hold(
        from.mode.state != State::Holding || to.mode.state != State::Playing || to.mode.is_soft,
        "from standing still it starts softly",
    )?;
    hold(to.mode.state != State::Arming || to.mode.is_soft, "it arms softly")?;
    hold(
        to.mode.state != State::Maintenance || !moves || event.enabled && event.feeds.jog,
        "maintenance moves while the button is held",
    )?;
    hold(
        to.mode.state != State::Floating
            || from.mode.state == State::Floating
            || from.mode.state == State::Holding
                && event.command == Some(Command::Float)
                && event.carries,
        "it floats from standing, by command, and where every servo takes an effort",
    )?;
    hold(
        from.mode.state != State::Floating || !moves,
        "what is in somebody's hands goes nowhere by itself",
    )?;
    hold(has_one_operator(from, event, to), "one operator has the rig until he or she leaves it")
}

/// Returns the rule as an error if it is broken.
fn hold(holds: bool, rule: &'static str) -> Result<(), &'static str> {
    if holds { Ok(()) } else { Err(rule) }
}

fn is_ok(answer: Option<Answer>) -> bool {
    matches!(answer, Some(Ok(_)))
}

/// Returns the present faults, as an observer sees them.
fn present(state: State, event: &Event) -> FaultSet {
    let silent = state.is_on() && !event.measured;
    let stopped = event.command == Some(Command::EStop);
    let own = [(silent, Fault::ServoSilent), (stopped, Fault::EStop)];
    event.present.union(own.into_iter().filter(|(is, _)| *is).map(|(_, fault)| fault).collect())
}

/// Returns the strictest reaction that a state requires.
fn reaction(faults: FaultSet, state: State) -> Reaction {
    static BY_STATE: LazyLock<Vec<[(Reaction, FaultSet); 4]>> = LazyLock::new(|| {
        let of = |state: State, reaction: Reaction| {
            let rows =
                TABLE.iter().filter(|row| row.reactions[usize::from(state.number())] == reaction);
            (reaction, rows.map(|row| row.fault).collect())
        };
        let strictest_first = [Reaction::Limp, Reaction::Lower, Reaction::Stop, Reaction::Hold];
        State::ALL.map(|state| strictest_first.map(|reaction| of(state, reaction))).to_vec()
    });
    let rows = &BY_STATE[usize::from(state.number())];
    let asked = rows.iter().find(|(_, of)| !of.and(faults).is_empty());
    asked.map_or(Reaction::Note, |(reaction, _)| *reaction)
}

/// Returns whether a mode that allows more than lowering follows the reaction that a present fault requires.
fn is_followed(reaction: Reaction, mode: &Mode) -> bool {
    match reaction {
        Reaction::Note => true,
        Reaction::Hold => mode.allows() <= Allows::Stand,
        Reaction::Stop => mode.state == State::Stopping,
        Reaction::Lower | Reaction::Limp => false,
    }
}

/// Returns the distance of a state from limp.
fn rank(state: State) -> i8 {
    match state {
        State::Stopping => 2,
        State::Lowering => 1,
        state if state.is_on() => 3,
        _ => 0,
    }
}

fn has_one_operator(from: &Watched, event: &Event, to: &Watched) -> bool {
    match (from.mode.operator, to.mode.operator) {
        (None, None) => true,
        (None, Some(new)) => event.command == Some(Command::Maintain(new)),
        (Some(old), None) => event.command == Some(Command::Leave(old)),
        (Some(old), Some(new)) => {
            let is_armed = event.command == Some(Command::Arm) && to.mode.state == State::Arming;
            old == new && !is_armed && !matches!(to.mode.state, State::Playing | State::Calibrating)
                || from.mode.state == to.mode.state
        }
    }
}
