//! All lines of a board, with servos in the rig's order. The bus of each line plans its own packets when it is asked.

use core::cell::RefCell;

use heapless::Vec;
use sinew_servo_bus::settings::ServoRequirements;
use sinew_servo_bus::{
    Command, CommandError, Compared, EncodeError, Feedback, Health, Limit, Request, ServoBus,
};

/// At most `L` lines with at most `SERVOS` servos in total.
#[derive(Debug)]
pub struct Lines<B, const L: usize, const SERVOS: usize> {
    buses: Vec<B, L>,
    /// Line of each servo, and its place on that line.
    places: Vec<(usize, usize), SERVOS>,
    /// Line of the servo whose settings are compared.
    compared: Option<usize>,
    /// Error that kept a packet of this tick from being sent.
    failed: Option<EncodeError>,
}

impl<B: ServoBus, const L: usize, const SERVOS: usize> Lines<B, L, SERVOS> {
    /// Creates lines with servos. `line_of` contains the line of each servo, in the rig's order. Lines and servos
    /// that do not fit are left out.
    pub fn new(
        lines: impl IntoIterator<Item = B>,
        line_of: impl IntoIterator<Item = usize>,
    ) -> Self {
        let mut own = Self { buses: Vec::new(), places: Vec::new(), compared: None, failed: None };
        lines.into_iter().for_each(|line| own.add(line));
        line_of.into_iter().for_each(|line| own.place(line));
        own
    }

    /// Adds a line if there is room.
    pub(crate) fn add(&mut self, line: B) {
        let _ = self.buses.push(line);
    }

    /// Adds a servo, if there is room, at the next place on its line.
    pub(crate) fn place(&mut self, line: usize) {
        let place = self.places.iter().filter(|(other, _)| *other == line).count();
        let _ = self.places.push((line, place));
    }

    /// Returns the number of lines.
    pub fn count(&self) -> usize {
        self.buses.len()
    }

    /// Plans the first packets of a line in a tick. Returns `None` if there is no such line, or if the bus cannot plan,
    /// for example because `out` is too short.
    pub fn plan(&mut self, line: usize, out: &mut [u8]) -> Option<Request> {
        let planned = self.buses.get_mut(line)?.plan(out);
        planned.inspect_err(|why| self.failed = Some(*why)).ok()
    }

    /// Plans further packets of a line. Returns `None` if there are none, there is no such line, or the bus cannot
    /// plan.
    pub fn plan_more(&mut self, line: usize, left_us: u32, out: &mut [u8]) -> Option<Request> {
        let planned = self.buses.get_mut(line)?.plan_more(left_us, out);
        planned.inspect_err(|why| self.failed = Some(*why)).ok()?
    }

    /// Passes bytes from servos to a line's bus. Returns whether the reply is complete, or there is no such line.
    pub fn reply(&mut self, line: usize, bytes: &[u8]) -> bool {
        self.buses.get_mut(line).is_none_or(|bus| bus.reply(bytes))
    }

    fn of(&self, servo: usize) -> Option<(&B, usize)> {
        let (line, place) = *self.places.get(servo)?;
        Some((self.buses.get(line)?, place))
    }
}

/// The lines as the controller sees them: a single bus, which plans nothing by itself.
#[derive(Debug)]
pub struct AllLines<'l, B, const L: usize, const SERVOS: usize>(
    pub &'l RefCell<Lines<B, L, SERVOS>>,
);

impl<B: ServoBus, const L: usize, const SERVOS: usize> ServoBus for AllLines<'_, B, L, SERVOS> {
    fn len(&self) -> usize {
        self.0.borrow().places.len()
    }

    fn command(&mut self, servo: usize, command: Command) -> Result<Option<Limit>, CommandError> {
        let Lines { buses, places, .. } = &mut *self.0.borrow_mut();
        let unknown = CommandError::Servo { index: servo, count: places.len() };
        let (line, place) = *places.get(servo).ok_or(unknown)?;
        buses.get_mut(line).ok_or(unknown)?.command(place, command)
    }

    fn plan(&mut self, _: &mut [u8]) -> Result<Request, EncodeError> {
        self.0.borrow_mut().failed = None;
        Ok(Request::default())
    }

    fn plan_more(&mut self, _: u32, _: &mut [u8]) -> Result<Option<Request>, EncodeError> {
        self.0.borrow().failed.map_or(Ok(None), Err)
    }

    fn reply(&mut self, _: &[u8]) -> bool {
        true
    }

    fn compare(&mut self, asked: Option<(usize, ServoRequirements)>) {
        let Lines { buses, places, compared, .. } = &mut *self.0.borrow_mut();
        let place =
            asked.and_then(|(servo, requirements)| Some((*places.get(servo)?, requirements)));
        *compared = place.map(|((line, _), _)| line);
        for (index, line) in buses.iter_mut().enumerate() {
            let own = place.filter(|((line, _), _)| *line == index);
            line.compare(own.map(|((_, place), requirements)| (place, requirements)));
        }
    }

    fn compared(&self) -> Compared {
        let Lines { buses, compared, .. } = &*self.0.borrow();
        let line = compared.and_then(|line| buses.get(line));
        line.map_or(Compared::Nothing, ServoBus::compared)
    }

    fn feedback(&self, servo: usize) -> Option<Feedback> {
        let lines = self.0.borrow();
        let (line, place) = lines.of(servo)?;
        line.feedback(place)
    }

    fn health(&self, servo: usize) -> Option<Health> {
        let lines = self.0.borrow();
        let (line, place) = lines.of(servo)?;
        line.health(place)
    }
}
