//! All lines of a board: servos in the rig's order. What goes over a line its bus plans for itself, when the host asks.

use core::cell::RefCell;

use heapless::Vec;
use sinew_bus::settings::Demand;
use sinew_bus::{
    Command, CommandError, Compared, EncodeError, Feedback, Health, Limit, Request, ServoBus,
    dynamixel, feetech,
};

use crate::arm;
use crate::node::{CAPACITY, LINES};

/// The bus of one line.
#[expect(clippy::large_enum_variant, reason = "an image has no heap")]
pub(crate) enum Line {
    Arm(arm::Bus),
    Dynamixel(dynamixel::Bus<CAPACITY>),
    Feetech(feetech::Bus<CAPACITY>),
}

macro_rules! of {
    ($bus:expr, $it:ident => $do:expr) => {
        match $bus {
            Line::Arm($it) => $do,
            Line::Dynamixel($it) => $do,
            Line::Feetech($it) => $do,
        }
    };
}

/// All lines.
pub(crate) struct Lines {
    buses: Vec<Line, LINES>,
    /// Line and place of each servo.
    places: Vec<(usize, usize), CAPACITY>,
    /// The line whose servo is compared.
    compared: Option<usize>,
    /// Why a packet of this tick did not go out.
    failed: Option<EncodeError>,
}

impl Lines {
    /// `line_of`: the line of each servo, in the rig's order.
    pub(crate) fn new(
        lines: impl IntoIterator<Item = Line>,
        line_of: impl IntoIterator<Item = usize>,
    ) -> Self {
        let mut counts = [0; LINES];
        let places = line_of.into_iter().map(|line| {
            counts[line] += 1;
            (line, counts[line] - 1)
        });
        Self {
            places: places.collect(),
            buses: lines.into_iter().collect(),
            compared: None,
            failed: None,
        }
    }

    /// First packets of a line in a tick; none if there is no room for them.
    pub(crate) fn plan(&mut self, line: usize, out: &mut [u8]) -> Option<Request> {
        let planned = of!(&mut self.buses[line], bus => bus.plan(out));
        planned.inspect_err(|why| self.failed = Some(*why)).ok()
    }

    /// What a line wants besides, if anything.
    pub(crate) fn plan_more(
        &mut self,
        line: usize,
        left_us: u32,
        out: &mut [u8],
    ) -> Option<Request> {
        let planned = of!(&mut self.buses[line], bus => bus.plan_more(left_us, out));
        planned.inspect_err(|why| self.failed = Some(*why)).ok()?
    }

    /// What servos of a line have said. Whether that is all.
    pub(crate) fn reply(&mut self, line: usize, bytes: &[u8]) -> bool {
        of!(&mut self.buses[line], bus => bus.reply(bytes))
    }

    fn of(&self, servo: usize) -> Option<(&Line, usize)> {
        let (line, place) = *self.places.get(servo)?;
        Some((self.buses.get(line)?, place))
    }
}

/// The lines as the controller sees them: one bus, which plans nothing by itself.
pub(crate) struct AllLines<'l>(pub(crate) &'l RefCell<Lines>);

impl ServoBus for AllLines<'_> {
    fn len(&self) -> usize {
        self.0.borrow().places.len()
    }

    fn command(&mut self, servo: usize, command: Command) -> Result<Option<Limit>, CommandError> {
        let Lines { buses, places, .. } = &mut *self.0.borrow_mut();
        let Some((line, place)) = places.get(servo).copied() else {
            return Err(CommandError::Servo { index: servo, count: places.len() });
        };
        of!(&mut buses[line], bus => bus.command(place, command))
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

    fn compare(&mut self, asked: Option<(usize, Demand)>) {
        let Lines { buses, places, compared, .. } = &mut *self.0.borrow_mut();
        let place = asked.and_then(|(servo, demand)| Some((*places.get(servo)?, demand)));
        *compared = place.map(|((line, _), _)| line);
        for (index, line) in buses.iter_mut().enumerate() {
            let own = place.filter(|((line, _), _)| *line == index);
            of!(line, bus => bus.compare(own.map(|((_, place), demand)| (place, demand))));
        }
    }

    fn compared(&self) -> Compared {
        let Lines { buses, compared, .. } = &*self.0.borrow();
        let line = compared.and_then(|line| buses.get(line));
        line.map_or(Compared::Nothing, |line| of!(line, bus => bus.compared()))
    }

    fn feedback(&self, servo: usize) -> Option<Feedback> {
        let lines = self.0.borrow();
        let (line, place) = lines.of(servo)?;
        of!(line, bus => bus.feedback(place))
    }

    fn health(&self, servo: usize) -> Option<Health> {
        let lines = self.0.borrow();
        let (line, place) = lines.of(servo)?;
        of!(line, bus => bus.health(place))
    }
}
