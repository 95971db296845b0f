//! A simulated board on a port, in real time. A recorder checks its servos in each tick.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use sinew_firmware::supervisor::State;
use sinew_performance::play::{Chip, Memory, Options, RigParts, SimulatedBoard};
use sinew_rig::new::arm;
use sinew_servo_sim::device::{MEMORY_LEN, Servo};
use sinew_servo_sim::plant::RigPlant;
use sinew_servo_sim::port::Port;

/// Register of an XL330's torque.
const TORQUE_ENABLE: u16 = 64;
/// Stack of a thread that has a board.
const STACK_BYTES: usize = 64 << 20;

/// States of a board and behaviour of its servos since [`Watched::begin`].
#[derive(Debug, Default)]
pub(super) struct Seen {
    /// Each new state with its time on the board, s. The first one is the state at the beginning.
    pub(super) states: Vec<(f64, State)>,
    pub(super) ticks_on: u64,
    /// Number of ticks in which the state permits no torque but a servo has torque.
    pub(super) torque_in_off: u64,
    /// Maximum of a joint's distance beyond its range while torque is on, rad.
    pub(super) beyond_rad: f64,
    /// Maximum speed of a joint while torque is on, rad/s.
    pub(super) speed_rad_s: f64,
    /// Maximum turn of a joint since the beginning, rad.
    pub(super) turned_rad: f64,
    /// Positions at the beginning, rad.
    first: Vec<f64>,
}

impl Seen {
    fn look(&mut self, now_s: f64, state: State, ranges: &[[f64; 2]], servos: &[Servo<'_>]) {
        if self.first.is_empty() {
            self.first = servos.iter().map(|servo| servo.shaft().position_rad).collect();
        }
        if self.states.last().is_none_or(|(_, last)| *last != state) {
            self.states.push((now_s, state));
        }
        self.ticks_on += u64::from(state.is_on());
        let has_torque = servos.iter().any(|servo| servo.get(TORQUE_ENABLE) != 0);
        self.torque_in_off += u64::from(has_torque && !state.is_on());
        for ((servo, [least, most]), first) in servos.iter().zip(ranges).zip(&self.first) {
            let shaft = servo.shaft();
            self.turned_rad = self.turned_rad.max((shaft.position_rad - first).abs());
            if state.is_on() {
                let beyond = (least - shaft.position_rad).max(shaft.position_rad - most);
                self.beyond_rad = self.beyond_rad.max(beyond);
                self.speed_rad_s = self.speed_rad_s.max(shaft.velocity_rad_s.abs());
            }
        }
    }

    pub(super) fn state(&self) -> State {
        self.states.last().map_or(State::Off, |(_, state)| *state)
    }
}

/// A board that is served until this value is dropped. Its rig is an arm of three servos.
pub(super) struct Watched {
    seen: Arc<Mutex<Seen>>,
    stop: Arc<AtomicBool>,
    served: Option<JoinHandle<()>>,
}

impl Watched {
    /// Starts a board at a link. `baud`: rate of the port.
    pub(super) fn start(link: &str, baud: u32) -> Self {
        let port = Port::open(link.as_ref(), baud).unwrap();
        let (seen, stop) = (Arc::new(Mutex::new(Seen::default())), Arc::default());
        let serve = {
            let (seen, stop) = (Arc::clone(&seen), Arc::clone(&stop));
            move || serve(&port, &stop, &seen)
        };
        let served = thread::Builder::new().stack_size(STACK_BYTES).spawn(serve).unwrap();
        Self { seen, stop, served: Some(served) }
    }

    pub(super) fn seen(&self) -> MutexGuard<'_, Seen> {
        self.seen.lock().unwrap()
    }

    /// Returns the record, and starts a new one from the current state.
    pub(super) fn begin(&self) -> Seen {
        let mut seen = self.seen();
        let states = seen.states.last().copied().into_iter().collect();
        std::mem::replace(&mut *seen, Seen { states, ..Seen::default() })
    }

    /// Waits until the rig is in a state. Returns whether it reaches the state in time.
    pub(super) fn until(&self, is_there: impl Fn(State) -> bool, wait: Duration) -> bool {
        let end = Instant::now() + wait;
        while !is_there(self.seen().state()) {
            if Instant::now() > end {
                return false;
            }
            thread::sleep(Duration::from_millis(2));
        }
        true
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let served = self.served.take().map(JoinHandle::join);
        assert!(thread::panicking() || served.is_none_or(|served| served.is_ok()));
    }
}

fn serve(port: &Port, stop: &AtomicBool, seen: &Mutex<Seen>) {
    let rig = arm(3).unwrap();
    let mechanism = rig.mechanism().unwrap();
    let options = Options { is_of_board: true, ..Options::default() };
    let parts = RigParts::new(&rig, &mechanism, options).unwrap();
    // Each dof has its own servo, without a gear between them. A shaft counts from the beginning of its turn.
    let dofs = parts.compact().dofs().iter().zip(&parts.servos);
    let range = |range: [f32; 2], turn_rad: f64| range.map(|end| 0.5 * turn_rad + f64::from(end));
    let ranges: Vec<_> =
        dofs.map(|(dof, servo)| range(dof.range, servo.own.kind.range_rad)).collect();
    let chip = Chip::blank();
    SimulatedBoard::<RigPlant>::store_rig(&parts, &chip).unwrap();
    let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
    let plant = parts.plant(&rig, &mechanism).unwrap();
    let mut board = SimulatedBoard::new(&parts, &mut memories, plant, chip).unwrap();
    let look = |board: &mut SimulatedBoard<'_, RigPlant>| {
        let (now_s, state) = (1e-6 * board.now_us() as f64, board.state().unwrap());
        board.look_at_servos(|servos| seen.lock().unwrap().look(now_s, state, &ranges, servos));
    };
    board.serve(port, stop, look).unwrap();
}
