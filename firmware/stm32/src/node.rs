//! The node of all STM32 boards: it reads the stored data from flash, then runs the control loop in an interrupt and
//! the background task in `main`.

use core::cell::RefCell;
use core::ops::Range;
use core::ptr;
use core::sync::atomic::{AtomicPtr, AtomicU8, AtomicU32, Ordering};

use cortex_m::peripheral::{DWT, NVIC, SCB};
use critical_section::Mutex;
use embassy_stm32::gpio::{Input, Output};
use embassy_stm32::{interrupt, pac, peripherals, rcc};
use heapless::Vec;
use sinew_firmware::controller::{
    ControllerSettings, ServoSetup, Start, check_budget, estimated_us,
};
use sinew_firmware::node::{
    BackgroundTask, ControlLoop, Found, Mail, Next, NodeSettings, Port, Safety, Setup, Shared,
    start,
};
use sinew_firmware::supervisor::Fault;
use sinew_firmware::watchdog::{Complete, Watchdog};
use sinew_link::message::{About, Capacities, Release, Version};
use sinew_rig::board::BoardRig;
use sinew_servo_bus::{Schedule, Timing, dynamixel};
use sinew_storage::{BoardTable, Store};
use sinew_wiring::{AllLines, Wiring};
use static_cell::StaticCell;

use crate::bus::{Exchange, LinePort, Lines, Ports};
use crate::capacity::{BODIES, COORDINATES, DOFS, LINES, SERVOS, rounded};
use crate::{Chip, Light, Serial, ServoLine, clock, flash, pulses, reset, watchdog};

/// Maximum length of a rig's item (its compact form and its wiring), bytes: half of a sector of 16 kB, since the log
/// keeps the old item until the new one is complete. OP3 with 20 XM430 takes 6.4 kB.
const RIG_ROOM: usize = 8192;

/// Priority of the control loop's interrupt: above everything except DMA, because DMA's interrupts count the rounds of
/// its ring buffers.
const LOOP_PRIORITY: u8 = 8 << 4;

type Rig = BoardRig<BODIES, DOFS, SERVOS>;
type LoopControl = ControlLoop<'static, BODIES, DOFS, SERVOS, COORDINATES>;
type OwnMail = Locked<Mail<'static, DOFS, SERVOS, COORDINATES>>;
type OwnWiring = Wiring<LINES, SERVOS>;

/// The hardware of a board. Its interrupts are bound, and its clocks run.
pub struct Hardware {
    /// The host link.
    pub link: Serial,
    /// Bit rate of the host link, bit/s.
    pub link_bps: u32,
    /// The servos' bus line.
    pub servos: ServoLine,
    /// The I2C bus of a PCA9685.
    pub i2c: pulses::Bus,
    /// The output-enable pin (OE) of the PCA9685, PB5. High is off; a pull-up keeps it high from reset on.
    pub outputs: Output<'static>,
    /// Input of the emergency stop's circuit: high while the circuit is closed.
    pub stop: Input<'static>,
    /// The status light.
    pub light: Light,
    /// The chip's flash.
    pub flash: Chip,
    /// The parts of flash that storage uses.
    pub table: BoardTable,
    /// Clock of the processor, Hz.
    pub core_hz: u32,
}

/// A value that interrupt and background task share.
struct Locked<T>(Mutex<RefCell<T>>);

impl<T> Shared<T> for Locked<T> {
    fn with<R>(&self, act: impl FnOnce(&mut T) -> R) -> R {
        critical_section::with(|cs| act(&mut self.0.borrow_ref_mut(cs)))
    }
}

/// The board's pins and watchdog as the control loop uses them.
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
        watchdog::for_outputs(on);
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

/// All that the loop's interrupt uses.
struct Loop<'l> {
    control: &'l mut LoopControl,
    lines: &'static RefCell<Lines>,
    ports: Ports,
    pins: Pins,
    mail: &'static OwnMail,
    /// Time, from the beginning of a tick's exchange, in which further packets may be sent to servos, µs. The rest of
    /// the tick is for the computation before and after the exchange.
    asks_us: u32,
}

