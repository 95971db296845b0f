//! The node, tick by tick as its host says.

use core::cell::{Cell, RefCell};

use sinew_firmware::controller::Controller;
use sinew_firmware::node::{Control, Desk, Found, Mail, Next, NodeSettings, Setup, start};
use sinew_firmware::supervisor::FaultSet;
use sinew_link::message::{About, Capacities, Release, Version};
use sinew_storage::{Area, BoardTable, Capacity};

use crate::arm::{self, Kind};
use crate::hardware::{Alone, Chip, Desktop, Lent, Pins, Servos};
use crate::message::{Bytes, End, LINE_AT_ONCE, OfLoop, ToHost, ToNode};

const COUNT: u16 = 8;

/// Bodies, freedoms, servos and coordinates that it holds.
pub const CAPACITY: usize = COUNT as usize;

/// Sectors as the F446's.
pub const TABLE: BoardTable = BoardTable {
    log: Area { start: 0x4000, sector_len: 0x4000, sectors: 2 },
    slots: &[
        Area { start: 0xC000, sector_len: 0x4000, sectors: 1 },
        Area { start: 0x1_0000, sector_len: 0x4000, sectors: 1 },
    ],
    capacity: Capacity { bodies: COUNT, degrees_of_freedom: COUNT, servos: COUNT },
};

/// Bytes up to the end of its last slot.
pub const FLASH_LEN: usize = 0x1_4000;

/// What it says of itself.
pub const ABOUT: About = About {
    protocol: Version::CURRENT,
    firmware: Release { major: 0, minor: 1, patch: 0 },
    rig: 0,
    capacities: Capacities {
        bodies: COUNT,
        coordinates: COUNT,
        dofs: COUNT,
        servos: COUNT,
        slots: 2,
        slot_bytes: 0,
    },
};

/// What the line to the host carries, bit/s.
pub const LINE_BPS: u32 = 1_000_000;

/// Bytes that the line takes in a step.
pub const LINE_IN_STEP: usize = 200;

/// Room for the longest rig in its compact form.
pub const RIG_ROOM: usize = 16_384;

/// The number of the first session after so many starts.
pub fn first_session(starts: u16) -> u16 {
    starts.wrapping_mul(100)
}

/// Runs a node from its first power-on, with blank flash, as often as it begins anew.
///
/// `flash`: [`FLASH_LEN`] bytes. `lent`: room for all shows that are loaded from one start to the next.
///
/// # Panics
/// If the host says what cannot be.
pub fn run(host: &mut End<impl Bytes>, flash: &mut [u8], lent: &mut [u8]) -> ! {
    let ToNode::PowerOn(kind) = host.take() else { panic!("no power-on") };
    flash.fill(0xFF);
    let mut starts = 0_u16;
    loop {
        starts = starts.wrapping_add(1);
        until_restart(kind, starts, host, flash, lent);
    }
}

fn until_restart(
    kind: Kind,
    starts: u16,
    host: &mut End<impl Bytes>,
    flash: &mut [u8],
    lent: &mut [u8],
) {
    let flash = RefCell::new(flash);
    let chip = Chip(&flash);
    let mut lent = Lent(lent);
    let parts = arm::parts(kind);
    let defaults = NodeSettings::new(parts.settings, parts.schedule);
    let found = start::<_, CAPACITY, CAPACITY, CAPACITY>(
        chip,
        TABLE,
        &defaults,
        FaultSet::EMPTY,
        &mut [0; RIG_ROOM],
    );
    let Found { store, disarmed, settings, rig, is_bad, start } = found.expect("flash is RAM");
    let rig = rig.as_ref().map(|(rig, crc)| (rig, *crc));
    let mut bus = parts.bus;
    let mut control = rig.and_then(|(rig, _)| {
        let controller = Controller::<CAPACITY, CAPACITY, CAPACITY, CAPACITY>::new(
            rig,
            &settings.controller,
            &parts.servos,
            &parts.schedule,
            start,
        );
        Control::new(rig, controller.ok()?, settings.live()).ok()
    });
    let tick_s = 1e-6 * parts.schedule.tick_us() as f32;
    let rig = rig.filter(|_| control.is_some());
    let setup = Setup { about: ABOUT, settings, is_bad, rig, tick_s, line_bps: LINE_BPS };
    let mail = Alone(RefCell::new(Mail::new(disarmed)));
    let mut desk = Desk::new(store, setup, first_session(starts));
    loop {
        let ToNode::Tick { from_to_us: [from_us, to_us], is_stopped, steps, line } = host.take()
        else {
            panic!("no tick")
        };
        let came = heapless::Vec::<u8, LINE_AT_ONCE>::from_slice(line).expect("not too many bytes");
        let now_us = Cell::new(from_us);
        let mut pins = Pins { now_us: &now_us, is_stopped, outputs: false, is_fed: false };
        let mut of_loop = None;
        if let Some(control) = &mut control {
            let mut wire = Servos { host, now_us: &now_us, left_us: 0 };
            // What was not whole is told: the watchdog was not fed.
            let _ = control.tick(&mut pins, &mail, &mut bus, &mut wire, &mut [0; 1024]);
            of_loop = Some((control.controller().report().state, bytes_of(control.controller())));
        }
        let mut port = Desktop {
            now_us: to_us,
            came: &came,
            said: heapless::Vec::new(),
            chip,
            lent: &mut lent,
        };
        let restarts = (0..steps).any(|_| desk.step(&mut port, &mail) == Next::Restart);
        let of_loop = of_loop.as_ref().map(|(state, commanded)| OfLoop {
            is_fed: pins.is_fed,
            outputs: pins.outputs,
            state: state.number(),
            commanded,
        });
        let taken = came.len() - port.came.len();
        host.put(&ToHost::Ticked { of_loop, taken, line: &port.said, restarts });
        if restarts {
            return;
        }
    }
}

/// Bytes of what is commanded to all freedoms.
type Commanded = heapless::Vec<u8, { CAPACITY * 4 * size_of::<f32>() }>;

fn bytes_of(controller: &Controller<'_, CAPACITY, CAPACITY, CAPACITY, CAPACITY>) -> Commanded {
    commanded(controller).flat_map(f32::to_le_bytes).collect()
}

/// What a controller has commanded in its last tick: positions, then speeds, then the tracker's effort of each freedom
/// and how far it is from where it should be.
pub fn commanded<'c, const B: usize, const V: usize, const S: usize, const C: usize>(
    controller: &'c Controller<'_, B, V, S, C>,
) -> impl Iterator<Item = f32> + 'c {
    let (q, qd) = controller.commanded();
    let freedoms = controller.report().freedoms.iter();
    q.iter().chain(qd).copied().chain(freedoms.flat_map(|freedom| [freedom.effort, freedom.error]))
}
