//! A model check of two programs at the link of one rig: every reachable mode and session, with every message of each
//! program. The session is that of the link, the mode that of the supervisor; the node between them is modelled.

use std::collections::{HashSet, VecDeque};

use sinew_firmware::supervisor::{
    self, Event, Fault, FaultSet, Feed as OwnFeed, Feeds, Mode, Operator as Own, Registers, State,
};
use sinew_link::message::{
    About, Capacities, Command, Feed, Hello, Numbered, Operator, Release, Version,
};
use sinew_link::{Intake, Session};

/// Session numbers that a program may have: of no session, of the previous session, of the current session.
const NUMBERS: [u16; 3] = [0, 7, 8];
const CURRENT: u16 = NUMBERS[2];

const ABOUT: About = About {
    protocol: Version::CURRENT,
    firmware: Release { major: 0, minor: 1, patch: 0 },
    rig: 0,
    capacities: Capacities {
        bodies: 1,
        coordinates: 1,
        dofs: 1,
        servos: 1,
        slots: 1,
        slot_bytes: 1,
    },
};

/// A rig, the program that has the session, and the session number that each of two programs received last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
struct Desk {
    mode: Mode,
    holder: Option<usize>,
    told: [u16; 2],
}

impl Desk {
    /// Returns the link's session, as if no command had arrived in it before.
    fn session(&self) -> Session {
        let mut session = Session::new(CURRENT - 1);
        if let Some(holder) = self.holder {
            let welcome = session.hello(greeting(holder), ABOUT, false);
            assert_eq!(welcome.session, CURRENT);
        }
        session
    }

    /// Handles a greeting, or a command, like the node. Returns the command if the supervisor gets it.
    fn take(&mut self, who: usize, said: Option<&Command>) -> Option<Command> {
        let mut session = self.session();
        if let Some(item) = said {
            let command = Numbered { session: self.told[who], seq: 0, item: item.clone() };
            return (session.command(&command) == Intake::Execute).then(|| item.clone());
        }
        let before = session.id();
        let welcome = session.hello(greeting(who), ABOUT, self.mode.state.is_on());
        if session.id() == before {
            self.told[who] = welcome.session;
        } else {
            self.pass_to(who);
        }
        None
    }

    /// Gives a program a new session.
    fn pass_to(&mut self, who: usize) {
        let outdated = |told: u16| if told == CURRENT { NUMBERS[1] } else { told };
        self.told = self.told.map(outdated);
        (self.holder, self.told[who]) = (Some(who), CURRENT);
    }
}

fn greeting(who: usize) -> Hello {
    let nonce = u32::try_from(who).unwrap();
    Hello { protocol: Version::CURRENT, nonce }
}

/// Returns a command of the link as the supervisor gets it. One operator and one feed represent all.
fn of_link(command: &Command) -> supervisor::Command {
    match command {
        Command::EStop => supervisor::Command::EStop,
        Command::Arm => supervisor::Command::Arm,
        Command::Disarm => supervisor::Command::Disarm,
        Command::Play(_) => supervisor::Command::Play(OwnFeed::Live),
        Command::Hold => supervisor::Command::Hold,
        Command::Stop => supervisor::Command::Stop,
        Command::Calibrate => supervisor::Command::Calibrate,
        Command::Teach => supervisor::Command::Teach,
        Command::Maintain(_) => supervisor::Command::Maintain(Own(1)),
        Command::Leave(_) => supervisor::Command::Leave(Own(1)),
        Command::ClearFaults => supervisor::Command::ClearFaults,
        Command::Float => supervisor::Command::Float,
        other => panic!("{other:?} is not for the supervisor"),
    }
}

/// Returns a greeting, which is `None`, and all commands.
fn messages() -> Vec<Option<Command>> {
    let commands = [
        Command::EStop,
        Command::Arm,
        Command::Disarm,
        Command::Play(Feed::Live),
        Command::Hold,
        Command::Stop,
        Command::Calibrate,
        Command::Teach,
        Command::Maintain(Operator(1)),
        Command::Leave(Operator(1)),
        Command::ClearFaults,
        Command::Float,
    ];
    [None].into_iter().chain(commands.map(Some)).collect()
}

/// Returns the situations of a rig whose servos are set up. The faults are those of a program that is killed, is deaf,
/// or ends the motion.
fn situations() -> Vec<Event> {
    let faults = [Fault::LinkLost, Fault::HostDeaf, Fault::EStop].map(FaultSet::of);
    let mut situations = Vec::new();
    for present in [FaultSet::EMPTY].into_iter().chain(faults) {
        for bits in 0..1 << 4 {
            let is = |bit: u32| bits >> bit & 1 == 1;
            situations.push(Event {
                present,
                measured: is(0),
                registers: Registers::Same,
                stop_tested: true,
                feeds: Feeds { show: false, live: is(1), jog: false },
                carries: true,
                arrived: is(2),
                time_over: is(3),
                ..Event::default()
            });
        }
    }
    situations
}

