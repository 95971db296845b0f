//! Makes servos safe without the control loop: at a start, and in a panic.

use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::peripheral::SCB;
use embassy_stm32::pac;

use crate::registers;
use crate::reset;

/// Torque-off packets to all servos, in the protocols Dynamixel 2.0 and Feetech. Servos of one protocol ignore the
/// other's packet as noise.
pub const TORQUE_OFF: [&[u8]; 2] = [
    &[0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x06, 0x00, 0x03, 0x40, 0x00, 0x00, 0x2E, 0x16],
    &[0xFF, 0xFF, 0xFE, 0x04, 0x03, 0x28, 0x00, 0xD2],
];

/// Whether USART1 is already set up as the servos' line.
pub(crate) static HAS_LINE: AtomicBool = AtomicBool::new(false);

/// Sends the torque-off command to all servos, twice, byte by byte. It takes the line from whatever used it.
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
    // Sets the direction of a bus buffer, PA8.
    pac::GPIOA.bsrr().write(|w| w.set_bs(8, true));
    // The silence ends a packet that was cut off.
    cortex_m::asm::delay(200_000);
    for bytes in [TORQUE_OFF, TORQUE_OFF].into_iter().flatten() {
        for byte in bytes {
            while !registers::has_room(uart) {}
            // SAFETY: the address is the UART's data register.
            unsafe { registers::out(uart).write_volatile(*byte) };
        }
        registers::clear_sent(uart);
        while !registers::is_sent(uart) {}
    }
}

/// Handles a panic: makes the servos safe first, then writes the record, then resets.
pub fn panicked(file: &str, line: u32) -> ! {
    cortex_m::interrupt::disable();
    // Switches off a PCA9685 by its OE, PB5: high is off.
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

/// Handles errors outside of Rust code's control: a stack overflow, an invalid address.
#[cortex_m_rt::exception]
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    panicked("hard fault", 0)
}
