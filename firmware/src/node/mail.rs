//! What goes from below the loop to it, and back.

use heapless::{Deque, Vec};
use sinew_link::message::{Dof, Health, LiveFrame, PASSED_MAX, Pass, Servo, Summary};
use sinew_show::ShowFrames;
use sinew_storage::Disarmed;

use crate::controller::Jog;
use crate::supervisor::{Answer, Command, FaultNews, LOGGED, Operator, State};

/// Of whom a command is: its session and number.
pub(super) type Ticket = (u16, u16);

/// Live frames that may wait for the next tick.
pub(super) const LIVE_WAITING: usize = 4;

/// Faults that may wait for storage, with the notes between them that they were cleared.
pub(super) const FAULTS_WAITING: usize = 16;
const _: () = assert!(FAULTS_WAITING > LOGGED, "what the supervisor keeps has room at once");

/// Something that both halves reach: on a board a value behind a critical section.
///
/// **Duty**: `act` has the value for itself, is never called within itself, and is short; so it cannot fail.
pub trait Shared<T> {
    /// Gives the value to `act`.
    fn with<R>(&self, act: impl FnOnce(&mut T) -> R) -> R;
}

/// The mail between the halves of a node: each takes what the other has left.
///
/// While torque is off, the one [`Disarmed`] lies here. The loop takes it away to arm, and what is below takes it to
/// erase; whoever comes second does not get it.
#[derive(Debug)]
pub struct Mail<'a, const V: usize, const S: usize, const C: usize> {
    /// A valid and new message came.
    pub(super) heard: bool,
    /// An emergency stop goes before all else.
    pub(super) stop: Option<Ticket>,
    pub(super) order: Option<(Ticket, Order<'a, C>)>,
    pub(super) enable: Option<Operator>,
    pub(super) jog: Option<Jog>,
    pub(super) live: Deque<LiveFrame, LIVE_WAITING>,
    pub(super) wants_snapshot: bool,
    pub(super) answers: Deque<(Ticket, Said), 4>,
    pub(super) faults: Deque<FaultNews, FAULTS_WAITING>,
    pub(super) snapshot: Option<Tick<V, S, C>>,
    /// What servos said to the last packet of the host.
    pub(super) of_servos: OfServos,
    pub(super) health: Health,
    pub(super) state: State,
    pub(super) disarmed: Option<Disarmed>,
}

/// Something for the loop to do.
#[derive(Debug)]
pub(super) enum Order<'a, const C: usize> {
    Supervise(Command),
    /// Another show, or none.
    Show(Option<ShowFrames<'a, C>>),
    /// Bytes for servos.
    Pass(Pass),
    Health,
}

/// What became of it.
#[derive(Debug, Clone, Copy)]
pub(super) enum Said {
    Supervised(Answer),
    Shown,
    /// Servos were talked to: [`Mail::of_servos`] is what they said.
    Passed,
    /// They were not, in this state.
    NotPassed(State),
    /// There is no such line or rate.
    NoLine,
    /// The bytes would take the line too long.
    TooLong,
    /// [`Mail::health`] is there.
    Measured,
    /// Somebody is erasing.
    Busy,
}

/// What servos said to a packet of the host.
#[derive(Debug, Default)]
pub(super) struct OfServos {
    pub(super) bytes: Vec<u8, PASSED_MAX>,
    pub(super) took_us: u32,
}

/// What telemetry tells of a tick.
#[derive(Debug, Clone)]
pub(super) struct Tick<const V: usize, const S: usize, const C: usize> {
    pub(super) number: u32,
    pub(super) summary: Summary,
    pub(super) q: Vec<f32, C>,
    pub(super) dofs: Vec<Dof, V>,
    pub(super) servos: Vec<Servo, S>,
}

impl<const V: usize, const S: usize, const C: usize> Mail<'_, V, S, C> {
    /// Nothing yet, and torque is off.
    pub fn new(disarmed: Disarmed) -> Self {
        Self {
            heard: false,
            stop: None,
            order: None,
            enable: None,
            jog: None,
            live: Deque::new(),
            wants_snapshot: false,
            answers: Deque::new(),
            faults: Deque::new(),
            snapshot: None,
            of_servos: OfServos::default(),
            health: Health::default(),
            state: State::Off,
            disarmed: Some(disarmed),
        }
    }
}
