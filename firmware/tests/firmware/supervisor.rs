//! Tests of the supervisor with its clocks: named sequences of events, and random ones.

use proptest::prelude::*;
use sinew_firmware::supervisor::{
    Command, Fault, FaultLog, FaultSet, Feed, Feeds, Findings, Inputs, LOGGED, Moving, Operator,
    Outcome, Refused, RegisterDiffers, Registers, Settings, Source, State, Supervisor,
};

const TICK_US: u64 = 10_000;
const ALL_FEEDS: Feeds = Feeds { show: true, live: true, jog: true };

/// A supervisor with 100 ticks per second and inputs without any fault.
struct Rig {
    supervisor: Supervisor,
    inputs: Inputs,
    last: Option<Outcome>,
}

impl Rig {
    fn new() -> Self {
        let supervisor = Supervisor::new(Settings::default(), 3, FaultLog::default()).unwrap();
        let inputs = Inputs {
            heard: true,
            measured: true,
            registers: Registers::Same,
            stop_tested: true,
            feeds: ALL_FEEDS,
            is_there: true,
            ..Inputs::default()
        };
        Self { supervisor, inputs, last: None }
    }

    fn tick(&mut self) -> Outcome {
        self.inputs.now_us += TICK_US;
        let outcome = self.supervisor.step(&self.inputs);
        self.last = Some(outcome);
        outcome
    }

    fn command(&mut self, command: Command) -> Outcome {
        self.inputs.command = Some(command);
        let outcome = self.tick();
        self.inputs.command = None;
        outcome
    }

    fn fault(&mut self, fault: Fault) -> Outcome {
        self.inputs.findings.note(fault);
        let outcome = self.tick();
        self.inputs.findings = Findings::default();
        outcome
    }

    /// Ticks until a state is reached, and returns the time, s.
    fn until(&mut self, state: State) -> f32 {
        let ticks = (1_u16..10_000).find(|_| self.tick().state == state).expect("it is reached");
        f32::from(ticks) * 0.01
    }

    fn holding() -> Self {
        let mut rig = Self::new();
        rig.tick();
        assert_eq!(rig.command(Command::Arm).answer, Some(Ok(State::Arming)));
        rig.until(State::Holding);
        rig
    }

    fn playing(feed: Feed) -> Self {
        let mut rig = Self::holding();
        assert_eq!(rig.command(Command::Play(feed)).answer, Some(Ok(State::Playing)));
        rig
    }
}

#[test]
fn power_on_moves_nothing_and_arming_is_slow() {
    let mut rig = Rig::new();
    for _ in 0..1000 {
        assert!(!rig.tick().permission.torque);
    }
    let armed = rig.command(Command::Arm).permission;
    assert_eq!((armed.torque, armed.source), (true, Source::Measured));
    assert_eq!(armed.speed_rad_s, Some(20.0_f32.to_radians()));
    // The state changes in the tick after a second has passed.
    assert!((rig.until(State::Holding) - 1.0).abs() < 0.011);
}

#[test]
fn arming_says_what_is_missing() {
    let mut rig = Rig::new();
    rig.tick();
    let mut refused = |change: fn(&mut Inputs)| {
        let good = rig.inputs;
        change(&mut rig.inputs);
        let answer = rig.command(Command::Arm).answer;
        rig.inputs = Inputs { now_us: rig.inputs.now_us, ..good };
        answer.unwrap().unwrap_err()
    };
    assert_eq!(refused(|inputs| inputs.measured = false), Refused::NotMeasured);
    assert_eq!(refused(|inputs| inputs.stop_tested = false), Refused::StopUntested);
    let unread = refused(|inputs| inputs.registers = Registers::Unread);
    assert_eq!(unread, Refused::RegistersUnread);
    let differs = refused(|inputs| {
        let item = "Operating Mode";
        let differs = RegisterDiffers { servo: 2, item, address: 11, found: 3, expected: 0 };
        inputs.registers = Registers::Differ(differs);
    });
    assert_eq!(
        differs.to_string(),
        "servo 2: Operating Mode (11) is 3, it must be 0: `sinew servo apply` sets it"
    );
    let moving = refused(|inputs| {
        inputs.moving = Some(Moving { dof: 2, mrad_s: 1250, most_mrad_s: 349 });
    });
    assert_eq!(
        moving.to_string(),
        "the rig is moving: joint 2 at 1.250 rad/s, at most 0.349; wait until it rests"
    );
    let hot = refused(|inputs| inputs.findings.note(Fault::HotMeasured));
    assert_eq!(hot, Refused::Fault(Fault::HotMeasured));
    assert_eq!(hot.to_string(), "fault 5 (hot, measured): remove its cause and clear it first");
    assert_eq!(rig.command(Command::Arm).answer, Some(Ok(State::Arming)));
    let again = rig.command(Command::Arm).answer.unwrap().unwrap_err();
    assert_eq!(again.to_string(), "the rig is arming: wait until that is over");
}

