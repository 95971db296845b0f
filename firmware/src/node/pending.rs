//! Work that is under way: of the background task until the loop has answered, of the loop until its tick is over.

use sinew_link::message::Pass;

/// The work of the background task once the loop has answered.
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
