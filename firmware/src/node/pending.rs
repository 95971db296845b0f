//! Work in progress: of the background task until the loop has answered, of the loop until its tick is over.

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
