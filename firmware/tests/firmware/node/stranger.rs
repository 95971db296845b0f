//! A second program on a line where a first one uses the rig, in every state: the third table of the page
//! `docs/fault-matrix.md`.

use sinew_firmware::supervisor::{Fault, State};
use sinew_link::message::{
    Command, Hello, Numbered, Outcome, Refusal, ToController, ToHost, Version,
};

use super::cell::must_be;
use super::line::Trouble;
use super::matrix::enter;
use super::stored::show;
use super::test_rig::Kind;
use super::world::World;

const KIND: Kind = Kind::Current;
const NONCE: u32 = 77;

/// Sends a message of the second program and returns the answer.
fn said(world: &mut World, message: &ToController) -> ToHost {
    let now_us = world.now_us();
    world.host.others.clear();
    world.host.send(message, now_us);
    for _ in 0..40 {
        world.tick();
        if let Some(said) = world.host.others.first() {
            return said.clone();
        }
    }
    panic!("nothing came back of {message:?}");
}

fn asked(world: &mut World, session: u16, command: Command) -> Outcome {
    // The number is far ahead of the first program's numbers.
    let numbered = Numbered { session, seq: 5_000, item: command };
    match said(world, &ToController::Command(numbered)) {
        ToHost::Answer(answer) => answer.item,
        other => panic!("{other:?}"),
    }
}

/// Returns a column of the table: the second program says hello, the first one sends a command, then the second one
/// sends `Hold` and `Stop`.
fn column(state: State) -> [String; 4] {
    let mut world = World::new(KIND, Trouble::default(), 29);
    world.store(&show(KIND, 20, true));
    world.until(State::Limp, 2.0);
    enter(&mut world, state, Fault::EStop);
    let hello = ToController::Hello(Hello { protocol: Version::CURRENT, nonce: NONCE });
    let ToHost::Welcome(welcome) = said(&mut world, &hello) else { panic!("no welcome") };
    let of_first = world.host.welcome.unwrap().session;
    assert_ne!(welcome.session, of_first, "{state}");
    let greeted = if welcome.verdict.is_ok() { "has the session" } else { "busy" };
    assert_eq!(welcome.session == 0, welcome.verdict.is_err(), "{state}");
    let first = match world.ask(Command::ReadSetting { key: 1 }) {
        Outcome::Applied(_) => "goes on",
        Outcome::Refused(Refusal::Session) => "session over",
        other => panic!("{state}: {other:?}"),
    };
    assert_eq!(
        (greeted == "busy", first),
        (state.is_on(), if state.is_on() { "goes on" } else { "session over" })
    );
    // A motion in progress continues meanwhile.
    let before = world.state();
    let hold = match asked(&mut world, welcome.session, Command::Hold) {
        Outcome::Refused(Refusal::Session) => "refused, session",
        Outcome::Refused(Refusal::State(_)) => "refused, state",
        other => panic!("{state}: {other:?}"),
    };
    assert_eq!(world.state(), before, "{state}");
    // With an old number and no session: a stop is accepted in any case.
    let stop = Numbered { session: 0, seq: 0, item: Command::Stop };
    let stopped = match said(&mut world, &ToController::Command(stop)) {
        ToHost::Answer(Numbered { item: Outcome::Applied(_), .. }) => {
            world.state().unwrap().to_string()
        }
        other => panic!("{state}: {other:?}"),
    };
    [greeted, first, hold, &stopped].map(str::to_owned)
}

#[test]
fn a_second_program_takes_over_nothing_while_torque_is_on() {
    let columns = State::ALL.map(column);
    let heads = State::ALL.map(|state| state.to_string()).join(" | ");
    let mut lines = vec![
        format!("| a second program | {heads} |"),
        format!("| --- |{}", " --- |".repeat(State::COUNT)),
    ];
    let rows =
        ["it says hello", "the first one's next command", "its `Hold`", "its `Stop`: the rig is"];
    for (row, name) in rows.into_iter().enumerate() {
        let cells: Vec<&str> = columns.iter().map(|column| column[row].as_str()).collect();
        lines.push(format!("| {name} | {} |", cells.join(" | ")));
    }
    must_be(2, &lines);
}
