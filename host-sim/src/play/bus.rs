//! All buses of a rig as one: servos in the rig's order, lines in turn.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use sinew_bus::settings::Demand;
use sinew_bus::{
    Command, CommandError, Compared, EncodeError, Feedback, Health, Limit, Request, ServoBus,
    dynamixel, feetech,
};

use super::SERVOS;
use super::twin::{Twin, Twinned};

/// The bus of one line.
pub(super) enum Protocol {
    Dynamixel(Box<dynamixel::Bus<SERVOS>>),
    Feetech(Box<feetech::Bus<SERVOS>>),
    /// One of these, and that of a twin.
    Twinned(Box<Twinned>),
}

macro_rules! of {
    ($bus:expr, $it:ident => $do:expr) => {
        match $bus {
            Protocol::Dynamixel($it) => $do,
            Protocol::Feetech($it) => $do,
            Protocol::Twinned($it) => $do,
        }
    };
}

impl ServoBus for Protocol {
    fn len(&self) -> usize {
        of!(self, bus => bus.len())
    }
    fn command(&mut self, servo: usize, command: Command) -> Result<Option<Limit>, CommandError> {
        of!(self, bus => bus.command(servo, command))
    }
    fn plan(&mut self, out: &mut [u8]) -> Result<Request, EncodeError> {
        of!(self, bus => bus.plan(out))
    }
    fn plan_more(&mut self, left_us: u32, out: &mut [u8]) -> Result<Option<Request>, EncodeError> {
        of!(self, bus => bus.plan_more(left_us, out))
    }
    fn reply(&mut self, bytes: &[u8]) -> bool {
        of!(self, bus => bus.reply(bytes))
    }
    fn compare(&mut self, asked: Option<(usize, Demand)>) {
        of!(self, bus => bus.compare(asked));
    }
    fn compared(&self) -> Compared {
        of!(self, bus => bus.compared())
    }
    fn feedback(&self, servo: usize) -> Option<Feedback> {
        of!(self, bus => bus.feedback(servo))
    }
    fn health(&self, servo: usize) -> Option<Health> {
        of!(self, bus => bus.health(servo))
    }
}

/// The buses of a rig.
///
/// In a tick a line is asked when the one before wants nothing more. Each has a clock of its own, so in simulated time
/// they talk side by side, as on a board with a serial port for each.
pub(super) struct Buses {
    lines: Vec<Protocol>,
    /// Line and place of each servo.
    places: Vec<(usize, usize)>,
    /// The line that talks, as the wire must know it.
    turn: Rc<Cell<usize>>,
}

impl Buses {
    pub(super) fn new(lines: Vec<Protocol>, places: Vec<(usize, usize)>) -> Self {
        Self { lines, places, turn: Rc::default() }
    }

    /// The same, with the packets of a twin.
    pub(super) fn with_twin(mut self, twin: &Rc<RefCell<Twin>>) -> Self {
        let twinned = |(line, own)| Twinned::new(own, Rc::clone(twin), line);
        let lines = self.lines.into_iter().enumerate();
        self.lines = lines.map(|line| Protocol::Twinned(Box::new(twinned(line)))).collect();
        self
    }

    pub(super) fn turn(&self) -> Rc<Cell<usize>> {
        Rc::clone(&self.turn)
    }

    fn talks(&mut self) -> Option<&mut Protocol> {
        self.lines.get_mut(self.turn.get())
    }

    fn of(&self, servo: usize) -> Option<(&Protocol, usize)> {
        let (line, place) = *self.places.get(servo)?;
        Some((self.lines.get(line)?, place))
    }
}

impl ServoBus for Buses {
    fn len(&self) -> usize {
        self.places.len()
    }

    fn command(&mut self, servo: usize, command: Command) -> Result<Option<Limit>, CommandError> {
        let Some((line, place)) = self.places.get(servo).copied() else {
            return Err(CommandError::Servo { index: servo, count: self.places.len() });
        };
        of!(&mut self.lines[line], bus => bus.command(place, command))
    }

    fn plan(&mut self, out: &mut [u8]) -> Result<Request, EncodeError> {
        self.turn.set(0);
        let Some(first) = self.talks() else { return Ok(Request::default()) };
        of!(first, bus => bus.plan(out))
    }

    fn plan_more(&mut self, left_us: u32, out: &mut [u8]) -> Result<Option<Request>, EncodeError> {
        let Some(talks) = self.talks() else { return Ok(None) };
        let more = of!(talks, bus => bus.plan_more(left_us, out))?;
        if more.is_some() {
            return Ok(more);
        }
        self.turn.set(self.turn.get() + 1);
        let Some(next) = self.talks() else { return Ok(None) };
        of!(next, bus => bus.plan(out)).map(Some)
    }

    fn reply(&mut self, bytes: &[u8]) -> bool {
        self.talks().is_none_or(|talks| of!(talks, bus => bus.reply(bytes)))
    }

    /// These servos are set up by whoever simulates them: there is nothing to compare.
    fn compare(&mut self, _: Option<(usize, Demand)>) {}

    fn compared(&self) -> Compared {
        Compared::Nothing
    }

    fn feedback(&self, servo: usize) -> Option<Feedback> {
        let (bus, place) = self.of(servo)?;
        of!(bus, bus => bus.feedback(place))
    }

    fn health(&self, servo: usize) -> Option<Health> {
        let (bus, place) = self.of(servo)?;
        of!(bus, bus => bus.health(place))
    }
}
