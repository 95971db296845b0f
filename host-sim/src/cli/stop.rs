//! Ctrl-C: how often it came.

use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Counts what asks this program to end.
pub(super) struct Stop {
    came: Arc<AtomicBool>,
    times: Cell<u32>,
}

impl Stop {
    /// From now on, Ctrl-C and SIGTERM are counted and end nothing by themselves.
    pub(super) fn new() -> anyhow::Result<Self> {
        let came = Arc::new(AtomicBool::new(false));
        #[cfg(unix)]
        for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
            signal_hook::flag::register(signal, Arc::clone(&came))?;
        }
        Ok(Self { came, times: Cell::new(0) })
    }

    /// How often it came.
    pub(super) fn times(&self) -> u32 {
        let more = u32::from(self.came.swap(false, Ordering::Relaxed));
        self.times.set(self.times.get() + more);
        self.times.get()
    }
}