/// The control loop, after it was started. From then on only its interrupt uses it. It is stored in the frame of
/// [`node`], which never returns.
static LOOP: AtomicPtr<Loop<'static>> = AtomicPtr::new(ptr::null_mut());
/// Number of the first latched fault; 0 for none.
static FAULT: AtomicU8 = AtomicU8::new(0);
static STACK_FREE: AtomicU32 = AtomicU32::new(0);
/// Clock of the processor, Hz.
static CORE_HZ: AtomicU32 = AtomicU32::new(0);

#[embassy_stm32::interrupt]
fn TIM3() {
    pac::TIM3.sr().modify(|w| w.set_uif(false));
    // SAFETY: the frame that holds the loop never returns, and since the pointer was set only this interrupt uses it.
    let Some(own) = (unsafe { LOOP.load(Ordering::Acquire).as_mut() }) else { return };
    let Loop { control, lines, ports, pins, mail, asks_us } = own;
    let was_on = control.controller().permission().torque;
    let mut wire = Exchange { ports, lines, was_on, asks_us: *asks_us, until_us: 0 };
    // An incomplete tick has not fed the watchdog, and the report contains the reason.
    let _ = control.tick(pins, *mail, &mut AllLines(lines), &mut wire, &mut []);
    let fault = control.controller().report().latched.first();
    FAULT.store(fault.map_or(0, Fault::number), Ordering::Relaxed);
}

/// The board as the background task uses it: the host link and flash.
struct HostPort {
    link: Serial,
}

impl Port<'static> for HostPort {
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
        is_driven(behind)
    }
}

/// Returns the ports of a wiring's lines, or `None` if two lines need the same port, or a PCA9685 cannot make the
/// requested pulse rate.
fn places(wiring: &OwnWiring) -> Option<Vec<LinePort, LINES>> {
    let places: Vec<LinePort, LINES> =
        wiring.lines.iter().map(LinePort::of).collect::<Option<_>>()?;
    let serial = places.iter().filter(|place| matches!(place, LinePort::Serial(_))).count();
    (serial <= 1 && places.len() - serial <= 1).then_some(places)
}

/// Returns settings for a board without a rig. Nothing uses them before a rig is stored.
fn without_rig() -> NodeSettings {
    let timing = Timing { baud: 1_000_000, return_delay_us: 2, turnaround_us: 5 };
    let schedule = Schedule::new(timing, &dynamixel::traffic(1, 2, true), 100);
    NodeSettings::new(ControllerSettings::default(), schedule.expect("one servo at 100 Hz"))
}

/// Returns a wiring's settings with the time that this processor needs for a tick, and its schedule. Returns `None`
/// if that does not fit into a tick: a loop that took longer than its tick would begin the next one at once, and the
/// link would starve.
fn in_time(wiring: &OwnWiring) -> Option<(ControllerSettings, Schedule)> {
    wiring.check().ok()?;
    let (mut settings, schedule) = (wiring.settings(), wiring.schedule().ok()?);
    let servos = wiring.servos.len();
    settings.compute_us = estimated_us(servos, CORE_HZ.load(Ordering::Relaxed));
    check_budget(settings.compute_us, &schedule, servos).ok()?;
    Some((settings, schedule))
}

/// Returns whether this board can drive a wiring.
#[inline(never)]
fn is_driven(behind: &[u8]) -> bool {
    let wiring = OwnWiring::decode(behind);
    wiring.is_ok_and(|wiring| places(&wiring).is_some() && in_time(&wiring).is_some())
}

/// Returns the board's settings for a wiring, or `None` if the board cannot drive the wiring.
#[inline(never)]
fn of_wiring(behind: &[u8]) -> Option<NodeSettings> {
    let wiring = OwnWiring::decode(behind).ok()?;
    let (settings, schedule) = in_time(&wiring)?;
    Some(NodeSettings::new(settings, schedule))
}

