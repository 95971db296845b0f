//! The node of all these boards: read back at the start, then the loop in its interrupt and the desk in what it leaves.

use core::cell::RefCell;
use core::ops::Range;
use core::ptr;
use core::sync::atomic::{AtomicPtr, AtomicU8, AtomicU32, Ordering};

use cortex_m::peripheral::{DWT, NVIC, SCB};
use critical_section::Mutex;
use embassy_stm32::gpio::{Input, Output};
use embassy_stm32::{interrupt, pac, peripherals, rcc};
use heapless::Vec;
use sinew_bus::{Schedule, Timing, dynamixel};
use sinew_firmware::controller::{
    Controller, ControllerError, ControllerSettings, ServoSetup, Start, check_budget, estimated_us,
};
use sinew_firmware::node::{
    Control, Desk, Found, Mail, Next, NodeSettings, Port, Safety, Setup, Shared, start,
};
use sinew_firmware::supervisor::Fault;
use sinew_firmware::watchdog::{Complete, Watchdog};
use sinew_link::message::{About, Capacities, Release, Version};
use sinew_rig::board::BoardRig;
use sinew_storage::{BoardTable, Capacity, Store};
use sinew_wiring::{AllLines, Built, Line, Protocol, Wiring};
use static_cell::{ConstStaticCell, StaticCell};

use crate::bus::{Exchange, Lines, Place, Ports};
use crate::{Chip, Light, Serial, ServoLine, clock, dog, flash, pulses, reset};

/// Servos that these boards hold. What runs would have room for 20 in 128 kB: 66 kB, and 27 for what does not depend on
/// it. But to make a controller takes some five times its size of stack, as its parts are moved into it: of six servos
/// 100 kB, where 94 are left.
pub const SERVOS: usize = 5;
/// Bodies.
pub const BODIES: usize = SERVOS + 1;
/// Degrees of freedom.
pub const FREEDOMS: usize = SERVOS;
/// Coordinates: a ball joint has four for three freedoms.
pub const COORDINATES: usize = SERVOS + 2;
/// Lines of servos: one of UART, one of I2C.
pub const LINES: usize = 2;

/// The largest rig.
pub const CAPACITY: Capacity = Capacity {
    bodies: rounded(BODIES),
    degrees_of_freedom: rounded(FREEDOMS),
    servos: rounded(SERVOS),
};

/// Room for the longest item of a rig: its compact form, and its wiring.
const RIG_ROOM: usize = 4096;

/// The loop's interrupt is above all but DMA, whose rings count their turns by theirs.
const LOOP_PRIORITY: u8 = 8 << 4;

type Rig = BoardRig<BODIES, FREEDOMS, SERVOS>;
type LoopControl = Control<'static, BODIES, FREEDOMS, SERVOS, COORDINATES>;
type OwnController = Controller<'static, BODIES, FREEDOMS, SERVOS, COORDINATES>;
type OwnMail = Locked<Mail<'static, FREEDOMS, SERVOS, COORDINATES>>;
type OwnWiring = Wiring<LINES, SERVOS>;

#[expect(clippy::cast_possible_truncation, reason = "they are small")]
const fn rounded(count: usize) -> u16 {
    count as u16
}

/// What a board gives. Its interrupts are bound, its clocks run.
pub struct Hardware {
    /// The line to the host.
    pub link: Serial,
    /// What it carries, bit/s.
    pub link_bps: u32,
    /// The servos' line.
    pub servos: ServoLine,
    /// The bus of a PCA9685.
    pub i2c: pulses::Bus,
    /// Its OE on PB5: high is off, and high from reset on by a pull-up.
    pub outputs: Output<'static>,
    /// The emergency stop's loop: high while it is closed.
    pub stop: Input<'static>,
    /// The status light.
    pub light: Light,
    /// The chip's flash.
    pub flash: Chip,
    /// What of it is storage's.
    pub table: BoardTable,
    /// The processor's clock, Hz.
    pub core_hz: u32,
}

/// A value that both halves reach.
struct Locked<T>(Mutex<RefCell<T>>);

impl<T> Shared<T> for Locked<T> {
    fn with<R>(&self, act: impl FnOnce(&mut T) -> R) -> R {
        critical_section::with(|cs| act(&mut self.0.borrow_ref_mut(cs)))
    }
}

/// The board as the loop sees it.
struct Pins {
    outputs: Output<'static>,
    stop: Input<'static>,
    watchdog: Watchdog<fn()>,
    core_hz: u32,
}

