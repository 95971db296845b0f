//! Runs the node tick by tick; the host starts each tick.

use core::cell::{Cell, RefCell};
use core::convert::Infallible;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};

use sinew_firmware::controller::MotionController;
use sinew_firmware::node::{
    BackgroundTask, ControlLoop, Found, Mail, Next, NodeSettings, Setup, start,
};
use sinew_firmware::supervisor::{Fault, FaultSet};
use sinew_link::message::{About, Capacities, Release, Version};
use sinew_storage::{Area, BoardTable, Capacity};
use sinew_wiring::AllLines;

use crate::built_in::{BuiltIn, Received};
use crate::hardware::{Chip, HostPort, Pins, Servos, ShowBuffer, SingleThreaded, put, take};
use crate::limits::{CAPACITY, COORDINATES, LINE_AT_ONCE, LINE_BPS, RIG_ROOM};
use crate::message::{Bytes, End, LoopMessage, ToHost, ToNode};

/// Capacity that the arm's board reports.
const OF_ARM: u16 = 8;

const fn capacity(of: u16) -> Capacity {
    Capacity { bodies: of, dofs: of, servos: of }
}

/// Flash layout of the arm's board, with sectors as in the F446.
pub const TABLE: BoardTable = BoardTable {
    log: Area { start: 0x4000, sector_len: SECTOR_LEN, sectors: 2 },
    slots: &[
        Area { start: 0xC000, sector_len: SECTOR_LEN, sectors: 1 },
        Area { start: 0x1_0000, sector_len: SECTOR_LEN, sectors: 1 },
    ],
    capacity: capacity(OF_ARM),
};

/// Flash layout of a rig's board, with room for minutes of shows.
const OF_RIGS: BoardTable = BoardTable {
    slots: &[
        Area { start: 0xC000, sector_len: SECTOR_LEN, sectors: 16 },
        Area { start: 0x4_C000, sector_len: SECTOR_LEN, sectors: 16 },
    ],
    capacity: capacity(rounded(CAPACITY)),
    ..TABLE
};

const SECTOR_LEN: u32 = 0x4000;

#[expect(clippy::cast_possible_truncation, reason = "they are small")]
const fn rounded(count: usize) -> u16 {
    count as u16
}

/// Description that the arm's board sends.
pub const ABOUT: About = About {
    protocol: Version::CURRENT,
    firmware: Release { major: 0, minor: 1, patch: 0 },
    rig: 0,
    capacities: Capacities {
        bodies: OF_ARM,
        coordinates: OF_ARM,
        dofs: OF_ARM,
        servos: OF_ARM,
        slots: 2,
        slot_bytes: 0,
    },
};

/// Description that a rig's board sends.
const ABOUT_RIGS: About = About {
    capacities: Capacities {
        bodies: rounded(CAPACITY),
        coordinates: rounded(COORDINATES),
        dofs: rounded(CAPACITY),
        servos: rounded(CAPACITY),
        slots: 2,
        slot_bytes: 16 * SECTOR_LEN,
    },
    ..ABOUT
};

/// Returns the number from which a board counts its sessions, after a number of starts.
pub fn first_session(starts: u16) -> u16 {
    starts.wrapping_mul(100)
}

/// Runs a node from its power-on, through all its restarts.
///
/// `causes` are the reasons for the start; without reasons the node is new, and its flash is blank. `flash` has
/// [`FLASH_LEN`](crate::limits::FLASH_LEN) bytes. `lent` is room for all shows that are loaded between two starts.
///
/// # Panics
/// If the host sends an invalid message.
pub fn run<B: Bytes<Error = Infallible>>(
    host: &mut End<B>,
    mut causes: FaultSet,
    flash: &mut [u8],
    lent: &mut [u8],
) -> ! {
    let said = built_in(host);
    if causes.is_empty() {
        flash.fill(0xFF);
    }
    let mut starts = 0_u16;
    loop {
        starts = starts.wrapping_add(1);
        until_restart(&said, (starts, core::mem::take(&mut causes)), host, flash, lent);
    }
}

/// Whether [`ToNode::Panic`] was received: then a panic of the program is not an error.
pub static IS_ORDERED: AtomicBool = AtomicBool::new(false);

/// Returns the bit of a fault in a set.
pub fn bit(fault: Fault) -> u32 {
    1 << (fault.number() % 32)
}

/// Returns the bits of a set of faults.
pub fn bits(faults: FaultSet) -> u32 {
    faults.iter().fold(0, |bits, fault| bits | bit(fault))
}

