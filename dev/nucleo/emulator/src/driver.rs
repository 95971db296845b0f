//! Lockstep with the host: the machine runs when the host says so, and stops while the host computes.

use std::io::{BufRead, Write};

use rigless::device::{Level, ResetCause};
use rigless::emulator::{AccessKind, Driver, Host, Settled, Stop, StopReason};
use rigless::session::Session;
use rigless::soc::Layout as _;
use rigless::soc::stm32f427::generated::usart6::{Register, cr1, sr};
use rigless::soc::stm32f427::peripherals::gpio::Pin;
use rigless::time::VirtualNanos;

use crate::board::{Nucleo, Port};
use crate::flash::{self, Eraser};
use crate::protocol::{Command, Line, hex};

/// First address of the peripherals.
const PERIPHERALS: u64 = 0x4000_0000;
/// Port and pin of the light.
const LIGHT: (usize, u8) = (0, 5);

pub struct Lockstep<I, O> {
    input: I,
    output: O,
    /// Content of flash at power-on; `None` after that.
    flash: Option<Vec<u8>>,
    eraser: Eraser,
    /// Whether the core stops until a reset.
    is_hung: bool,
    /// Time until which the host lets the machine run, ns.
    goal_ns: u64,
    resets: usize,
    /// Levels that the host puts on pins. A reset does not change them.
    pins: Vec<((usize, u8), bool)>,
    light: Level,
    /// Whether an access outside of memory was reported.
    is_stray_told: bool,
    /// Lines to print at the next stop.
    told: Vec<String>,
}

impl<I: BufRead + Send, O: Write + Send> Lockstep<I, O> {
    pub fn new(input: I, output: O, flash: Vec<u8>) -> Self {
        let (eraser, light) = (Eraser::default(), Level::Low);
        let (goal_ns, resets, told, pins) = (0, 0, Vec::new(), Vec::new());
        let (is_hung, is_stray_told, flash) = (false, false, Some(flash));
        Self {
            input,
            output,
            flash,
            eraser,
            is_hung,
            goal_ns,
            resets,
            pins,
            light,
            is_stray_told,
            told,
        }
    }

    /// Reports the bytes that the firmware has sent since the last stop.
    fn hear(&mut self, board: &mut Nucleo, now_ns: u64) {
        if is_over(board, now_ns) {
            let baud = board.bus_baud();
            self.take(board, Port::Bus, &format!(" {baud}"));
        }
        self.take(board, Port::Link, "");
    }

    fn take(&mut self, board: &mut Nucleo, port: Port, rate: &str) {
        let (name, wire) = (port.name(), board.wire(port));
        if !wire.sent.is_empty() {
            let bytes = std::mem::take(&mut wire.sent);
            wire.is_flag_cleared = false;
            self.told.push(format!("{name} {}{rate} {}", wire.sent_ns, hex(&bytes)));
        }
        let unheard = std::mem::take(&mut wire.unheard);
        if unheard > 0 {
            self.told.push(format!("unheard {name} {unheard}"));
        }
    }

