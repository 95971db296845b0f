//! The servos' bus line: a single half-duplex wire, whose bytes are transferred by DMA.

use core::sync::atomic::Ordering;

use embassy_stm32::dma::TransferOptions;
use embassy_stm32::gpio::Output;
use embassy_stm32::mode::Blocking;
use embassy_stm32::pac::usart::Usart;
use embassy_stm32::usart::Uart;

use crate::clock;
use crate::registers;
use crate::serial::{Dma, Ring};
use crate::stop::{self, TORQUE_OFF};

/// Maximum number of bytes received between two reads.
const WAITING: usize = 1024;

/// The servos' bus line.
pub struct ServoLine {
    registers: Usart,
    uart: Uart<'static, Blocking>,
    direction: Output<'static>,
    ring: Ring,
    out: Dma,
}

impl ServoLine {
    /// Creates the line from a started half-duplex UART and its registers. May be called only once.
    ///
    /// The line does not use the read and write functions of embassy's own `Uart`, because that stops reading at
    /// the first error on the line and discards what was received before.
    ///
    /// `direction` is for a bus buffer, if there is one: high while bytes are sent.
    pub fn new(
        uart: Uart<'static, Blocking>,
        registers: Usart,
        direction: Output<'static>,
        come: Dma,
        out: Dma,
    ) -> Self {
        static WAITS: static_cell::ConstStaticCell<[u8; WAITING]> =
            static_cell::ConstStaticCell::new([0; WAITING]);
        let ring = Ring::new(registers, come, WAITS.take());
        registers.cr3().modify(|w| w.set_dmat(true));
        let mut line = Self { registers, uart, direction, ring, out };
        line.listen();
        stop::HAS_LINE.store(true, Ordering::Relaxed);
        line
    }

    /// Sends the torque-off command to all servos, twice.
    pub(crate) fn torque_off(&mut self) {
        for bytes in [TORQUE_OFF, TORQUE_OFF].into_iter().flatten() {
            self.send(bytes);
        }
    }

    /// Sets the bit rate, bit/s. Returns false if the UART's clock cannot be divided to this rate.
    pub(crate) fn set_rate(&mut self, baud: u32) -> bool {
        self.uart.set_baudrate(baud).is_ok()
    }

    /// Empties the input, sends `bytes`, and passes received bytes to `reply` until that returns true or `wait_us`
    /// have passed since the first byte was sent.
    pub(crate) fn talk(
        &mut self,
        bytes: &[u8],
        wait_us: u32,
        mut reply: impl FnMut(&[u8]) -> bool,
    ) {
        self.ring.clear();
        let until = clock::now_us().saturating_add(wait_us.into());
        self.send(bytes);
        let mut came = [0; 64];
        loop {
            // Reads the time first: bytes that arrive before the last read still count.
            let is_over = clock::now_us() >= until;
            let len = self.ring.read(&mut came);
            if (len > 0 && reply(&came[..len])) || (is_over && len == 0) {
                return;
            }
        }
    }

    /// Sends bytes. Returns when the last byte has left, and servos may answer.
    pub(crate) fn send(&mut self, bytes: &[u8]) {
        if bytes.is_empty() {
            return;
        }
        self.registers.cr1().modify(|w| {
            w.set_re(false);
            w.set_te(true);
        });
        self.direction.set_high();
        forget_sent(self.registers);
        let out = registers::out(self.registers);
        // SAFETY: the address is the UART's data register; the bytes do not move until the transfer is finished.
        let transfer = unsafe {
            self.out.channel.write(self.out.request, bytes, out, TransferOptions::default())
        };
        transfer.blocking_wait();
        while !registers::is_sent(self.registers) {}
        self.listen();
    }

    fn listen(&mut self) {
        self.direction.set_low();
        self.registers.cr1().modify(|w| {
            w.set_te(false);
            w.set_re(true);
        });
    }
}

/// Clears the flag that the previous transmission is complete (SR.TC). DMA writes no status register, so the flag
/// would still be set: `send` would then switch the transmitter off while the last bytes are still in it, and only
/// eight of a ping's ten bytes would leave. embassy-stm32 0.6.0's half-duplex `write` does not clear the flag
/// either (embassy#6522 is about the same hazard).
fn forget_sent(uart: Usart) {
    if cfg!(not(feature = "stale-tc")) {
        registers::clear_sent(uart);
    }
}