#[test]
fn a_show_waits_until_the_rig_has_come_to_it() {
    let mut rig = Rig::holding();
    rig.inputs.is_there = false;
    let begun = rig.command(Command::Play(Feed::Show)).permission;
    assert_eq!((begun.weight, begun.runs), (0.0, false));
    let mut before = 0.0;
    for _ in 0..300 {
        let permission = rig.tick().permission;
        assert!(permission.weight >= before && !permission.runs);
        assert_eq!(permission.speed_rad_s, Some(20.0_f32.to_radians()));
        before = permission.weight;
    }
    assert!((before - 1.0).abs() < 1e-6);
    rig.inputs.is_there = true;
    let there = rig.tick().permission;
    assert!(there.runs && there.speed_rad_s.is_none(), "{there:?}");
    // A change from one feed to another is soft, too.
    let changed = rig.command(Command::Play(Feed::Live)).permission;
    assert_eq!((changed.weight, changed.speed_rad_s), (0.0, Some(20.0_f32.to_radians())));
    assert!(!changed.runs);
}

#[test]
fn a_stop_button_that_is_released_moves_nothing() {
    let mut rig = Rig::playing(Feed::Live);
    assert!(!rig.fault(Fault::EStop).permission.torque, "in the same tick");
    for command in [Command::Play(Feed::Show), Command::Hold, Command::Arm] {
        assert!(rig.command(command).answer.unwrap().is_err());
    }
    for _ in 0..1000 {
        let outcome = rig.tick();
        assert_eq!((outcome.state, outcome.permission.torque), (State::Faulted, false));
    }
    assert_eq!(rig.command(Command::ClearFaults).answer, Some(Ok(State::Limp)));
    assert!(!rig.tick().permission.torque);
}

#[test]
fn a_silent_link_holds_and_then_lowers() {
    let mut rig = Rig::playing(Feed::Show);
    rig.inputs.heard = false;
    assert!((rig.until(State::Holding) - 0.2).abs() < 0.011);
    assert!((rig.until(State::Lowering) - 1.8).abs() < 0.011);
    // A rig that is not down fades in the last 3 s of 18 s.
    rig.inputs.is_there = false;
    let efforts: Vec<f32> = (0..1600).map(|_| rig.tick().permission.effort).collect();
    let [whole, fading] = [&efforts[..1495], &efforts[1505..]];
    assert!(whole.iter().all(|effort| *effort >= 1.0));
    assert!(fading.is_sorted_by(|a, b| a > b) && fading[94] > 0.6, "a third of 3 s");
    rig.until(State::Faulted);
    rig.inputs.heard = true;
    assert_eq!(rig.tick().latched, FaultSet::of(Fault::LinkLost));
}

#[test]
fn a_link_that_comes_back_in_time_resumes_nothing() {
    let mut rig = Rig::playing(Feed::Show);
    rig.inputs.heard = false;
    rig.until(State::Holding);
    rig.inputs.heard = true;
    for _ in 0..100 {
        assert_eq!(rig.tick().state, State::Holding);
    }
    assert!(rig.supervisor.mode().latched.is_empty());
}

#[test]
fn stop_goes_to_the_rest_pose_and_ends_there_or_in_time() {
    let mut rig = Rig::playing(Feed::Show);
    let stopping = rig.command(Command::Stop);
    assert_eq!((stopping.state, stopping.permission.source), (State::Stopping, Source::Rest));
    // The rig is at its rest pose, so the state ends after the blend of 1 s.
    assert!((rig.until(State::Lowering) - 1.0).abs() < 0.011);
    // The rig is down, so lowering ends at once.
    assert!(rig.until(State::Limp) < 0.011);

    let mut stuck = Rig::playing(Feed::Show);
    stuck.inputs.is_there = false;
    stuck.command(Command::Stop);
    // A second stop changes nothing.
    assert_eq!(stuck.command(Command::Stop).answer, Some(Ok(State::Stopping)));
    assert_eq!(stuck.command(Command::Hold).answer, Some(Err(Refused::InState(State::Stopping))));
    assert!((stuck.until(State::Lowering) - 9.98).abs() < 0.011);
    assert!((stuck.until(State::Limp) - 18.0).abs() < 0.011);

    // With a hot servo, lowering ends earlier.
    let mut hot = Rig::playing(Feed::Show);
    hot.inputs.is_there = false;
    hot.inputs.findings.note_of(Fault::HotMeasured, 4);
    hot.until(State::Lowering);
    assert!((hot.until(State::Faulted) - 6.0).abs() < 0.011);
}

