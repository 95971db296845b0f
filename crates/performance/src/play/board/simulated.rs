//! A board with its servos, simulated tick by tick.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::io;
use std::time::Duration;

use sinew_firmware::node::{Next, RIG_SCHEMA};
use sinew_firmware::supervisor::State;
use sinew_link::message::{About, Capacities, Release, Version};
use sinew_servo_sim::bench::Branch;
use sinew_servo_sim::device::Servo;
use sinew_servo_sim::fault::Fault;
use sinew_servo_sim::line::{Line, LineDevice as _, run_all};
use sinew_servo_sim::load::Plant;
use sinew_servo_sim::plant::{Hand, RigPlant};
use sinew_storage::{Approver, Descriptor, Kind, Store};

use super::bus::{AllLines, Servos};
use super::error::BoardError;
use super::flash::{Chip, TABLE};
use super::node::{HostPort, Node, Pins};
use crate::play::bus::Buses;
use crate::play::simulated_lines::lines;
use crate::play::{BODIES, COORDINATES, DOFS, Memory, RigParts, SERVOS, Wires, pulses};

/// Number of steps of the background task per tick. A step reads at most 64 received bytes.
const STEPS: u32 = 8;
/// Name of the approver that is stored with the rig of a simulated board.
const APPROVER: &str = "simulated board";

/// A board that is powered on.
pub struct SimulatedBoard<'a, P> {
    parts: &'a RigParts,
    chip: Chip,
    about: About,
    node: Node,
    buses: RefCell<Buses>,
    lines: Vec<Line<Branch<'a, P>>>,
    bauds: Vec<Option<u32>>,
    wires: Wires,
    lent: Vec<&'static [u8]>,
    ticks: u64,
    starts: u32,
    /// Bytes from the host that the board has not read yet.
    came: VecDeque<u8>,
    /// Bytes for the host that the host has not read yet.
    pub(super) said: VecDeque<u8>,
}

impl<'a, P: Plant> SimulatedBoard<'a, P> {
    /// Starts a board with the content of its flash. `memories`: one for each servo; `plant`: the mechanism that the
    /// servos move.
    ///
    /// # Errors
    /// [`BoardError`] if servos, lines or flash cannot be used.
    pub fn new(
        parts: &'a RigParts,
        memories: &'a mut [Memory],
        plant: P,
        chip: Chip,
    ) -> Result<Self, BoardError> {
        let about = ABOUT;
        Ok(Self {
            node: Node::start(parts, &chip, about)?,
            buses: RefCell::new(parts.all_buses()?),
            lines: lines(parts, memories, plant)?,
            bauds: (parts.lines.iter())
                .map(|line| (!line.is_of_pulses()).then_some(line.baud))
                .collect(),
            wires: Wires::default(),
            lent: Vec::new(),
            ticks: 0,
            starts: 1,
            came: VecDeque::new(),
            said: VecDeque::new(),
            about,
            chip,
            parts,
        })
    }

    /// Stores the rig of these parts in flash that has no rig, like an upload.
    ///
    /// # Errors
    /// [`BoardError`] if the flash cannot be used, or the rig does not fit.
    pub fn store_rig(parts: &RigParts, chip: &Chip) -> Result<(), BoardError> {
        let failed = |error| BoardError::Flash(format!("{error:?}"));
        let (mut store, disarmed) = Store::open(chip.clone(), TABLE).map_err(failed)?;
        if store.rig().map_err(failed)?.is_some() {
            return Ok(());
        }
        let bytes = parts.board_rig().map_err(BoardError::Rig)?;
        let approver = Approver::new(APPROVER).map_err(|why| BoardError::Flash(why.to_string()))?;
        let descriptor = Descriptor::of(Kind::Rig, RIG_SCHEMA, &bytes, 0, approver);
        store.put(&disarmed, &descriptor, &bytes).map_err(failed)?;
        Ok(())
    }

    /// Restarts the board with firmware that has another version of the host link.
    ///
    /// # Errors
    /// [`BoardError`] if the board does not start.
    pub fn speaking(mut self, protocol: Version) -> Result<Self, BoardError> {
        self.about.protocol = protocol;
        self.node = Node::start(self.parts, &self.chip, self.about)?;
        Ok(self)
    }

