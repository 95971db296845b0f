//! The tracker as a whole: both kinds of frames, both kinds of readings, refusals, and what it asks of a source.

use sinew_core::glam::Vec3;
use sinew_core::tracker::{
    Frame, FrameSource, InputError, Measured, MethodName, ObserverChoice, Settings, StepError,
    Timing, Tracker,
};
use sinew_core::{
    Body, Inertia, JointKind, JointStates, JointTargets, Transform, Tree, Workspace, math,
};

const JOINTS: usize = 3;
const DT_S: f32 = 0.002;

fn arm() -> Tree<JOINTS> {
    let link = |index: usize| Body {
        parent: index.checked_sub(1),
        joint: JointKind::Revolute { axis: [Vec3::Y, Vec3::X, Vec3::Z][index] },
        placement: Transform::from_translation(Vec3::Y * 0.1),
        inertia: Inertia::of_box(0.2, Vec3::Y * 0.05, Vec3::new(0.04, 0.1, 0.04)),
        rotor_inertia: 0.0,
    };
    Tree::from_bodies(&[0, 1, 2].map(link)).unwrap()
}

/// Position, speed and acceleration of joint `joint` at frame `index`: sines of their own.
fn motion(joint: usize, index: i32) -> [f32; 3] {
    let (rate, phase) = (3.0 + joint as f32, joint as f32);
    let t_s = index as f32 * DT_S;
    let (sine, cosine) = (rate * t_s + phase).sin_cos();
    [0.3 * sine, 0.3 * rate * cosine, -0.3 * rate * rate * sine]
}

/// The motion in coordinates, and the numbers of the frames that were asked for.
#[derive(Default)]
struct InCoordinates {
    numbers: [[f32; JOINTS]; 3],
    asked: Vec<i32>,
}

impl FrameSource for InCoordinates {
    fn frame(&mut self, index: i32) -> Frame<'_> {
        self.asked.push(index);
        for joint in 0..JOINTS {
            let [position, speed, acceleration] = motion(joint, index);
            self.numbers[0][joint] = position;
            self.numbers[1][joint] = speed;
            self.numbers[2][joint] = acceleration;
        }
        let [q, qd, qdd] = &self.numbers;
        Frame::Coordinates { q, qd, qdd }
    }
}

/// The same as poses; `bad` frames have one that is none.
#[derive(Default)]
struct AsPoses {
    poses: [Transform; JOINTS],
    bad: Option<i32>,
}

impl FrameSource for AsPoses {
    fn frame(&mut self, index: i32) -> Frame<'_> {
        let tree = arm();
        for (joint, (pose, body)) in self.poses.iter_mut().zip(tree.bodies()).enumerate() {
            let JointKind::Revolute { axis } = body.joint else { unreachable!("an arm") };
            let turn = Transform::new(math::exp(axis * motion(joint, index)[0]), Vec3::ZERO);
            *pose = body.placement * turn;
        }
        if self.bad == Some(index) {
            self.poses[1].translation_m.x = f32::NAN;
        }
        Frame::Poses(&self.poses)
    }
}

fn tracker(settings: Settings, latency_ticks: usize) -> Tracker<JOINTS, 8> {
    let timing = Timing { dt_s: DT_S, latency_ticks };
    Tracker::new(arm(), &settings, timing).unwrap()
}

fn world() -> Settings {
    Settings { method: MethodName::World, ..Settings::default() }
}

fn rest() -> [Transform; JOINTS] {
    let tree = arm();
    [0, 1, 2].map(|joint| tree.bodies()[joint].placement)
}

#[test]
fn coordinates_go_through_as_they_are() {
    let mut tracker = tracker(world(), 0);
    let (mut targets, mut states) = (JointTargets::rest(&arm()), JointStates::rest(&arm()));
    let controller = world().controller(arm(), DT_S).unwrap();
    let mut workspace = Workspace::new();
    let mut frames = InCoordinates::default();
    for tick in 0..5 {
        let (q, qd) = ([0.1, -0.2, 0.05 * tick as f32], [0.5, 0.0, -0.25]);
        let torques = tracker.step(&mut frames, tick, Measured::Coordinates { q: &q, qd: &qd });
        let Frame::Coordinates { q: to, qd: at, qdd } = frames.frame(tick) else { unreachable!() };
        targets.set_coordinates(&arm(), to, at, qdd).unwrap();
        states.set_coordinates(&arm(), &q, &qd).unwrap();
        let expected = controller.tick(&mut targets, &states, &[], &mut workspace);
        assert_eq!(torques.unwrap(), expected, "tick {tick}");
    }
}