impl Safety for Pins {
    fn now_us(&self) -> u64 {
        clock::now_us()
    }
    fn is_stopped(&mut self) -> bool {
        self.stop.is_low()
    }
    fn enable_outputs(&mut self, on: bool) {
        self.outputs.set_level((!on).into());
        dog::for_outputs(on);
    }
    fn feed(&mut self, tick: Complete) {
        self.watchdog.feed(tick);
    }
    fn stack_free(&self) -> u32 {
        STACK_FREE.load(Ordering::Relaxed)
    }
    fn cycles(&self) -> u32 {
        DWT::cycle_count()
    }
    fn cycles_hz(&self) -> u32 {
        self.core_hz
    }
}

/// All that the loop has.
struct Loop {
    control: &'static mut LoopControl,
    lines: &'static RefCell<Lines>,
    ports: Ports,
    pins: Pins,
    mail: &'static OwnMail,
    /// For so long from its beginning a tick asks servos for more: the rest is for what it computes, and for the desk.
    asks_us: u32,
}

/// The loop, once there is one: from then on its interrupt alone has it.
static LOOP: AtomicPtr<Loop> = AtomicPtr::new(ptr::null_mut());
/// The first fault that is latched, by number; 0 for none.
static FAULT: AtomicU8 = AtomicU8::new(0);
static STACK_FREE: AtomicU32 = AtomicU32::new(0);
/// The processor's clock, Hz.
static CORE_HZ: AtomicU32 = AtomicU32::new(0);

#[embassy_stm32::interrupt]
fn TIM3() {
    pac::TIM3.sr().modify(|w| w.set_uif(false));
    // SAFETY: it is a static, and nobody else has it since it was put there.
    let Some(own) = (unsafe { LOOP.load(Ordering::Acquire).as_mut() }) else { return };
    let Loop { control, lines, ports, pins, mail, asks_us } = own;
    let until_us = clock::now_us().saturating_add(u64::from(*asks_us));
    let mut wire = Exchange { ports, lines, until_us };
    // What was not whole has not fed the watchdog, and the report says why.
    let _ = control.tick(pins, *mail, &mut AllLines(lines), &mut wire, &mut []);
    let fault = control.controller().report().latched.first();
    FAULT.store(fault.map_or(0, Fault::number), Ordering::Relaxed);
}

/// The board as link and storage see it.
struct Desktop {
    link: Serial,
}

impl Port<'static> for Desktop {
    fn now_us(&self) -> u64 {
        clock::now_us()
    }
    fn receive(&mut self, into: &mut [u8]) -> usize {
        self.link.read(into)
    }
    fn send(&mut self, bytes: &[u8]) -> usize {
        self.link.send(bytes)
    }
    fn cycles(&self) -> u32 {
        DWT::cycle_count()
    }
    fn look<R>(&mut self, range: Range<u32>, look: impl FnOnce(&[u8]) -> R) -> Option<R> {
        flash::memory(range).map(look)
    }
    fn lend(&mut self, range: Range<u32>) -> Option<&'static [u8]> {
        flash::memory(range)
    }
    fn drives(behind: &[u8]) -> bool {
        of_wiring(behind).is_some()
    }
}

/// Where the lines of a wiring are; none if there are two of a kind.
fn places(wiring: &OwnWiring) -> Option<Vec<Place, LINES>> {
    let places: Vec<Place, LINES> =
        wiring.lines.iter().map(|line| Place::of(&line.protocol)).collect();
    let serial = places.iter().filter(|place| matches!(place, Place::Serial)).count();
    (serial <= 1 && places.len() - serial <= 1).then_some(places)
}

/// Before there is a rig: what nothing goes by.
fn without_rig() -> NodeSettings {
    let timing = Timing { baud: 1_000_000, return_delay_us: 2, turnaround_us: 5 };
    let schedule = Schedule::new(timing, &dynamixel::traffic(1, 2, true), 100);
    NodeSettings::new(ControllerSettings::default(), schedule.expect("one servo at 100 Hz"))
}

/// The board's settings for a wiring that it can drive: in the time of a tick, too. What its processor takes is known
/// here alone. A loop that took longer than its tick would begin the next at once, and the link would starve.
#[inline(never)]
fn of_wiring(behind: &[u8]) -> Option<NodeSettings> {
    let wiring = OwnWiring::decode(behind).ok()?;
    places(&wiring)?;
    let Built { mut settings, servos, schedule, .. } = wiring.build().ok()?;
    settings.compute_us = estimated_us(servos.len(), CORE_HZ.load(Ordering::Relaxed));
    check_budget(settings.compute_us, &schedule, servos.len()).ok()?;
    Some(NodeSettings::new(settings, schedule))
}