/// The data that a start has read from flash.
struct ReadBack {
    store: Store<Chip>,
    settings: NodeSettings,
    rig: Option<(&'static Rig, u32)>,
    wired: Option<&'static BoardWiring>,
    is_bad: bool,
    start: Start,
    mail: &'static OwnMail,
}

#[inline(never)]
fn read_back(flash: Chip, table: BoardTable) -> ReadBack {
    static RIG: StaticCell<Rig> = StaticCell::new();
    static MAIL: StaticCell<OwnMail> = StaticCell::new();
    let mut room = [0; RIG_ROOM];
    let mut wired = None;
    let defaults = |behind: &[u8]| {
        let settings = is_driven(behind).then(|| of_wiring(behind)).flatten();
        wired = settings.as_ref().and_then(|_| wire(behind));
        settings.unwrap_or_else(without_rig)
    };
    let found = start(flash, table, defaults, reset::why(), &mut room, RIG.uninit());
    let Found { store, disarmed, settings, rig, is_bad, start } =
        found.expect("the table is of this flash");
    let mail: &'static OwnMail = MAIL.init(Locked(Mutex::new(RefCell::new(Mail::new(disarmed)))));
    ReadBack { store, settings, rig, wired, is_bad, start, mail }
}

/// The lines of a wiring, and the wiring's other data for the loop.
struct BoardWiring {
    lines: &'static RefCell<Lines>,
    places: Vec<LinePort, LINES>,
    servos: Vec<ServoSetup, SERVOS>,
    schedule: Schedule,
}

#[inline(never)]
fn wire(behind: &[u8]) -> Option<&'static BoardWiring> {
    static WIRED: StaticCell<BoardWiring> = StaticCell::new();
    static LINES_OF_ALL: StaticCell<RefCell<Lines>> = StaticCell::new();
    let wiring = OwnWiring::decode(behind).ok()?;
    let places = places(&wiring)?;
    let lines = LINES_OF_ALL.uninit().write(no_lines());
    wiring.connect(lines.get_mut()).ok()?;
    let (servos, schedule) = (wiring.setups(), wiring.schedule().ok()?);
    Some(WIRED.init(BoardWiring { lines, places, servos, schedule }))
}

#[inline(never)]
fn no_lines() -> RefCell<Lines> {
    RefCell::new(Lines::new([], []))
}

