//! Boards: a thread keeps the session with a board alive, and executes one order after the other. An order to hold or
//! to stop ends the running one.

mod console;
mod inbox;
mod open;
mod order;
mod pose;
mod remote;
mod session;

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel, sync_channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use numpy::PyReadonlyArray1;
use pyo3::create_exception;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use sinew_performance::play::ServoChoice;
use sinew_show::Show;

use crate::arrays::single;
use crate::error::value;
use crate::rig::NativeRig;
use crate::show::NativeShow;
use inbox::Inbox;
use open::Target;
use order::{Asked, Cancel, Order, Reply};

pub(crate) use console::{NativeConsole, open_console};

create_exception!(
    sinew_motion,
    BoardError,
    PyRuntimeError,
    "An error of a board, or a refusal of its controller, in the words of the command."
);

/// Stack of the thread, bytes: a controller with all its capacities is built on it.
const STACK_BYTES: usize = 256 << 20;

/// Interval between two checks for signals of the operating system.
const LOOK: Duration = Duration::from_millis(20);

/// Longest wait for the reply to a cancelled order.
const CANCEL: Duration = Duration::from_secs(3);

/// A session with a board, in a thread. After the last use of this value the thread stops the rig.
#[pyclass(frozen, module = "sinew_motion._sinew_motion")]
pub(crate) struct NativeBoard {
    orders: Mutex<Option<Sender<Asked>>>,
    thread: Mutex<Option<JoinHandle<()>>>,
    /// Error that has ended the thread.
    over: Arc<OnceLock<String>>,
    nq: usize,
}

/// Opens the board at a port, that of a console (an empty name: the only console), or a simulated board.
#[pyfunction]
pub(crate) fn open_board(
    py: Python<'_>,
    rig: PyRef<'_, NativeRig>,
    port: Option<PathBuf>,
    console: Option<String>,
    servos: Vec<String>,
) -> PyResult<NativeBoard> {
    let servos = servos
        .iter()
        .map(|text| text.parse::<ServoChoice>().map_err(value))
        .collect::<PyResult<Vec<_>>>()?;
    let target = match (console, port) {
        (Some(name), _) => {
            Target::Console(console::find(Some(name).filter(|name| !name.is_empty()))?)
        }
        (None, Some(port)) => Target::Port(port),
        (None, None) => Target::Simulated,
    };
    let nq = rig.loaded.mechanism.coordinate_count();
    let loaded = (*rig.loaded).clone();
    let (orders, inbox) = channel();
    let (opened, open) = sync_channel(1);
    let over = Arc::new(OnceLock::new());
    let why = Arc::clone(&over);
    let serve = move || {
        let tell = opened.clone();
        let served = open::serve(loaded, target, &servos, Inbox::new(inbox), move || {
            let _ = tell.send(Ok(Reply::Done));
        });
        if let Err(error) = served {
            let error = why.get_or_init(|| format!("{error:#}"));
            // The caller waits only for the opening.
            let _ = opened.try_send(Err(error.clone()));
        }
    };
    let thread = thread::Builder::new().name("board".to_owned());
    let thread = Mutex::new(Some(thread.stack_size(STACK_BYTES).spawn(serve)?));
    let board = NativeBoard { orders: Mutex::new(Some(orders)), thread, over, nq };
    board.wait(py, &Cancel::default(), open)?;
    Ok(board)
}

impl NativeBoard {
    /// Executes an order, and returns its reply. After a signal, cancels the order, and raises the exception of the
    /// signal.
    fn ask(&self, py: Python<'_>, order: Order) -> PyResult<Reply> {
        let (reply, replies) = sync_channel(1);
        let cancel = Cancel::default();
        let asked = Asked { order, cancel: cancel.clone(), reply };
        let sent = {
            let orders = self.orders.lock().unwrap_or_else(PoisonError::into_inner);
            let orders =
                orders.as_ref().ok_or_else(|| BoardError::new_err("the board is closed"))?;
            orders.send(asked)
        };
        sent.map_err(|_| self.is_over())?;
        self.wait(py, &cancel, replies)
    }

    /// Returns the error for an order after the end of the session, with the reason of the end.
    fn is_over(&self) -> PyErr {
        let why = self.over.get().map(|why| format!(": {why}")).unwrap_or_default();
        BoardError::new_err(format!("the session is over{why}"))
    }

    /// Waits for the reply to an order. After a signal the order is cancelled, and the signal's exception is raised.
    fn wait(
        &self,
        py: Python<'_>,
        cancel: &Cancel,
        replies: Receiver<Result<Reply, String>>,
    ) -> PyResult<Reply> {
        let replies = Mutex::new(replies);
        let receive = |time| {
            py.detach(|| replies.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(time))
        };
        loop {
            match receive(LOOK) {
                Ok(reply) => return reply.map_err(BoardError::new_err),
                Err(RecvTimeoutError::Disconnected) => return Err(self.is_over()),
                Err(RecvTimeoutError::Timeout) => {}
            }
            if let Err(signal) = py.check_signals() {
                cancel.cancel();
                let _ = receive(CANCEL);
                return Err(signal);
            }
        }
    }