/// What a start has found, but the rig's wiring.
struct ReadBack {
    store: Store<Chip>,
    settings: NodeSettings,
    rig: Option<(&'static Rig, u32)>,
    is_bad: bool,
    start: Start,
    mail: &'static OwnMail,
}

#[inline(never)]
fn read_back(flash: Chip, table: BoardTable, room: &mut [u8]) -> (ReadBack, Range<usize>) {
    static RIG: StaticCell<Rig> = StaticCell::new();
    static MAIL: StaticCell<OwnMail> = StaticCell::new();
    let room_at = room.as_ptr() as usize;
    let mut wiring = 0..0;
    let defaults = |behind: &[u8]| {
        let at = (behind.as_ptr() as usize).wrapping_sub(room_at);
        if !behind.is_empty() {
            wiring = at..at + behind.len();
        }
        of_wiring(behind).unwrap_or_else(without_rig)
    };
    let found = start::<_, BODIES, FREEDOMS, SERVOS>(flash, table, defaults, reset::why(), room);
    let Found { store, disarmed, settings, rig, is_bad, start } =
        found.expect("the table is of this flash");
    let rig = rig.map(|(rig, crc)| (&*RIG.init(rig), crc));
    let mail: &'static OwnMail = MAIL.init(Locked(Mutex::new(RefCell::new(Mail::new(disarmed)))));
    (ReadBack { store, settings, rig, is_bad, start, mail }, wiring)
}

/// The node, from here to the next reset.
///
/// What is large is made in functions of its own, and put into statics there: their stack is free again before the
/// next.
pub fn run(mut core: cortex_m::Peripherals, hardware: Hardware) -> ! {
    static ROOM: ConstStaticCell<[u8; RIG_ROOM]> = ConstStaticCell::new([0; RIG_ROOM]);

    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();
    clock::start();
    let Hardware {
        link,
        link_bps,
        mut servos,
        i2c,
        outputs,
        stop,
        mut light,
        flash,
        table,
        core_hz,
    } = hardware;
    CORE_HZ.store(core_hz, Ordering::Relaxed);
    // Whatever was before: at the rate that most servos have, and again at theirs as soon as it is known.
    servos.torque_off();

    let room = ROOM.take();
    let (found, wiring) = read_back(flash, table, room);
    let ReadBack { store, settings, rig, is_bad, start, mail } = found;
    let first_session = u16::try_from(start.count % 0x1_0000).unwrap_or_default().wrapping_mul(100);
    let behind = room.get(wiring).unwrap_or_default();
    let of_loop = rig.and_then(|(rig, crc)| {
        let pins = Unwatched { outputs, stop, core_hz };
        let tick_us = with_rig(rig, behind, &settings, start, mail, (servos, i2c), pins)?;
        Some((rig, crc, 1e-6 * tick_us as f32))
    });
    let tick_s = of_loop.map_or(0.01, |(_, _, tick_s)| tick_s);
    let rig_of_loop = of_loop.map(|(rig, crc, _)| (rig, crc));
    let about = About {
        protocol: Version::CURRENT,
        firmware: RELEASE,
        rig: 0,
        capacities: Capacities {
            bodies: rounded(BODIES),
            coordinates: rounded(COORDINATES),
            dofs: rounded(FREEDOMS),
            servos: rounded(SERVOS),
            slots: u8::try_from(table.slots.len()).unwrap_or(u8::MAX),
            slot_bytes: table
                .slots
                .iter()
                .map(sinew_storage::Area::holds::<Chip>)
                .min()
                .unwrap_or(0),
        },
    };
    // A rig that is stored, and that this board cannot move: what is stored is bad.
    let is_bad = is_bad || (rig.is_some() && rig_of_loop.is_none());
    let setup = Setup { about, settings, is_bad, rig: rig_of_loop, tick_s, line_bps: link_bps };
    let mut desk = Desk::new(store, setup, first_session);
    let mut port = Desktop { link };
    let mut stack_due_us = 0;
    loop {
        if desk.step(&mut port, mail) == Next::Restart {
            port.link.finish();
            SCB::sys_reset();
        }
        let now_us = clock::now_us();
        let fault = FAULT.load(Ordering::Relaxed);
        light.step(now_us, (fault > 0).then_some(fault));
        if now_us >= stack_due_us {
            stack_due_us = now_us.saturating_add(1_000_000);
            STACK_FREE.store(stack_free(), Ordering::Relaxed);
        }
    }
}

/// Of the workspace.
const RELEASE: Release = Release { major: 0, minor: 1, patch: 0 };

/// Pins of a loop whose watchdog does not run yet.
struct Unwatched {
    outputs: Output<'static>,
    stop: Input<'static>,
    core_hz: u32,
}

/// A controller, made where the caller wants it: what its parts took of the stack is free again.
#[inline(never)]
fn controller(
    rig: &'static Rig,
    settings: &NodeSettings,
    (servos, schedule): (&[ServoSetup], &Schedule),
    start: Start,
) -> Result<OwnController, ControllerError> {
    Controller::new(rig, &settings.controller, servos, schedule, start)
}

#[inline(never)]
fn control(
    rig: &'static Rig,
    settings: &NodeSettings,
    of_servos: (&[ServoSetup], &Schedule),
    start: Start,
) -> Option<&'static mut LoopControl> {
    match controller(rig, settings, of_servos, start) {
        Ok(controller) => own(rig, controller, settings),
        Err(_) => None,
    }
}

