//! The board's bus lines as the control loop uses them.

use core::cell::RefCell;

use sinew_firmware::controller::Wire;
use sinew_servo_bus::Request;
use sinew_servo_bus::pca9685::Prescale;
use sinew_wiring::{BusLine, Protocol};
use static_cell::ConstStaticCell;

use crate::capacity::{LINES, SERVOS};
use crate::{ServoLine, clock, pulses};

/// Maximum length of the packets of one line, bytes.
const OUT_LEN: usize = 1024;

pub(crate) type Lines = sinew_wiring::Lines<sinew_wiring::Bus<SERVOS>, LINES, SERVOS>;

/// Hardware port of a bus line on this board.
#[derive(Clone, Copy)]
pub(crate) enum LinePort {
    /// A serial line with this bit rate, bit/s.
    Serial(u32),
    /// A PCA9685 on I2C, with this clock divider.
    I2c(Prescale),
}

impl LinePort {
    /// Returns the port of a line, or `None` if a PCA9685 cannot make the requested pulse rate.
    pub(crate) fn of(line: &BusLine) -> Option<Self> {
        match line.protocol {
            Protocol::Dynamixel(_) | Protocol::Feetech(_) => Some(Self::Serial(line.timing.baud)),
            Protocol::Pca9685(pulses) => pulses.prescale().ok().map(Self::I2c),
        }
    }
}

/// Hardware ports of all lines, and the buffer for their packets.
pub(crate) struct Ports {
    pub(crate) serial: ServoLine,
    pub(crate) i2c: pulses::Bus,
    pub(crate) places: heapless::Vec<LinePort, LINES>,
    pub(crate) out: &'static mut [u8; OUT_LEN],
}

impl Ports {
    /// Creates the ports. May be called only once.
    pub(crate) fn new(
        serial: ServoLine,
        i2c: pulses::Bus,
        places: heapless::Vec<LinePort, LINES>,
    ) -> Self {
        // The buffer is static: on the stack, each function that passes the value on would hold a copy.
        static OUT: ConstStaticCell<[u8; OUT_LEN]> = ConstStaticCell::new([0; OUT_LEN]);
        Self { serial, i2c, places, out: OUT.take() }
    }
}

pub(crate) struct Exchange<'l> {
    pub(crate) ports: &'l mut Ports,
    pub(crate) lines: &'l RefCell<Lines>,
    /// Whether torque was on in the tick before.
    pub(crate) was_on: bool,
    /// Time, from the beginning of the exchange, in which further packets may be sent to servos, µs.
    pub(crate) asks_us: u32,
    /// Time at which this time ends, µs.
    pub(crate) until_us: u64,
}

impl Wire for Exchange<'_> {
    /// Exchanges the packets of all lines, one line after the other. Each line's bus plans its own packets.
    fn exchange(&mut self, _: &[u8], _: u32, _: impl FnMut(&[u8]) -> bool) {
        self.until_us = clock::now_us().saturating_add(self.asks_us.into());
        for (line, place) in self.ports.places.clone().into_iter().enumerate() {
            let mut planned = self.lines.borrow_mut().plan(line, self.ports.out);
            while let Some(Request { len, time_us, .. }) = planned {
                let bytes = self.ports.out.get(..len).unwrap_or_default();
                match place {
                    _ if bytes.is_empty() => {}
                    LinePort::Serial(_) => self
                        .ports
                        .serial
                        .talk(bytes, time_us, |said| self.lines.borrow_mut().reply(line, said)),
                    LinePort::I2c(prescale) => {
                        // These are the first pulses after a pause: the chip may have been without power until now.
                        if !self.was_on {
                            pulses::start(&mut self.ports.i2c, &prescale);
                        }
                        pulses::write(&mut self.ports.i2c, bytes);
                    }
                }
                let left_us = self.left_us();
                let mut lines = self.lines.borrow_mut();
                planned = lines.plan_more(line, left_us, self.ports.out);
            }
        }
    }

    fn left_us(&self) -> u32 {
        let left_us = self.until_us.saturating_sub(clock::now_us());
        u32::try_from(left_us).unwrap_or(u32::MAX)
    }

    fn rate(&self, line: u8) -> Option<u32> {
        match self.ports.places.get(usize::from(line))? {
            LinePort::Serial(own) => Some(*own),
            // A PCA9685 is not a servo and understands no packets.
            LinePort::I2c(_) => None,
        }
    }

    fn pass(
        &mut self,
        line: u8,
        baud: u32,
        bytes: &[u8],
        wait_us: u32,
        mut reply: impl FnMut(&[u8]),
    ) -> Option<u32> {
        let own = self.rate(line)?;
        let serial = &mut self.ports.serial;
        let is_set = baud == 0 || serial.set_rate(baud);
        let begun_us = clock::now_us();
        let mut last_us = begun_us;
        if is_set {
            serial.talk(bytes, wait_us, |said| {
                last_us = clock::now_us();
                reply(said);
                false
            });
        }
        // Setting this rate cannot fail: it was set at the start.
        serial.set_rate(own);
        let took_us = u32::try_from(last_us.saturating_sub(begun_us)).unwrap_or(u32::MAX);
        is_set.then_some(took_us)
    }
}