/// Returns the rule that a step breaks, if any. `obeyed`: the command that the supervisor got.
fn broken(
    from: &Desk,
    who: usize,
    said: Option<&Command>,
    event: &Event,
    (to, obeyed): (&Desk, Option<&Command>),
) -> Option<&'static str> {
    let ends = matches!(said, Some(Command::Stop | Command::EStop));
    let is_ours = from.holder == Some(who) && from.told[who] == CURRENT;
    let silent = from.mode.next(event).0;
    let knows = |who: usize| to.told[who] == CURRENT;
    let armed = !from.mode.state.is_on() && to.mode.state.is_on();
    let rules = [
        (
            !from.mode.state.is_on() || from.holder == to.holder,
            "a rig with torque stays with its program",
        ),
        (
            !armed || is_ours && said == Some(&Command::Arm),
            "torque comes on by the program that has the session",
        ),
        (is_ours || ends || to.mode == silent, "a stranger commands nothing but an end"),
        (!ends || obeyed.is_some(), "anybody may end the motion"),
        (
            (0..2).all(|who| knows(who) == (to.holder == Some(who))),
            "only the program that has the session knows its number",
        ),
    ];
    rules.into_iter().find(|(holds, _)| !holds).map(|(_, rule)| rule)
}

/// Checks every desk that `take` can reach. Returns the number of desks and of steps.
fn check(
    take: impl Fn(&mut Desk, usize, Option<&Command>) -> Option<Command>,
) -> Result<(usize, usize), &'static str> {
    let (messages, situations) = (messages(), situations());
    let mut found = HashSet::from([Desk::default()]);
    let mut waiting = VecDeque::from([Desk::default()]);
    let mut steps = 0;
    while let Some(from) = waiting.pop_front() {
        for (who, said) in (0..2).flat_map(|who| messages.iter().map(move |said| (who, said))) {
            let (mut taken, said) = (from, said.as_ref());
            let obeyed = take(&mut taken, who, said);
            for event in &situations {
                let command = obeyed.as_ref().map(of_link);
                let mode = from.mode.next(&Event { command, ..*event }).0;
                let to = Desk { mode, ..taken };
                steps += 1;
                if let Some(rule) = broken(&from, who, said, event, (&to, obeyed.as_ref())) {
                    return Err(rule);
                }
                if found.insert(to) {
                    waiting.push_back(to);
                }
            }
        }
    }
    Ok((found.len(), steps))
}

#[test]
fn no_program_gets_a_rig_that_another_one_uses() {
    let (desks, steps) = check(Desk::take).unwrap_or_else(|rule| panic!("broken: {rule}"));
    println!("{desks} desks, {steps} steps");
    assert!(desks > 100, "it stopped early: {desks}");
}

#[track_caller]
fn mistake(rule: &str, take: impl Fn(&mut Desk, usize, Option<&Command>) -> Option<Command>) {
    assert_eq!(check(take), Err(rule));
}

/// With this mistake, nobody would watch the lowering to its end, and a fault in it would be reported to another
/// program.
#[test]
fn a_greeting_that_takes_over_a_rig_that_is_lowered_is_found() {
    mistake("a rig with torque stays with its program", |desk, who, said| {
        if said.is_none() && desk.mode.state == State::Lowering {
            desk.pass_to(who);
            return None;
        }
        desk.take(who, said)
    });
}

/// With this mistake, a refused program could command another program's rig with the session number in the answer.
#[test]
fn an_answer_that_tells_a_live_session_s_number_is_found() {
    mistake("only the program that has the session knows its number", |desk, who, said| {
        let obeyed = desk.take(who, said);
        if said.is_none() {
            desk.told[who] = CURRENT;
        }
        obeyed
    });
}

/// With this mistake, a rig that somebody guides by hand would stiffen.
#[test]
fn a_stranger_s_hold_is_found() {
    mistake("a stranger commands nothing but an end", |desk, who, said| {
        let is_hold = said == Some(&Command::Hold);
        desk.take(who, said).or_else(|| is_hold.then_some(Command::Hold))
    });
}

/// With this mistake, the previous program would not be refused after a takeover.
#[test]
fn a_session_that_outlives_its_end_is_found() {
    mistake("torque comes on by the program that has the session", |desk, who, said| {
        let is_old = desk.told[who] == NUMBERS[1];
        let is_arm = said == Some(&Command::Arm);
        desk.take(who, said).or_else(|| (is_old && is_arm).then_some(Command::Arm))
    });
}

#[test]
fn a_stop_that_is_refused_for_its_session_is_found() {
    mistake("anybody may end the motion", |desk, who, said| {
        desk.take(who, said).filter(|_| desk.told[who] == CURRENT)
    });
}
