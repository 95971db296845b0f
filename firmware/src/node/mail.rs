//! The mailbox between the control loop and the background task.

use heapless::{Deque, Vec};
use sinew_link::message::{Dof, Health, LiveFrame, PASSED_MAX, Pass, Servo, Summary};
use sinew_show::ShowFrames;
use sinew_storage::Disarmed;

use crate::controller::Jog;
use crate::supervisor::{Answer, Command, FaultNews, LOGGED, Operator, State};

/// Identifies a command: session and sequence number.
pub(super) type CommandId = (u16, u16);

/// Live frames that may wait for the next tick.
pub(super) const LIVE_WAITING: usize = 4;

/// Faults that may wait for storage, with the notes between them that they were cleared.
pub(super) const FAULTS_WAITING: usize = 16;
const _: () = assert!(FAULTS_WAITING > LOGGED, "what the supervisor keeps has room at once");

/// State shared by interrupt and background. On a board, a value protected by a critical section.
///
/// **Duty**: `act` has the value for itself, is never called within itself, and is short; so it cannot fail.
pub trait Shared<T> {
    /// Gives the value to `act`.
    fn with<R>(&self, act: impl FnOnce(&mut T) -> R) -> R;
}

/// The mailbox of a node: each context takes what the other has left.
///
/// While torque is off, the one [`Disarmed`] is stored here. The control loop takes it away to arm, the background task
/// to erase; whoever comes second does not get it.
#[derive(Debug)]
pub struct Mail<'a, const DOFS: usize, const SERVOS: usize, const COORDS: usize> {
    /// A valid and new message came.
    pub(super) heard: bool,
    /// The host acknowledges nothing that it is told.
    pub(super) is_deaf: bool,
    /// An emergency stop goes before all else.
    pub(super) stop: Option<CommandId>,
    pub(super) order: Option<(CommandId, LoopRequest<'a, COORDS>)>,
    pub(super) enable: Option<Operator>,
    pub(super) jog: Option<Jog>,
    pub(super) live: Deque<LiveFrame, LIVE_WAITING>,
    pub(super) wants_snapshot: bool,
    pub(super) answers: Deque<(CommandId, LoopReply), 4>,
    pub(super) faults: Deque<FaultNews, FAULTS_WAITING>,
    pub(super) snapshot: Option<Tick<DOFS, SERVOS, COORDS>>,
    /// The servos' reply to the last packet of the host.
    pub(super) of_servos: PassthroughReply,
    pub(super) health: Health,
    pub(super) state: State,
    pub(super) disarmed: Option<Disarmed>,
}

/// A request of the background task that the loop carries out.
#[derive(Debug)]
pub(super) enum LoopRequest<'a, const COORDS: usize> {
    Supervise(Command),
    /// Another show, or none.
    Show(Option<ShowFrames<'a, COORDS>>),
    /// Bytes for servos.
    Pass(Pass),
    Health,
}

/// The loop's reply to a request.
#[derive(Debug, Clone, Copy)]
pub(super) enum LoopReply {
    Supervised(Answer),
    Shown,
    /// Servos were talked to: [`Mail::of_servos`] has their reply.
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
pub(super) struct PassthroughReply {
    pub(super) bytes: Vec<u8, PASSED_MAX>,
    pub(super) took_us: u32,
}

/// What telemetry tells of a tick.
#[derive(Debug, Clone)]
pub(super) struct Tick<const DOFS: usize, const SERVOS: usize, const COORDS: usize> {
    pub(super) number: u32,
    pub(super) summary: Summary,
    pub(super) q: Vec<f32, COORDS>,
    pub(super) dofs: Vec<Dof, DOFS>,
    pub(super) servos: Vec<Servo, SERVOS>,
}

impl<const DOFS: usize, const SERVOS: usize, const COORDS: usize> Mail<'_, DOFS, SERVOS, COORDS> {
    /// Nothing yet, and torque is off.
    pub fn new(disarmed: Disarmed) -> Self {
        Self {
            heard: false,
            is_deaf: false,
            stop: None,
            order: None,
            enable: None,
            jog: None,
            live: Deque::new(),
            wants_snapshot: false,
            answers: Deque::new(),
            faults: Deque::new(),
            snapshot: None,
            of_servos: PassthroughReply::default(),
            health: Health::default(),
            state: State::Off,
            disarmed: Some(disarmed),
        }
    }
}
