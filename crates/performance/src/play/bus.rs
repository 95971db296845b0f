//! All buses of a rig as one bus: servos in the rig's order.

use std::cell::RefCell;
use std::rc::Rc;

use sinew_servo_bus::settings::ServoRequirements;
use sinew_servo_bus::{
    Command, CommandError, Compared, EncodeError, Feedback, Health, Limit, Request, ServoBus,
};

use super::error::PartsError;
use super::peer::{PeerBus, PeerController};
use super::rig_parts::RigParts;

/// The buses of a rig, for its controller.
///
/// Each bus plans the packets of its line: see [`exchange`](super::exchange).
pub(super) struct Buses {
    pub(super) lines: Vec<Box<dyn ServoBus>>,
    /// Line and place of each servo.
    places: Vec<(usize, usize)>,
    /// The line with the servo that is being compared, or `None`.
    compares: Option<usize>,
}

impl Buses {
    pub(super) fn new(lines: Vec<Box<dyn ServoBus>>, places: Vec<(usize, usize)>) -> Self {
        Self { lines, places, compares: None }
    }

    /// Sends a peer's packets instead of the buses' packets.
    pub(super) fn with_peer(mut self, peer: &Rc<RefCell<dyn PeerController>>) -> Self {
        let of_peer = |(line, own)| PeerBus::new(own, Rc::clone(peer), line);
        let lines = self.lines.into_iter().enumerate();
        self.lines = lines.map(|line| Box::new(of_peer(line)) as _).collect();
        self
    }

    fn of(&self, servo: usize) -> Option<(&dyn ServoBus, usize)> {
        let (line, place) = *self.places.get(servo)?;
        Some((&**self.lines.get(line)?, place))
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
        self.lines[line].command(place, command)
    }

    /// Plans nothing: the lines run in parallel, each with packets of its own.
    fn plan(&mut self, _: &mut [u8]) -> Result<Request, EncodeError> {
        Ok(Request::default())
    }

    fn plan_more(&mut self, _: u32, _: &mut [u8]) -> Result<Option<Request>, EncodeError> {
        Ok(None)
    }

    fn reply(&mut self, _: &[u8]) -> bool {
        true
    }

    fn compare(&mut self, asked: Option<(usize, ServoRequirements)>) {
        let place =
            asked.and_then(|(servo, requirements)| Some((*self.places.get(servo)?, requirements)));
        self.compares = place.map(|((line, _), _)| line);
        for (index, line) in self.lines.iter_mut().enumerate() {
            let own = place.filter(|((line, _), _)| *line == index);
            line.compare(own.map(|((_, place), requirements)| (place, requirements)));
        }
    }

    fn compared(&self) -> Compared {
        let line = self.compares.and_then(|line| self.lines.get(line));
        line.map_or(Compared::Nothing, |line| line.compared())
    }

    fn feedback(&self, servo: usize) -> Option<Feedback> {
        let (bus, place) = self.of(servo)?;
        bus.feedback(place)
    }

    fn health(&self, servo: usize) -> Option<Health> {
        let (bus, place) = self.of(servo)?;
        bus.health(place)
    }
}

impl RigParts {
    /// Makes the buses of all lines.
    pub(super) fn all_buses(&self) -> Result<Buses, PartsError> {
        let places = self.servos.iter().map(|part| part.place).collect();
        Ok(Buses::new(self.buses()?, places))
    }
}
