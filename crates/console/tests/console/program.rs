//! A program that drives through the Unix socket, by the rules that hold for pages.

use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::json;
use sinew_board_client::console::Report;
use sinew_console::{Driver, PageCommand};
use sinew_link::message::{Command, State};

use crate::client::{HOLDING, LIMP, PLAYING, Page};
use crate::other_side::OtherSide;

/// Longest wait for the console.
const PATIENCE: Duration = Duration::from_mins(1);
/// Longer than any wait of a test.
const LONG_S: f64 = 600.0;

/// Sends a command, and returns the console's answer.
fn ask(program: &mut Driver, command: PageCommand) -> Result<String, String> {
    let id = program.ask(command).unwrap();
    answer(program, id)
}

fn answer(program: &mut Driver, id: u64) -> Result<String, String> {
    let end = Instant::now() + PATIENCE;
    loop {
        program.step(Duration::from_millis(10)).unwrap();
        if let Some(answer) = program.answer(id) {
            return answer;
        }
        assert!(Instant::now() < end, "no answer");
    }
}

fn report(program: &mut Driver) -> Report {
    serde_json::from_str(&ask(program, PageCommand::State).unwrap()).unwrap()
}

/// Waits for a state, and returns the report that has it.
fn until(program: &mut Driver, state: State) -> Report {
    let end = Instant::now() + PATIENCE;
    loop {
        let now = report(program);
        if now.summary.state == state && !now.q.is_empty() {
            return now;
        }
        assert!(Instant::now() < end, "the rig is {}", now.summary.state);
    }
}

/// Opens a program's connection, as soon as the console accepts it.
fn open(console: &OtherSide) -> Driver {
    let end = Instant::now() + PATIENCE;
    loop {
        match Driver::open(&console.name) {
            Ok(program) => return program,
            Err(error) => assert!(Instant::now() < end, "{error}"),
        }
        sleep(Duration::from_millis(10));
    }
}

fn armed(console: &OtherSide) -> (Driver, Vec<f32>) {
    let mut program = open(console);
    until(&mut program, State::Limp);
    ask(&mut program, PageCommand::Arm).unwrap();
    let q = until(&mut program, State::Holding).q;
    (program, q)
}

fn goto(q: Vec<f32>, seconds: f64) -> PageCommand {
    PageCommand::Goto { q, seconds }
}

#[test]
fn a_program_arms_moves_plays_and_stops() {
    let console = OtherSide::start(true);
    let (mut program, start) = armed(&console);
    assert!(program.drives());
    let goal = vec![start[0] + 0.1];
    assert_eq!(ask(&mut program, goto(goal.clone(), 0.5)).unwrap(), "the rig is there");
    // The board commands the goal; gravity does not act on this joint, and friction stops a servo before it.
    let there = until(&mut program, State::Holding);
    assert!((there.q[0] - goal[0]).abs() < 0.02, "{} and {}", there.q[0], goal[0]);
    // A program's poses reach the board as they are.
    for step in 0_u8..20 {
        let q = vec![goal[0] - 0.002 * f32::from(step)];
        ask(&mut program, PageCommand::Live { q }).unwrap();
    }
    until(&mut program, State::Playing);
    // Nothing repeats the last pose: the board holds.
    until(&mut program, State::Holding);
    let last = goal[0] - 0.038;
    assert!(console.told.lock().unwrap().poses.iter().any(|q| (q[0] - last).abs() < 1e-6));
    let play = PageCommand::Play { slot: 0, is_loop: false, rounds: 1 };
    assert_eq!(ask(&mut program, play).unwrap(), "the show is over");
    assert_eq!(ask(&mut program, PageCommand::Faults).unwrap(), "[]");
    ask(&mut program, PageCommand::Stop).unwrap();
    until(&mut program, State::Limp);
}

#[test]
fn only_who_has_the_wheel_arms_and_moves() {
    let console = OtherSide::start(true);
    let mut page = Page::open(&console);
    let mut program = open(&console);
    let q = until(&mut program, State::Limp).q;
    assert!(!program.drives());
    let why = "somebody else drives";
    let moves = [
        PageCommand::Arm,
        goto(q.clone(), 1.0),
        PageCommand::Live { q: q.clone() },
        PageCommand::Play { slot: 0, is_loop: false, rounds: 1 },
        PageCommand::Wheel { take: true },
    ];
    for command in moves {
        let refused = ask(&mut program, command.clone()).unwrap_err();
        assert!(refused.contains(why), "{command:?}: {refused}");
    }
    assert!(!console.told.lock().unwrap().commands.contains(&Command::Arm));
    let (is_done, text) = page.ask(json!({ "type": "faults" }));
    assert!(!is_done && text.contains("only programs"), "{text}");
    // The page releases the wheel, for which the program has asked; then the page is refused.
    assert!(page.ask(json!({ "type": "wheel", "take": false })).0);
    assert!(ask(&mut program, PageCommand::Arm).is_ok() && program.drives());
    until(&mut program, State::Holding);
    let (is_done, text) = page.ask(json!({ "type": "home" }));
    assert!(!is_done && text.contains(why), "{text}");
    // Every page holds a motion of a program, which learns it.
    let id = program.ask(goto(vec![q[0] + 0.1], LONG_S)).unwrap();
    page.until_state(PLAYING);
    assert!(page.ask(json!({ "type": "hold" })).0);
    let ended = answer(&mut program, id).unwrap_err();
    assert!(ended.contains("the motion was ended"), "{ended}");
}

