//! Long work without Python's global lock. Signals such as Ctrl-C are handled during the work.

use std::any::Any;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::error::value;

/// Number of rows between two checks for signals; they take a few milliseconds.
const PIECE: usize = 4096;

/// Interval between two checks for signals, and between two calls of a progress function.
const LOOK: Duration = Duration::from_millis(50);

/// Stack of each working thread, bytes: an evaluation builds a tracker of about 0.5 MB on it.
const STACK_BYTES: usize = 16 << 20;

/// Calls `work` with ranges of rows until all `count` rows are done. Releases the global lock meanwhile.
pub(crate) fn in_pieces(
    py: Python<'_>,
    count: usize,
    mut work: impl FnMut(Range<usize>) -> PyResult<()> + Send,
) -> PyResult<()> {
    let mut start = 0;
    while start < count {
        let piece = start..(start + PIECE).min(count);
        start = piece.end;
        py.detach(|| work(piece))?;
        if start < count {
            py.check_signals()?;
        }
    }
    Ok(())
}

/// Number of finished and of all steps, which a working thread updates.
#[derive(Debug, Clone, Default)]
pub(crate) struct Progress {
    done: Arc<AtomicUsize>,
    total: Arc<AtomicUsize>,
    is_cancelled: Arc<AtomicBool>,
}

/// Payload of the unwinding that ends a cancelled thread.
struct Cancelled;

impl Progress {
    /// Sets the number of all steps.
    pub(crate) fn expect(&self, steps: usize) {
        self.total.store(steps, Ordering::Relaxed);
    }

    /// Adds finished steps.
    pub(crate) fn add(&self, steps: usize) {
        self.done.fetch_add(steps, Ordering::Relaxed);
    }

    /// Ends the work by unwinding if Python has cancelled the call.
    pub(crate) fn look(&self) {
        if self.is_cancelled.load(Ordering::Relaxed) {
            resume_unwind(Box::new(Cancelled));
        }
    }
}

/// Runs `work` in its own thread, and returns its result. Meanwhile calls `told`, if given, with the numbers of
/// finished and of all steps. Ctrl-C ends the call at once, and the work at its next [`Progress::look`]; if the work
/// does not look, it runs to its end, and its result is dropped.
pub(crate) fn in_background<T: Send + 'static>(
    py: Python<'_>,
    told: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Progress) -> anyhow::Result<T> + Send + 'static,
) -> PyResult<T> {
    let progress = Progress::default();
    let (of_work, (send, receive)) = (progress.clone(), sync_channel(1));
    let body = move || {
        let pool = rayon::ThreadPoolBuilder::new().stack_size(STACK_BYTES).build();
        let result = catch_unwind(AssertUnwindSafe(|| match pool {
            Ok(pool) => pool.install(|| work(&of_work)),
            Err(error) => {
                Err(anyhow::Error::new(error).context("the threads could not be started"))
            }
        }));
        // After a cancelled call, nobody receives the result.
        let _ = send.send(result);
    };
    thread::Builder::new().name("sinew".to_owned()).spawn(body)?;
    let tell = || -> PyResult<()> {
        py.check_signals()?;
        if let Some(told) = told {
            let [done, total] =
                [&progress.done, &progress.total].map(|count| count.load(Ordering::Relaxed));
            told.call1((done, total))?;
        }
        Ok(())
    };
    let receive = std::sync::Mutex::new(receive);
    loop {
        let received = py.detach(|| {
            let receive = receive.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            receive.recv_timeout(LOOK)
        });
        match received {
            Ok(Ok(result)) => {
                if result.is_ok() {
                    tell()?;
                }
                return result.map_err(value);
            }
            Ok(Err(payload)) => return Err(panicked(payload.as_ref())),
            Err(RecvTimeoutError::Disconnected) => return Err(panicked(&"the thread ended")),
            Err(RecvTimeoutError::Timeout) => {
                if let Err(error) = tell() {
                    progress.is_cancelled.store(true, Ordering::Relaxed);
                    return Err(error);
                }
            }
        }
    }
}

/// Returns a `RuntimeError` for a panic, which is a bug of this package.
fn panicked(payload: &(dyn Any + Send)) -> PyErr {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_default();
    PyRuntimeError::new_err(format!("a fault of sinew_motion, please report it: {text}"))
}
