//! A second controller that plays beside the controller in this process.

use std::cell::RefCell;
use std::rc::Rc;

use sinew_firmware::supervisor::Command as LoopCommand;
use sinew_servo_bus::settings::ServoRequirements;
use sinew_servo_bus::{
    Command, CommandError, Compared, EncodeError, Feedback, Health, Limit, Request, ServoBus,
};

use super::RigController;

/// A controller outside of this program, such as a board's image in an emulator. It receives the same commands and
/// answers as the controller in this process, in the same ticks. The servos receive its packets.
pub trait PeerController {
    /// Begins a tick, with the host's command.
    fn begin(&mut self, command: Option<LoopCommand>);

    /// Returns the first packets of a line in a tick. `own`: the packets of the controller in this process, whose bytes
    /// are in `out`. The returned packets must be written to `out`.
    fn plan(&mut self, line: usize, own: Request, out: &mut [u8]) -> Request;

    /// Returns more packets of a line, `left_us` before the time for packets ends. `None` if the line needs no more
    /// packets. `own`, `out`: see [`Self::plan`].
    fn plan_more(
        &mut self,
        line: usize,
        left_us: u32,
        own: Option<Request>,
        out: &mut [u8],
    ) -> Option<Request>;

    /// Receives answers of a line's servos. Returns whether they are complete. `own`: whether they are complete for the
    /// controller in this process.
    fn reply(&mut self, line: usize, bytes: &[u8], own: bool) -> bool;

    /// Ends a tick, `took_us` after its beginning. `is_whole`: whether the tick was complete for the controller in this
    /// process.
    fn end(&mut self, took_us: u32, is_whole: bool, own: &RigController<'_>);
}

/// The bus of a line in this process, with the packets of a peer.
pub(super) struct PeerBus {
    own: Box<dyn ServoBus>,
    peer: Rc<RefCell<dyn PeerController>>,
    line: usize,
}

impl PeerBus {
    pub(super) fn new(
        own: Box<dyn ServoBus>,
        peer: Rc<RefCell<dyn PeerController>>,
        line: usize,
    ) -> Self {
        Self { own, peer, line }
    }
}

impl ServoBus for PeerBus {
    fn len(&self) -> usize {
        self.own.len()
    }

    fn command(&mut self, servo: usize, command: Command) -> Result<Option<Limit>, CommandError> {
        self.own.command(servo, command)
    }

    fn plan(&mut self, out: &mut [u8]) -> Result<Request, EncodeError> {
        let own = self.own.plan(out)?;
        Ok(self.peer.borrow_mut().plan(self.line, own, out))
    }

    fn plan_more(&mut self, left_us: u32, out: &mut [u8]) -> Result<Option<Request>, EncodeError> {
        let own = self.own.plan_more(left_us, out)?;
        Ok(self.peer.borrow_mut().plan_more(self.line, left_us, own, out))
    }

    fn reply(&mut self, bytes: &[u8]) -> bool {
        let own = self.own.reply(bytes);
        self.peer.borrow_mut().reply(self.line, bytes, own)
    }

    fn compare(&mut self, asked: Option<(usize, ServoRequirements)>) {
        self.own.compare(asked);
    }

    fn compared(&self) -> Compared {
        self.own.compared()
    }

    fn feedback(&self, servo: usize) -> Option<Feedback> {
        self.own.feedback(servo)
    }

    fn health(&self, servo: usize) -> Option<Health> {
        self.own.health(servo)
    }
}