#[test]
fn a_hold_of_somebody_else_ends_a_stream_of_poses() {
    let console = OtherSide::start(false);
    let (mut program, q) = armed(&console);
    let mut page = Page::open(&console);
    let stream = |program: &mut Driver| {
        let begun = Instant::now();
        let mut refused = Vec::new();
        while begun.elapsed() < Duration::from_secs(1) {
            let q = vec![q[0] + 0.1 * begun.elapsed().as_secs_f32()];
            refused.extend(ask(program, PageCommand::Live { q }).err());
            sleep(Duration::from_millis(10));
        }
        refused
    };
    assert_eq!(stream(&mut program), Vec::<String>::new());
    assert!(page.ask(json!({ "type": "hold" })).0);
    until(&mut program, State::Holding);
    let count = console.told.lock().unwrap().poses.len();
    let refused = stream(&mut program);
    assert!(refused.len() > 20, "{refused:?}");
    assert!(refused.iter().all(|why| why.contains("told to stand")), "{refused:?}");
    assert_eq!(report(&mut program).summary.state, State::Holding);
    assert_eq!(console.told.lock().unwrap().poses.len(), count);
    // The program knows that the rig stands.
    ask(&mut program, PageCommand::Hold).unwrap();
    assert_eq!(stream(&mut program), Vec::<String>::new());
}

#[test]
fn after_a_stop_of_somebody_else_a_program_clears_before_it_arms() {
    let console = OtherSide::start(false);
    let (mut program, _) = armed(&console);
    let mut page = Page::open(&console);
    assert!(page.ask(json!({ "type": "stop" })).0);
    until(&mut program, State::Limp);
    let refused = ask(&mut program, PageCommand::Arm).unwrap_err();
    assert!(refused.contains("`clear` first"), "{refused}");
    ask(&mut program, PageCommand::Clear).unwrap();
    ask(&mut program, PageCommand::Arm).unwrap();
    until(&mut program, State::Holding);
}

#[test]
fn a_motion_is_not_replaced_by_another() {
    let console = OtherSide::start(true);
    let (mut program, q) = armed(&console);
    let first = program.ask(goto(vec![q[0] + 0.3], LONG_S)).unwrap();
    // The board does not play yet, or does.
    let play = PageCommand::Play { slot: 0, is_loop: false, rounds: 1 };
    for command in [goto(q, 0.0), play, PageCommand::Faults] {
        assert!(ask(&mut program, command.clone()).is_err(), "{command:?}");
    }
    ask(&mut program, PageCommand::Hold).unwrap();
    assert!(answer(&mut program, first).unwrap_err().contains("the motion was ended"));
}

#[test]
fn wrong_poses_are_refused() {
    let console = OtherSide::start(false);
    let (mut program, q) = armed(&console);
    for (wrong, why) in [
        (vec![], "a pose of 1 number"),
        (vec![0.0, 0.0], "found 2"),
        (vec![50.0], "`turn1`: expected"),
    ] {
        for command in [goto(wrong.clone(), 0.0), PageCommand::Live { q: wrong.clone() }] {
            let refused = ask(&mut program, command).unwrap_err();
            assert!(refused.contains(why), "{wrong:?}: {refused}");
        }
    }
    let refused = ask(&mut program, goto(q.clone(), -1.0)).unwrap_err();
    assert!(refused.contains("seconds"), "{refused}");
    assert!(console.told.lock().unwrap().poses.is_empty());
    // JSON has no NaN: it becomes `null`, which is no number, and the connection is closed.
    program.ask(PageCommand::Live { q: vec![f32::NAN] }).unwrap();
    let end = Instant::now() + PATIENCE;
    while program.step(Duration::from_millis(10)).is_ok() {
        assert!(Instant::now() < end, "the console still serves it");
    }
}

#[test]
fn the_rig_holds_if_its_program_dies() {
    let console = OtherSide::start(false);
    let (mut program, q) = armed(&console);
    let mut page = Page::open(&console);
    program.ask(goto(vec![q[0] + 0.3], LONG_S)).unwrap();
    page.until_state(PLAYING);
    // The system closes the socket of a program that dies.
    drop(program);
    page.until_state(HOLDING);
    let (is_done, text) = page.ask(json!({ "type": "wheel", "take": true }));
    assert!(is_done, "{text}");
}

#[test]
fn the_rig_holds_and_sinks_if_its_program_stands_still() {
    let console = OtherSide::start(false);
    let (mut program, q) = armed(&console);
    let mut page = Page::open(&console);
    program.ask(goto(vec![q[0] + 0.3], LONG_S)).unwrap();
    page.until_state(PLAYING);
    // The program sends nothing more, but its socket stays open.
    page.until_state(HOLDING);
    page.until_state(LIMP);
    drop(program);
}
