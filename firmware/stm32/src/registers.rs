//! Registers of a UART, which have different names in each chip family.

use embassy_stm32::pac::usart::Usart;

/// Returns whether the last byte has left the line.
pub(crate) fn is_sent(uart: Usart) -> bool {
    #[cfg(feature = "stm32f446re")]
    return uart.sr().read().tc();
    #[cfg(feature = "stm32g474re")]
    return uart.isr().read().tc();
}

/// Returns whether there is room for a byte.
pub(crate) fn has_room(uart: Usart) -> bool {
    #[cfg(feature = "stm32f446re")]
    return uart.sr().read().txe();
    #[cfg(feature = "stm32g474re")]
    return uart.isr().read().txe();
}

/// Clears the flag that the last byte has left.
pub(crate) fn clear_sent(uart: Usart) {
    // Written ones leave the other flags unchanged.
    #[cfg(feature = "stm32f446re")]
    uart.sr().write(|w| {
        w.0 = u32::MAX;
        w.set_tc(false);
    });
    #[cfg(feature = "stm32g474re")]
    uart.icr().write(|w| w.set_tc(true));
}

/// Returns the address to which sent bytes are written.
pub(crate) fn out(uart: Usart) -> *mut u8 {
    #[cfg(feature = "stm32f446re")]
    return uart.dr().as_ptr().cast();
    #[cfg(feature = "stm32g474re")]
    return uart.tdr().as_ptr().cast();
}

/// Returns the address from which received bytes are read.
pub(crate) fn come(uart: Usart) -> *mut u8 {
    #[cfg(feature = "stm32f446re")]
    return uart.dr().as_ptr().cast();
    #[cfg(feature = "stm32g474re")]
    return uart.rdr().as_ptr().cast();
}