    /// Reports events to the host, and executes its commands until it lets the machine run. Returns `None` when the
    /// host is done.
    fn converse(
        &mut self,
        session: &mut Session<Nucleo>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<()> {
        let now_ns = stop.at.0;
        self.hear(session.board_mut(), now_ns);
        for line in self.told.drain(..) {
            writeln!(self.output, "{line}").ok()?;
        }
        writeln!(self.output, "at {now_ns}").ok()?;
        loop {
            self.output.flush().ok()?;
            match Line::read(&mut self.input)? {
                Ok(Command::Run(to_ns)) => {
                    self.goal_ns = to_ns.max(now_ns + 1);
                    return Some(());
                }
                Ok(Command::Say(port, from_ns, bytes)) => {
                    session.board_mut().wire(port).say(from_ns.max(now_ns), bytes);
                }
                Ok(Command::Pin(port, pin, level)) => {
                    self.pins.retain(|(of, _)| *of != (port, pin));
                    self.pins.push(((port, pin), level));
                    drive(session, stop.at, (port, pin), level);
                }
                Ok(Command::Reset) => {
                    session.reset_by_pin(stop.at, stop.instruction_count, host);
                    self.begin_anew(session, stop.at, host);
                }
                Ok(Command::Hang) => {
                    self.is_hung = true;
                    self.hold(host);
                }
                Ok(Command::Flash) => {
                    writeln!(self.output, "flash {}", hex(&flash::read(host))).ok()?;
                }
                Err(why) => writeln!(self.output, "error {why}").ok()?,
            }
        }
    }

    /// Stops the core while flash is erased, and while it hangs.
    fn hold(&self, host: &mut dyn Host) {
        host.hold(self.is_hung || self.eraser.is_busy());
    }

    /// Restores flash, pins and state after a reset.
    fn begin_anew(
        &mut self,
        session: &mut Session<Nucleo>,
        at: VirtualNanos,
        host: &mut dyn Host,
    ) {
        self.resets = session.resets().len();
        self.eraser.cut();
        self.is_hung = false;
        self.hold(host);
        self.drive_pins(session, at);
    }

    /// Drives the pins again: their models forget levels at a reset.
    fn drive_pins(&self, session: &mut Session<Nucleo>, at: VirtualNanos) {
        for (pin, level) in &self.pins {
            drive(session, at, *pin, *level);
        }
    }

    /// Returns the time until which the machine runs: at most until the host's next bytes.
    fn until(&self, board: &mut Nucleo, now_ns: u64) -> VirtualNanos {
        let says = [Port::Bus, Port::Link].map(|port| board.wire(port).next_ns(now_ns));
        let wire = board.wire(Port::Bus);
        let silent_ns =
            (!wire.sent.is_empty()).then_some(wire.sent_ns).map(|sent| sent + silence_ns(board));
        let all = says.into_iter().chain([silent_ns]).flatten();
        VirtualNanos(all.fold(self.goal_ns, u64::min).max(now_ns + 1))
    }

    /// Reports changes of resets, flash and the light.
    fn look(&mut self, session: &mut Session<Nucleo>, stop: Stop, host: &mut dyn Host) {
        let now_ns = stop.at.0;
        let resets = session.resets().len();
        if resets > self.resets || stop.reason == StopReason::Reset {
            if let Some(reset) = session.resets().last() {
                self.told.push(format!("reset {now_ns} {}", cause(reset.cause)));
            }
            self.begin_anew(session, stop.at, host);
            self.goal_ns = now_ns;
        }
        let board = session.board_mut();
        if self.eraser.is_busy() {
            let (_, registers) = board.mcu.program();
            let sr = registers.get(rigless::soc::stm32f427::generated::flash::Register::Sr);
            if let Some(sector) = self.eraser.end(sr, host) {
                self.told.push(format!("erased {now_ns} {sector}"));
                self.hold(host);
            }
        }
        let (light, registers) = board.mcu.port(LIGHT.0);
        let level = light.level(Pin::new(LIGHT.1).expect("a pin"), registers);
        if level != self.light {
            self.light = level;
            self.told.push(format!("light {now_ns} {}", u8::from(level == Level::High)));
        }
    }
}

impl<I: BufRead + Send, O: Write + Send> Driver<Nucleo> for Lockstep<I, O> {
    fn on_settled(&mut self, session: &mut Session<Nucleo>, host: &mut dyn Host, now: Settled) {
        match now {
            // Memory is emulated elsewhere: an access below the peripherals that arrives here is outside of memory.
            Settled::Access { access, .. }
                if access.address < PERIPHERALS && !self.is_stray_told =>
            {
                let (now_ns, address) = (access.virtual_time.0, access.address);
                let from = access.program_counter.unwrap_or_default();
                self.told.push(format!("stray {now_ns} {address:x} {from:x}"));
                self.is_stray_told = true;
            }
            Settled::Access { access, value } if access.kind == AccessKind::Write => {
                let now_ns = access.virtual_time.0;
                if access.address == flash::CR
                    && let Some(sector) = self.eraser.begin(value, host)
                {
                    self.told.push(format!("erase {now_ns} {sector}"));
                    self.hold(host);
                }
                let is_bus = access.address == 0x4001_1000 + u64::from(Register::Cr1.spec().offset);
                if is_bus && is_over(session.board_mut(), now_ns) {
                    session.run_until(VirtualNanos(now_ns + 1));
                }
            }
            Settled::Stop(stop) => {
                self.look(session, stop, host);
                if self.goal_ns <= stop.at.0 || is_over(session.board_mut(), stop.at.0) {
                    session.run_until(stop.at);
                } else {
                    let until = self.until(session.board_mut(), stop.at.0);
                    session.run_until(until);
                }
            }
            _ => {}
        }
    }

    fn on_stop(
        &mut self,
        session: &mut Session<Nucleo>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        if let Some(flash) = self.flash.take() {
            flash::fill(host, 0, &flash);
        }
        let now_ns = stop.at.0;
        if now_ns >= self.goal_ns || is_over(session.board_mut(), now_ns) {
            self.converse(session, stop, host)?;
        }
        Some(self.until(session.board_mut(), now_ns))
    }
}

/// Returns the cause of a reset: the button, the core itself, or the watchdog.
fn cause(cause: ResetCause) -> String {
    match cause {
        ResetCause::Pin => "pin".to_owned(),
        ResetCause::Core => "core".to_owned(),
        ResetCause::Model(instance) => instance.to_lowercase(),
        other => format!("{other:?}").to_lowercase(),
    }
}

/// Returns whether the bytes that the firmware sent on the bus have left the transmitter: all of them, or those for
/// which the transmitter had time.
///
/// The transmitter's flag shows it if the firmware has cleared the flag since the last time. Otherwise silence shows
/// it.
fn is_over(board: &mut Nucleo, now_ns: u64) -> bool {
    let (_, registers) = board.mcu.serial_port(Port::Bus as usize);
    let (status, control) = (registers.get(Register::Sr), registers.get(Register::Cr1));
    let (is_complete, is_on) = (sr::TC.is_set(status), cr1::TE.is_set(control));
    let wire = board.wire(Port::Bus);
    wire.is_flag_cleared |= !is_complete;
    if wire.sent.is_empty() {
        return false;
    }
    let (since_ns, is_told) = (wire.sent_ns, is_complete && wire.is_flag_cleared);
    !is_on || is_told || now_ns >= since_ns + silence_ns(board)
}

/// Returns the silence after which a burst is over, ns: one and a half bytes.
fn silence_ns(board: &mut Nucleo) -> u64 {
    15_000_000_000 / board.bus_baud().max(1)
}

/// Puts an external level on a pin.
fn drive(session: &mut Session<Nucleo>, at: VirtualNanos, (port, pin): (usize, u8), level: bool) {
    let Some(pin) = Pin::new(pin) else { return };
    session.board_mut().mcu.drive_port(at, port, |gpio, registers, context| {
        gpio.drive(pin, Some(Level::from(level)), registers, context);
    });
}
