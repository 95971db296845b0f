//! The servos' line: one wire, half duplex, whose bytes DMA fetches and brings.

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

/// Bytes that may come between two looks.
const WAITING: usize = 1024;

/// The line of the servos.
pub struct ServoLine {
    registers: Usart,
    uart: Uart<'static, Blocking>,
    direction: Output<'static>,
    ring: Ring,
    out: Dma,
}

impl ServoLine {
    /// Of a half-duplex UART that was started, whose registers these are. To be made once.
    ///
    /// It neither reads nor writes by embassy's own `Uart`: that stops to read at a line's first error, and forgets how
    /// much had come before.
    ///
    /// `direction` is for a bus buffer, if there is one: high while bytes leave.
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

    /// Says torque off to all servos, twice.
    pub(crate) fn torque_off(&mut self) {
        for bytes in [TORQUE_OFF, TORQUE_OFF].into_iter().flatten() {
            self.send(bytes);
        }
    }

    /// Bits a second. False: the UART's clock cannot be divided so.
    pub(crate) fn set_rate(&mut self, baud: u32) -> bool {
        self.uart.set_baudrate(baud).is_ok()
    }

    /// Empties its input, sends `bytes`, and gives what comes to `reply` until that has all or `wait_us` are over since
    /// the first byte out.
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
            // The time first: what comes in the last look still counts.
            let is_over = clock::now_us() >= until;
            let len = self.ring.read(&mut came);
            if (len > 0 && reply(&came[..len])) || (is_over && len == 0) {
                return;
            }
        }
    }

    /// Sends bytes; comes back when the last one has left, and servos may speak.
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
        // SAFETY: the address is the UART's data; the bytes stay where they are until the transfer is over.
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

/// DMA writes no status register, so the flag of the frame before (SR.TC) would still be there: one would switch the
/// transmitter off while the last bytes are in it, and a ping of ten bytes would leave with eight. embassy-stm32
/// 0.6.0's half-duplex `write` does not clear it either (embassy#6522 is about the same hazard).
fn forget_sent(uart: Usart) {
    if cfg!(not(feature = "stale-tc")) {
        registers::clear_sent(uart);
    }
}
