//! The mailbox between the control loop and the background task.

use heapless::{Deque, Vec};
use sinew_link::message::{Dof, Health, LiveFrame, PASSED_MAX, Pass, Servo, Summary};
use sinew_show::ShowFrames;
use sinew_storage::Disarmed;

use crate::controller::Jog;
use crate::supervisor::{Answer, Command, FaultNews, LOGGED, Operator, State};

/// Session and sequence number, which identify a command.
pub(super) type CommandId = (u16, u16);

/// Maximum number of live frames that wait for the next tick.
pub(super) const LIVE_WAITING: usize = 4;

/// Maximum number of faults that wait for storage, including the notes that faults were cleared.
pub(super) const FAULTS_WAITING: usize = 16;
const _: () = assert!(FAULTS_WAITING > LOGGED, "what the supervisor keeps has room at once");

/// State that interrupt and background task share. On a board, a value protected by a critical section.
///
/// **Duty**: `act` has exclusive access to the value, is never called within itself, and is short; so it cannot fail.
pub trait Shared<T> {
    /// Calls `act` with the value, and returns its result.
    fn with<R>(&self, act: impl FnOnce(&mut T) -> R) -> R;
}

/// The mailbox of a node. Each context takes the items that the other has left.
///
/// While torque is off, the only [`Disarmed`] is stored here. The control loop takes it to arm, the background task
/// takes it to erase; the second one to ask does not get it.
#[derive(Debug)]
pub struct Mail<'a, const DOFS: usize, const SERVOS: usize, const COORDS: usize> {
    /// Whether a valid new message arrived.
    pub(super) heard: bool,
    /// Whether the host acknowledges none of the messages to it.
    pub(super) is_deaf: bool,
    /// An emergency stop, which goes before all other commands.
    pub(super) stop: Option<CommandId>,
    pub(super) order: Option<(CommandId, LoopRequest<'a, COORDS>)>,
    pub(super) enable: Option<Operator>,
    pub(super) jog: Option<Jog>,
    pub(super) live: Deque<LiveFrame, LIVE_WAITING>,
    pub(super) wants_snapshot: bool,
    pub(super) answers: Deque<(CommandId, LoopReply), 4>,
    pub(super) faults: Deque<FaultNews, FAULTS_WAITING>,
    pub(super) snapshot: Option<Tick<DOFS, SERVOS, COORDS>>,
    /// The servos' reply to the host's last packet.
    pub(super) of_servos: PassthroughReply,
    pub(super) health: Health,
    pub(super) state: State,
    pub(super) disarmed: Option<Disarmed>,
}

/// A request of the background task to the loop.
#[derive(Debug)]
pub(super) enum LoopRequest<'a, const COORDS: usize> {
    Supervise(Command),
    /// A new show, or none.
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
    /// The packet was sent to servos: [`Mail::of_servos`] has their reply.
    Passed,
    /// The packet was not sent in this state.
    NotPassed(State),
    /// There is no such line or bit rate.
    NoLine,
    /// The transfer of the bytes would take too long.
    TooLong,
    /// The measurements are in [`Mail::health`].
    Measured,
    /// The background task is erasing flash.
    Busy,
}

/// The servos' reply to a packet of the host.
#[derive(Debug, Default)]
pub(super) struct PassthroughReply {
    pub(super) bytes: Vec<u8, PASSED_MAX>,
    pub(super) took_us: u32,
}

/// A tick's data for telemetry.
#[derive(Debug, Clone)]
pub(super) struct Tick<const DOFS: usize, const SERVOS: usize, const COORDS: usize> {
    pub(super) number: u32,
    pub(super) summary: Summary,
    pub(super) q: Vec<f32, COORDS>,
    pub(super) dofs: Vec<Dof, DOFS>,
    pub(super) servos: Vec<Servo, SERVOS>,
}

impl<const DOFS: usize, const SERVOS: usize, const COORDS: usize> Mail<'_, DOFS, SERVOS, COORDS> {
    /// Creates an empty mailbox; torque is off.
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
