//! Signals that ask this program to end: Ctrl-C, SIGTERM, SIGHUP.

use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Counts the signals that ask this program to end.
pub(super) struct Stop {
    came: Arc<AtomicBool>,
    times: Cell<u32>,
}

impl Stop {
    /// Starts counting. From now on, such signals do not end the program by themselves.
    pub(super) fn new() -> anyhow::Result<Self> {
        Ok(Self { came: flag()?, times: Cell::new(0) })
    }

    /// Returns the number of counted signals. Signals between two calls count as one.
    pub(super) fn times(&self) -> u32 {
        let more = u32::from(self.came.swap(false, Ordering::Relaxed));
        self.times.set(self.times.get() + more);
        self.times.get()
    }
}

/// Returns a flag that such signals set. From now on, they do not end the program by themselves. SIGHUP stays ignored
/// if the program was started so that it survives its terminal (`nohup`).
pub(super) fn flag() -> anyhow::Result<Arc<AtomicBool>> {
    let came = Arc::new(AtomicBool::new(false));
    #[cfg(unix)]
    {
        use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
        for signal in [SIGINT, SIGTERM, SIGHUP] {
            if signal != SIGHUP || !ignores_hang_up() {
                signal_hook::flag::register(signal, Arc::clone(&came))?;
            }
        }
    }
    Ok(came)
}

/// Returns whether this program was started with SIGHUP ignored, as `/proc` of Linux reports it.
#[cfg(unix)]
fn ignores_hang_up() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    // Signal 1 is the lowest bit.
    ignored.is_some_and(|mask| mask & 1 != 0)
}
