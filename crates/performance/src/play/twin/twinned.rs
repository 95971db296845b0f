//! The bus of a line, whose packets are the twin's.

use std::cell::RefCell;
use std::rc::Rc;

use sinew_qemu_node::message::ToNode;
use sinew_servo_bus::settings::ServoRequirements;
use sinew_servo_bus::{
    Command, CommandError, Compared, EncodeError, Feedback, Health, Limit, Request, ServoBus,
};

use super::Twin;

/// The bus in process, and the same line of the twin.
pub(in crate::play) struct Twinned {
    own: Box<dyn ServoBus>,
    twin: Rc<RefCell<Twin>>,
    line: usize,
}

impl Twinned {
    pub(in crate::play) fn new(
        own: Box<dyn ServoBus>,
        twin: Rc<RefCell<Twin>>,
        line: usize,
    ) -> Self {
        Self { own, twin, line }
    }
}

impl ServoBus for Twinned {
    fn len(&self) -> usize {
        self.own.len()
    }

    fn command(&mut self, servo: usize, command: Command) -> Result<Option<Limit>, CommandError> {
        self.own.command(servo, command)
    }

    fn plan(&mut self, out: &mut [u8]) -> Result<Request, EncodeError> {
        let own = self.own.plan(out)?;
        let question = ToNode::Plan { line: self.line };
        Ok(self.twin.borrow_mut().planned(&question, Some(own), out).unwrap_or_default())
    }

    fn plan_more(&mut self, left_us: u32, out: &mut [u8]) -> Result<Option<Request>, EncodeError> {
        let own = self.own.plan_more(left_us, out)?;
        let question = ToNode::PlanMore { line: self.line, left_us };
        Ok(self.twin.borrow_mut().planned(&question, own, out))
    }

    fn reply(&mut self, bytes: &[u8]) -> bool {
        let own = self.own.reply(bytes);
        self.twin.borrow_mut().said(self.line, bytes, own)
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