    /// Runs a tick: the control loop, then some steps of the background task. A packet that is passed on to servos
    /// makes the tick longer.
    pub fn tick(&mut self) {
        let tick_ns = u64::from(self.parts.tick_us()) * 1000;
        let (clock_us, failed) = (Cell::new(self.now_us()), Cell::new(None));
        let has_outputs = Cell::new(false);
        self.ticks += 1;
        let end_ns = self.ticks * tick_ns;
        if let Some(control) = &mut self.node.control {
            let mut wire = Servos {
                buses: &self.buses,
                failed: &failed,
                lines: &mut self.lines,
                bauds: &self.bauds,
                end_ns,
                clock_us: &clock_us,
                has_outputs: &has_outputs,
                wires: &mut self.wires,
            };
            let mut pins = Pins { clock_us: &clock_us, has_outputs: &has_outputs };
            let mut bus = AllLines { buses: &self.buses, failed: &failed };
            // There is no watchdog: an incomplete tick is visible only in telemetry.
            let _ = control.tick(&mut pins, &*self.node.mail, &mut bus, &mut wire, &mut []);
        }
        run_all(&mut self.lines, end_ns);
        let now_ns = self.lines.first().map_or(end_ns, |line| line.servos.now_ns());
        self.ticks = self.ticks.max(now_ns.div_ceil(tick_ns));
        for _ in 0..STEPS {
            let now_us = self.now_us();
            let Self { came, said, chip, lent, node, .. } = self;
            let mut port = HostPort { now_us, came, said, chip, lent };
            if node.background.step(&mut port, &*node.mail) == Next::Restart {
                self.restart();
                return;
            }
        }
    }

    /// Restarts the board with the content of its flash. Servos keep their power.
    fn restart(&mut self) {
        // This succeeded at the first start, with the same parts.
        if let (Ok(node), Ok(buses)) =
            (Node::start(self.parts, &self.chip, self.about), self.parts.all_buses())
        {
            (self.node, self.buses) = (node, RefCell::new(buses));
            // At a start the pull-up switches OE off, and the chip is reset.
            for line in &mut self.lines {
                line.servos.enable_pulses(false);
                line.servos.start_chip(pulses::prescale());
            }
            self.starts += 1;
        }
    }

    /// Gives the board bytes from a host.
    pub fn give(&mut self, bytes: &[u8]) {
        self.came.extend(bytes);
    }

    /// Returns the time since power-on, µs.
    pub fn now_us(&self) -> u64 {
        self.ticks * u64::from(self.parts.tick_us())
    }

    /// Returns the state of the control loop; `None` without a rig that fits.
    pub fn state(&self) -> Option<State> {
        self.node.control.as_ref().map(|control| control.controller().report().state)
    }

    /// Sets the faults of the servos. A servo is given by its index in the rig; times are since power-on.
    pub fn set_faults(&mut self, faults: impl IntoIterator<Item = Fault>) {
        let place = |fault: Fault| Fault { servo: self.parts.place_on_bench(fault.servo), ..fault };
        let faults = faults.into_iter().map(place).collect();
        // Without a line there are no servos.
        if let Some(line) = self.lines.first_mut() {
            line.servos.bench_mut().faults = faults;
        }
    }

    /// Returns the number of starts, including the first.
    pub fn starts(&self) -> u32 {
        self.starts
    }

    /// Returns the length of a tick.
    pub(super) fn tick_time(&self) -> Duration {
        Duration::from_micros(self.parts.tick_us().into())
    }
}

impl<P: Plant> SimulatedBoard<'_, P> {
    /// Calls `look` with all servos; does not call it if the rig has no line.
    pub fn look_at_servos(&self, look: impl FnOnce(&[Servo<'_>])) {
        if let Some(line) = self.lines.first() {
            look(line.servos.bench().servos());
        }
    }
}

impl SimulatedBoard<'_, RigPlant> {
    /// Makes a hand hold a dof of the rig; `None`: the hand releases it. Returns whether the rig has this dof.
    pub fn lead(&mut self, dof: usize, hand: Option<Hand>) -> bool {
        // Without a line there are no servos.
        let line = self.lines.first_mut();
        line.is_some_and(|line| line.servos.bench_mut().plant.lead(dof, hand))
    }
}

/// A host link without a port, in simulated time: time passes while the host waits.
impl<P: Plant> sinew_board_client::Line for SimulatedBoard<'_, P> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.give(bytes);
        Ok(())
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        let end = self.now() + wait;
        while self.said.is_empty() && self.now() < end {
            self.tick();
        }
        let count = into.len().min(self.said.len());
        into.iter_mut().zip(self.said.drain(..count)).for_each(|(to, byte)| *to = byte);
        Ok(count)
    }

    fn now(&self) -> Duration {
        Duration::from_micros(self.now_us())
    }
}

#[expect(clippy::cast_possible_truncation, reason = "they are small")]
const ABOUT: About = About {
    protocol: Version::CURRENT,
    firmware: Release { major: 0, minor: 1, patch: 0 },
    rig: 0,
    capacities: Capacities {
        bodies: BODIES as u16,
        coordinates: COORDINATES as u16,
        dofs: DOFS as u16,
        servos: SERVOS as u16,
        slots: TABLE.slots.len() as u8,
        slot_bytes: TABLE.slots[0].total_len(),
    },
};
