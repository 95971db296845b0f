//! Runs the board's controller in this process, from the same rig item that the board received.

use std::cell::RefCell;

use sinew_firmware::controller::{ControllerSettings, Inputs, MotionController, Start};
use sinew_firmware::node::split_rig;
use sinew_firmware::supervisor::{Command, FaultSet};
use sinew_rig::board::BoardRig;
use sinew_servo_sim::bench::Branch;
use sinew_servo_sim::line::{Line, LineDevice as _};
use sinew_servo_sim::plant::RigPlant;
use sinew_wiring::{AllLines, Bus, Lines, Wiring};

use crate::test_rig::Rig;

/// Capacity of boards with an STM32.
const SERVOS: usize = 20;
const BODIES: usize = SERVOS + 1;
const COORDINATES: usize = SERVOS + 2;

/// Packets that were sent together, and the servos' answers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Exchange {
    pub(crate) sent: Vec<u8>,
    pub(crate) answered: Vec<u8>,
}

/// A controller with simulated servos.
pub(crate) struct InProcess {
    controller: Box<MotionController<'static, BODIES, SERVOS, SERVOS, COORDINATES>>,
    lines: RefCell<Lines<Bus<SERVOS>, 1, SERVOS>>,
    servos: Line<Branch<'static, RigPlant>>,
    ticks: u64,
    tick_us: u64,
}

impl InProcess {
    /// Creates the controller just before its own power and the servos' power come on.
    pub(crate) fn new(rig: &Rig) -> Self {
        let (form, behind) = split_rig(&rig.bytes);
        let board = Box::leak(Box::new(BoardRig::decode(form).unwrap()));
        let wiring = Wiring::<1, SERVOS>::decode(behind).unwrap();
        let settings = ControllerSettings { rig_crc: rig.parts.rig_crc(), ..wiring.settings() };
        let (setups, schedule) = (wiring.setups(), wiring.schedule().unwrap());
        let controller =
            MotionController::new(board, &settings, &setups, &schedule, Start::default());
        let mut controller = Box::new(controller.unwrap());
        controller.load_show(Some(rig.show.clone().leak())).unwrap();
        let mut lines = Lines::new([], []);
        wiring.connect(&mut lines).unwrap();
        let (lines, servos) = (RefCell::new(lines), rig.servos());
        Self { controller, lines, servos, ticks: 0, tick_us: schedule.tick_us().into() }
    }

    /// Runs a tick whose clock is read `late_us` late. `leaves` gives, for each packet, the time at which it begins to
    /// leave, ns, and other bytes that leave in its place, if any. Without an entry, a packet leaves at once.
    pub(crate) fn tick(
        &mut self,
        command: Option<Command>,
        late_us: u64,
        leaves: &mut dyn Iterator<Item = (u64, Option<&[u8]>)>,
    ) -> Vec<Exchange> {
        let Self { controller, lines, servos, ticks, tick_us } = self;
        let now_us = *ticks * *tick_us + late_us;
        *ticks += 1;
        let inputs = Inputs { now_us, heard: true, command, found: FaultSet::EMPTY, jog: None };
        let begun = controller.begin(&inputs, &mut (), &mut AllLines(lines));
        let (mut out, mut exchanges) = ([0; 1024], Vec::new());
        let mut lines = lines.borrow_mut();
        let mut planned = lines.plan(0, &mut out);
        while let Some(request) = planned {
            let sent = out[..request.len].to_vec();
            let (begin_ns, other) = leaves.next().unwrap_or_else(|| (servos.servos.now_ns(), None));
            servos.run_until(begin_ns);
            let end_ns = servos.servos.now_ns() + u64::from(request.time_us) * 1000;
            let answered =
                answers(servos, other.unwrap_or(&sent), end_ns, |said| lines.reply(0, said));
            if !sent.is_empty() {
                exchanges.push(Exchange { sent, answered });
            }
            // The tick has enough time for all questions of the bus.
            planned = lines.plan_more(0, u32::MAX, &mut out);
        }
        let _ = controller.end(begun, Ok(()), 0);
        exchanges
    }

    /// Returns whether servos may have torque.
    pub(crate) fn has_torque(&self) -> bool {
        self.controller.permission().torque
    }
}

/// Sends bytes, and passes the answers to `reply` until it returns true or the time is over.
fn answers(
    servos: &mut Line<Branch<'static, RigPlant>>,
    sent: &[u8],
    end_ns: u64,
    mut reply: impl FnMut(&[u8]) -> bool,
) -> Vec<u8> {
    let (mut said, mut answered) = ([0; 1024], Vec::new());
    while servos.take(&mut said) > 0 {}
    servos.write(sent);
    loop {
        let next_ns = servos.next_ns().map_or(end_ns, |next| next.min(end_ns));
        servos.run_until(next_ns);
        if servos.is_sending() {
            continue;
        }
        let len = servos.take(&mut said);
        answered.extend_from_slice(&said[..len]);
        if reply(&said[..len]) || next_ns == end_ns {
            return answered;
        }
    }
}
