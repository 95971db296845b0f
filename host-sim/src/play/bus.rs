//! All buses of a rig as one: servos in the rig's order.

use std::cell::RefCell;
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

/// The buses of a rig, for its controller.
///
/// What goes over the lines each of them plans for itself: see [`exchange`](super::exchange).
pub(super) struct Buses {
    pub(super) lines: Vec<Protocol>,
    /// Line and place of each servo.
    places: Vec<(usize, usize)>,
    /// The line whose servo is compared.
    compares: Option<usize>,
}

impl Buses {
    pub(super) fn new(lines: Vec<Protocol>, places: Vec<(usize, usize)>) -> Self {
        Self { lines, places, compares: None }
    }

    /// The same, with the packets of a twin.
    pub(super) fn with_twin(mut self, twin: &Rc<RefCell<Twin>>) -> Self {
        let twinned = |(line, own)| Twinned::new(own, Rc::clone(twin), line);
        let lines = self.lines.into_iter().enumerate();
        self.lines = lines.map(|line| Protocol::Twinned(Box::new(twinned(line)))).collect();
        self
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

    /// Nothing: its lines talk side by side, each with packets of its own.
    fn plan(&mut self, _: &mut [u8]) -> Result<Request, EncodeError> {
        Ok(Request::default())
    }

    fn plan_more(&mut self, _: u32, _: &mut [u8]) -> Result<Option<Request>, EncodeError> {
        Ok(None)
    }

    fn reply(&mut self, _: &[u8]) -> bool {
        true
    }

    fn compare(&mut self, asked: Option<(usize, Demand)>) {
        let place = asked.and_then(|(servo, demand)| Some((*self.places.get(servo)?, demand)));
        self.compares = place.map(|((line, _), _)| line);
        for (index, line) in self.lines.iter_mut().enumerate() {
            let own = place.filter(|((line, _), _)| *line == index);
            of!(line, bus => bus.compare(own.map(|((_, place), demand)| (place, demand))));
        }
    }

    fn compared(&self) -> Compared {
        let line = self.compares.and_then(|line| self.lines.get(line));
        line.map_or(Compared::Nothing, |line| of!(line, bus => bus.compared()))
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
