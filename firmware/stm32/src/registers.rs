//! A UART's registers, which have other names from one family to the next.

use embassy_stm32::pac::usart::Usart;

/// Whether the last byte has left the line.
pub(crate) fn is_sent(uart: Usart) -> bool {
    #[cfg(feature = "stm32f446re")]
    return uart.sr().read().tc();
    #[cfg(feature = "stm32g474re")]
    return uart.isr().read().tc();
}

/// Whether there is room for a byte.
pub(crate) fn has_room(uart: Usart) -> bool {
    #[cfg(feature = "stm32f446re")]
    return uart.sr().read().txe();
    #[cfg(feature = "stm32g474re")]
    return uart.isr().read().txe();
}

/// Takes back that the last byte has left.
pub(crate) fn clear_sent(uart: Usart) {
    // Ones leave the other flags as they are.
    #[cfg(feature = "stm32f446re")]
    uart.sr().write(|w| {
        w.0 = u32::MAX;
        w.set_tc(false);
    });
    #[cfg(feature = "stm32g474re")]
    uart.icr().write(|w| w.set_tc(true));
}

/// Where bytes go to.
pub(crate) fn out(uart: Usart) -> *mut u8 {
    #[cfg(feature = "stm32f446re")]
    return uart.dr().as_ptr().cast();
    #[cfg(feature = "stm32g474re")]
    return uart.tdr().as_ptr().cast();
}

/// Where bytes come from.
pub(crate) fn come(uart: Usart) -> *mut u8 {
    #[cfg(feature = "stm32f446re")]
    return uart.dr().as_ptr().cast();
    #[cfg(feature = "stm32g474re")]
    return uart.rdr().as_ptr().cast();
}