    fn done(&self, py: Python<'_>, order: Order) -> PyResult<()> {
        self.ask(py, order).map(|_| ())
    }

    /// Copies a pose, and checks its length and its numbers.
    fn pose(&self, q: &PyReadonlyArray1<'_, f64>) -> PyResult<Vec<f32>> {
        let q: Vec<f32> = q.as_array().iter().copied().map(single).collect();
        if q.len() != self.nq {
            return Err(value(format!("q: expected {} numbers, found {}", self.nq, q.len())));
        }
        match q.iter().position(|x| !(-1e6..=1e6).contains(x)) {
            None => Ok(q),
            Some(bad) => {
                Err(value(format!("q[{bad}] is {}; it must be a number from -1e6 to 1e6", q[bad])))
            }
        }
    }
}

fn wide(numbers: Vec<f32>) -> Vec<f64> {
    numbers.into_iter().map(f64::from).collect()
}

/// Returns a duration of s.
fn duration(name: &str, seconds: f64) -> PyResult<Duration> {
    if (0.0..=3600.0).contains(&seconds) {
        return Ok(Duration::from_secs_f64(seconds));
    }
    Err(value(format!("{name}: expected a number of s from 0 to 3600, found {seconds}")))
}

/// State of a rig: name of the state, coordinates, efforts, supply in V, time in the show in s, largest error in rad,
/// and temperature and heat of each servo.
type StateRow = (String, Vec<f64>, Vec<f64>, f64, f64, f64, Vec<(Option<i8>, u8)>);

/// A fault: name, state, servo, time after the board's start, number of occurrences, whether it is a warning,
/// condition, remedy.
type FaultRow = (String, String, Option<u16>, f64, u16, bool, &'static str, &'static str);

#[pymethods]
impl NativeBoard {
    fn arm(&self, py: Python<'_>) -> PyResult<()> {
        self.done(py, Order::Arm)
    }

    fn goto(&self, py: Python<'_>, q: PyReadonlyArray1<'_, f64>, seconds: f64) -> PyResult<()> {
        let order = Order::Goto { q: self.pose(&q)?, least: duration("duration", seconds)? };
        self.done(py, order)
    }

    fn live(&self, py: Python<'_>, q: PyReadonlyArray1<'_, f64>) -> PyResult<Vec<f64>> {
        let Reply::Sent(sent) = self.ask(py, Order::Live { q: self.pose(&q)? })? else {
            return Err(BoardError::new_err("the pose that was sent is not known"));
        };
        Ok(wide(sent))
    }

    fn play(&self, py: Python<'_>, show: PyRef<'_, NativeShow>, rounds: u32) -> PyResult<()> {
        if rounds == 0 {
            return Err(value("rounds: expected 1 or more, found 0"));
        }
        let is_loop = Show::open(&show.bytes).map_err(value)?.is_loop();
        if rounds > 1 && !is_loop {
            return Err(value(format!(
                "rounds: expected 1 for a show that is no loop, found {rounds}"
            )));
        }
        self.done(py, Order::Play { bytes: show.bytes.clone(), rounds })
    }

    fn upload(&self, py: Python<'_>, show: PyRef<'_, NativeShow>) -> PyResult<()> {
        self.done(py, Order::Upload { bytes: show.bytes.clone() })
    }

    fn hold(&self, py: Python<'_>) -> PyResult<()> {
        self.done(py, Order::Hold)
    }

    fn stop(&self, py: Python<'_>) -> PyResult<()> {
        self.done(py, Order::Stop)
    }

    fn estop(&self, py: Python<'_>) -> PyResult<()> {
        self.done(py, Order::EStop)
    }

    fn clear(&self, py: Python<'_>) -> PyResult<()> {
        self.done(py, Order::Clear)
    }

    fn wheel(&self, py: Python<'_>, take: bool) -> PyResult<()> {
        self.done(py, Order::Wheel { take })
    }

    fn state(&self, py: Python<'_>) -> PyResult<StateRow> {
        let Reply::State(state) = self.ask(py, Order::State)? else {
            return Err(BoardError::new_err("the state is not known"));
        };
        Ok((
            state.name,
            wide(state.q),
            wide(state.effort),
            f64::from(state.supply_v),
            f64::from(state.show_ms) * 1e-3,
            f64::from(state.error_rad),
            state.servos,
        ))
    }

    fn faults(&self, py: Python<'_>) -> PyResult<Vec<FaultRow>> {
        let Reply::Faults(faults) = self.ask(py, Order::Faults)? else {
            return Err(BoardError::new_err("the log of faults is not known"));
        };
        Ok(faults)
    }

    /// Stops the rig, and ends the session. Does nothing if the session is closed.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        let is_open = self.orders.lock().unwrap_or_else(PoisonError::into_inner).is_some();
        if !is_open {
            return Ok(());
        }
        let closed = self.done(py, Order::Close);
        self.orders.lock().unwrap_or_else(PoisonError::into_inner).take();
        // After an error, the thread may still stop the rig.
        let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(thread) = thread.filter(|_| closed.is_ok()) {
            // The port and the socket for other terminals are free afterwards.
            let _ = py.detach(|| thread.join());
        }
        closed
    }
}
