//! Work in progress: that of the background task, which waits for an answer of the loop, and that of the loop, which
//! waits for the end of its tick.

use sinew_link::message::Pass;

/// A background task's command that waits for the loop's answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pending {
    Supervisor,
    Load { slot: usize },
    Unload { slot: usize },
    Service,
}

/// A request of the host that the loop serves after its tick.
#[derive(Debug)]
pub(super) enum ServiceRequest {
    Pass(Pass),
    Health,
}