#[inline(never)]
fn own(
    rig: &'static Rig,
    controller: OwnController,
    settings: &NodeSettings,
) -> Option<&'static mut LoopControl> {
    static CONTROL: StaticCell<LoopControl> = StaticCell::new();
    Some(CONTROL.init(Control::new(rig, controller, settings.live()).ok()?))
}

/// The lines of a wiring, and what else the loop has of it.
struct Wired {
    lines: &'static RefCell<Lines>,
    places: Vec<Place, LINES>,
    servos: Vec<ServoSetup, SERVOS>,
    schedule: Schedule,
    of_lines: Vec<Line, LINES>,
}

#[inline(never)]
fn wired(behind: &[u8]) -> Option<Wired> {
    static LINES_OF_ALL: StaticCell<RefCell<Lines>> = StaticCell::new();
    let wiring = OwnWiring::decode(behind).ok()?;
    let places = places(&wiring)?;
    let Built { servos, schedule, buses, .. } = wiring.build().ok()?;
    let lines = LINES_OF_ALL.init(RefCell::new(Lines::new(buses, wiring.line_of())));
    Some(Wired { lines, places, servos, schedule, of_lines: wiring.lines })
}

/// Starts the loop of a rig: lines, watchdog, timer. The length of its tick, µs; none if it cannot be as the wiring
/// says.
#[inline(never)]
fn with_rig(
    rig: &'static Rig,
    behind: &[u8],
    settings: &NodeSettings,
    start: Start,
    mail: &'static OwnMail,
    (serial, i2c): (ServoLine, pulses::Bus),
    pins: Unwatched,
) -> Option<u32> {
    static OWN: StaticCell<Loop> = StaticCell::new();
    let Wired { lines, places, servos, schedule, of_lines } = wired(behind)?;
    let tick_us = schedule.tick_us();
    let control = control(rig, settings, (&servos, &schedule), start)?;
    let mut ports = Ports::new(serial, i2c, places);
    for line in &of_lines {
        match &line.protocol {
            // A chip that does not answer yet makes no pulses: OE is high until there is torque.
            Protocol::Pca9685(pulses) => {
                let _ = pulses::start(&mut ports.i2c, &pulses.prescale().ok()?);
            }
            _ if !ports.serial.set_rate(line.timing.baud) => return None,
            _ => ports.serial.torque_off(),
        }
    }
    let reload = u16::try_from(tick_us.checked_sub(1)?).ok()?;
    rcc::enable_and_reset::<peripherals::TIM3>();
    let ticks = rcc::frequency::<peripherals::TIM3>().0 / 1_000_000;
    pac::TIM3.psc().write_value(u16::try_from(ticks.checked_sub(1)?).ok()?);
    pac::TIM3.arr().write(|w| w.set_arr(reload));
    pac::TIM3.egr().write(|w| w.set_ug(true));
    pac::TIM3.sr().modify(|w| w.set_uif(false));
    pac::TIM3.dier().modify(|w| w.set_uie(true));

    let Unwatched { outputs, stop, core_hz } = pins;
    let pins = Pins { outputs, stop, watchdog: dog::start(), core_hz };
    let asks_us = tick_us.saturating_sub(settings.controller.compute_us);
    let own = OWN.init(Loop { control, lines, ports, pins, mail, asks_us });
    LOOP.store(own, Ordering::Release);
    // SAFETY: the loop's value is there, and the priority is set before the interrupt comes.
    unsafe {
        cortex_m::Peripherals::steal().NVIC.set_priority(interrupt::TIM3, LOOP_PRIORITY);
        NVIC::unmask(interrupt::TIM3);
    }
    pac::TIM3.cr1().modify(|w| w.set_cen(true));
    Some(tick_us)
}

/// What the runtime has painted before anything ran.
const PAINT: u32 = 0xCCCC_CCCC;

/// Bytes of the stack that were never used.
fn stack_free() -> u32 {
    unsafe extern "C" {
        static __sheap: u32;
        static _stack_start: u32;
    }
    let (mut at, end) = (&raw const __sheap, &raw const _stack_start);
    let mut free = 0;
    // SAFETY: it is RAM between what is static and where the stack begins.
    while at < end && unsafe { at.read_volatile() } == PAINT {
        at = at.wrapping_add(1);
        free += 4;
    }
    free
}