/// Runs the node until the next reset.
///
/// The loop is on the stack, before everything that the background task puts there. It is initialized in place. Other
/// large values are made in functions of their own, whose stack is free again before the next one.
pub fn run(mut core: cortex_m::Peripherals, mut hardware: Hardware) -> ! {
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();
    clock::start();
    // Switches torque off whatever happened before: now at the rate that most servos have, and again at the servos'
    // own rate as soon as it is known.
    hardware.servos.torque_off();

    let Hardware { link, link_bps, servos, i2c, outputs, stop, light, flash, table, core_hz } =
        hardware;
    CORE_HZ.store(core_hz, Ordering::Relaxed);
    let ReadBack { store, settings, rig, wired, is_bad, start, mail } = read_back(flash, table);
    let first_session = u16::try_from(start.count % 0x1_0000).unwrap_or_default().wrapping_mul(100);
    let about = About {
        protocol: Version::CURRENT,
        firmware: RELEASE,
        rig: 0,
        capacities: Capacities {
            bodies: rounded(BODIES),
            coordinates: rounded(COORDINATES),
            dofs: rounded(DOFS),
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
    // Without a loop the host is told that there is no rig.
    let setup = Setup { about, settings, is_bad, rig: None, tick_s: 0.01, line_bps: link_bps };
    let mut background = BackgroundContext { store, setup, first_session, mail, link, light };
    let Some((rig, wired)) = rig.zip(wired) else {
        // A stored rig that this board cannot move counts as bad data.
        background.setup.is_bad |= rig.is_some();
        below(background)
    };
    let of_loop = background.setup.settings.clone();
    let pins = PinsBeforeWatchdog { outputs, stop, core_hz };
    let ports = Ports::new(servos, i2c, wired.places.clone());
    ControlLoop::with(rig.0, &of_loop, &wired.servos, &wired.schedule, start, |control| {
        node(control.ok(), rig, wired, ports, pins, background)
    })
}
/// Version of the workspace.
const RELEASE: Release = Release { major: 0, minor: 1, patch: 0 };

/// Pins of a loop before its watchdog runs.
struct PinsBeforeWatchdog {
    outputs: Output<'static>,
    stop: Input<'static>,
    core_hz: u32,
}

/// Starts the loop of a rig if possible, then runs the background task.
#[inline(never)]
fn node(
    control: Option<&mut LoopControl>,
    rig: (&'static Rig, u32),
    wired: &'static BoardWiring,
    mut ports: Ports,
    pins: PinsBeforeWatchdog,
    mut background: BackgroundContext,
) -> ! {
    let mut own = None;
    let tick_us = wired.schedule.tick_us();
    let reload = tick_us.checked_sub(1).and_then(|reload| u16::try_from(reload).ok());
    if let (Some(control), Some(reload)) = (control, reload)
        && is_started(&mut ports)
        && set_timer(reload)
    {
        let PinsBeforeWatchdog { outputs, stop, core_hz } = pins;
        let pins = Pins { outputs, stop, watchdog: watchdog::start(), core_hz };
        let asks_us = tick_us.saturating_sub(background.setup.settings.controller.compute_us);
        let own = own.insert(Loop {
            control,
            lines: wired.lines,
            ports,
            pins,
            mail: background.mail,
            asks_us,
        });
        LOOP.store(ptr::from_mut(own).cast(), Ordering::Release);
        background.setup.rig = Some(rig);
        background.setup.tick_s = 1e-6 * tick_us as f32;
        start_timer();
    } else {
        // The stored rig cannot be moved by this board.
        background.setup.is_bad = true;
    }
    below(background)
}

/// Sets all lines as the wiring requires and switches torque off on them. Returns whether that was possible.
fn is_started(ports: &mut Ports) -> bool {
    ports.places.clone().iter().all(|place| match *place {
        LinePort::I2c(prescale) => {
            // Pulses that the chip made before are off now. OE is high until torque is on, and the chip is started
            // again then: it need not answer yet.
            pulses::start(&mut ports.i2c, &prescale);
            true
        }
        LinePort::Serial(baud) => {
            let is_set = ports.serial.set_rate(baud);
            if is_set {
                ports.serial.torque_off();
            }
            is_set
        }
    })
}

/// Sets the period of the loop's timer: `reload` is a tick's time in µs, less one. Returns false if its clock cannot
/// be divided accordingly.
fn set_timer(reload: u16) -> bool {
    rcc::enable_and_reset::<peripherals::TIM3>();
    let ticks = rcc::frequency::<peripherals::TIM3>().0 / 1_000_000;
    let Some(prescaler) = ticks.checked_sub(1).and_then(|by| u16::try_from(by).ok()) else {
        return false;
    };
    pac::TIM3.psc().write_value(prescaler);
    pac::TIM3.arr().write(|w| w.set_arr(reload));
    pac::TIM3.egr().write(|w| w.set_ug(true));
    pac::TIM3.sr().modify(|w| w.set_uif(false));
    pac::TIM3.dier().modify(|w| w.set_uie(true));
    true
}

fn start_timer() {
    // SAFETY: the loop's pointer is set, and the priority is set before the interrupt is enabled.
    unsafe {
        cortex_m::Peripherals::steal().NVIC.set_priority(interrupt::TIM3, LOOP_PRIORITY);
        NVIC::unmask(interrupt::TIM3);
    }
    pac::TIM3.cr1().modify(|w| w.set_cen(true));
}

/// The background task and its data.
struct BackgroundContext {
    store: Store<Chip>,
    setup: Setup<'static, BODIES, DOFS, SERVOS>,
    first_session: u16,
    mail: &'static OwnMail,
    link: Serial,
    light: Light,
}

/// Runs the background task and the light, until the next reset.
fn below(
    BackgroundContext { store, setup, first_session, mail, link, mut light }: BackgroundContext,
) -> ! {
    let mut background = BackgroundTask::new(store, setup, first_session);
    let mut port = HostPort { link };
    let mut stack_due_us = 0;
    loop {
        if background.step(&mut port, mail) == Next::Restart {
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

/// The pattern with which the runtime fills the stack before anything runs.
const PAINT: u32 = 0xCCCC_CCCC;

/// Returns the number of bytes of the stack that were never used.
fn stack_free() -> u32 {
    unsafe extern "C" {
        static __sheap: u32;
        static _stack_start: u32;
    }
    let (mut at, end) = (&raw const __sheap, &raw const _stack_start);
    let mut free = 0;
    // SAFETY: the addresses are RAM between the static data and the beginning of the stack.
    while at < end && unsafe { at.read_volatile() } == PAINT {
        at = at.wrapping_add(1);
        free += 4;
    }
    free
}
