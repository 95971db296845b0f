//! A hold or a stop of somebody else binds the program that drives. It does not see the page on which a person pressed
//! HOLD, and its next pose would move the rig again.

use super::Refused;

/// The orders that a program must give before it moves the rig again.
#[derive(Debug, Default)]
pub(super) struct Bound {
    /// Whether the rig was told to stand: poses of a program are refused.
    held: bool,
    /// Whether the rig was told to stop: a program must clear this before it arms.
    stopped: bool,
    /// The end of the last motion along poses; the next pose is refused once, so that the program learns it.
    ended: Option<String>,
}

impl Bound {
    /// Notes that the rig was told to stand, or had to.
    pub(super) fn hold(&mut self) {
        self.held = true;
    }

    /// Notes that the rig was told to stop.
    pub(super) fn stop(&mut self) {
        (self.held, self.stopped) = (true, true);
    }

    /// Notes the end of a motion along poses that its program has not ended.
    pub(super) fn end(&mut self, why: String) {
        self.ended = Some(why);
    }

    /// Notes an order of the driver other than a pose: the driver knows where the rig is.
    pub(super) fn release(&mut self) {
        (self.held, self.ended) = (false, None);
    }

    /// Allows arming again. Returns whether the rig was told to stop before.
    pub(super) fn clear(&mut self) -> bool {
        std::mem::take(&mut self.stopped)
    }

    pub(super) fn check_arm(&self) -> Result<(), Refused> {
        if self.stopped {
            return Err(Refused::because("somebody else has stopped the rig: `clear` first"));
        }
        Ok(())
    }

    pub(super) fn check_pose(&mut self) -> Result<(), Refused> {
        if self.held {
            return Err(Refused::because(
                "the rig was told to stand: poses move it again after `hold`, `goto`, `play` or `arm`",
            ));
        }
        self.ended.take().map_or(Ok(()), |why| Err(Refused::Other(why)))
    }
}
