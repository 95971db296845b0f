//! A model check of the supervisor: every reachable mode is checked with every event.
//!
//! Clocks are modelled as before or after each time-out, at any moment. Faults with the same row in the table are the
//! same to the supervisor: one represents each kind. At a time there are none, one, two, or all of the kinds; each
//! other fault is checked alone. Sessions of two programs have a model of their own: `takeover`.

mod checker;
mod events;
mod takeover;

use checker::{Counts, check};
use events::{Events, kinds};
use sinew_firmware::supervisor::{
    Answer, Command, Event, Fault, FaultSet, Feeds, Mode, Source, State,
};

fn all_kinds() -> Events {
    Events::new(&kinds())
}

#[test]
fn no_reachable_mode_breaks_a_rule() {
    let Counts { modes, steps } = check(&all_kinds(), Mode::next).unwrap_or_else(|v| panic!("{v}"));
    println!("{modes} reachable modes, {steps} steps, {} kinds of faults", kinds().len());
    assert!(modes > 100, "it stopped early: {modes}");
}

#[test]
fn a_fault_that_another_stands_for_breaks_no_rule_either() {
    let kinds = kinds();
    for fault in Fault::ALL.into_iter().filter(|fault| !kinds.contains(fault)) {
        check(&Events::new(&[fault]), Mode::next).unwrap_or_else(|v| panic!("{fault}: {v}"));
    }
}

/// Returns the rule that the checker reports for a supervisor with a mistake.
fn mistake(step: impl Fn(Mode, &Event) -> (Mode, Option<Answer>)) -> &'static str {
    // The faults that the mistakes need are enough.
    let events = Events::new(&[Fault::EStop, Fault::HotMeasured, Fault::HostDeaf, Fault::Jump]);
    let Err(violation) = check(&events, step) else { panic!("a planted mistake was not found") };
    violation.rule
}

#[test]
fn a_stop_that_arms_when_it_is_released_is_found() {
    let rule = mistake(|mode, event| {
        let (mut next, answer) = mode.next(event);
        if mode.state == State::Faulted && !event.present.contains(Fault::EStop) && event.measured {
            (next.state, next.latched, next.is_soft) = (State::Arming, FaultSet::EMPTY, true);
        }
        (next, answer)
    });
    assert_eq!(rule, "torque comes on by an arm command alone");
}

#[test]
fn a_feed_that_falls_silent_unnoticed_is_found() {
    let rule = mistake(|mode, event| {
        let feeds = Feeds { show: true, live: true, jog: true };
        if mode.state == State::Playing {
            mode.next(&Event { feeds, ..*event })
        } else {
            mode.next(event)
        }
    });
    assert_eq!(rule, "what moves has a live source");
}

#[test]
fn a_stop_that_begins_again_is_found() {
    let rule = mistake(|mode, event| {
        let (mut next, answer) = mode.next(event);
        // A hot servo stops the rig, even if it is already being lowered.
        let is_hot = event.present == FaultSet::of(Fault::HotMeasured);
        if mode.state == State::Lowering && is_hot && event.measured && event.command.is_none() {
            next.state = State::Stopping;
        }
        (next, answer)
    });
    assert_eq!(rule, "what ends comes nearer to its end");
}

#[test]
fn a_fault_that_need_not_be_cleared_is_found() {
    let rule = mistake(|mode, event| {
        let (next, answer) = mode.next(event);
        (Mode { latched: FaultSet::EMPTY, ..next }, answer)
    });
    assert_eq!(rule, "after a fault nothing is armed that was not cleared");
}

#[test]
fn an_enabling_button_that_sticks_is_found() {
    let rule = mistake(|mode, event| mode.next(&Event { enabled: true, ..*event }));
    assert_eq!(rule, "maintenance moves while the button is held");
}

#[test]
fn a_limp_rig_that_floats_unarmed_is_found() {
    let rule = mistake(|mode, event| {
        let (mut next, answer) = mode.next(event);
        let is_limp = mode.state == State::Limp && event.measured && event.present.is_empty();
        if is_limp && event.command == Some(Command::Float) {
            next.state = State::Floating;
            return (next, Some(Ok(State::Floating)));
        }
        (next, answer)
    });
    assert_eq!(rule, "torque comes on by an arm command alone");
}