#[test]
fn maintenance_moves_by_one_hand_as_long_as_it_holds() {
    let mut rig = Rig::holding();
    let (mine, other) = (Operator(1), Operator(2));
    rig.command(Command::Maintain(mine));
    assert_eq!(rig.tick().permission.source, Source::Hold);
    for _ in 0..50 {
        rig.command(Command::Enable(mine));
    }
    let moves = rig.tick().permission;
    assert_eq!(moves.source, Source::Feed(Feed::Jog));
    assert_eq!(moves.speed_rad_s, Some(10.0_f32.to_radians()));
    // The button is released: the rig holds 0.2 s after the last message, which was a tick ago.
    let held = (0..100).find(|_| rig.tick().permission.source == Source::Hold);
    assert!(matches!(held, Some(17..=19)), "{held:?}");
    let refused = Some(Err(Refused::InMaintenance(mine)));
    for command in [Command::Enable(other), Command::Leave(other), Command::Hold] {
        assert_eq!(rig.command(command).answer, refused, "{command:?}");
    }
    // Anybody may stop the rig: it is lowered, and does not move past the operator's hands. It stays the operator's.
    assert_eq!(rig.command(Command::Stop).answer, Some(Ok(State::Lowering)));
    rig.until(State::Limp);
    assert_eq!(rig.command(Command::Arm).answer, refused);
    assert_eq!(rig.command(Command::Leave(mine)).answer, Some(Ok(State::Limp)));
    assert_eq!(rig.command(Command::Arm).answer, Some(Ok(State::Arming)));
}

#[test]
fn faults_are_cleared_when_they_are_gone() {
    let mut rig = Rig::playing(Feed::Show);
    assert_eq!(rig.fault(Fault::ShowBad).state, State::Holding);
    let refused = |fault| Some(Err(Refused::Fault(fault)));
    assert_eq!(rig.command(Command::Play(Feed::Show)).answer, refused(Fault::ShowBad));
    let needs = Some(Err(Refused::NeedsUpload(Fault::ShowBad)));
    assert_eq!(rig.command(Command::ClearFaults).answer, needs);
    assert_eq!(rig.command(Command::Play(Feed::Live)).answer, Some(Ok(State::Playing)));
    assert!(rig.tick().latched.contains(Fault::ShowBad));
    rig.inputs.uploaded = FaultSet::OF_SHOW;
    assert!(rig.tick().latched.is_empty());
    rig.inputs.uploaded = FaultSet::EMPTY;

    rig.inputs.findings.note_of(Fault::SupplyLow, 4);
    rig.until(State::Faulted);
    let still = Some(Err(Refused::StillThere(Fault::SupplyLow)));
    assert_eq!(rig.command(Command::ClearFaults).answer, still);
    rig.inputs.findings = Findings::default();
    assert_eq!(rig.command(Command::ClearFaults).answer, Some(Ok(State::Limp)));
    assert_eq!(rig.command(Command::ClearFaults).answer, Some(Err(Refused::NoFault)));

    let log = rig.supervisor.log();
    let first = log.first().unwrap();
    assert_eq!((first.fault, first.state, first.start), (Fault::ShowBad, State::Playing, 3));
    let last: Vec<_> = log.last().map(|record| (record.fault, record.servo)).collect();
    assert_eq!(last, [(Fault::SupplyLow, Some(4)), (Fault::ShowBad, None)]);
}

#[test]
fn settings_that_cannot_be_are_refused() {
    let refused = |settings| Supervisor::new(settings, 0, FaultLog::default()).unwrap_err();
    let good = Settings::default();
    for bad in [f32::NAN, f32::INFINITY, -1.0] {
        assert_eq!(refused(Settings { link_hold_s: bad, ..good }).what, "link_hold_s");
        assert_eq!(refused(Settings { lower_s: bad, ..good }).what, "lower_s");
    }
    let fast = refused(Settings { soft_rad_s: 0.4, ..good });
    assert!(fast.to_string().starts_with("soft_rad_s is 0.4; it must be a number from "), "{fast}");
    assert_eq!(refused(Settings { link_limp_s: 0.2, ..good }).what, "link_limp_s");
}

