//! Time from a page's goal to the goal that a servo gets on its bus.

use std::thread::sleep;
use std::time::Duration;

use serde_json::json;

use crate::client::{HOLDING, Page};
use crate::load::assert_gentle;
use crate::other_side::OtherSide;

/// Number of times that each response is measured, so that the 99th percentile is not the largest.
const TIMES: usize = 200;
/// Time without a change of the goal, after which a joint stands.
const STANDS: Duration = ms(60);
/// Longest time of a response. A response above it is an error, not a slow machine.
const LOST: Duration = ms(3000);

const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// Responses, sorted.
#[derive(Debug)]
pub(crate) struct Responses(Vec<Duration>);

impl Responses {
    fn new(mut times: Vec<Duration>) -> Self {
        times.sort();
        Self(times)
    }

    pub(crate) fn median(&self) -> Duration {
        self.0[self.0.len() / 2]
    }

    /// Returns the 99th percentile: at most one of 100 responses is longer.
    pub(crate) fn most(&self) -> Duration {
        self.0[self.0.len() * 99 / 100]
    }

    pub(crate) fn print(&self, what: &str) {
        println!(
            "{what}: median {:.1?}, 99th percentile {:.1?}, largest {:.1?} of {}",
            self.median(),
            self.most(),
            self.0[self.0.len() - 1],
            self.0.len()
        );
    }
}

/// Waits until a time of the board's clock.
fn wait(console: &OtherSide, until: Duration) {
    while console.now() < until {
        sleep(Duration::from_micros(300));
    }
}

/// Holds the slider at a goal until the servo's goal has changed in the direction of the goal. Returns the time from
/// the first message. Continues to hold the slider for `more`.
fn slide(console: &OtherSide, page: &mut Page, goal: f32, more: Duration) -> Duration {
    let (asked, way) = (console.now(), usize::from(goal > 0.0));
    let (mut due, mut end, mut took) = (asked, asked + LOST, None);
    while console.now() < end {
        if console.now() >= due {
            due = console.now() + ms(50);
            page.say(&json!({ "type": "jog", "dof": 0, "goal": goal }));
        }
        // Pictures come every 33 ms.
        page.hear().unwrap();
        let changed = console.servo.lock().unwrap().changed[way];
        if took.is_none() && changed > asked {
            took = Some(changed.saturating_sub(asked));
            end = console.now() + more;
        }
    }
    took.expect("the servo gets another goal")
}

/// Measures the time to the first count of a servo's goal from rest.
pub(crate) fn from_rest(console: &OtherSide, page: &mut Page) -> Responses {
    let turn = |turn: usize| {
        // The goal comes at any time between two pictures.
        wait(console, console.now() + ms((7 * turn as u64) % 34));
        let stands =
            || console.servo.lock().unwrap().changed.iter().max().copied().unwrap() + STANDS;
        while console.now() < stands() {
            wait(console, stands());
        }
        let goal = if turn.is_multiple_of(2) { 0.5 } else { -0.5 };
        let took = slide(console, page, goal, ms(0));
        assert!(page.ask(json!({ "type": "release", "dof": 0 })).0);
        page.picture = None;
        page.until_state(HOLDING);
        took
    };
    Responses::new((0..TIMES).map(turn).collect())
}

/// Measures the time to the first count of a servo's goal in the other direction, while the joint moves. The joint
/// brakes first.
pub(crate) fn in_motion(console: &OtherSide, page: &mut Page) -> Responses {
    let mut turn = |turn: usize| {
        let goal = if turn.is_multiple_of(2) { 1.2 } else { -1.2 };
        slide(console, page, goal, ms(60 + (7 * turn as u64) % 34))
    };
    turn(1);
    let responses = Responses::new((0..TIMES).map(turn).collect());
    assert!(page.ask(json!({ "type": "release", "dof": 0 })).0);
    responses
}

/// Checks responses. A busy machine takes longer; a motion that began softly took more than 120 ms on any machine.
fn check(responses: &Responses, what: &str) {
    responses.print(&format!("from a page's goal to the first count of a servo's goal, {what}"));
    assert!(responses.median() < ms(200), "{responses:?}");
}

#[test]
fn a_slider_reaches_the_goal_of_a_servo_at_rest_soon() {
    let console = OtherSide::start_on_positions();
    let mut page = Page::open(&console);
    page.arm();
    check(&from_rest(&console, &mut page), "from rest");
    assert_gentle(&console, 1.5);
}

#[test]
fn a_slider_reaches_the_goal_of_a_servo_in_motion_soon() {
    let console = OtherSide::start_on_positions();
    let mut page = Page::open(&console);
    page.arm();
    check(&in_motion(&console, &mut page), "the other way");
    // For some ticks a servo whose friction reverses is faster than its joint.
    assert_gentle(&console, 2.0);
}