#[test]
fn servos_that_take_no_effort_and_are_to_float_are_found() {
    let rule = mistake(|mode, event| mode.next(&Event { carries: true, ..*event }));
    assert_eq!(rule, "it floats from standing, by command, and where every servo takes an effort");
}

/// The mistake moves the rig to the rest pose, out of the hands of the person who leads it.
#[test]
fn a_stop_that_pulls_a_rig_out_of_hands_is_found() {
    let rule = mistake(|mode, event| {
        let (mut next, answer) = mode.next(event);
        // Nothing else is wrong in this event.
        let is_stop = event.command == Some(Command::Stop) && event.measured;
        let is_stop = is_stop && event.present.is_empty();
        if mode.state == State::Floating && is_stop && next.state == State::Lowering {
            next.state = State::Stopping;
        }
        (next, answer.map(|answer| answer.map(|_| next.state)))
    });
    assert_eq!(rule, "what is in somebody's hands goes nowhere by itself");
}

/// With this mistake, a host would continue to drive the rig although the wire from the board is dead.
#[test]
fn a_host_that_acknowledges_nothing_and_drives_on_is_found() {
    let rule = mistake(|mode, event| {
        let present = event.present.minus(FaultSet::of(Fault::HostDeaf));
        let is_overheard = mode.state == State::Playing;
        mode.next(&if is_overheard { Event { present, ..*event } } else { *event })
    });
    assert_eq!(rule, "no fault goes without its reaction");
}

/// With this mistake, any next event of the host would end the fault.
#[test]
fn a_deaf_host_whose_rig_is_armed_uncleared_is_found() {
    let rule = mistake(|mode, event| {
        let (mut next, answer) = mode.next(event);
        if !event.present.contains(Fault::HostDeaf) {
            next.latched = next.latched.minus(FaultSet::of(Fault::HostDeaf));
            if next.state == State::Faulted && next.latched.is_empty() {
                next.state = State::Limp;
            }
        }
        (next, answer.map(|answer| answer.map(|_| next.state)))
    });
    assert_eq!(rule, "after a fault nothing is armed that was not cleared");
}

/// The host is deaf, so nobody watches the rig, but a person holds it in the hands.
#[test]
fn a_deaf_host_whose_rig_is_pulled_out_of_hands_is_found() {
    let rule = mistake(|mode, event| {
        let (mut next, answer) = mode.next(event);
        let is_deaf = event.present == FaultSet::of(Fault::HostDeaf) && event.measured;
        if mode.state == State::Floating && is_deaf && event.command.is_none() {
            next.state = State::Stopping;
        }
        (next, answer)
    });
    assert_eq!(rule, "what is in somebody's hands goes nowhere by itself");
}

/// With this mistake, a rig that its servos cannot hold would be armed; it would swing up until the supply sags.
#[test]
fn a_rig_that_is_armed_and_cannot_be_held_is_found() {
    let rule = mistake(|mode, event| mode.next(&Event { overload: None, ..*event }));
    let expected = "arming is from rest, measured, of servos that are set up and bear the rig, with a tested stop";
    assert_eq!(rule, expected);
}

/// With this mistake, a rig would continue to hold with a wrong encoder, and no user would notice it.
#[test]
fn a_jump_that_a_rig_holds_on_with_is_found() {
    let rule = mistake(|mode, event| {
        let present = event.present.minus(FaultSet::of(Fault::Jump));
        let stands = mode.state == State::Holding;
        mode.next(&if stands { Event { present, ..*event } } else { *event })
    });
    assert_eq!(rule, "no fault goes without its reaction");
}

/// With this mistake, the jumped readings would be believed as soon as torque is off, without a command that clears the
/// fault.
#[test]
fn a_jump_that_nobody_clears_is_found() {
    let rule = mistake(|mode, event| {
        let (mut next, answer) = mode.next(event);
        if !next.state.is_on() {
            next.latched = next.latched.minus(FaultSet::of(Fault::Jump));
            if next.state == State::Faulted && next.latched.is_empty() {
                next.state = State::Limp;
            }
        }
        (next, answer.map(|answer| answer.map(|_| next.state)))
    });
    assert_eq!(rule, "after a fault nothing is armed that was not cleared");
}

/// The source of a mode is consistent with its state.
#[test]
fn a_mode_that_stands_follows_nobody() {
    for state in State::ALL {
        let mode = Mode { state, ..Mode::default() };
        assert!(!matches!(mode.source(), Source::Feed(_)), "{state}");
    }
}