fn command() -> impl Strategy<Value = Option<Command>> {
    use Command::{
        Arm, Calibrate, ClearFaults, Disarm, EStop, Enable, Float, Hold, Leave, Maintain, Play,
        Stop, Teach,
    };
    let operator = (1_u8..3).prop_map(Operator);
    let feed = prop::sample::select(vec![Feed::Show, Feed::Live, Feed::Jog]);
    prop_oneof![
        30 => Just(None),
        6 => Just(Some(Arm)),
        3 => Just(Some(ClearFaults)),
        3 => prop::sample::select(vec![Hold, Disarm, Stop, Calibrate, Teach, Float, EStop]).prop_map(Some),
        4 => feed.prop_map(|feed| Some(Play(feed))),
        2 => operator.clone().prop_map(|operator| Some(Maintain(operator))),
        2 => operator.clone().prop_map(|operator| Some(Enable(operator))),
        2 => operator.prop_map(|operator| Some(Leave(operator))),
    ]
}

prop_compose! {
    /// Generates the inputs of some ticks, mostly without any fault.
    fn inputs()(
        command in command(),
        (step_us, ticks) in (1_u64..3_000_000, 1_usize..200),
        fault in prop::option::weighted(0.15, prop::sample::select(Fault::ALL.to_vec())),
        [heard, measured, stop_tested, show, live, jog] in prop::array::uniform6(prop::bool::weighted(0.9)),
        [uploaded, is_there, is_slow] in prop::array::uniform3(prop::bool::weighted(0.3)),
        [unread, moves] in prop::array::uniform2(prop::bool::weighted(0.1)),
    ) -> (Inputs, u64, usize) {
        let mut findings = Findings::default();
        if let Some(fault) = fault {
            findings.note(fault);
        }
        let feeds = Feeds { show, live, jog };
        let registers = if unread { Registers::Unread } else { Registers::Same };
        let uploaded = if uploaded { FaultSet::OF_SHOW } else { FaultSet::EMPTY };
        let inputs = Inputs {
            now_us: 0, heard, command, findings, uploaded, measured, registers, stop_tested, feeds,
            carries: !is_slow, is_there, moving: moves.then_some(Moving { dof: 0, mrad_s: 500, most_mrad_s: 349 }),
            overload: None,
        };
        if is_slow { (inputs, step_us, 1) } else { (inputs, TICK_US, ticks) }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]
    #[test]
    fn no_course_of_events_breaks_a_promise(course in prop::collection::vec(inputs(), 1..60)) {
        let settings = Settings::default();
        let mut one = Supervisor::new(settings, 0, FaultLog::default()).unwrap();
        let mut same = one;
        let (mut now_us, mut was_on, mut off_by_us, mut heard_us) = (0, false, None, None);
        for (inputs, step_us, ticks) in course {
            for tick in 0..ticks {
                now_us += step_us;
                // A command is given only once.
                let command = inputs.command.filter(|_| tick == 0);
                let inputs = Inputs { now_us, command, ..inputs };
                if inputs.heard {
                    heard_us = Some(now_us);
                }
                let before = one.mode().state;
                let found = one.step(&inputs);
                prop_assert_eq!(found, same.step(&inputs));
                let permission = found.permission;

                prop_assert!((0.0..=1.0).contains(&permission.weight));
                prop_assert!((0.0..=1.0).contains(&permission.effort));
                prop_assert!(permission.torque || permission.effort <= 0.0 && !permission.runs);
                if permission.torque && !was_on {
                    prop_assert_eq!((command, found.answer), (Some(Command::Arm), Some(Ok(State::Arming))));
                    prop_assert!(inputs.measured && inputs.stop_tested);
                    prop_assert_eq!(inputs.registers, Registers::Same);
                }
                was_on = permission.torque;
                if let Source::Feed(feed) = permission.source {
                    prop_assert!(inputs.feeds.gives(feed) && inputs.measured);
                }
                // The time-out counts by the state before: the tick in which it is detected.
                let silent_us = heard_us.map_or(u64::MAX, |heard| now_us - heard);
                if silent_us >= 2_001_000 {
                    prop_assert!(!permission.torque || found.state == State::Lowering);
                } else if silent_us >= 201_000 {
                    prop_assert!(!matches!(permission.source, Source::Feed(_)), "{before} {found:?}");
                }
                // A state that ends must end in its time, whatever happens.
                off_by_us = match (found.state, off_by_us) {
                    (State::Lowering, None) => Some(now_us + 18_000_000 + TICK_US),
                    (State::Stopping, None) => Some(now_us + 28_000_000 + 2 * TICK_US),
                    (State::Stopping | State::Lowering, by) => by,
                    (_, by) => {
                        prop_assert!(by.is_none() || !permission.torque);
                        None
                    }
                };
                if step_us == TICK_US {
                    prop_assert!(off_by_us.is_none_or(|by| now_us <= by), "{found:?}");
                } else {
                    // With rare ticks it is detected at the next one.
                    off_by_us = off_by_us.map(|by| by + step_us);
                }
            }
        }
        prop_assert!(one.log().last().count() <= LOGGED);
    }
}