#[test]
fn differences_of_poses_come_near_to_exact_derivatives() {
    let settings = Settings { differences: sinew_core::tracker::Differences::Aligned, ..world() };
    let (mut exact, mut differenced) = (tracker(settings, 0), tracker(settings, 0));
    let (mut in_coordinates, mut as_poses) = (InCoordinates::default(), AsPoses::default());
    for tick in 0..20 {
        exact.step(&mut in_coordinates, tick, &rest()).unwrap();
        differenced.step(&mut as_poses, tick, &rest()).unwrap();
        let of = |tracker: &Tracker<JOINTS, 8>| {
            let targets = tracker.targets();
            let states = targets.states().iter().zip(targets.accelerations());
            states.map(|(state, rate)| (state.velocity.angular, rate.angular)).collect::<Vec<_>>()
        };
        for (exact, differenced) in of(&exact).iter().zip(of(&differenced)) {
            // The velocity at the end of a step of constant acceleration: third derivatives of 0.3 * 5³ over 2 ms, and
            // for accelerations a rounding of 1e-7 over the square of that.
            assert!((exact.0 - differenced.0).length() < 0.04 * 2.0, "{exact:?} {differenced:?}");
            assert!((exact.1 - differenced.1).length() < 0.2, "{exact:?} {differenced:?}");
        }
    }
}

#[test]
fn a_refused_reading_has_no_torques_and_the_next_one_goes_on() {
    for settings in [world(), Settings::recommended()] {
        let mut tracker = tracker(settings, 1);
        let mut frames = AsPoses::default();
        for tick in 0..9 {
            let mut measured = rest();
            if tick == 4 {
                measured[2].rotation.w = f32::NAN;
            }
            let torques = tracker.step(&mut frames, tick, &measured).map(<[_]>::len);
            if tick == 4 {
                assert!(matches!(torques, Err(StepError::Measured(InputError::Pose(_)))));
            } else {
                assert_eq!(torques, Ok(JOINTS));
            }
        }
        let too_few = tracker.step(&mut frames, 9, &rest()[..2]).unwrap_err();
        assert!(too_few.to_string().starts_with("the measured joints: "), "{too_few}");
    }
}

#[test]
fn a_refused_frame_has_no_torques_and_the_next_good_one_begins_anew() {
    for settings in [world(), Settings::recommended()] {
        let mut tracker = tracker(settings, 0);
        let mut frames = AsPoses { bad: Some(6), ..AsPoses::default() };
        let refused: Vec<_> =
            (0..12).filter(|tick| tracker.step(&mut frames, *tick, &rest()).is_err()).collect();
        // From the tick that looks ahead to it to the last that it leads to: for the projection, which goes on from
        // frame to frame, one more.
        let ticks = if settings.method == MethodName::Recommended { 5..=8 } else { 4..=6 };
        assert_eq!(refused, ticks.collect::<Vec<_>>());
    }
}

#[test]
fn a_source_of_the_other_kind_needs_a_beginning() {
    let mut tracker = tracker(world(), 0);
    tracker.step(&mut AsPoses::default(), 0, &rest()).unwrap();
    let error = tracker.step(&mut InCoordinates::default(), 1, &rest()).unwrap_err();
    assert_eq!(error, StepError::Frame(InputError::Kind));
    tracker.begin(&mut InCoordinates::default(), 2, &rest()).unwrap();
    tracker.step(&mut InCoordinates::default(), 2, &rest()).unwrap();
    let error = tracker.step(&mut AsPoses::default(), 3, &rest()).unwrap_err();
    assert_eq!(error, StepError::Frame(InputError::Kind));
}

#[test]
fn a_latency_that_is_looked_ahead_over_asks_for_the_frame_that_a_torque_meets() {
    let predict = ObserverChoice { predict: true, ..ObserverChoice::default() };
    for (observer, ahead) in [(predict, 3), (ObserverChoice::default(), 0)] {
        let mut tracker = tracker(Settings { observer, ..world() }, 3);
        let mut frames = InCoordinates::default();
        for tick in 0..4 {
            tracker.step(&mut frames, tick, &rest()).unwrap();
            assert_eq!(frames.asked.last(), Some(&(tick + ahead)));
        }
    }
}
