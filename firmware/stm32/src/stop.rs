//! Servos made safe without the loop: at a start, and in a panic.

use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::peripheral::SCB;
use embassy_stm32::pac;

use crate::registers;
use crate::reset;

/// Torque off for all, as two makers' servos know it (Dynamixel 2.0, Feetech). Each takes the other's for noise.
pub const TORQUE_OFF: [&[u8]; 2] = [
    &[0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x06, 0x00, 0x03, 0x40, 0x00, 0x00, 0x2E, 0x16],
    &[0xFF, 0xFF, 0xFE, 0x04, 0x03, 0x28, 0x00, 0xD2],
];

/// Whether USART1 is the servos' line already.
pub(crate) static HAS_LINE: AtomicBool = AtomicBool::new(false);

/// Says torque off to all servos, twice, byte by byte: whoever had the line has lost it.
pub fn torque_off() {
    if !HAS_LINE.load(Ordering::Relaxed) {
        return;
    }
    let uart = pac::USART1;
    uart.cr3().modify(|w| w.set_dmat(false));
    uart.cr1().modify(|w| {
        w.set_re(false);
        w.set_te(true);
    });
    // The direction of a bus buffer, PA8.
    pac::GPIOA.bsrr().write(|w| w.set_bs(8, true));
    // A packet that was cut off ends in silence.
    cortex_m::asm::delay(200_000);
    for bytes in [TORQUE_OFF, TORQUE_OFF].into_iter().flatten() {
        for byte in bytes {
            while !registers::has_room(uart) {}
            // SAFETY: the UART's data.
            unsafe { registers::out(uart).write_volatile(*byte) };
        }
        registers::clear_sent(uart);
        while !registers::is_sent(uart) {}
    }
}

/// What a panic does: servos safe first, then the record, then a reset.
pub fn panicked(file: &str, line: u32) -> ! {
    cortex_m::interrupt::disable();
    // OE of a PCA9685, PB5: high is off.
    pac::GPIOB.bsrr().write(|w| w.set_bs(5, true));
    torque_off();
    reset::record(file, line);
    SCB::sys_reset()
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    let (file, line) = info.location().map_or(("", 0), |at| (at.file(), at.line()));
    panicked(file, line)
}

/// What no Rust code asks for: a stack that ran over, an address that is none.
#[cortex_m_rt::exception]
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    panicked("hard fault", 0)
}