fn built_in<B: Bytes<Error = Infallible>>(host: &mut End<B>) -> Received {
    let rig = match take(host) {
        ToNode::PowerOn(BuiltIn::Arm(kind)) => return Received::Arm(kind),
        ToNode::PowerOn(BuiltIn::Rig(rig)) => rig,
        other => panic!("{other:?} before power-on"),
    };
    let lines = (0..rig.lines).map(|_| match take(host) {
        ToNode::Line(line) => line,
        other => panic!("{other:?} in place of a line"),
    });
    let lines = lines.collect();
    let servos = (0..rig.servos).map(|_| match take(host) {
        ToNode::Servo(servo) => servo,
        other => panic!("{other:?} in place of a servo"),
    });
    Received::Rig { rig, lines, servos: servos.collect() }
}

fn until_restart<B: Bytes<Error = Infallible>>(
    said: &Received,
    (starts, causes): (u16, FaultSet),
    host: &mut End<B>,
    flash: &mut [u8],
    lent: &mut [u8],
) {
    let flash = RefCell::new(flash);
    let chip = Chip(&flash);
    let mut lent = ShowBuffer(lent);
    let parts = said.parts();
    let defaults = NodeSettings::new(parts.settings, parts.schedule);
    let (table, about) = match said {
        Received::Arm(_) => (TABLE, ABOUT),
        Received::Rig { .. } => (OF_RIGS, ABOUT_RIGS),
    };
    let mut slot = MaybeUninit::uninit();
    let found = start::<_, CAPACITY, CAPACITY, CAPACITY>(
        chip,
        table,
        |_| defaults,
        causes,
        &mut [0; RIG_ROOM],
        &mut slot,
    );
    let Found { store, disarmed, settings, rig, is_bad, start } = found.expect("flash is RAM");
    let lines = RefCell::new(parts.lines);
    let mut control = rig.and_then(|(rig, _)| {
        ControlLoop::<CAPACITY, CAPACITY, CAPACITY, COORDINATES>::new(
            rig,
            &settings,
            &parts.servos,
            &parts.schedule,
            start,
        )
        .ok()
    });
    let tick_s = 1e-6 * parts.schedule.tick_us() as f32;
    let rig = rig.filter(|_| control.is_some());
    let setup = Setup { about, settings, is_bad, rig, tick_s, line_bps: LINE_BPS };
    let mail = SingleThreaded(RefCell::new(Mail::new(disarmed)));
    let mut background = BackgroundTask::new(store, setup, first_session(starts));
    loop {
        match take(host) {
            ToNode::Tick { now_us, is_stopped } => {
                let now_us = Cell::new(now_us);
                let mut pins = Pins { now_us: &now_us, is_stopped, outputs: false, is_fed: false };
                let Some(control) = &mut control else {
                    put(host, &ToHost::Ticked(None));
                    continue;
                };
                let mut wire = Servos { host, lines: &lines, now_us: &now_us };
                // An incomplete tick is reported: the watchdog was not fed.
                let _ = control.tick(&mut pins, &mail, &mut AllLines(&lines), &mut wire, &mut []);
                let controller = control.controller();
                let report = controller.report();
                let of_loop = LoopMessage {
                    is_fed: pins.is_fed,
                    outputs: pins.outputs,
                    state: report.state.number(),
                    faults: [report.present, report.latched].map(bits),
                    commanded: &bytes_of(controller),
                };
                put(host, &ToHost::Ticked(Some(of_loop)));
            }
            ToNode::Below { now_us, steps, line } => {
                let came = heapless::Vec::<u8, LINE_AT_ONCE>::from_slice(line);
                let came = came.expect("not too many bytes");
                let said = heapless::Vec::new();
                let mut port = HostPort { now_us, came: &came, said, chip, lent: &mut lent };
                let restarts =
                    (0..steps).any(|_| background.step(&mut port, &mail) == Next::Restart);
                let taken = came.len() - port.came.len();
                put(host, &ToHost::Stepped { taken, line: &port.said, restarts });
                if restarts {
                    return;
                }
            }
            ToNode::Panic => {
                IS_ORDERED.store(true, Ordering::Relaxed);
                panic!("the host has ordered it");
            }
            other => panic!("{other:?} between ticks"),
        }
    }
}

/// Bytes of the commands to all dofs.
type Commanded = heapless::Vec<u8, { (COORDINATES + 3 * CAPACITY) * size_of::<f32>() }>;

fn bytes_of(
    controller: &MotionController<'_, CAPACITY, CAPACITY, CAPACITY, COORDINATES>,
) -> Commanded {
    commanded(controller).flat_map(f32::to_le_bytes).collect()
}

/// Returns the commands of a controller's last tick: positions, then speeds, then the tracker's effort and the error
/// of each dof.
pub fn commanded<
    'c,
    const BODIES: usize,
    const DOFS: usize,
    const SERVOS: usize,
    const COORDS: usize,
>(
    controller: &'c MotionController<'_, BODIES, DOFS, SERVOS, COORDS>,
) -> impl Iterator<Item = f32> + 'c {
    let (q, qd) = controller.commanded();
    let dofs = controller.report().dofs.iter();
    q.iter().chain(qd).copied().chain(dofs.flat_map(|dof| [dof.effort, dof.error]))
}
